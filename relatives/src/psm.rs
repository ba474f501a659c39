//! Polar scan matching (Diosi and Kleeman 2005; numbers of its version 0.3, for near scans as it advises): turns by shifting ranges,
//! shifts by weighted least squares.
//!
//! Two slips of that code are not repeated: the weight does narrow after ten iterations, and the normal matrix is symmetric. Ours:
//! a range changes with a shift as the surface's slope says, where the source takes every surface to face its beam, which errs by
//! decimetres along corridors; and the covariance, which follows from the same derivatives.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use std::f64::consts::PI;

use crate::Dense;
use crate::geometry::{Point, Pose, perp, unit, wrap};

/// Neighbours farther apart are of two surfaces, metres.
const JUMP: f64 = 0.2;
/// Largest turn that one search covers, radians.
const TURN: f64 = 20.0 * PI / 180.0;
/// Residuals beyond this are not used, metres.
const OUTLIER: f64 = 0.3;
/// Squared residual at which a point counts half, m^2, and what it is divided by from this iteration on.
const WEIGHT: f64 = 0.09;
const NARROWER: f64 = 50.0;
const NARROW_FROM: usize = 10;
/// Corrections under this, in centimetres and degrees together, so many times in a row end the iterations.
const STOP: f64 = 0.4;
const STOPS: usize = 3;
const ITERATIONS: usize = 30;
/// Least share of the beams that two scans must have in common.
pub const VALID: f64 = 40.0 / 181.0;
/// Least 1-sigma of a range against another scan's, metres: a laser's.
const SIGMA: f64 = 0.01;
/// The sigma of a normal distribution over the median of its magnitude.
const NORMAL: f64 = 1.4826;
/// Readings that count as one: the median is of five.
const SHARED: f64 = 5.0;
/// 1-sigma of what a match cannot tell, metres and radians.
const UNKNOWN: f64 = 1.0;

/// A scan made ready: ranges in metres, zero where there is none, and the surface that each is of.
#[derive(Clone, Debug)]
pub struct Scan {
    first: f64,
    step: f64,
    ranges: Vec<f64>,
    surface: Vec<usize>,
}

/// Where a scan was taken, in the frame of the reference scan, and how sure.
#[derive(Clone, Copy, Debug)]
pub struct Matched {
    /// The pose.
    pub pose: Pose,
    /// Its covariance.
    pub covariance: Matrix3<f64>,
}

impl Scan {
    /// Median of five, and split into surfaces.
    pub fn new(dense: &Dense<'_>) -> Self {
        let valid = |range: f32| range.is_finite() && range > 0.0 && f64::from(range) < dense.reach;
        let raw: Vec<f64> = dense.ranges.iter().map(|r| if valid(*r) { f64::from(*r) } else { 0.0 }).collect();
        let median = |i: usize| {
            let mut near = raw[i.saturating_sub(2)..(i + 3).min(raw.len())].to_vec();
            near.sort_by(f64::total_cmp);
            near[near.len() / 2]
        };
        let ranges: Vec<f64> = (0..raw.len()).map(|i| if raw[i] > 0.0 { median(i) } else { 0.0 }).collect();
        let mut surface = vec![0; ranges.len()];
        for i in 1..ranges.len() {
            // A wall that is met at a slant goes on as its last two ranges did.
            let straight = if i > 1 { 2.0 * ranges[i - 1] - ranges[i - 2] } else { ranges[i - 1] };
            let off = (ranges[i] - ranges[i - 1]).abs().min((ranges[i] - straight).abs());
            surface[i] = surface[i - 1] + usize::from(off > JUMP);
        }
        Self { first: dense.first, step: dense.step, ranges, surface }
    }

    fn bearing(&self, i: usize) -> f64 {
        self.first + self.step * i as f64
    }

    fn point(&self, i: usize) -> Point {
        unit(self.bearing(i)) * self.ranges[i]
    }

