//! A path against the true one.

use crate::recording::{PathScore, Pose2, Step, wrap};

/// Scores a path given as (estimated, true) poses in the start frame; none where there are none.
pub fn score(pairs: &[(Pose2, Pose2)]) -> Option<PathScore> {
    if pairs.is_empty() {
        return None;
    }
    let alignment = align(pairs);
    let rmse = |error: &dyn Fn(&Pose2, &Pose2) -> f64| {
        let sum: f64 = pairs.iter().map(|(estimate, truth)| error(estimate, truth).powi(2)).sum();
        (sum / pairs.len() as f64).sqrt()
    };
    let distance = |from: [f64; 2], to: &Pose2| (from[0] - to.x_m).hypot(from[1] - to.y_m);
    let heading_rad = rmse(&|e, t| wrap(e.theta_rad + alignment.theta_rad - t.theta_rad));
    Some(PathScore {
        poses: pairs.len(),
        ate_m: rmse(&|e, t| distance(alignment.transform([e.x_m, e.y_m]), t)),
        start_m: Some(rmse(&|e, t| distance([e.x_m, e.y_m], t))),
        heading_deg: heading_rad.to_degrees(),
        nees: None,
        alignment,
    })
}

/// Scores a drive's estimate where its truth is known and the robot claims a place; none where that is nowhere.
pub fn of_estimate(steps: &[Step]) -> Option<PathScore> {
    let pairs = |path: fn(&Step) -> Pose2| -> Vec<(Pose2, Pose2)> {
        steps.iter().filter_map(|step| Some((path(step), step.claimed_truth()?))).collect()
    };
    let PathScore { start_m, .. } = score(&pairs(Step::pose_from_start))?;
    Some(PathScore { start_m, nees: mean_nees(steps), ..score(&pairs(|step| step.pose))? })
}

/// The rotation and translation that take the estimated positions nearest to the true ones in the least-squares sense
/// (Umeyama 1991 without scale, in the plane).
pub fn align(pairs: &[(Pose2, Pose2)]) -> Pose2 {
    let n = pairs.len().max(1) as f64;
    let mean = |value: &dyn Fn(&(Pose2, Pose2)) -> f64| pairs.iter().map(value).sum::<f64>() / n;
    let from = [mean(&|p| p.0.x_m), mean(&|p| p.0.y_m)];
    let to = [mean(&|p| p.1.x_m), mean(&|p| p.1.y_m)];
    let (mut dot, mut cross) = (0.0, 0.0);
    for (estimate, truth) in pairs {
        let (ex, ey) = (estimate.x_m - from[0], estimate.y_m - from[1]);
        let (tx, ty) = (truth.x_m - to[0], truth.y_m - to[1]);
        dot += ex * tx + ey * ty;
        cross += ex * ty - ey * tx;
    }
    let rotation = Pose2::new(0.0, 0.0, f64::atan2(cross, dot));
    let [x, y] = rotation.transform(from);
    Pose2 { x_m: to[0] - x, y_m: to[1] - y, ..rotation }
}

/// Mean normalised estimation error squared of the pose in the map frame, over the steps that have a truth and a
/// covariance that can be inverted (at the start it is singular). Three for an honest filter.
pub fn mean_nees(steps: &[Step]) -> Option<f64> {
    let values: Vec<f64> = steps.iter().filter_map(nees).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Normalised estimation error squared of one step's pose.
pub fn nees(step: &Step) -> Option<f64> {
    let error = step.error()?;
    squared_by_covariance([error.x_m, error.y_m, error.theta_rad], &step.covariance.map(|row| row.map(f64::from)))
}

/// Smallest share of a variance that may be left once the other axes are known. In the first steps of two wheels the
/// covariance has two directions only; what rounding to f32 leaves in the third says nothing.
const SINGULAR: f64 = 1e-5;

/// e^T P^-1 e through the Cholesky factor of P; none where P is singular or not positive.
pub fn squared_by_covariance(error: [f64; 3], covariance: &[[f64; 3]; 3]) -> Option<f64> {
    let mut factor = [[0.0f64; 3]; 3];
    let mut whitened = [0.0f64; 3];
    for i in 0..3 {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let rest = covariance[i][j] - known;
            if i != j {
                factor[i][j] = rest / factor[j][j];
            } else if rest > SINGULAR * covariance[i][i] {
                factor[i][i] = rest.sqrt();
            } else {
                return None;
            }
        }
        let known: f64 = (0..i).map(|k| factor[i][k] * whitened[k]).sum();
        whitened[i] = (error[i] - known) / factor[i][i];
    }
    Some(whitened.iter().map(|w| w * w).sum())
}

