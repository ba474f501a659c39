//! How well the visits of a wall agree: how far apart they see it, how thick it gets, and whether the last visit closes on
//! the first.
//!
//! A wall that is twice in the map must not hide how far apart the two copies are: the nearer copy would take every reading
//! that is off. So each wall is judged by *all* readings in front of it and behind it up to [`REACH_M`] that faced it and
//! did not end on a wall of another direction. What stands there beside the wall (a cupboard, an ajar door's leaf) is kept
//! out in two ways: visits are compared only over the stretches of the wall that both saw, and a visit's place is the mean
//! of its densest band of points.

use std::collections::BTreeSet;

use slam_core::WallView;

use super::hits::{Hit, by_dead_reckoning, by_estimate};
use super::map::segment_of;
use crate::evaluate::statistics::mean;
use crate::recording::{Pose2, Recording, SeenWall, Segment, Visit};

/// Two visits of a wall are different ones when this much time lies between them, seconds.
pub const APART_S: f64 = 30.0;

/// Points farther from a wall are not its own, metres. A drift of half a metre must show; what stands deeper than a wardrobe
/// behind a wall's line, seen through a door, is another wall.
const REACH_M: f64 = 0.6;

/// A wall may go on so far unseen, metres: less than a door is wide. At a corner the points there are not the other wall's.
const CORNER_M: f64 = 0.4;

/// A beam meets a wall's face when the cosine of its incidence is more than this (78 degrees).
const FACING_COS: f64 = 0.2;

/// Walls whose normals are within this cosine (15 degrees) may be one and the same.
const PARALLEL_COS: f64 = 0.966;

/// Visits are compared where both saw the same stretch of the wall, in pieces of this length, metres.
const STRETCH_M: f64 = 0.25;

/// And where they share this many of them: past one end of a wall, two visits may see different things behind it.
const STRETCHES: usize = 2;

/// Width of the band that holds most of a visit's points, metres: ten centimetres of noise either side and a slant.
const BAND_M: f64 = 0.3;

/// A visit with fewer points has no mean worth comparing.
const VISIT_POINTS: usize = 5;

/// Every wall of the final map that readings met, in the order of the map.
pub fn walls_seen(recording: &Recording) -> Vec<SeenWall> {
    let (estimate, odometry) = (by_estimate(recording), by_dead_reckoning(recording));
    let faces: Vec<Face> = recording.walls().iter().filter_map(Face::of).collect();
    let points = points_of(&faces, &estimate);
    let judge = |(face, points): (&Face, Vec<Point>)| Judge { recording, face, odometry: &odometry }.judge(&points);
    faces.iter().zip(points).filter_map(judge).collect()
}

/// One end point as a wall sees it.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Index of the hit.
    hit: usize,
    /// Index into [`Recording::steps`].
    step: usize,
    /// Which stretch of the wall it lies in.
    stretch: i64,
    /// Distance behind the wall's line, metres.
    behind_m: f64,
}

/// The index of a face that a hit may be on, and where: along it and behind it, metres.
type Met = (usize, [f64; 2]);

/// The points of each face, in order of time.
fn points_of(faces: &[Face], hits: &[Hit]) -> Vec<Vec<Point>> {
    let mut points = vec![Vec::new(); faces.len()];
    for (index, hit) in hits.iter().enumerate() {
        let met: Vec<Met> = faces.iter().enumerate().filter_map(|(i, face)| Some((i, face.meets(hit)?))).collect();
        let is_within = |(i, [along_m, _]): &Met| (0.0..=faces[*i].length_m).contains(along_m);
        for &(i, [along_m, behind_m]) in met.iter().filter(|met| is_within(met)) {
            let is_parallel = |j: usize| dot(faces[i].normal, faces[j].normal) > PARALLEL_COS;
            let nearest_m = |of: &dyn Fn(&Met) -> bool| {
                met.iter().filter(|met| of(met)).map(|(_, [_, behind_m])| behind_m.abs()).fold(f64::INFINITY, f64::min)
            };
            let own_m = nearest_m(&|met| is_parallel(met.0) && is_within(met));
            if own_m <= nearest_m(&|met| !is_parallel(met.0)) {
                let stretch = (along_m / STRETCH_M).floor() as i64;
                points[i].push(Point { hit: index, step: hit.step, stretch, behind_m });
            }
        }
    }
    points
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// A mapped wall as a frame: along it and behind it.
struct Face {
    wall: u16,
    from_m: [f64; 2],
    /// Points away from the side that it is seen from.
    normal: [f64; 2],
    length_m: f64,
}

impl Face {
    fn of(wall: &WallView) -> Option<Self> {
        let Segment { from_m, to_m } = segment_of(wall, &Pose2::default());
        let length_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
        let (s, c) = f64::from(wall.beta_rad).sin_cos();
        (length_m > 0.0).then_some(Self { wall: wall.id, from_m, normal: [c, s], length_m })
    }

    /// Along the wall from its first end, and behind it, metres.
    fn local(&self, point_m: [f64; 2]) -> [f64; 2] {
        let offset = [point_m[0] - self.from_m[0], point_m[1] - self.from_m[1]];
        [dot(offset, [-self.normal[1], self.normal[0]]), dot(offset, self.normal)]
    }

    /// Where a hit that may be the wall's own, or of its prolongation, lies; none where it is not.
    fn meets(&self, hit: &Hit) -> Option<[f64; 2]> {
        let [along_m, behind_m] = self.local(hit.at_m);
        let near = behind_m.abs() <= REACH_M && (-CORNER_M..=self.length_m + CORNER_M).contains(&along_m);
        (near && dot(hit.direction, self.normal) > FACING_COS).then_some([along_m, behind_m])
    }
}

/// What a wall's visits are judged with.
struct Judge<'a> {
    recording: &'a Recording,
    face: &'a Face,
    odometry: &'a [Hit],
}

