//! After OrthoSLAM (Nguyen, Harati, Martinelli, Siegwart, Tomatis 2006): only lines parallel or at right angles to each other,
//! and small filters instead of one joint state. The equations of the filters are ours.
//!
//! The heading is one Kalman filter. Distances between parallel lines that are seen in one window do not depend on the pose; each
//! has a filter of its own, and a line's place is the least uncertain chain of such distances. A line that is seen without another
//! one is chained to the start by where the robot was.

use nalgebra::{Matrix2, Matrix3};
use std::f64::consts::{FRAC_PI_2, PI};

use crate::fit::{Fit, Splitting, off_quarter, split};
use crate::geometry::{Point, Pose, Segment, hull, overlap, rotation, unit, wrap};
use crate::window::{Extent, Window};
use crate::{Input, Output, Relative};

const WINDOW: Extent = Extent { path: 1.5, turn: 1.05, points: 1600, step: 0.01 };
const SPLITTING: Splitting = Splitting { split: 0.05, gap: 0.25, length: 0.5, points: 10, rms: 0.05 };
/// Way between two extractions, metres.
const EVERY: f64 = 0.3;
/// Lines farther off the axes are left out, radians.
const OFF_AXIS: f64 = 5.0 * PI / 180.0;
/// A wall stands on its axis to this, radians: half a degree.
const BUILT: f64 = 0.5 * PI / 180.0;
/// A line is a known one within three sigma, and within this, metres.
const NEAR: f64 = 0.3;
const APART: f64 = 0.3;

/// A mapped line: its normal along an axis, and what of it was seen along the other.
struct Wall {
    axis: usize,
    sign: f64,
    extent: [f64; 2],
}

/// A distance between two places on one axis; place 0 is the start, place i + 1 the i-th wall.
struct Link {
    ends: [usize; 2],
    distance: f64,
    variance: f64,
}

/// A line of a window on its axis: its wall, and its signed distance from the robot.
struct Sight {
    axis: usize,
    sign: f64,
    distance: f64,
    variance: f64,
    extent: [f64; 2],
    wall: Option<usize>,
}

/// The filters.
pub struct Ortho {
    window: Window,
    extracted: f64,
    theta: f64,
    theta_variance: f64,
    /// Direction of the axes in the start frame; none before a line was seen.
    axes: Option<f64>,
    /// Position along the axes, and its variances.
    at: Point,
    variance: Point,
    walls: Vec<Wall>,
    links: Vec<Link>,
    /// Place and variance of each wall, by the best chain.
    places: Vec<(f64, f64)>,
}

impl Default for Ortho {
    fn default() -> Self {
        Self {
            window: Window::new(WINDOW),
            extracted: 0.0,
            theta: 0.0,
            theta_variance: 0.0,
            axes: None,
            at: Point::zeros(),
            variance: Point::zeros(),
            walls: Vec::new(),
            links: Vec::new(),
            places: Vec::new(),
        }
    }
}

impl Ortho {
    fn grid(&self) -> f64 {
        self.axes.unwrap_or(0.0)
    }

    fn predict(&mut self, input: &Input<'_>) {
        let turn = rotation(self.theta - self.grid());
        let moved = turn * input.motion.at;
        let noise = turn * input.motion_cov.fixed_view::<2, 2>(0, 0) * turn.transpose();
        self.at += moved;
        self.variance += Point::new(noise[(0, 0)], noise[(1, 1)]);
        self.variance += Point::new(moved.y * moved.y, moved.x * moved.x) * self.theta_variance;
        self.theta = wrap(self.theta + input.motion.theta);
        self.theta_variance += input.motion_cov[(2, 2)];
    }

    fn follow_heading(&mut self, fit: &Fit) -> bool {
        let direction = self.theta + fit.line.a;
        let Some(axes) = self.axes else {
            self.axes = Some(wrap(direction));
            self.at = rotation(-direction) * self.at;
            return true;
        };
        let off = off_quarter(direction, axes);
        let noise = fit.covariance[(1, 1)] + BUILT * BUILT;
        let limit = OFF_AXIS.max(3.0 * (self.theta_variance + noise).sqrt()).min(0.5);
        if off.abs() > limit {
            return false;
        }
        let gain = self.theta_variance / (self.theta_variance + noise);
        self.theta = wrap(self.theta - gain * off);
        self.theta_variance *= 1.0 - gain;
        true
    }

