//! The curve range = a volts^b, fitted where its noise is constant: in volts.

use std::ops::RangeInclusive;

use lab::evaluate::statistics::{median, rms};

/// One reading of a sensor at a known range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Time, seconds.
    pub time_s: f64,
    /// True range, metres.
    pub range_m: f64,
    /// Output, volts.
    pub volts: f64,
}

/// The curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Range at one volt, metres.
    pub scale_m: f64,
    /// Power of the voltage; negative.
    pub exponent: f64,
}

/// Standard deviations per median absolute residual of a normal distribution.
pub const SIGMA_PER_MAD: f64 = 1.4826;

/// Residuals beyond this many standard deviations are bounded in their influence (Huber 1964: 95 % efficiency).
const HUBER: f64 = 1.345;

/// Rounds of the fit; it has converged long before.
const ROUNDS: usize = 30;

impl Fit {
    /// The robust least-squares fit; none for fewer than ten readings or readings without spread.
    pub fn of(readings: &[Reading]) -> Option<Self> {
        if readings.len() < 10 {
            return None;
        }
        let mut fit = Self::in_logarithms(readings)?;
        for _ in 0..ROUNDS {
            fit = fit.improved(readings)?;
        }
        (fit.scale_m > 0.0 && fit.exponent < 0.0).then_some(fit)
    }

    /// A straight line through the logarithms: a first guess.
    fn in_logarithms(readings: &[Reading]) -> Option<Self> {
        let n = readings.len() as f64;
        let points = || readings.iter().map(|reading| (reading.volts.ln(), reading.range_m.ln()));
        let (mean_x, mean_y) = (points().map(|p| p.0).sum::<f64>() / n, points().map(|p| p.1).sum::<f64>() / n);
        let xx: f64 = points().map(|p| (p.0 - mean_x).powi(2)).sum();
        let xy: f64 = points().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
        let exponent = xy / xx;
        exponent.is_finite().then(|| Self { scale_m: (mean_y - exponent * mean_x).exp(), exponent })
    }

    /// One Gauss-Newton step in (ln a, 1 / b) with Huber's weights.
    fn improved(&self, readings: &[Reading]) -> Option<Self> {
        let sizes: Vec<f64> = readings.iter().map(|reading| self.residual_v(reading).abs()).collect();
        let bound_v = HUBER * SIGMA_PER_MAD * median(&sizes)?;
        let power = 1.0 / self.exponent;
        let (mut normal, mut right) = ([[0.0; 2]; 2], [0.0; 2]);
        for (reading, size) in readings.iter().zip(&sizes) {
            let weight = if *size > bound_v { bound_v / size } else { 1.0 };
            // volts = exp(power (ln r - ln a))
            let volts = self.volts(reading.range_m);
            let row = [-power * volts, (reading.range_m.ln() - self.scale_m.ln()) * volts];
            for i in 0..2 {
                for j in 0..2 {
                    normal[i][j] += weight * row[i] * row[j];
                }
                right[i] += weight * row[i] * self.residual_v(reading);
            }
        }
        let determinant = normal[0][0] * normal[1][1] - normal[0][1] * normal[1][0];
        let by_scale = (normal[1][1] * right[0] - normal[0][1] * right[1]) / determinant;
        let by_power = (normal[0][0] * right[1] - normal[1][0] * right[0]) / determinant;
        (by_scale.is_finite() && by_power.is_finite())
            .then(|| Self { scale_m: (self.scale_m.ln() + by_scale).exp(), exponent: 1.0 / (power + by_power) })
    }

    /// The curve's output at a range, volts.
    pub fn volts(&self, range_m: f64) -> f64 {
        (range_m / self.scale_m).powf(1.0 / self.exponent)
    }

    /// Read minus expected, volts.
    pub fn residual_v(&self, reading: &Reading) -> f64 {
        reading.volts - self.volts(reading.range_m)
    }
}

/// Correlation of each value with the next one.
pub fn correlation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let product: f64 = values.windows(2).map(|pair| (pair[0] - mean) * (pair[1] - mean)).sum();
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    product / square
}

/// RMS residual where the output is taken to show the range of some time ago, over readings whose range is in `span_m`;
/// none where there are none. Outliers beyond half a volt are left out.
pub fn lagged_rms_v(fit: &Fit, readings: &[Reading], span_m: RangeInclusive<f64>, lag_s: f64) -> Option<f64> {
    let mut residuals_v = Vec::new();
    let mut after = 0;
    for reading in readings.iter().filter(|reading| span_m.contains(&reading.range_m)) {
        let then_s = reading.time_s - lag_s;
        while after < readings.len() && readings[after].time_s < then_s {
            after += 1;
        }
        let (Some(to), Some(from)) = (readings.get(after), readings.get(after.wrapping_sub(1))) else { continue };
        let share = (then_s - from.time_s) / (to.time_s - from.time_s);
        let range_m = from.range_m + share * (to.range_m - from.range_m);
        let residual_v = reading.volts - fit.volts(range_m);
        if residual_v.abs() < 0.5 {
            residuals_v.push(residual_v);
        }
    }
    rms(&residuals_v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_sim::rng::Rng;

    /// A wall that comes nearer and goes away, read by a sensor of known curve, noise and lag.
    fn readings(lag_s: f64) -> Vec<Reading> {
        let truth = Fit { scale_m: 0.3, exponent: -1.2 };
        let range_m = |t_s: f64| 0.45 + 0.25 * (2.0 * t_s).sin();
        let mut rng = Rng::stream(1, "sensor", 0);
        let reading = |i: u32| {
            let time_s = 0.05 * f64::from(i);
            let outlier = if i.is_multiple_of(50) { 0.4 } else { 0.0 };
            let volts = truth.volts(range_m(time_s - lag_s)) + 0.02 * rng.gaussian() + outlier;
            Reading { time_s, range_m: range_m(time_s), volts }
        };
        (0..2000).map(reading).collect()
    }

    #[test]
    fn the_curve_is_found_in_spite_of_outliers() {
        let fit = Fit::of(&readings(0.0)).expect("a fit");
        assert!((fit.scale_m - 0.3).abs() < 0.003 && (fit.exponent + 1.2).abs() < 0.02, "{fit:?}");
    }

    #[test]
    fn the_lag_is_where_the_residual_is_least() {
        let delayed = readings(0.12);
        let fit = Fit { scale_m: 0.3, exponent: -1.2 };
        let rms_v = |lag_s: f64| lagged_rms_v(&fit, &delayed, 0.1..=1.0, lag_s).expect("readings");
        let best = (0..40).map(|i| 0.01 * f64::from(i)).min_by(|a, b| rms_v(*a).total_cmp(&rms_v(*b)));
        assert!((best.expect("lags") - 0.12).abs() < 0.015, "{best:?}");
    }

    #[test]
    fn too_little_is_no_fit() {
        assert_eq!(Fit::of(&readings(0.0)[..9]), None);
        assert_eq!(Fit::of(&[Reading { time_s: 0.0, range_m: 1.0, volts: 1.0 }; 20]), None);
    }
}
