//! Statistics of figures over runs.

/// A quantile of the values (0 to 1), interpolated; none of none.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = share.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    Some(below + (place - place.floor()) * (above - below))
}

/// The median; none of none.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// The mean; none of none.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The standard error of the mean of independent values, by their own spread; none of fewer than two.
pub fn standard_error(values: &[f64]) -> Option<f64> {
    let (mean, n) = (mean(values)?, values.len() as f64);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (n > 1.0).then(|| (squares / (n - 1.0) / n).sqrt())
}

/// The root of the mean square; none of none.
pub fn rms(values: &[f64]) -> Option<f64> {
    mean(&values.iter().map(|value| value * value).collect::<Vec<_>>()).map(f64::sqrt)
}

/// The largest; none of none.
pub fn max(values: &[f64]) -> Option<f64> {
    values.iter().copied().max_by(f64::total_cmp)
}

/// The band in which the mean of `runs` chi-square variables of this many degrees of freedom lies with probability
/// 95 %, by the cube-root approximation (Wilson and Hilferty 1931).
pub fn chi_square_mean_band(degrees: usize, runs: usize) -> [f64; 2] {
    let k = (degrees * runs.max(1)) as f64;
    let spread = 2.0 / (9.0 * k);
    [-1.959_964, 1.959_964].map(|z: f64| degrees as f64 * (1.0 - spread + z * spread.sqrt()).max(0.0).powi(3))
}

/// The standard normal density.
pub fn normal_density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_interpolated() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(median(&values), Some(2.5));
        assert_eq!((quantile(&values, 0.0), quantile(&values, 1.0)), (Some(1.0), Some(4.0)));
        assert_eq!(median(&[]), None);
    }

    #[test]
    fn the_standard_error_is_of_the_values_own_spread() {
        // Variance 5/3 of four values.
        let found = standard_error(&[1.0, 2.0, 3.0, 4.0]).expect("four values");
        assert!((found - (5.0f64 / 12.0).sqrt()).abs() < 1e-12, "{found}");
        assert_eq!(standard_error(&[1.0]), None);
    }

    #[test]
    fn the_band_is_the_chi_square_tables() {
        // 2.5 % and 97.5 % points of chi-square with 150 degrees of freedom: 117.985 and 185.800.
        let [low, high] = chi_square_mean_band(3, 50);
        assert!((low - 117.985 / 50.0).abs() < 0.005 && (high - 185.8 / 50.0).abs() < 0.005, "{low} {high}");
        // With 3 degrees 0.2158 and 9.3484, each over 1: the approximation is at its worst there.
        let [low, high] = chi_square_mean_band(3, 1);
        assert!((low - 0.2158).abs() < 0.04 && (high - 9.3484).abs() < 0.1, "{low} {high}");
    }
}
