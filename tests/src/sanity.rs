//! What must be true of an estimator whatever it was given.

use slam_core::ekf::Ekf;
use slam_core::{Estimate, Outcome, RangeInput, Refusal, Sample, Slam, StepReport};

/// Counts of what became of the readings, kept from the reports.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    steps: u32,
    updates: u32,
    refused: [u32; Refusal::COUNT],
    kept: u32,
}

impl Tally {
    /// Counts one step, and checks that each input had exactly one outcome.
    pub fn add<const S: usize>(&mut self, sample: &Sample<S>, report: &StepReport<S>, sensors: usize, in_time: bool) {
        self.steps += 1;
        for (i, (input, reading)) in sample.ranges.iter().zip(&report.readings).enumerate() {
            let expected_missing = i >= sensors || *input == RangeInput::Missing || !in_time;
            assert_eq!(reading.outcome == Outcome::Missing, expected_missing, "sensor {i}: {input:?}");
            let range_is_valid = reading.range_m.is_none_or(|range_m| range_m.is_finite() && range_m > 0.0);
            assert!(range_is_valid, "sensor {i}: {input:?} became {:?}", reading.range_m);
            assert_eq!(reading.range_m.is_some(), reading.hit_m.is_some());
            match reading.outcome {
                Outcome::Missing => {}
                Outcome::Updated { .. } => self.updates += 1,
                Outcome::Refused(why) => self.refused[why as usize] += 1,
                Outcome::Gated { .. } | Outcome::Unexplained => self.kept += 1,
            }
        }
    }

    /// How many were refused for this reason.
    pub fn refused(&self, why: Refusal) -> u32 {
        self.refused[why as usize]
    }

    /// Compares with the estimator's own counters.
    pub fn assert_agrees<const S: usize, const W: usize, const B: usize, const ROWS: usize>(
        &self,
        slam: &Slam<S, W, B, ROWS>,
    ) {
        let counters = slam.counters();
        assert_eq!(counters.steps, self.steps);
        assert_eq!(counters.updates, self.updates);
        assert_eq!(counters.refused, self.refused, "in the order of {:?}", Refusal::ALL);
        // A reading that ended where the sensor's last one did is not kept a second time.
        assert!(counters.buffered <= self.kept, "{} buffered of {}", counters.buffered, self.kept);
        assert!(counters.overwritten <= counters.buffered);
    }
}

/// Pose, covariance, walls and calibration are numbers, and the covariance is one: symmetric, not negative.
pub fn assert_sane<const S: usize, const W: usize, const B: usize, const ROWS: usize>(slam: &Slam<S, W, B, ROWS>) {
    let Estimate { pose, covariance } = slam.estimate();
    assert!(pose.x_m.is_finite() && pose.y_m.is_finite(), "{pose:?}");
    assert!(pose.theta_rad.abs() <= core::f32::consts::PI, "{pose:?}");
    assert!(slam.dead_reckoning().x_m.is_finite() && slam.dead_reckoning().theta_rad.abs() < 3.15);
    assert_is_covariance(&covariance.into());
    for wall in slam.walls() {
        assert!(wall.rho_m.is_finite() && wall.beta_rad.is_finite(), "{wall:?}");
        assert!(wall.lo_m <= wall.hi_m && wall.sigma_rho_m.is_finite(), "{wall:?}");
    }
    for (parameter, factor, sigma) in slam.calibration() {
        assert!(factor.is_finite() && sigma.is_finite() && sigma > 0.0, "{parameter:?}: {factor} +- {sigma}");
    }
    assert!(slam.walls().count() <= W && slam.state_len() <= Ekf::<ROWS>::CAPACITY);
}

/// Symmetric to the bit, and without a negative principal minor beyond f32's rounding.
pub fn assert_is_covariance(covariance: &[[f32; 3]; 3]) {
    let p = covariance.map(|row| row.map(f64::from));
    for i in 0..3 {
        assert!(p[i][i].is_finite() && p[i][i] >= 0.0, "variance {i}: {covariance:?}");
        for j in 0..3 {
            assert_eq!(covariance[i][j].to_bits(), covariance[j][i].to_bits(), "{covariance:?}");
            assert!(p[i][j] * p[i][j] <= p[i][i] * p[j][j] * (1.0 + 1e-4) + 1e-30, "{i}, {j}: {covariance:?}");
        }
    }
    let minor = |a: usize, b: usize| p[1][a] * p[2][b] - p[1][b] * p[2][a];
    let determinant = p[0][0] * minor(1, 2) - p[0][1] * minor(0, 2) + p[0][2] * minor(0, 1);
    assert!(determinant >= -1e-4 * p[0][0] * p[1][1] * p[2][2], "{covariance:?}");
}
