//! Series over the steps of a run that the page shows but cannot compute from its reduced data.

use crate::recording::{Recording, nis};
use slam_core::Outcome;
use std::collections::VecDeque;

/// Span of the running mean of NIS, seconds.
const NIS_WINDOW_S: f64 = 30.0;

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
