//! Lines through the points of a window: total least squares with its covariance, and splitting of a chain of points.

use nalgebra::{Matrix2, Vector2};

use crate::geometry::{Line, Point, unit, wrap};
use crate::window::{Seen, Window};

/// A line through points, in the robot's frame.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The line; its distance is not negative, so that its normal points from the robot to the wall.
    pub line: Line,
    /// Covariance of (rho, a).
    pub covariance: Matrix2<f64>,
    /// RMS distance of the points from it, metres.
    pub rms: f64,
    /// From where to where along the tangent, metres.
    pub extent: [f64; 2],
    /// Places of the points in the window.
    pub points: Vec<usize>,
}

impl Fit {
    /// Length of the stretch that was seen, metres.
    pub fn length(&self) -> f64 {
        self.extent[1] - self.extent[0]
    }

    /// The ends of the stretch that was seen.
    pub fn ends(&self) -> [Point; 2] {
        self.extent.map(|along| self.line.point(along))
    }
}

/// The line with the least sum of squared distances.
pub fn least_squares(points: impl Iterator<Item = Point> + Clone) -> Line {
    let n = points.clone().count().max(1) as f64;
    let mean = points.clone().fold(Point::zeros(), |sum, p| sum + p) / n;
    let [sxx, sxy, syy] = points.fold([0.0; 3], |[xx, xy, yy], p| {
        let d = p - mean;
        [xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y]
    });
    let a = 0.5 * (-2.0 * sxy).atan2(syy - sxx);
    Line { rho: mean.dot(&unit(a)), a }.facing()
}

/// The fit to these points of the window, with the covariance that theirs make.
pub fn fit(window: &Window, places: &[usize]) -> Fit {
    let seen: Vec<&Seen> = places.iter().filter_map(|i| window.points.get(*i)).collect();
    let line = least_squares(seen.iter().map(|seen| seen.at));
    let mut covariance = Matrix2::zeros();
    for (seen, by) in seen.iter().zip(derivatives(&seen, &line)) {
        covariance += by * seen.covariance() * by.transpose();
    }
    let along = seen.iter().map(|seen| line.along(seen.at));
    let extent = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], t| [lo.min(t), hi.max(t)]);
    let squares: f64 = seen.iter().map(|seen| line.beyond(seen.at).powi(2)).sum();
    let rms = (squares / seen.len().max(1) as f64).sqrt();
    Fit { line, covariance, rms, extent, points: places.to_vec() }
}

/// d(rho, a) by each point.
fn derivatives(seen: &[&Seen], line: &Line) -> Vec<Matrix2<f64>> {
    let n = seen.len().max(1) as f64;
    let mean = seen.iter().fold(Point::zeros(), |sum, seen| sum + seen.at) / n;
    let (mut numerator, mut denominator) = (0.0, 0.0);
    for d in seen.iter().map(|seen| seen.at - mean) {
        numerator -= 2.0 * d.x * d.y;
        denominator += d.y * d.y - d.x * d.x;
    }
    let scale = 1.0 / (numerator * numerator + denominator * denominator).max(1e-18);
    let along = line.along(mean);
    let by = |seen: &&Seen| {
        let d = seen.at - mean;
        let a = Vector2::new(
            scale * (denominator * -d.y + numerator * d.x),
            scale * (denominator * -d.x - numerator * d.y),
        );
        let rho = unit(line.a) / n + a * along;
        Matrix2::from_rows(&[rho.transpose(), a.transpose()])
    };
    seen.iter().map(by).collect()
}

/// What a chain of points must be for a line.
#[derive(Clone, Copy, Debug)]
pub struct Splitting {
    /// A point farther from the chord splits the chain, metres.
    pub split: f64,
    /// Neighbours farther apart split it, metres.
    pub gap: f64,
    /// Shortest line, metres.
    pub length: f64,
    /// Fewest points.
    pub points: usize,
    /// Largest RMS distance, metres.
    pub rms: f64,
}

