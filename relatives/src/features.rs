//! What features of a map look like from the robot: lines, points and stored poses, with derivatives.

use nalgebra::{Matrix2, Matrix3, SVector, Vector2, Vector3};
use std::f64::consts::PI;

use crate::ekf::{Ekf, Observation};
use crate::geometry::{Line, Pose, perp, rotation, unit, wrap};

/// A mapped line (its states from `at` on are rho and a) seen as this line in the robot's frame; whether it is seen from the
/// side that its normal comes from.
pub fn line(ekf: &Ekf, at: usize, seen: &Line, noise: Matrix2<f64>) -> (Observation<2>, bool) {
    let (pose, state) = (ekf.pose(), ekf.states::<2>(at));
    let n = unit(state[1]);
    let distance = state[0] - pose.at.dot(&n);
    let slope = -pose.at.dot(&perp(n));
    let side = if distance < 0.0 { -1.0 } else { 1.0 };
    let turned = if distance < 0.0 { PI } else { 0.0 };
    let expected = Line { rho: side * distance, a: state[1] - pose.theta + turned };
    let by = vec![
        (0, Vector2::new(-side * n.x, 0.0)),
        (1, Vector2::new(-side * n.y, 0.0)),
        (2, Vector2::new(0.0, -1.0)),
        (at, Vector2::new(side, 0.0)),
        (at + 1, Vector2::new(side * slope, 1.0)),
    ];
    let innovation = Vector2::new(seen.rho - expected.rho, wrap(seen.a - expected.a));
    (Observation { innovation, by, noise }, distance >= 0.0)
}

/// Adds a line that is seen as this one from the robot; returns its place.
pub fn add_line(ekf: &mut Ekf, seen: &Line, noise: Matrix2<f64>) -> usize {
    let pose = ekf.pose();
    let map = seen.moved(&pose);
    let n = unit(map.a);
    // rho = r + p . n(b + theta): the heading turns n.
    let slope = pose.at.dot(&perp(n));
    let by_pose = nalgebra::Matrix2x3::new(n.x, n.y, slope, 0.0, 0.0, 1.0);
    let by_seen = Matrix2::new(1.0, slope, 0.0, 1.0);
    ekf.add(Vector2::new(map.rho, map.a), by_pose, by_seen * noise * by_seen.transpose())
}

/// The mapped line at a place.
pub fn line_at(ekf: &Ekf, at: usize) -> Line {
    let state = ekf.states::<2>(at);
    Line { rho: state[0], a: state[1] }
}

/// A mapped point seen here in the robot's frame.
pub fn point(ekf: &Ekf, at: usize, seen: Vector2<f64>, noise: Matrix2<f64>) -> Observation<2> {
    let pose = ekf.pose();
    let back = rotation(-pose.theta);
    let expected = back * (ekf.states::<2>(at) - pose.at);
    let by = vec![
        (0, -back.column(0).into_owned()),
        (1, -back.column(1).into_owned()),
        (2, -perp(expected)),
        (at, back.column(0).into_owned()),
        (at + 1, back.column(1).into_owned()),
    ];
    Observation { innovation: seen - expected, by, noise }
}

/// Adds a point that is seen here from the robot; returns its place.
pub fn add_point(ekf: &mut Ekf, seen: Vector2<f64>, noise: Matrix2<f64>) -> usize {
    let pose = ekf.pose();
    let turn = rotation(pose.theta);
    let arm = perp(turn * seen);
    let by_pose = nalgebra::Matrix2x3::new(1.0, 0.0, arm.x, 0.0, 1.0, arm.y);
    ekf.add(pose.transform(seen), by_pose, turn * noise * turn.transpose())
}

/// A stored pose, of which a match says where it is in the robot's frame.
pub fn stored_pose(ekf: &Ekf, at: usize, seen: &Pose, noise: Matrix3<f64>) -> Observation<3> {
    let (pose, state) = (ekf.pose(), ekf.states::<3>(at));
    let stored = Pose::new(state[0], state[1], state[2]);
    let (expected, (by_pose, by_stored)) = (pose.relative(&stored), pose.relative_jacobians(&stored));
    let column = |by: &Matrix3<f64>, c: usize| by.column(c).into_owned();
    let by = (0..3).map(|c| (c, column(&by_pose, c))).chain((0..3).map(|c| (at + c, column(&by_stored, c)))).collect();
    let off = seen.at - expected.at;
    Observation { innovation: Vector3::new(off.x, off.y, wrap(seen.theta - expected.theta)), by, noise }
}

/// Stores the present pose; returns its place.
pub fn add_pose(ekf: &mut Ekf) -> usize {
    let pose = ekf.pose();
    let value: SVector<f64, 3> = Vector3::new(pose.at.x, pose.at.y, pose.theta);
    ekf.add(value, Matrix3::identity(), Matrix3::zeros())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A filter whose pose and one feature have these values.
    fn filter<const M: usize>(pose: [f64; 3], feature: [f64; M]) -> Ekf {
        let mut ekf = Ekf::default();
        ekf.predict(&Pose { at: Vector2::new(pose[0], pose[1]), theta: pose[2] }, &Matrix3::identity());
        ekf.add(SVector::from(feature), nalgebra::SMatrix::<f64, M, 3>::zeros(), nalgebra::SMatrix::identity());
        ekf
    }

    /// The derivatives of what is expected are those of differences: expected = -innovation against a seen zero.
    fn check<const M: usize, const N: usize>(feature: [f64; M], observe: impl Fn(&Ekf) -> Observation<N>) {
        let pose = [0.4, -0.7, 0.6];
        let by = observe(&filter(pose, feature)).by;
        for (state, column) in by {
            let moved = |by: f64| {
                let (mut pose, mut feature) = (pose, feature);
                if state < 3 {
                    pose[state] += by
                } else {
                    feature[state - 3] += by
                }
                observe(&filter(pose, feature)).innovation
            };
            let slope = -(moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((slope - column).norm() < 1e-7, "state {state}: {column} {slope}");
        }
    }

    #[test]
    fn every_derivative_is_that_of_differences() {
        let seen = Line { rho: 1.0, a: 0.5 };
        check([2.0, 0.9], |ekf| line(ekf, 3, &seen, Matrix2::identity()).0);
        check([-2.0, 0.9], |ekf| line(ekf, 3, &seen, Matrix2::identity()).0);
        check([1.0, 2.0], |ekf| point(ekf, 3, Vector2::new(0.1, 0.2), Matrix2::identity()));
        check([1.0, 2.0, 0.3], |ekf| stored_pose(ekf, 3, &Pose::new(0.1, 0.2, 0.3), Matrix3::identity()));
    }

    #[test]
    fn what_is_added_is_seen_where_it_was() {
        let mut ekf = filter([0.4, -0.7, 0.6], [0.0, 0.0]);
        let seen = Line { rho: 1.3, a: -2.0 };
        let at = add_line(&mut ekf, &seen, Matrix2::identity());
        let (again, is_front) = line(&ekf, at, &seen, Matrix2::zeros());
        assert!(again.innovation.norm() < 1e-12 && is_front);
        // A line that was just added is expected with the noise that it was added with.
        assert!((ekf.innovation_covariance(&again) - Matrix2::identity()).norm() < 1e-9);
        let at = add_point(&mut ekf, Vector2::new(0.5, 0.2), Matrix2::identity());
        let again = point(&ekf, at, Vector2::new(0.5, 0.2), Matrix2::zeros());
        assert!(again.innovation.norm() < 1e-12);
        assert!((ekf.innovation_covariance(&again) - Matrix2::identity()).norm() < 1e-9);
    }
}
