//! Polar scan matching (Diosi and Kleeman 2005; numbers of its version 0.3): turns by shifting ranges, shifts by weighted least
//! squares along the beams.
//!
//! Two slips of that code are not repeated: the weight does narrow after ten iterations, and the normal matrix is symmetric.

use nalgebra::{Matrix2, Matrix3, Vector2};
use std::f64::consts::PI;

use crate::Dense;
use crate::geometry::{Point, Pose, rotation, unit, wrap};

/// Neighbours farther apart are of two surfaces, metres.
const JUMP: f64 = 0.2;
/// Largest turn that one search covers, radians.
const TURN: f64 = 20.0 * PI / 180.0;
/// Residuals beyond this are not used, metres.
const OUTLIER: f64 = 1.0;
/// Squared residual at which a point counts half, m^2, and what it is divided by from this iteration on.
const WEIGHT: f64 = 0.49;
const NARROWER: f64 = 50.0;
const NARROW_FROM: usize = 10;
/// Corrections under this, in centimetres and degrees together, so many times in a row end the iterations.
const STOP: f64 = 0.4;
const STOPS: usize = 3;
const ITERATIONS: usize = 30;
/// Least share of the beams that must be valid.
const VALID: f64 = 40.0 / 181.0;
/// 1-sigma of a match whose mean residual is at most 6 cm, metres and radians: a tenth of the source's 20 cm and 4 degrees. Of 1, 0.3
/// and 0.1 it gave the best paths on simulated drives of their own (seeds 1001 to 1003 of the flat and the room).
const SIGMA: (f64, f64) = (0.02, 0.4 * PI / 180.0);
/// A scan whose surfaces' directions scatter less is a corridor; its sigma along and across grow so many times.
const CORRIDOR: f64 = 25.0 * PI / 180.0;
const ALONG: f64 = 20.0;
const ACROSS: f64 = 1.5;

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

    /// Scatter of the directions of the surfaces, and their mean modulo a half turn, radians.
    fn directions(&self) -> (f64, f64) {
        let (mut s, mut c, mut n) = (0.0, 0.0, 0.0);
        for i in 1..self.ranges.len() {
            if self.ranges[i] > 0.0 && self.ranges[i - 1] > 0.0 && self.surface[i] == self.surface[i - 1] {
                let d = self.point(i) - self.point(i - 1);
                let double = 2.0 * d.y.atan2(d.x);
                (s, c, n) = (s + double.sin(), c + double.cos(), n + 1.0);
            }
        }
        let length = (f64::hypot(s, c) / f64::max(n, 1.0)).clamp(1e-9, 1.0);
        // The scatter of a wrapped normal distribution of the doubled angle.
        (0.5 * (-2.0 * length.ln()).sqrt(), 0.5 * s.atan2(c))
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
            if off.abs() < OUTLIER {
                let (h, w) = (unit(self.bearing(i)), weight / (off * off + weight));
                normal += h * h.transpose() * w;
                right += h * (w * off);
                (sum, count) = (sum + off.abs(), count + 1.0);
            }
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
        let grown = (100.0 * residual - 5.0).max(1.0);
        let (scatter, direction) = self.directions();
        let (along, across) = if scatter < CORRIDOR { (ALONG, ACROSS) } else { (1.0, 1.0) };
        let turn = rotation(direction);
        let position = Matrix2::from_diagonal(&Vector2::new(along * along, across * across));
        let mut covariance = Matrix3::zeros();
        let own = turn * position * turn.transpose() * (SIGMA.0 * SIGMA.0);
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&own);
        covariance[(2, 2)] = SIGMA.1 * SIGMA.1;
        residual.is_finite().then_some(Matched { pose, covariance: covariance * grown })
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
