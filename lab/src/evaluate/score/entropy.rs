//! Mean map entropy: how sharp the picture is that all end points make together.
//!
//! Droeschel, Stueckler and Behnke 2014: the mean over the points of 1/2 ln |2 pi e S|, S the covariance of the points
//! within [`RADIUS_M`].

use std::collections::HashMap;

use super::hits::Hit;

/// Radius of the neighbourhood whose entropy is taken, metres.
pub const RADIUS_M: f64 = 0.4;

/// Points with fewer neighbours say nothing about entropy.
const NEIGHBOURS: usize = 5;

/// Standard deviation that no neighbourhood goes below, metres: a perfect line has no entropy to take.
const FLOOR_M: f64 = 0.001;

/// Most points whose neighbourhood is looked at; the neighbours are all points.
const SAMPLED: usize = 8000;

/// Step from one of these points to the next: a prime, so that no sensor is left out.
const STRIDE: usize = 7919;

/// Mean map entropy, nats; none where no point has neighbours.
pub fn mean_nats(hits: &[Hit]) -> Option<f64> {
    let cell = |at_m: [f64; 2]| at_m.map(|coordinate| (coordinate / RADIUS_M).floor() as i64);
    let mut cells: HashMap<[i64; 2], Vec<[f64; 2]>> = HashMap::new();
    for hit in hits {
        cells.entry(cell(hit.at_m)).or_default().push(hit.at_m);
    }
    let sampled: Box<dyn Iterator<Item = usize>> = match hits.len() {
        n if n <= SAMPLED => Box::new(0..n),
        n => Box::new((0..SAMPLED).map(move |i| i * STRIDE % n)),
    };
    let mut near: Vec<[f64; 2]> = Vec::new();
    let entropies: Vec<f64> = sampled
        .filter_map(|i| {
            let at_m = hits[i].at_m;
            let [column, row] = cell(at_m);
            let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [column + dx, row + dy]));
            let points = around.filter_map(|key| cells.get(&key)).flatten();
            near.clear();
            near.extend(points.filter(|other| {
                let [x, y] = [other[0] - at_m[0], other[1] - at_m[1]];
                x * x + y * y <= RADIUS_M * RADIUS_M
            }));
            of(&near)
        })
        .collect();
    (!entropies.is_empty()).then(|| entropies.iter().sum::<f64>() / entropies.len() as f64)
}

fn of(points: &[[f64; 2]]) -> Option<f64> {
    if points.len() < NEIGHBOURS {
        return None;
    }
    let n = points.len() as f64;
    let [x, y] = points.iter().fold([0.0; 2], |[x, y], point| [x + point[0], y + point[1]]).map(|sum| sum / n);
    let moments = points.iter().fold([0.0; 3], |[xx, xy, yy], point| {
        let [dx, dy] = [point[0] - x, point[1] - y];
        [xx + dx * dx, xy + dx * dy, yy + dy * dy]
    });
    let [xx, xy, yy] = moments.map(|sum| sum / (n - 1.0));
    let floor_m2 = FLOOR_M * FLOOR_M;
    let (xx, yy) = (xx + floor_m2, yy + floor_m2);
    let tau_e = std::f64::consts::TAU * std::f64::consts::E;
    Some(0.5 * (tau_e * tau_e * (xx * yy - xy * xy)).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(offset_m: f64) -> Vec<Hit> {
        let along = (0..200).map(|i| 0.01 * f64::from(i));
        along.map(|x| Hit { step: 0, at_m: [x, offset_m * (37.0 * x).sin()], direction: [0.0, 1.0] }).collect()
    }

    #[test]
    fn entropy_of_a_known_spread_is_the_formulas() {
        // Variances 1/3 and 1/12 of a uniform grid over 2 x 1, uncorrelated.
        let points: Vec<[f64; 2]> =
            (0..100).flat_map(|i| (0..100).map(move |j| [0.02 * f64::from(i), 0.01 * f64::from(j)])).collect();
        let expected = 0.5 * ((std::f64::consts::TAU * std::f64::consts::E).powi(2) / 36.0).ln();
        let found = of(&points).expect("enough points");
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }

    #[test]
    fn a_thicker_wall_has_more_entropy() {
        let thin = mean_nats(&line(0.01)).expect("points");
        let thick = mean_nats(&line(0.1)).expect("points");
        assert!(thick > thin + 1.0, "{thin} {thick}");
        assert_eq!(mean_nats(&[]), None);
    }

    #[test]
    fn a_sample_of_many_points_has_the_entropy_of_them_all() {
        // Eight sensors in turn, each with a wall of its own roughness.
        let hits: Vec<Hit> = (0..40_000u32)
            .map(|i| {
                let rough_m = 0.005 * f64::from(i % 8);
                let x = 0.000_1 * f64::from(i);
                let at_m = [x, 2.0 * f64::from(i % 8) + rough_m * (37.0 * x).sin()];
                Hit { step: 0, at_m, direction: [0.0, 1.0] }
            })
            .collect();
        let found = mean_nats(&hits).expect("points");
        let each: Vec<f64> = (0..8)
            .map(|sensor| {
                let own: Vec<Hit> = hits.iter().skip(sensor).step_by(8).copied().collect();
                mean_nats(&own).expect("points")
            })
            .collect();
        let expected = each.iter().sum::<f64>() / 8.0;
        assert!((found - expected).abs() < 0.01, "{found} {expected}");
    }
}