/// Length of a path, metres.
pub fn length_m(path: impl Iterator<Item = Pose2>) -> f64 {
    let mut last: Option<Pose2> = None;
    path.map(|pose| last.replace(pose).map_or(0.0, |from| (pose.x_m - from.x_m).hypot(pose.y_m - from.y_m))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square_path() -> Vec<Pose2> {
        (0..40).map(|i| Pose2::new(f64::from(i % 10), f64::from(i / 10), 0.1 * f64::from(i))).collect()
    }

    #[test]
    fn a_moved_and_turned_path_aligns_exactly() {
        let moved_by = Pose2::new(3.0, -2.0, 0.7);
        let pairs: Vec<_> = square_path().iter().map(|p| (moved_by.compose(p), *p)).collect();
        let score = score(&pairs).expect("there are poses");
        assert!(score.ate_m < 1e-12 && score.heading_deg < 1e-9, "{score:?}");
        assert!((score.alignment.theta_rad + 0.7).abs() < 1e-12);
        assert!(score.start_m > Some(1.0));
    }

    #[test]
    fn scale_is_not_aligned_away() {
        let pairs: Vec<_> =
            square_path().iter().map(|p| (Pose2 { x_m: 1.1 * p.x_m, y_m: 1.1 * p.y_m, ..*p }, *p)).collect();
        let score = score(&pairs).expect("there are poses");
        assert!(score.ate_m > 0.1, "{score:?}");
    }

    #[test]
    fn an_estimate_is_scored_from_where_the_robot_started_in_its_map() {
        let start = Pose2::new(0.3, -0.1, 0.2);
        let step = |truth: &Pose2| Step { pose: start.compose(truth), start, truth: Some(*truth), ..Step::default() };
        let mut steps: Vec<Step> = square_path().iter().map(step).collect();
        steps.push(Step { searching: true, truth: Some(Pose2::new(9.0, 9.0, 0.0)), ..Step::default() });
        let score = of_estimate(&steps).expect("there are poses");
        assert!(score.poses == 40 && score.start_m < Some(1e-12) && score.ate_m < 1e-12, "{score:?}");
    }

    #[test]
    fn nees_of_a_one_sigma_error_on_every_axis_is_three() {
        let step = Step {
            pose: Pose2::new(0.1, 0.2, 0.3),
            covariance: [[0.01, 0.0, 0.0], [0.0, 0.04, 0.0], [0.0, 0.0, 0.09]],
            truth: Some(Pose2::default()),
            ..Step::default()
        };
        assert!((nees(&step).expect("positive covariance") - 3.0).abs() < 1e-5);
        assert_eq!(nees(&Step { covariance: [[0.0; 3]; 3], ..step.clone() }), None);
        let flat = [[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0 + 1e-6]];
        assert_eq!(nees(&Step { covariance: flat, ..step }), None, "two axes are one");
    }

    #[test]
    fn nees_agrees_with_an_inverse_by_cofactors() {
        let p = [[2.0, 0.3, -0.4], [0.3, 1.0, 0.2], [-0.4, 0.2, 3.0]];
        let e = [0.5, -1.0, 2.0];
        let minor = |r0: usize, c0: usize, r1: usize, c1: usize| p[r0][c0] * p[r1][c1] - p[r0][c1] * p[r1][c0];
        let det = p[0][0] * minor(1, 1, 2, 2) - p[0][1] * minor(1, 0, 2, 2) + p[0][2] * minor(1, 0, 2, 1);
        let adjugate = [
            [minor(1, 1, 2, 2), -minor(0, 1, 2, 2), minor(0, 1, 1, 2)],
            [-minor(1, 0, 2, 2), minor(0, 0, 2, 2), -minor(0, 0, 1, 2)],
            [minor(1, 0, 2, 1), -minor(0, 0, 2, 1), minor(0, 0, 1, 1)],
        ];
        let expected: f64 =
            (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| e[i] * adjugate[i][j] * e[j] / det).sum();
        let found = squared_by_covariance(e, &p).expect("positive");
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}
