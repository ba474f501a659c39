//! A run's errors at a few times: what figures over many runs are made from.

use crate::row::{RunKey, RunRow};
use lab::evaluate::score::path::nees;
use lab::recording::Step;

/// Times of a run that are kept.
pub(crate) const TIMES: usize = 30;

/// The errors of one run at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorSample {
    /// The run.
    pub key: RunKey,
    /// Time since the start, seconds.
    pub t_s: f64,
    /// Distance from the true position in the start frame, metres.
    pub error_m: f64,
    /// What the filter takes that distance's 1-sigma for, metres.
    pub sigma_m: f64,
    /// Pose error squared, normalised with the covariance.
    pub nees: f64,
    /// Errors of x, y and heading over their 1-sigmas.
    pub normalised: [f64; 3],
}

impl ErrorSample {
    /// The samples of a run: evenly spaced, the last one at its end.
    pub fn of(key: &RunKey, steps: &[Step]) -> Vec<Self> {
        let at = |i: usize| steps.get((steps.len() * (i + 1) / TIMES).checked_sub(1)?);
        (0..TIMES).filter_map(at).filter_map(|step| Self::of_step(key, step)).collect()
    }

    fn of_step(key: &RunKey, step: &Step) -> Option<Self> {
        let error = step.error()?;
        let errors = [error.x_m, error.y_m, error.theta_rad];
        let variances = [0, 1, 2].map(|i| f64::from(step.covariance[i][i]));
        Some(Self {
            key: key.clone(),
            t_s: step.t_s,
            error_m: errors[0].hypot(errors[1]),
            sigma_m: (variances[0] + variances[1]).sqrt(),
            nees: nees(step)?,
            normalised: [0, 1, 2].map(|i| errors[i] / variances[i].sqrt()),
        })
    }

    /// The header of the file of samples.
    pub fn header() -> String {
        "plan,case,seed,variant,t_s,error_m,sigma_m,nees,z_x,z_y,z_theta".to_owned()
    }

    /// One line of that file, without its end.
    pub fn line(&self) -> String {
        // The key is written as a row writes it, without the figures' commas.
        let key = RunRow::new(self.key.clone()).line();
        let key = key.trim_end_matches(',');
        let [x, y, theta] = self.normalised;
        let Self { t_s, error_m, sigma_m, nees, .. } = self;
        format!("{key},{t_s},{error_m:.5},{sigma_m:.5},{nees:.4},{x:.4},{y:.4},{theta:.4}")
    }

    /// Reads a line; none when it is no sample.
    pub fn parse(line: &str) -> Option<Self> {
        let cells = super::row::cells(line)?;
        let [plan, case, seed, variant, numbers @ ..] = cells.as_slice() else { return None };
        let numbers: Vec<f64> = numbers.iter().map(|cell| cell.parse().ok()).collect::<Option<_>>()?;
        let [t_s, error_m, sigma_m, nees, x, y, theta] = numbers[..] else { return None };
        let key = RunKey { plan: plan.clone(), case: case.clone(), seed: seed.parse().ok()?, variant: variant.clone() };
        Some(Self { key, t_s, error_m, sigma_m, nees, normalised: [x, y, theta] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lab::recording::Pose2;

    #[test]
    fn samples_read_back_and_end_at_the_end() {
        let step = |i: i32| Step {
            t_s: 0.5 * f64::from(i),
            pose: Pose2::new(0.1, 0.0, 0.01),
            covariance: [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]],
            truth: Some(Pose2::default()),
            ..Step::default()
        };
        let steps: Vec<Step> = (0..100).map(step).collect();
        let key = RunKey { plan: "p".into(), case: "c".into(), seed: 1, variant: "a, b".into() };
        let samples = ErrorSample::of(&key, &steps);
        assert_eq!((samples.len(), samples[TIMES - 1].t_s), (TIMES, 49.5));
        assert_eq!(ErrorSample::parse(&samples[3].line()).map(|sample| sample.line()), Some(samples[3].line()));
        assert!((samples[0].normalised[0] - 1.0).abs() < 1e-6);
    }
}
