//! A line through points of which some are not its own.

use std::f64::consts::FRAC_PI_2;

use crate::recording::wrap;

/// Lines that are tried: with a third of the points on something else, that all go through one of those is out of the
/// question.
const TRIALS: usize = 30;

/// Where a beam ended, and its way there.
type Point = ([f64; 2], [f64; 2]);

/// Points that beams met.
#[derive(Clone, Debug, Default)]
pub struct Points {
    met: Vec<Point>,
}

impl Points {
    /// Adds a point that a beam of this direction met.
    pub fn add(&mut self, at_m: [f64; 2], beam: [f64; 2]) {
        self.met.push((at_m, beam));
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.met.len()
    }

    /// Offset and direction of the normal, which points along the beams: of lines through two of the points that with the
    /// least median distance (Rousseeuw 1984), then least squares across it of the half that is nearest.
    pub fn line(&self) -> (f64, f64) {
        let all = self.met.len();
        let trials = (0..TRIALS.min(all)).map(|trial| {
            let first = trial * all / TRIALS.min(all);
            let pair = [self.met[first], self.met[(first + all / 3) % all]];
            self.nearest_half(fit(&pair))
        });
        let best = trials.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(|| self.met.clone(), |(_, half)| half);
        fit(&best)
    }

    /// The median distance from a line, and the half of the points that is nearer.
    fn nearest_half(&self, (rho_m, beta): (f64, f64)) -> (f64, Vec<Point>) {
        let (s, c) = beta.sin_cos();
        let off_m = |(at_m, _): &Point| (at_m[0] * c + at_m[1] * s - rho_m).abs();
        let mut points = self.met.clone();
        points.sort_by(|a, b| off_m(a).total_cmp(&off_m(b)));
        points.truncate(points.len().div_ceil(2));
        (points.last().map_or(0.0, off_m), points)
    }
}

fn fit(points: &[Point]) -> (f64, f64) {
    let n = points.len().max(1) as f64;
    let mean = [0, 1].map(|axis| points.iter().map(|(at_m, _)| at_m[axis]).sum::<f64>() / n);
    let moment =
        |a: usize, b: usize| points.iter().map(|(at_m, _)| (at_m[a] - mean[a]) * (at_m[b] - mean[b])).sum::<f64>() / n;
    let along = 0.5 * (2.0 * moment(0, 1)).atan2(moment(0, 0) - moment(1, 1));
    let beta = along + FRAC_PI_2;
    let (s, c) = beta.sin_cos();
    let faces = points.iter().map(|(_, beam)| beam[0] * c + beam[1] * s).sum::<f64>() > 0.0;
    let beta = if faces { beta } else { along - FRAC_PI_2 };
    (mean[0] * beta.cos() + mean[1] * beta.sin(), wrap(beta))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_the_points_on_something_else_does_not_turn_it() {
        let mut points = Points::default();
        for i in 0..60 {
            let t = 0.05 * f64::from(i);
            points.add([t, 2.0 + 0.01 * f64::from(i % 3)], [0.0, 1.0]);
            if i % 2 == 0 {
                points.add([-1.0, 2.0 - t], [-1.0, 0.0]);
            }
        }
        let (rho_m, beta_rad) = points.line();
        assert!((rho_m - 2.01).abs() < 0.01 && (beta_rad - FRAC_PI_2).abs() < 0.01, "{rho_m} m, {beta_rad}");
    }
}
