//! Whether innovations are as large as the filter expects, when some are of something else than the wall.
//!
//! A beam that should meet a wall is stopped by what stands before it or goes through an open door. Such a reading says
//! nothing about the filter's noise, yet half a metre at 2 cm is a squared innovation of 600 times its variance: the mean
//! over all readings tells how much furniture there is. And the mean of those inside the gate is cut off by the gate. So
//! the innovations are taken for what they are, a mixture (Thrun, Burgard and Fox 2005, sec. 6.3): of the wall, normal with
//! the filter's variance times a factor, and of anything else, uniform over the sensor's range. The factor that makes them
//! most likely is the NIS of the readings that are the wall's.

/// An innovation, its variance and the length of the sensor's range: metres, m^2, metres.
#[derive(Clone, Copy, Debug)]
pub struct Innovation {
    /// Measured minus predicted, metres.
    pub value_m: f64,
    /// What the filter expects of its square, m^2.
    pub variance_m2: f64,
    /// From the sensor's shortest to its longest range, metres.
    pub span_m: f64,
}

/// Most rounds of expectation and maximisation; they settle sooner.
const ROUNDS: usize = 200;

/// The factor of the filter's variance that the wall's own innovations have, by expectation and maximisation; 1 is ideal.
/// None where there are no innovations.
pub fn of_associated(innovations: &[Innovation]) -> Option<f64> {
    let (mut factor, mut share) = (1.0, 0.5);
    for _ in 0..ROUNDS {
        let (mut weights, mut squares) = (0.0, 0.0);
        for innovation in innovations {
            let square = innovation.value_m.powi(2) / innovation.variance_m2;
            let deviation_m = (std::f64::consts::TAU * factor * innovation.variance_m2).sqrt();
            let wall = share * (-0.5 * square / factor).exp() / deviation_m;
            let other = (1.0 - share) / innovation.span_m;
            let weight = wall / (wall + other);
            weights += weight;
            squares += weight * square;
        }
        let before = (factor, share);
        (factor, share) = (squares / weights, weights / innovations.len() as f64);
        if (factor, share) == before {
            break;
        }
    }
    factor.is_finite().then_some(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Innovations of a wall with this factor, nearly normal, and as many others as said.
    fn innovations(factor: f64, others: usize) -> Vec<Innovation> {
        let normal = |i: i32| {
            // Twelve uniform numbers have a variance of one, and their sum nearly a normal distribution.
            let mut state = i as u64;
            let uniform = |_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1u64 << 53) as f64
            };
            (0..12).map(uniform).sum::<f64>() - 6.0
        };
        let wall = (1..=2000).map(|i| 0.03 * factor.sqrt() * normal(i));
        let other = (0..others).map(|i| -2.0 * (i as f64 + 0.5) / others as f64);
        wall.chain(other).map(|value_m| Innovation { value_m, variance_m2: 0.0009, span_m: 3.0 }).collect()
    }

    #[test]
    fn what_is_not_the_wall_does_not_count() {
        for factor in [0.3, 1.0, 2.0] {
            for others in [0, 600] {
                let found = of_associated(&innovations(factor, others)).expect("there are some");
                assert!((found / factor - 1.0).abs() < 0.12, "{found} for {factor} among {others}");
            }
        }
        assert_eq!(of_associated(&[]), None);
    }
}
