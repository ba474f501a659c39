//! The end points of the last stretch of the way, seen from where the robot is now (a multiscan).
//!
//! Each point carries what the odometry since then leaves unknown of it. Points of one window share that odometry and yet
//! count as independent, as in the systems that use it.

use nalgebra::{Matrix2, Matrix2x3};
use std::collections::VecDeque;

use crate::geometry::{Point, perp, rotation, unit};
use crate::{Beam, Input};

/// One end point.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Where it is, in the robot's present frame, metres.
    pub at: Point,
    /// Direction from the sensor to it, in the present frame, radians.
    pub bearing: f64,
    /// The reading, metres.
    pub range: f64,
    /// Which beam made it.
    pub beam: usize,
    /// 1-sigma of the reading, metres.
    pub sigma: f64,
    /// Covariance that the motion since has added, m^2.
    pub drift: Matrix2<f64>,
    /// Length of the way when it was made, metres.
    path: f64,
    /// Turns, added up without their signs, when it was made, radians.
    turned: f64,
}

impl Seen {
    /// Covariance of the point in the present frame: of the motion since, and of the reading along its beam.
    pub fn covariance(&self) -> Matrix2<f64> {
        let e = unit(self.bearing);
        self.drift + e * e.transpose() * (self.sigma * self.sigma)
    }
}

/// How long a window is, and how dense.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Way after which a point is dropped, metres.
    pub path: f64,
    /// Turns after which a point is dropped, radians.
    pub turn: f64,
    /// Most points.
    pub points: usize,
    /// A reading is taken after so much way, metres, or a turn of as many radians times `TURN_PER_STEP`.
    pub step: f64,
}

/// Turn that is worth a metre of way to [`Extent::step`], radians: 1 degree for 1 cm.
const TURN_PER_STEP: f64 = 1.745;

/// The window.
#[derive(Clone, Debug)]
pub struct Window {
    extent: Extent,
    /// Oldest first.
    pub points: VecDeque<Seen>,
    /// Length of the way so far, metres.
    pub path: f64,
    /// Turns so far, radians.
    pub turned: f64,
    taken: Option<[f64; 2]>,
}

impl Window {
    /// An empty window.
    pub fn new(extent: Extent) -> Self {
        Self { extent, points: VecDeque::new(), path: 0.0, turned: 0.0, taken: None }
    }

    /// A window that forgets nothing, of points that one beam saw from the origin.
    #[cfg(test)]
    pub fn of_points(points: impl IntoIterator<Item = Point>, sigma: f64) -> Self {
        let mut window = Self::new(Extent { path: 1e3, turn: 1e3, points: 1000, step: 0.0 });
        for at in points {
            let bearing = at.y.atan2(at.x);
            let beam = Beam { origin: Point::zeros(), bearing, opening: 0.0, range: at.norm(), sigma };
            window.step(&Input { beams: &[Some(beam)], ..Input::default() });
        }
        window
    }

    /// Moves on, forgets what is too old and takes in the readings if the robot has come far enough for new ones.
    pub fn step(&mut self, input: &Input<'_>) {
        let motion = &input.motion;
        self.path += motion.at.norm();
        self.turned += motion.theta.abs();
        let back = rotation(-motion.theta);
        for seen in &mut self.points {
            seen.at = back * (seen.at - motion.at);
            seen.bearing -= motion.theta;
            let arm = perp(seen.at);
            let mut by_motion = Matrix2x3::zeros();
            by_motion.fixed_view_mut::<2, 2>(0, 0).copy_from(&-back);
            by_motion.set_column(2, &-arm);
            seen.drift = back * seen.drift * back.transpose() + by_motion * input.motion_cov * by_motion.transpose();
        }
        let old =
            |seen: &Seen| self.path - seen.path > self.extent.path || self.turned - seen.turned > self.extent.turn;
        while self.points.front().is_some_and(old) {
            self.points.pop_front();
        }
        let is_due = self.taken.is_none_or(|[path, turned]| {
            let step = self.extent.step;
            self.path - path >= step || self.turned - turned >= step * TURN_PER_STEP
        });
        if is_due && input.beams.iter().any(Option::is_some) {
            self.taken = Some([self.path, self.turned]);
            self.take(input.beams);
        }
    }