    fn sight(&self, fit: &Fit) -> Sight {
        let quarter = ((self.theta + fit.line.a - self.grid()) / FRAC_PI_2).round();
        let k = quarter.rem_euclid(4.0) as usize;
        let n = unit(self.grid() + quarter * FRAC_PI_2 - self.theta);
        let seen: Vec<_> = fit.points.iter().map(|i| &self.window.points[*i]).collect();
        let count = seen.len().max(1) as f64;
        let distance = seen.iter().map(|seen| seen.at.dot(&n)).sum::<f64>() / count;
        // Readings are independent, the motion since is shared by all of them.
        let share = |c: &Matrix2<f64>| (n.transpose() * c * n)[(0, 0)];
        let reading = seen.iter().map(|seen| share(&seen.covariance())).sum::<f64>() / (count * count);
        let drift = seen.iter().map(|seen| share(&seen.drift)).sum::<f64>() / count;
        let axis = k % 2;
        let place = |point: Point| (self.at + rotation(self.theta - self.grid()) * point)[1 - axis];
        let ends = fit.ends().map(place);
        Sight {
            axis,
            sign: if k < 2 { 1.0 } else { -1.0 },
            distance,
            variance: reading + drift,
            extent: [ends[0].min(ends[1]), ends[0].max(ends[1])],
            wall: None,
        }
    }

    fn nearest(&self, sight: &Sight) -> Option<usize> {
        let found = self.at[sight.axis] + sight.sign * sight.distance;
        let candidates = self.walls.iter().zip(&self.places).enumerate().filter_map(|(i, (wall, place))| {
            let sigma = (self.variance[sight.axis] + sight.variance + place.1).sqrt();
            let off = (found - place.0).abs();
            let same = wall.axis == sight.axis && wall.sign == sight.sign;
            (same && off < NEAR.min(3.0 * sigma) && overlap(wall.extent, sight.extent) > -APART).then_some((off, i))
        });
        candidates.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
    }

    fn link(&mut self, ends: [usize; 2], distance: f64, variance: f64) {
        match self.links.iter_mut().find(|link| link.ends == ends) {
            Some(link) => {
                let gain = link.variance / (link.variance + variance);
                link.distance += gain * (distance - link.distance);
                link.variance *= 1.0 - gain;
            }
            None => self.links.push(Link { ends, distance, variance }),
        }
    }

    /// The least uncertain chain from the start to each wall (Dijkstra).
    fn chain(&mut self) {
        let mut best = vec![(0.0, f64::INFINITY); self.walls.len() + 1];
        let mut is_done = vec![false; best.len()];
        best[0].1 = 0.0;
        while let Some(next) = (0..best.len())
            .filter(|i| !is_done[*i] && best[*i].1.is_finite())
            .min_by(|a, b| best[*a].1.total_cmp(&best[*b].1))
        {
            is_done[next] = true;
            for link in self.links.iter().filter(|link| link.ends.contains(&next)) {
                let (other, sign) = if link.ends[0] == next { (link.ends[1], 1.0) } else { (link.ends[0], -1.0) };
                let variance = best[next].1 + link.variance;
                if variance < best[other].1 {
                    best[other] = (best[next].0 + sign * link.distance, variance);
                }
            }
        }
        self.places = best.split_off(1);
    }

    fn take(&mut self, fits: &[Fit]) {
        let square: Vec<&Fit> = fits.iter().filter(|fit| self.follow_heading(fit)).collect();
        let mut sights: Vec<Sight> = square.into_iter().map(|fit| self.sight(fit)).collect();
        for sight in &mut sights {
            sight.wall = self.nearest(sight);
        }
        let known: Vec<bool> = sights.iter().map(|sight| sight.wall.is_some()).collect();
        for i in 0..sights.len() {
            if !known[i] {
                let sight = &sights[i];
                self.walls.push(Wall { axis: sight.axis, sign: sight.sign, extent: sight.extent });
                let wall = self.walls.len() - 1;
                let with_known = (0..sights.len()).any(|j| known[j] && sights[j].axis == sights[i].axis);
                if !with_known {
                    let axis = sights[i].axis;
                    let place = self.at[axis] + sights[i].sign * sights[i].distance;
                    self.link([0, wall + 1], place, self.variance[axis] + sights[i].variance);
                }
                sights[i].wall = Some(wall);
            }
        }
        self.link_pairs(&sights);
        self.chain();
        for (sight, _) in sights.iter().zip(known).filter(|(_, known)| *known) {
            self.follow_position(sight);
        }
    }

