//! How well a map agrees with itself: scores that need no truth.
//!
//! Every reading's end point is projected with the pose of one path, the estimate's or dead reckoning's. Where the path is
//! right, points of one wall fall on one line, however often the robot came by.

use std::collections::{BTreeMap, HashMap};

use slam_core::WallView;

use crate::recording::{Consistency, Pose2, Recording, Segment, Step};
use crate::score::map::segment_of;

/// Radius of the neighbourhood whose entropy is taken, metres.
const RADIUS_M: f64 = 0.4;

/// Points with fewer neighbours say nothing about entropy.
const NEIGHBOURS: usize = 5;

/// Standard deviation that no neighbourhood goes below, metres: a perfect line has no entropy to take.
const FLOOR_M: f64 = 0.001;

/// Most points whose neighbourhood is looked at; the neighbours are all points.
const SAMPLED: usize = 4000;

/// Two visits of a wall are different ones when this much time lies between them, seconds.
const APART_S: f64 = 30.0;

/// Points farther from a wall are not its own, metres.
const REACH_M: f64 = 0.4;

/// A visit with fewer points has no mean worth comparing.
const VISIT_POINTS: usize = 5;

/// One reading's end point.
#[derive(Clone, Copy, Debug)]
struct Hit {
    t_s: f64,
    /// In the frame of the path that it was projected with, metres.
    at_m: [f64; 2],
    /// Where the beam began, in the same frame.
    from_m: [f64; 2],
}

/// Scores the record's map against itself; none where there are no readings.
pub fn score(recording: &Recording) -> Option<Consistency> {
    let estimate = hits(recording, |step| step.pose);
    let odometry = hits(recording, |step| step.dead_reckoning);
    let faces = faces_of(recording, &estimate);
    let gaps_m: Vec<f64> = faces.iter().filter(|face| face.visits > 1).map(|face| face.gap_m).collect();
    Some(Consistency {
        entropy_nats: mean_entropy_nats(&estimate)?,
        odometry_entropy_nats: mean_entropy_nats(&odometry)?,
        revisited: gaps_m.len(),
        widest_gap_m: gaps_m.iter().copied().fold(0.0, f64::max),
        mean_gap_m: if gaps_m.is_empty() { 0.0 } else { gaps_m.iter().sum::<f64>() / gaps_m.len() as f64 },
    })
}

fn hits(recording: &Recording, path: fn(&Step) -> Pose2) -> Vec<Hit> {
    let mut hits = Vec::new();
    for (i, step) in recording.steps.iter().enumerate() {
        let pose = path(step);
        for (sensor, reading) in recording.sensors.iter().zip(recording.readings(i)) {
            let Some(range_m) = reading.range_m.map(f64::from) else { continue };
            let (s, c) = sensor.bearing_rad.sin_cos();
            let at_m = pose.transform([sensor.x_m + range_m * c, sensor.y_m + range_m * s]);
            hits.push(Hit { t_s: step.t_s, at_m, from_m: pose.transform([sensor.x_m, sensor.y_m]) });
        }
    }
    hits
}

/// Mean map entropy (Droeschel, Stueckler and Behnke 2014): the mean over the points of 1/2 ln |2 pi e S|, S the covariance
/// of the points within [`RADIUS_M`].
fn mean_entropy_nats(hits: &[Hit]) -> Option<f64> {
    let cell = |at_m: [f64; 2]| at_m.map(|coordinate| (coordinate / RADIUS_M).floor() as i64);
    let mut cells: HashMap<[i64; 2], Vec<[f64; 2]>> = HashMap::new();
    for hit in hits {
        cells.entry(cell(hit.at_m)).or_default().push(hit.at_m);
    }
    let stride = hits.len().div_ceil(SAMPLED).max(1);
    let entropies: Vec<f64> = hits
        .iter()
        .step_by(stride)
        .filter_map(|hit| {
            let [column, row] = cell(hit.at_m);
            let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [column + dx, row + dy]));
            let near = around.filter_map(|key| cells.get(&key)).flatten();
            entropy_nats(near.filter(|at_m| (at_m[0] - hit.at_m[0]).hypot(at_m[1] - hit.at_m[1]) <= RADIUS_M))
        })
        .collect();
    (!entropies.is_empty()).then(|| entropies.iter().sum::<f64>() / entropies.len() as f64)
}

fn entropy_nats<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> Option<f64> {
    let points: Vec<&[f64; 2]> = points.collect();
    if points.len() < NEIGHBOURS {
        return None;
    }
    let n = points.len() as f64;
    let mean = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / n);
    let moment = |a: usize, b: usize| {
        points.iter().map(|point| (point[a] - mean[a]) * (point[b] - mean[b])).sum::<f64>() / (n - 1.0)
    };
    let floor_m2 = FLOOR_M * FLOOR_M;
    let (xx, xy, yy) = (moment(0, 0) + floor_m2, moment(0, 1), moment(1, 1) + floor_m2);
    let tau_e = std::f64::consts::TAU * std::f64::consts::E;
    Some(0.5 * (tau_e * tau_e * (xx * yy - xy * xy)).ln())
}

/// One face of a mapped wall as the readings saw it: the two faces of a thin wall are two walls, and points are kept apart
/// by the side from which they were seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Identifier of the wall.
    pub wall: u16,
    /// Readings that ended nearer to it than to any other wall.
    pub readings: usize,
    /// RMS of their distances from its line, metres.
    pub thickness_m: f64,
    /// Visits more than 30 s apart.
    pub visits: usize,
    /// Distance between the farthest two visits' mean positions along the normal, metres; 0 for fewer than two visits.
    pub gap_m: f64,
}

/// The faces of the mapped walls, in the order of the map.
pub fn faces(recording: &Recording) -> Vec<Face> {
    faces_of(recording, &hits(recording, |step| step.pose))
}

