//! Series over the steps of a run that the page shows but cannot compute from its reduced data.

use crate::recording::{Pose2, Recording, Step, nis};
use slam_core::Outcome;
use std::{collections::VecDeque, f64::consts::TAU};

/// Span of the running mean of NIS, seconds.
const NIS_WINDOW_S: f64 = 30.0;

/// The angle modulo a full turn that is nearest to zero, radians.
pub fn wrap(angle_rad: f64) -> f64 {
    angle_rad - TAU * (angle_rad / TAU).round()
}

/// Estimate minus truth in the start frame, where the truth is known.
pub fn error(step: &Step) -> Option<Pose2> {
    let truth = step.truth?;
    Some(Pose2 {
        x_m: step.pose.x_m - truth.x_m,
        y_m: step.pose.y_m - truth.y_m,
        theta_rad: wrap(step.pose.theta_rad - truth.theta_rad),
    })
}

/// Normalised estimation error squared of the pose, e^T P^-1 e: chi-square with three degrees of freedom for an honest
/// covariance. None without truth or where the covariance is not positive definite (as before the first motion).
pub fn nees(step: &Step) -> Option<f64> {
    let e = error(step)?;
    let e = [e.x_m, e.y_m, e.theta_rad];
    // Cholesky factor L, and y with L y = e: the result is |y|^2.
    let mut l = [[0.0f64; 3]; 3];
    let mut sum = 0.0;
    let mut y = [0.0; 3];
    for i in 0..3 {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = f64::from(step.covariance[i][j]) - dot;
            if i != j {
                l[i][j] = rest / l[j][j];
            } else if rest > 0.0 {
                l[i][i] = rest.sqrt();
            } else {
                return None;
            }
        }
        let dot: f64 = (0..i).map(|k| l[i][k] * y[k]).sum();
        y[i] = (e[i] - dot) / l[i][i];
        sum += y[i] * y[i];
    }
    sum.is_finite().then_some(sum)
}

/// Mean NIS of the last 30 seconds at each step: of the readings used, and of those outside the gate too.
pub fn running_nis(recording: &Recording) -> (Vec<Option<f64>>, Vec<Option<f64>>) {
    let mut used = RunningMean::default();
    let mut all = RunningMean::default();
    let mut out = (Vec::new(), Vec::new());
    for (i, step) in recording.steps.iter().enumerate() {
        for reading in recording.readings(i) {
            let Some(value) = nis(&reading.outcome).filter(|value| value.is_finite()) else { continue };
            all.push(step.t_s, value);
            if matches!(reading.outcome, Outcome::Updated { .. }) {
                used.push(step.t_s, value);
            }
        }
        out.0.push(used.mean(step.t_s));
        out.1.push(all.mean(step.t_s));
    }
    out
}

#[derive(Default)]
struct RunningMean {
    values: VecDeque<(f64, f64)>,
    sum: f64,
}

impl RunningMean {
    fn push(&mut self, t_s: f64, value: f64) {
        self.values.push_back((t_s, value));
        self.sum += value;
    }

    fn mean(&mut self, now_s: f64) -> Option<f64> {
        while let Some(&(t_s, value)) = self.values.front()
            && t_s < now_s - NIS_WINDOW_S
        {
            self.sum -= value;
            self.values.pop_front();
        }
        (!self.values.is_empty()).then(|| self.sum / self.values.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(error: [f64; 3], covariance: [[f32; 3]; 3]) -> Step {
        let pose = Pose2 { x_m: error[0], y_m: error[1], theta_rad: error[2] };
        Step { pose, covariance, truth: Some(Pose2::default()), ..Step::default() }
    }

    #[test]
    fn nees_of_a_diagonal_covariance_is_the_sum_of_squares() {
        let value = nees(&step([0.2, -0.3, 0.1], [[0.01, 0.0, 0.0], [0.0, 0.09, 0.0], [0.0, 0.0, 0.04]])).unwrap();
        assert!((value - (4.0 + 1.0 + 0.25)).abs() < 1e-5, "{value}");
    }

    #[test]
    fn nees_counts_correlation() {
        // P = [[2, 1], [1, 2]] in x and y: P^-1 = [[2, -1], [-1, 2]] / 3.
        let covariance = [[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1.0]];
        let value = nees(&step([1.0, 1.0, 0.0], covariance)).unwrap();
        assert!((value - 2.0 / 3.0).abs() < 1e-9, "{value}");
    }

    #[test]
    fn nees_needs_truth_and_a_positive_covariance() {
        assert_eq!(nees(&Step { truth: None, ..step([0.0; 3], [[1.0; 3]; 3]) }), None);
        assert_eq!(nees(&step([0.1; 3], [[0.0; 3]; 3])), None);
        assert_eq!(nees(&step([0.1; 3], [[f32::NAN; 3]; 3])), None);
    }

    #[test]
    fn the_running_mean_forgets() {
        let mut mean = RunningMean::default();
        mean.push(0.0, 4.0);
        mean.push(20.0, 2.0);
        assert_eq!(mean.mean(20.0), Some(3.0));
        assert_eq!(mean.mean(40.0), Some(2.0));
        assert_eq!(mean.mean(60.0), None);
    }
}