impl Judge<'_> {
    /// None where there are too few points to judge by.
    fn judge(&self, points: &[Point]) -> Option<SeenWall> {
        let visits: Vec<&[Point]> = self.visits(points).filter(|visit| visit.len() >= VISIT_POINTS).collect();
        let bands: Vec<Vec<f64>> = visits.iter().map(|visit| densest(visit.iter().map(|p| p.behind_m))).collect();
        let all: Vec<f64> = bands.iter().flatten().copied().collect();
        let centre_m = mean(&all)?;
        let squares = all.iter().map(|behind_m| (behind_m - centre_m).powi(2)).sum::<f64>();
        let pairs = visits.iter().enumerate().flat_map(|(i, a)| visits[i + 1..].iter().map(move |b| (*a, *b)));
        let gaps = pairs.filter_map(|(a, b)| apart_m(a, b, |point| point.behind_m).map(f64::abs));
        let closure = (visits.len() > 1).then(|| self.closure_m(visits[0], visits[visits.len() - 1])).flatten();
        Some(SeenWall {
            wall: self.face.wall,
            readings: all.len(),
            thickness_m: (squares / all.len() as f64).sqrt(),
            gap_m: gaps.max_by(f64::total_cmp),
            closure_m: closure.map(|(estimate_m, _)| estimate_m),
            odometry_closure_m: closure.map(|(_, odometry_m)| odometry_m),
            visits: visits.iter().zip(&bands).map(|(visit, band)| self.visit(visit, band)).collect(),
        })
    }

    fn visits<'p>(&self, points: &'p [Point]) -> impl Iterator<Item = &'p [Point]> {
        points.chunk_by(|a, b| self.t_s(b) - self.t_s(a) <= APART_S)
    }

    fn t_s(&self, point: &Point) -> f64 {
        self.recording.steps[point.step].t_s
    }

    fn visit(&self, points: &[Point], band: &[f64]) -> Visit {
        let (first, last) = (points.first(), points.last());
        Visit {
            begin_s: first.map_or(0.0, |point| self.t_s(point)),
            end_s: last.map_or(0.0, |point| self.t_s(point)),
            readings: points.len(),
            mean_m: mean(band).unwrap_or(0.0),
        }
    }

    /// How far the last visit sees the wall behind where the first one saw it: by the estimate, and where dead reckoning
    /// would have put it that set out at the first visit.
    fn closure_m(&self, first: &[Point], last: &[Point]) -> Option<(f64, f64)> {
        let step = &self.recording.steps[first[first.len() / 2].step];
        // From dead reckoning's frame to the map's, as they lay to each other then.
        let back = step.pose.compose(&step.dead_reckoning.relative(&Pose2::default()));
        let by_odometry = |point: &Point| self.face.local(back.transform(self.odometry[point.hit].at_m))[1];
        let estimate_m = apart_m(first, last, |point| point.behind_m)?;
        Some((estimate_m, apart_m(first, last, by_odometry)?))
    }
}

/// How far visit `b` sees the wall behind where `a` sees it, over the stretches that both saw; none where these are few.
fn apart_m(a: &[Point], b: &[Point], behind_m: impl Fn(&Point) -> f64) -> Option<f64> {
    let stretches = |points: &[Point]| points.iter().map(|point| point.stretch).collect::<BTreeSet<i64>>();
    let shared: BTreeSet<i64> = stretches(a).intersection(&stretches(b)).copied().collect();
    if shared.len() < STRETCHES {
        return None;
    }
    let place = |points: &[Point]| {
        let band = densest(points.iter().filter(|point| shared.contains(&point.stretch)).map(&behind_m));
        (band.len() >= VISIT_POINTS).then(|| mean(&band)).flatten()
    };
    Some(place(b)? - place(a)?)
}

/// The values in the band of [`BAND_M`] that holds most of them.
fn densest(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let mut best = 0..0;
    let mut end = 0;
    for begin in 0..values.len() {
        while end < values.len() && values[end] - values[begin] <= BAND_M {
            end += 1;
        }
        if end - begin > best.len() {
            best = begin..end;
        }
    }
    values[best].to_vec()
}

#[cfg(test)]
mod tests;
