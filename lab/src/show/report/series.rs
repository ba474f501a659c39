//! Series over the steps of a run that the page shows but cannot compute from its reduced data.

use crate::recording::{Recording, nis};
use slam_core::{Outcome, ReadingReport};
use std::collections::VecDeque;

/// Span of the running mean of NIS, seconds.
const NIS_WINDOW_S: f64 = 30.0;

/// Mean NIS of the last 30 seconds at each step: of the readings used, and of those outside the gate too.
pub fn running_nis(recording: &Recording) -> (Vec<Option<f64>>, Vec<Option<f64>>) {
    let mut running = RunningNis::default();
    recording.steps.iter().enumerate().map(|(i, step)| running.push(step.t_s, recording.readings(i))).unzip()
}

/// Mean NIS of the last 30 seconds, step by step.
#[derive(Default)]
pub struct RunningNis {
    used: RunningMean,
    all: RunningMean,
}

impl RunningNis {
    /// Takes in the readings of the next step: the mean of the readings used, and with those outside the gate.
    pub fn push(&mut self, t_s: f64, readings: &[ReadingReport]) -> (Option<f64>, Option<f64>) {
        for reading in readings {
            let Some(value) = nis(&reading.outcome).filter(|value| value.is_finite()) else { continue };
            self.all.push(t_s, value);
            if matches!(reading.outcome, Outcome::Updated { .. }) {
                self.used.push(t_s, value);
            }
        }
        (self.used.mean(t_s), self.all.mean(t_s))
    }
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