    fn take(&mut self, beams: &[Option<Beam>]) {
        for (index, beam) in beams.iter().enumerate() {
            let Some(beam) = beam else { continue };
            self.points.push_back(Seen {
                at: beam.end(),
                bearing: beam.bearing,
                range: beam.range,
                beam: index,
                sigma: beam.sigma,
                drift: Matrix2::zeros(),
                path: self.path,
                turned: self.turned,
            });
        }
        while self.points.len() > self.extent.points {
            self.points.pop_front();
        }
    }

    /// The points of one beam, oldest first, with their places in [`Window::points`].
    pub fn of_beam(&self, beam: usize) -> Vec<usize> {
        (0..self.points.len()).filter(|i| self.points[*i].beam == beam).collect()
    }

    /// One more than the largest beam.
    pub fn beams(&self) -> usize {
        self.points.iter().map(|seen| seen.beam + 1).max().unwrap_or(0)
    }

    /// Drops the points at these places.
    pub fn drop(&mut self, used: &[usize]) {
        let mut place = 0;
        self.points.retain(|_| {
            place += 1;
            !used.contains(&(place - 1))
        });
    }

    /// Memory that the points take, bytes.
    pub fn bytes(&self) -> usize {
        self.points.len() * size_of::<Seen>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use nalgebra::Matrix3;

    const ALL: Extent = Extent { path: 1e3, turn: 1e3, points: 1000, step: 0.0 };

    fn beam() -> Option<Beam> {
        Some(Beam { origin: Point::new(0.1, 0.0), bearing: 1.2, opening: 0.0, range: 0.9, sigma: 0.01 })
    }

    #[test]
    fn a_point_stays_where_it_is_while_the_robot_moves() {
        let mut window = Window::new(ALL);
        let step = |motion| Input { motion, beams: &[], ..Input::default() };
        window.step(&Input { beams: &[beam()], ..step(Pose::default()) });
        let motions = [Pose::new(0.3, 0.1, 0.4), Pose::new(0.2, -0.1, -1.0)];
        let mut pose = Pose::default();
        for motion in motions {
            window.step(&step(motion));
            pose = pose.compose(&motion);
        }
        let expected = pose.inverse_transform(beam().map(|beam| beam.end()).unwrap_or_default());
        assert!((window.points[0].at - expected).norm() < 1e-12);
        assert!((window.points[0].bearing - (1.2 - pose.theta)).abs() < 1e-12);
    }

    /// The covariance against one that is made of samples of the motions' noise.
    #[test]
    fn the_covariance_is_that_of_many_noisy_drives() {
        let motion = Pose::new(0.2, 0.05, 0.3);
        let sigma = [0.004, 0.003, 0.01];
        let noise = Matrix3::from_diagonal(&nalgebra::Vector3::from(sigma.map(|s| s * s)));
        let mut window = Window::new(ALL);
        window.step(&Input { beams: &[beam()], ..Input::default() });
        for _ in 0..3 {
            window.step(&Input { motion, motion_cov: noise, ..Input::default() });
        }
        // Each sigma one way and the other, one source at a time: exact for a linear model.
        let run = |source: usize, sign: f64| {
            let mut at = beam().map(|beam| beam.end()).unwrap_or_default();
            for step in 0..3 {
                let mut off = [0.0; 3];
                if source / 3 == step {
                    off[source % 3] = sign * sigma[source % 3] * 1e-3;
                }
                let noisy = Pose::new(motion.at.x + off[0], motion.at.y + off[1], motion.theta + off[2]);
                at = noisy.inverse_transform(at);
            }
            at
        };
        let mut expected = Matrix2::zeros();
        for source in 0..9 {
            let d = (run(source, 1.0) - run(source, -1.0)) * (0.5 * 1e3);
            expected += d * d.transpose();
        }
        assert!((window.points[0].drift - expected).norm() < 1e-4 * expected.norm());
    }
}