fn faces_of(recording: &Recording, hits: &[Hit]) -> Vec<Face> {
    let walls: Vec<(u16, Line)> =
        recording.walls().iter().filter_map(|wall| Some((wall.id, Line::of(wall)?))).collect();
    let mut seen: BTreeMap<(usize, bool), Vec<(f64, f64)>> = BTreeMap::new();
    for hit in hits {
        let own = walls.iter().enumerate().filter_map(|(i, (_, line))| Some((i, line.aside_m(hit.at_m)?)));
        if let Some((i, aside_m)) = own.min_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) {
            let is_left = walls[i].1.local(hit.from_m)[1] > 0.0;
            seen.entry((i, is_left)).or_default().push((hit.t_s, aside_m));
        }
    }
    seen.iter().map(|((i, _), timed)| face(walls[*i].0, timed)).collect()
}

fn face(wall: u16, timed: &[(f64, f64)]) -> Face {
    let means = visit_means_m(timed.iter().copied());
    let (lo, hi) = means.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), m| (lo.min(*m), hi.max(*m)));
    let squares: f64 = timed.iter().map(|(_, aside_m)| aside_m * aside_m).sum();
    Face {
        wall,
        readings: timed.len(),
        thickness_m: (squares / timed.len() as f64).sqrt(),
        visits: means.len(),
        gap_m: if means.len() > 1 { hi - lo } else { 0.0 },
    }
}

/// A mapped wall as a frame: along it and, to the left, across it.
struct Line {
    from_m: [f64; 2],
    along: [f64; 2],
    length_m: f64,
}

impl Line {
    fn of(wall: &WallView) -> Option<Self> {
        let Segment { from_m, to_m } = segment_of(wall, &Pose2::default());
        let length_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
        let along = [(to_m[0] - from_m[0]) / length_m, (to_m[1] - from_m[1]) / length_m];
        (length_m > 0.0).then_some(Self { from_m, along, length_m })
    }

    fn local(&self, point_m: [f64; 2]) -> [f64; 2] {
        let offset = [point_m[0] - self.from_m[0], point_m[1] - self.from_m[1]];
        let forward_m = offset[0] * self.along[0] + offset[1] * self.along[1];
        [forward_m, offset[1] * self.along[0] - offset[0] * self.along[1]]
    }

    /// Distance to the left of a point that may be the wall's own; none where it is not.
    fn aside_m(&self, point_m: [f64; 2]) -> Option<f64> {
        let [forward_m, aside_m] = self.local(point_m);
        ((0.0..=self.length_m).contains(&forward_m) && aside_m.abs() <= REACH_M).then_some(aside_m)
    }
}

/// The mean of each visit's values; `timed` are (time, value), in order of time.
fn visit_means_m(timed: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    let mut visits: Vec<Vec<f64>> = Vec::new();
    let mut last_s = f64::NEG_INFINITY;
    for (t_s, value_m) in timed {
        if t_s - last_s > APART_S {
            visits.push(Vec::new());
        }
        last_s = t_s;
        if let Some(visit) = visits.last_mut() {
            visit.push(value_m);
        }
    }
    let long = visits.iter().filter(|visit| visit.len() >= VISIT_POINTS);
    long.map(|visit| visit.iter().sum::<f64>() / visit.len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(offset_m: f64) -> Vec<Hit> {
        let along = (0..200).map(|i| 0.01 * f64::from(i));
        along.map(|x| Hit { t_s: x, at_m: [x, offset_m * (37.0 * x).sin()], from_m: [x, 1.0] }).collect()
    }

    #[test]
    fn entropy_of_a_known_spread_is_the_formulas() {
        // Variances 1/3 and 1/12 of a uniform grid over 2 x 1, uncorrelated.
        let points: Vec<[f64; 2]> =
            (0..100).flat_map(|i| (0..100).map(move |j| [0.02 * f64::from(i), 0.01 * f64::from(j)])).collect();
        let expected = 0.5 * ((std::f64::consts::TAU * std::f64::consts::E).powi(2) / 36.0).ln();
        let found = entropy_nats(points.iter()).expect("enough points");
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }

    #[test]
    fn a_thicker_wall_has_more_entropy() {
        let thin = mean_entropy_nats(&line(0.01)).expect("points");
        let thick = mean_entropy_nats(&line(0.1)).expect("points");
        assert!(thick > thin + 1.0, "{thin} {thick}");
        assert_eq!(mean_entropy_nats(&[]), None);
    }

    #[test]
    fn a_face_has_a_thickness_and_a_gap_between_its_visits() {
        let visit = |from_s: f64, value: f64| (0..10).map(move |i| (from_s + f64::from(i), value));
        let timed: Vec<_> = visit(0.0, 0.1).chain(visit(100.0, -0.1)).collect();
        let found = face(7, &timed);
        assert_eq!((found.wall, found.readings, found.visits), (7, 20, 2));
        assert!((found.thickness_m - 0.1).abs() < 1e-12 && (found.gap_m - 0.2).abs() < 1e-12, "{found:?}");
        assert_eq!(face(7, &timed[..10]).gap_m, 0.0);
    }

    #[test]
    fn visits_are_told_apart_by_time() {
        let visit = |from_s: f64, value: f64| (0..10).map(move |i| (from_s + f64::from(i), value));
        let means = visit_means_m(visit(0.0, 0.1).chain(visit(15.0, 0.3)).chain(visit(100.0, 0.4)));
        assert_eq!(means.len(), 2);
        assert!((means[0] - 0.2).abs() < 1e-12 && (means[1] - 0.4).abs() < 1e-12);
        assert!(visit_means_m(visit(0.0, 0.1).take(4)).is_empty());
    }
}