    /// The ranges that this scan would have from the origin of another frame, in which it was taken from `pose`, at its own
    /// bearings; zero where it tells none.
    pub fn seen_from(&self, pose: &Pose) -> Vec<f64> {
        let mut seen = vec![0.0_f64; self.ranges.len()];
        let polar = |i: usize| {
            let at = pose.transform(self.point(i));
            ((at.y.atan2(at.x) - self.first) / self.step, at.norm())
        };
        for i in 1..self.ranges.len() {
            if self.ranges[i] == 0.0 || self.ranges[i - 1] == 0.0 || self.surface[i] != self.surface[i - 1] {
                continue;
            }
            let ((from, near), (to, far)) = (polar(i - 1), polar(i));
            // What turns its back is hidden, and what wraps round is behind.
            if to <= from || to - from > 20.0 {
                continue;
            }
            for k in (from.ceil().max(0.0) as usize)..=(to.floor().max(-1.0) as isize).max(0) as usize {
                let share = (k as f64 - from) / (to - from);
                if k < seen.len() && (0.0..=1.0).contains(&share) {
                    let range = near + share * (far - near);
                    seen[k] = if seen[k] == 0.0 { range } else { seen[k].min(range) };
                }
            }
        }
        seen
    }

    /// How the range at a bearing changes with a shift: by this vector, as the surface stands there; none at its ends.
    fn by_shift(&self, i: usize) -> Option<Point> {
        let (before, after) = (i.checked_sub(1)?, i + 1);
        let is_one = after < self.ranges.len() && self.surface[before] == self.surface[after];
        let ranges = [before, i, after].map(|i| self.ranges.get(i).copied().unwrap_or(0.0));
        let slope = (ranges[2] - ranges[0]) / (2.0 * self.step * ranges[1]);
        let u = unit(self.bearing(i));
        (is_one && ranges.iter().all(|range| *range > 0.0)).then(|| u - perp(u) * slope)
    }

    /// What ranges of another scan, which was taken here, tell of its pose when they are seen at this one's bearings: inverse
    /// covariance. A corridor tells nothing of the way along it.
    fn information(&self, seen: &[f64], pose: &Pose) -> Matrix3<f64> {
        let both = seen.iter().zip(&self.ranges).filter(|(a, b)| **a > 0.0 && **b > 0.0);
        let mut off: Vec<f64> = both.map(|(a, b)| (a - b).abs()).filter(|off| *off < OUTLIER).collect();
        off.sort_by(f64::total_cmp);
        let sigma = (NORMAL * off.get(off.len() / 2).copied().unwrap_or(OUTLIER)).max(SIGMA);
        let mut information = Matrix3::zeros();
        for (i, range) in seen.iter().enumerate().filter(|(_, range)| **range > 0.0) {
            let off = self.ranges[i] - range;
            let Some(h) = self.by_shift(i).filter(|_| off.abs() < OUTLIER) else { continue };
            // A turn moves what is seen about where the other scan was taken.
            let by = Vector3::new(h.x, h.y, h.dot(&perp(self.point(i) - pose.at)));
            // Somewhere within the beam's width it met the surface.
            let width = self.step * self.step * (h.norm_squared() - 1.0) * range * range / 12.0;
            information += by * by.transpose() / (SHARED * (sigma * sigma + off * off + width));
        }
        information
    }

    /// Share of the beams that another scan, taken here, has in common with this one.
    pub fn shared(&self, other: &Self, pose: &Pose) -> f64 {
        let seen = other.seen_from(pose);
        let is_common = |(a, b): &(&f64, &f64)| **a > 0.0 && **b > 0.0 && (*a - *b).abs() < 2.0 * OUTLIER;
        seen.iter().zip(&self.ranges).filter(is_common).count() as f64 / self.ranges.len().max(1) as f64
    }

