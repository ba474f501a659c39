//! How well visits of one place agree, whatever the map says: by surfels, flat pieces of surface as one visit saw them.
//!
//! A wall of the final map may have moved away from the readings that made it, and two visits that lie far apart may have
//! two walls. Surfels need no wall: each is compared with the ones that other visits saw nearest to it along its normal.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::hits::Hit;
use super::passes::APART_S;
use crate::evaluate::statistics::{median, quantile};
use crate::recording::{Recording, SurfelScore};

/// Side of the cells that end points are gathered in, metres.
const CELL_M: f64 = 0.5;

/// Fewer points are no surfel.
const POINTS: usize = 5;

/// Standard deviation across a surfel, at most, metres: more is a corner, or clutter.
const FLAT_M: f64 = 0.06;

/// Standard deviation along it, at least, metres: about a third of a metre from end to end.
const LONG_M: f64 = 0.09;

/// Share of the beams that must have come from the same side.
const SAME_SIDE: f64 = 0.9;

/// Surfels whose normals are within this cosine (15 degrees) may be of one surface.
const PARALLEL_COS: f64 = 0.966;

/// And if their centres are this near along the surface, metres,
const BESIDE_M: f64 = 0.3;

/// and this near along the normal, metres.
const REACH_M: f64 = 1.0;

/// From here on two visits are counted as apart, metres.
const WIDE_M: f64 = 0.15;

/// A flat piece of surface as one visit saw it.
#[derive(Clone, Copy, Debug)]
struct Surfel {
    t_s: f64,
    at_m: [f64; 2],
    /// Unit normal; points away from the side that it was seen from.
    normal: [f64; 2],
}

/// Scores how far visits are apart; none where no place was seen twice.
pub fn score(recording: &Recording, hits: &[Hit]) -> Option<SurfelScore> {
    let surfels = surfels(recording, hits);
    let apart_m: Vec<f64> = surfels.iter().filter_map(|surfel| apart_m(surfel, &surfels)).collect();
    let wide = apart_m.iter().filter(|value| **value > WIDE_M).count();
    Some(SurfelScore {
        found: surfels.len(),
        compared: apart_m.len(),
        median_m: median(&apart_m)?,
        p90_m: quantile(&apart_m, 0.9)?,
        wide_share: wide as f64 / apart_m.len() as f64,
    })
}

fn surfels(recording: &Recording, hits: &[Hit]) -> Vec<Surfel> {
    let mut cells: HashMap<[i64; 2], Vec<&Hit>> = HashMap::new();
    for hit in hits {
        cells.entry(hit.at_m.map(|coordinate| (coordinate / CELL_M).floor() as i64)).or_default().push(hit);
    }
    let t_s = |hit: &Hit| recording.steps[hit.step].t_s;
    let visits = cells.values().flat_map(|cell| cell.chunk_by(|a, b| t_s(b) - t_s(a) <= APART_S));
    let mut surfels: Vec<Surfel> = visits.filter_map(|visit| surfel(visit, t_s)).collect();
    // Cells come in no order.
    surfels.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    surfels
}