    fn link_pairs(&mut self, sights: &[Sight]) {
        for (i, one) in sights.iter().enumerate() {
            for other in &sights[i + 1..] {
                let (Some(a), Some(b)) = (one.wall, other.wall) else { continue };
                if one.axis == other.axis && a != b {
                    let (from, to) = if a < b { (one, other) } else { (other, one) };
                    let distance = to.sign * to.distance - from.sign * from.distance;
                    self.link([a.min(b) + 1, a.max(b) + 1], distance, one.variance + other.variance);
                }
            }
        }
    }

    fn follow_position(&mut self, sight: &Sight) {
        let Some(wall) = sight.wall else { return };
        let (axis, (place, variance)) = (sight.axis, self.places[wall]);
        let extent = &mut self.walls[wall].extent;
        *extent = hull(*extent, sight.extent);
        let gain = self.variance[axis] / (self.variance[axis] + variance + sight.variance);
        self.at[axis] += gain * (place - sight.sign * sight.distance - self.at[axis]);
        self.variance[axis] *= 1.0 - gain;
    }
}

impl Relative for Ortho {
    fn step(&mut self, input: &Input<'_>) -> Output {
        self.predict(input);
        self.window.step(input);
        let way = self.window.path + self.window.turned / 3.0;
        if way - self.extracted >= EVERY {
            self.extracted = way;
            let fits = split(&self.window, &SPLITTING);
            self.take(&fits);
            let used: Vec<usize> = fits.into_iter().flat_map(|fit| fit.points).collect();
            self.window.drop(&used);
        }
        let turn = rotation(self.grid());
        let position = turn * Matrix2::from_diagonal(&self.variance) * turn.transpose();
        let mut covariance = Matrix3::zeros();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&position);
        covariance[(2, 2)] = self.theta_variance;
        Output { pose: Pose { at: turn * self.at, theta: self.theta }, covariance: Some(covariance) }
    }

    fn walls(&self) -> Vec<Segment> {
        let turn = rotation(self.grid());
        let segment = |(wall, place): (&Wall, &(f64, f64))| {
            let end = |along: f64| {
                let point = if wall.axis == 0 { Point::new(place.0, along) } else { Point::new(along, place.0) };
                turn * point
            };
            Segment { from: end(wall.extent[0]), to: end(wall.extent[1]) }
        };
        self.walls.iter().zip(&self.places).map(segment).collect()
    }

    fn bytes(&self) -> usize {
        self.window.bytes() + self.walls.len() * (size_of::<Wall>() + 16) + self.links.len() * size_of::<Link>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_chain_is_the_one_with_the_least_variance() {
        let walls = (0..3).map(|_| Wall { axis: 0, sign: 1.0, extent: [0.0, 1.0] }).collect();
        let mut ortho = Ortho { walls, ..Ortho::default() };
        ortho.link([0, 1], 1.0, 0.04);
        ortho.link([1, 2], 2.0, 0.01);
        ortho.link([0, 2], 3.3, 0.09);
        ortho.link([2, 3], -0.5, 0.01);
        ortho.chain();
        let expected = [(1.0, 0.04), (3.0, 0.05), (2.5, 0.06)];
        for (found, expected) in ortho.places.iter().zip(expected) {
            assert!((found.0 - expected.0).abs() < 1e-12 && (found.1 - expected.1).abs() < 1e-12, "{found:?}");
        }
        // A distance that is measured again has half the variance and the mean.
        ortho.link([0, 1], 1.2, 0.04);
        assert!((ortho.links[0].distance - 1.1).abs() < 1e-12 && (ortho.links[0].variance - 0.02).abs() < 1e-12);
    }
}