    /// The turn that lays ranges seen at this scan's bearings on this scan's best.
    fn turn(&self, seen: &[f64]) -> Option<f64> {
        let most = (TURN / self.step).round() as isize;
        let n = self.ranges.len() as isize;
        let error = |shift: isize| {
            let pairs = (0..n).filter_map(|i| {
                let j = i + shift;
                let (a, b) = (seen[i as usize], *self.ranges.get(usize::try_from(j).ok()?)?);
                (a > 0.0 && b > 0.0).then(|| (a - b).abs().min(OUTLIER))
            });
            let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), e| (sum + e, count + 1.0));
            (count > VALID * n as f64).then(|| sum / count)
        };
        let errors: Vec<Option<f64>> = (-most..=most).map(error).collect();
        let known = errors.iter().enumerate().filter_map(|(i, e)| Some((i, (*e)?)));
        let (best, least) = known.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let side = |i: Option<usize>| errors.get(i?).copied().flatten();
        let fraction = match (side(best.checked_sub(1)), side(Some(best + 1))) {
            (Some(before), Some(after)) if before + after > 2.0 * least => {
                (before - after) / (2.0 * (before + after - 2.0 * least))
            }
            _ => 0.0,
        };
        Some((best as f64 - most as f64 + fraction) * self.step)
    }

    /// The shift that lays them on it, and the mean residual of those that count.
    fn shift(&self, seen: &[f64], weight: f64) -> Option<(Point, f64)> {
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, range) in seen.iter().enumerate().filter(|(i, range)| **range > 0.0 && self.ranges[*i] > 0.0) {
            let off = self.ranges[i] - range;
            let Some(h) = self.by_shift(i).filter(|_| off.abs() < OUTLIER) else { continue };
            // Distances from the surface, not along the beam.
            let (n, across) = (h.normalize(), off / h.norm());
            let w = weight / (across * across + weight);
            normal += n * n.transpose() * w;
            right += n * (w * across);
            (sum, count) = (sum + off.abs(), count + 1.0);
        }
        let enough = count >= VALID * self.ranges.len() as f64;
        let inverse = normal.try_inverse().filter(|_| enough)?;
        Some((inverse * right, sum / count))
    }

    /// Where `current` was taken in this scan's frame, beginning at a guess; none where the two have too little in common.
    pub fn find(&self, current: &Self, guess: &Pose) -> Option<Matched> {
        let (mut pose, mut settled, mut residual) = (*guess, 0, f64::INFINITY);
        let (mut turned, mut iteration) = (0.0_f64, 0);
        while iteration < ITERATIONS && settled < STOPS {
            let seen = current.seen_from(&pose);
            if iteration % 2 == 0 {
                turned = self.turn(&seen)?;
                pose.theta = wrap(pose.theta + turned);
            } else {
                let weight = if iteration < NARROW_FROM { WEIGHT } else { WEIGHT / NARROWER };
                let (shift, error) = self.shift(&seen, weight)?;
                pose.at += shift;
                residual = error;
                let moved = 100.0 * (shift.x.abs() + shift.y.abs()) + turned.to_degrees().abs();
                settled = if moved < STOP { settled + 1 } else { 0 };
            }
            iteration += 1;
        }
        let information = self.information(&current.seen_from(&pose), &pose) + Matrix3::identity() / UNKNOWN.powi(2);
        let covariance = information.try_inverse().filter(|_| residual.is_finite())?;
        Some(Matched { pose, covariance })
    }

    /// Memory that the scan takes, bytes.
    pub fn bytes(&self) -> usize {
        16 * self.ranges.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Segment;
    use crate::known::Known;

    /// Ranges that a room with a niche gives from a pose, by casting rays.
    fn scan(pose: &Pose) -> Scan {
        let corners = [(-2.0, -1.5), (3.0, -1.5), (3.0, 1.0), (2.2, 1.0), (2.2, 1.8), (-2.0, 1.8), (-2.0, -1.5)];
        let walls =
            corners.windows(2).map(|c| Segment { from: Point::new(c[0].0, c[0].1), to: Point::new(c[1].0, c[1].1) });
        let known = Known::new(&walls.collect::<Vec<_>>(), 0.0, 0.0, 1);
        let ray = |i: usize| known.cast(pose.at, unit(pose.theta - 0.5 * PI + PI * i as f64 / 180.0)) as f32;
        let ranges: Vec<f32> = (0..181).map(ray).collect();
        let (first, step) = (-0.5 * PI, PI / 180.0);
        Scan::new(&Dense { origin: Point::zeros(), first, step, ranges: &ranges, reach: 10.0 })
    }

    #[test]
    fn a_scan_seen_from_elsewhere_is_the_scan_taken_there() {
        let from = Pose::new(0.1, 0.05, 0.05);
        let seen = scan(&from).seen_from(&from);
        let there = scan(&Pose::default());
        let both = (0..181).filter(|i| seen[*i] > 0.0 && there.ranges[*i] > 0.0);
        let mut off: Vec<f64> = both.map(|i| (seen[i] - there.ranges[i]).abs()).collect();
        off.sort_by(f64::total_cmp);
        assert!(off.len() > 120 && off[off.len() * 9 / 10] < 0.02, "{} {:?}", off.len(), off.last());
    }

    #[test]
    fn a_match_finds_where_the_scan_was_taken() {
        for truth in [Pose::new(0.2, -0.1, 0.15), Pose::new(-0.15, 0.2, -0.2)] {
            let found = scan(&Pose::default()).find(&scan(&truth), &Pose::default()).expect("a match");
            let off = truth.relative(&found.pose);
            assert!(off.at.norm() < 0.02 && off.theta.abs() < 0.01, "{found:?}");
        }
    }
}