/// Iterative end-point fit: every line of the window, beam by beam.
pub fn split(window: &Window, how: &Splitting) -> Vec<Fit> {
    let chains = (0..window.beams()).map(|beam| window.of_beam(beam));
    let mut fits = Vec::new();
    for chain in chains {
        let at = |i: usize| window.points[chain[i]].at;
        let breaks = (1..chain.len()).filter(|i| (at(*i) - at(i - 1)).norm() > how.gap);
        let ends: Vec<usize> = std::iter::once(0).chain(breaks).chain([chain.len()]).collect();
        for piece in ends.windows(2) {
            split_piece(window, &chain[piece[0]..piece[1]], how, &mut fits);
        }
    }
    fits
}

fn split_piece(window: &Window, chain: &[usize], how: &Splitting, fits: &mut Vec<Fit>) {
    if chain.len() < how.points.max(2) {
        return;
    }
    let at = |i: usize| window.points[chain[i]].at;
    let chord = at(chain.len() - 1) - at(0);
    let length = chord.norm().max(1e-9);
    let off = |i: usize| ((at(i) - at(0)).perp(&chord) / length).abs();
    let far = (1..chain.len() - 1).map(|i| (off(i), i)).fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a });
    if far.0 > how.split {
        split_piece(window, &chain[..=far.1], how, fits);
        split_piece(window, &chain[far.1..], how, fits);
        return;
    }
    let fit = fit(window, chain);
    if fit.length() >= how.length && fit.rms <= how.rms {
        fits.push(fit);
    }
}

/// The mean direction of walls modulo a quarter turn, each with its weight; none without any.
pub fn mean_quarter(angles: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (s, c) = angles.fold((0.0, 0.0), |(s, c), (a, w)| (s + w * (4.0 * a).sin(), c + w * (4.0 * a).cos()));
    (s != 0.0 || c != 0.0).then(|| 0.25 * s.atan2(c))
}

/// How far an angle is from the nearest quarter turn from `a`, radians.
pub fn off_quarter(angle: f64, a: f64) -> f64 {
    let quarter = std::f64::consts::FRAC_PI_2;
    let d = wrap(angle - a);
    d - quarter * (d / quarter).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(points: &[[f64; 2]]) -> Window {
        Window::of_points(points.iter().map(|at| (*at).into()), 0.02)
    }

    #[test]
    fn the_covariance_is_the_sum_over_displaced_points() {
        let points: Vec<[f64; 2]> = (0..9).map(|i| [0.2 * f64::from(i) - 0.5, 1.0 + 0.03 * f64::from(i % 3)]).collect();
        let places: Vec<usize> = (0..9).collect();
        let found = fit(&window(&points), &places);
        let mut expected = Matrix2::zeros();
        let step = 1e-5;
        for k in 0..points.len() {
            // Each reading longer and shorter, everything else as it was.
            let line = |sign: f64| {
                let mut moved = points.clone();
                let scale = 1.0 + sign * step / points[k][0].hypot(points[k][1]);
                moved[k] = moved[k].map(|v| v * scale);
                fit(&window(&moved), &places).line
            };
            let (up, down) = (line(1.0), line(-1.0));
            let d = Vector2::new(up.rho - down.rho, up.a - down.a) * (0.02 / (2.0 * step));
            expected += d * d.transpose();
        }
        assert!((found.covariance - expected).norm() < 1e-4 * expected.norm(), "{} {expected}", found.covariance);
    }

    #[test]
    fn a_corner_is_split_and_both_walls_found() {
        let wall = (0..20).map(|i| [0.05 * f64::from(i), 1.0]);
        let side = (0..20).map(|i| [0.95, 1.0 - 0.05 * f64::from(i)]);
        let points: Vec<[f64; 2]> = wall.chain(side).collect();
        let how = Splitting { split: 0.05, gap: 0.25, length: 0.3, points: 8, rms: 0.05 };
        let fits = split(&window(&points), &how);
        assert_eq!(fits.len(), 2, "{fits:?}");
        let quarter = std::f64::consts::FRAC_PI_2;
        assert!((fits[0].line.rho - 1.0).abs() < 1e-9 && (fits[0].line.a - quarter).abs() < 1e-6);
        assert!((fits[1].line.rho - 0.95).abs() < 0.01 && fits[1].line.a.abs() < 0.02);
    }

    #[test]
    fn quarters_are_averaged_over_the_wrap() {
        let mean = mean_quarter([0.02, 1.5508, -3.1016, 0.04].into_iter().map(|a| (a, 1.0))).expect("a mean");
        assert!(off_quarter(mean, 0.02).abs() < 0.011, "{mean}");
    }
}