/// The flat piece that the points of one visit of a cell make; none where they make none.
fn surfel(points: &[&Hit], t_s: impl Fn(&Hit) -> f64) -> Option<Surfel> {
    if points.len() < POINTS {
        return None;
    }
    let n = points.len() as f64;
    let at_m = [0, 1].map(|axis| points.iter().map(|hit| hit.at_m[axis]).sum::<f64>() / n);
    let moment = |a: usize, b: usize| {
        points.iter().map(|hit| (hit.at_m[a] - at_m[a]) * (hit.at_m[b] - at_m[b])).sum::<f64>() / (n - 1.0)
    };
    let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
    let (middle, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    if middle - half > FLAT_M * FLAT_M || middle + half < LONG_M * LONG_M {
        return None;
    }
    // The normal is across the longer axis.
    let (s, c) = (0.5 * (2.0 * xy).atan2(xx - yy) + 0.25 * TAU).sin_cos();
    let from_front = points.iter().filter(|hit| dot(hit.direction, [c, s]) > 0.0).count() as f64 / n;
    let normal = if from_front > 0.5 { [c, s] } else { [-c, -s] };
    let one_sided = from_front.max(1.0 - from_front) >= SAME_SIDE;
    one_sided.then(|| Surfel { t_s: points.iter().map(|hit| t_s(hit)).sum::<f64>() / n, at_m, normal })
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// How far from a surfel the visit that differs most saw its surface; none where no other visit saw it.
fn apart_m(own: &Surfel, surfels: &[Surfel]) -> Option<f64> {
    let same = surfels.iter().filter_map(|other| {
        let offset = [other.at_m[0] - own.at_m[0], other.at_m[1] - own.at_m[1]];
        let (behind_m, along_m) = (dot(offset, own.normal), dot(offset, [-own.normal[1], own.normal[0]]));
        let is_same = (other.t_s - own.t_s).abs() > APART_S
            && dot(own.normal, other.normal) > PARALLEL_COS
            && along_m.abs() < BESIDE_M
            && behind_m.abs() < REACH_M;
        is_same.then_some((other.t_s, behind_m.abs()))
    });
    let same: Vec<(f64, f64)> = same.collect();
    let visits = same.chunk_by(|a, b| b.0 - a.0 <= APART_S);
    let nearest = visits.filter_map(|visit| visit.iter().map(|(_, apart_m)| *apart_m).min_by(f64::total_cmp));
    nearest.max_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Step;

    /// A visit at `t_s` of a wall along x, 2 m long, at y(x), seen from below.
    fn visit(recording: &mut Recording, hits: &mut Vec<Hit>, t_s: f64, y_m: impl Fn(f64) -> f64) {
        for i in 0..100 {
            let x = 0.02 * f64::from(i);
            hits.push(Hit { step: recording.steps.len(), at_m: [x, y_m(x)], direction: [0.0, 1.0] });
            recording.steps.push(Step { t_s: t_s + 0.01 * f64::from(i), ..Step::default() });
        }
    }

    fn scored(visits: &[(f64, &dyn Fn(f64) -> f64)]) -> Option<SurfelScore> {
        let (mut recording, mut hits) = (Recording::default(), Vec::new());
        for (t_s, y_m) in visits {
            visit(&mut recording, &mut hits, *t_s, y_m);
        }
        score(&recording, &hits)
    }

    #[test]
    fn two_visits_of_one_wall_are_as_far_apart_as_they_are() {
        let found = scored(&[(0.0, &|_| 0.1), (100.0, &|_| 0.12)]).expect("seen twice");
        assert_eq!((found.found, found.compared, found.wide_share), (8, 8, 0.0));
        assert!((found.median_m - 0.02).abs() < 1e-9 && (found.p90_m - 0.02).abs() < 1e-9, "{found:?}");
        let found = scored(&[(0.0, &|_| 0.1), (100.0, &|_| 0.8)]).expect("seen twice");
        assert!((found.median_m - 0.7).abs() < 1e-9 && found.wide_share == 1.0, "{found:?}");
    }

    #[test]
    fn of_three_visits_the_one_that_differs_most_counts() {
        let found = scored(&[(0.0, &|_| 0.1), (100.0, &|_| 0.1), (200.0, &|_| 0.3)]).expect("seen often");
        assert!((found.median_m - 0.2).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn what_one_visit_saw_both_times_is_no_disagreement() {
        // A cupboard before half of the wall, there on both visits.
        let furnished = |x: f64| if x < 1.0 { 0.1 } else { 0.6 };
        let found = scored(&[(0.0, &furnished), (100.0, &furnished)]).expect("seen twice");
        assert!(found.p90_m < 1e-9, "{found:?}");
    }

    #[test]
    fn a_place_seen_once_and_a_rough_one_say_nothing() {
        assert_eq!(scored(&[(0.0, &|_| 0.1), (10.0, &|_| 0.4)]), None);
        let rough = |x: f64| 0.25 + 0.2 * (40.0 * x).sin();
        assert_eq!(scored(&[(0.0, &rough), (100.0, &rough)]), None);
    }
}
