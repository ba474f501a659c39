//! The maps of a drive, one after the other: where readings contradict one, the robot begins another, and may find itself back.
//!
//! What contradicts a map is most often a turn that nothing told. The odometry goes on over it, but what was seen later lies askew to what was
//! seen before. All of it is in one home, which has one grid: that says by how much.

use std::f64::consts::FRAC_PI_2;

use super::line::Points;
use crate::recording::{Pose2, Recording, Step, wrap};

/// Directions of walls that have nothing in common are so much alike by chance once in a thousand, natural logarithm (Rayleigh's test).
const NO_CHANCE: f64 = 6.9;

/// A wall as a part has it.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// The part that it was drawn in.
    pub part: usize,
    /// Offset of its line, metres.
    pub rho_m: f64,
    /// Direction of the normal, radians.
    pub beta_rad: f64,
    /// Readings that were on it.
    pub count: usize,
}

impl Line {
    /// Through what beams met in a part.
    pub fn of(points: &Points, part: usize) -> Self {
        let (rho_m, beta_rad) = points.line();
        Self { part, rho_m, beta_rad, count: points.count() }
    }
}

/// The steps in one map.
struct Part {
    /// The first of them.
    begin: usize,
    /// Direction of the grid at their end, radians.
    alpha: Option<f64>,
    /// Where its frame lies in the first one's.
    frame: Pose2,
}

/// A drive as parts with one map each.
pub struct Parts {
    parts: Vec<Part>,
}

impl Parts {
    /// Of a record. The readings of the step after which a map is begun anew are those of the map before.
    pub fn of(recording: &Recording) -> Self {
        let steps = &recording.steps;
        let mut parts = vec![Part { begin: 0, alpha: None, frame: Pose2::default() }];
        let mut end = |step: Option<&Step>, begin: usize| {
            if let Some(part) = parts.last_mut() {
                part.alpha = step.and_then(|step| step.alpha).map(|(alpha, _)| f64::from(alpha));
            }
            if begin < steps.len() {
                parts.push(Part { begin, alpha: None, frame: Pose2::default() });
            }
        };
        for (pair, index) in steps.windows(2).zip(1..) {
            let [before, after] = pair else { continue };
            if after.restarts != before.restarts {
                end(Some(before), index + 1);
            } else if before.searching && !after.searching {
                end(Some(before), index);
            }
        }
        end(steps.last(), steps.len());
        Self { parts }
    }

    /// Puts each fresh map where it lies in the first one's frame: one in which the robot found itself back is in that frame, and says where
    /// the one before it lies. Any other is turned about where it begins, the short way onto the first one's grid.
    pub fn turn(&mut self, steps: &[Step], lines: &[Line]) {
        let Some(first) = self.parts.first().and_then(|part| part.alpha) else { return };
        for i in 1..self.parts.len() {
            let own = self.parts[i].alpha.or_else(|| direction(lines.iter().filter(|line| line.part == i)));
            let next = self.parts.get(i + 1).map(|next| next.begin);
            let [.., before, part] = &mut self.parts[..=i] else { continue };
            let at = &steps[part.begin];
            part.alpha = own;
            if !at.searching {
                continue;
            }
            part.frame = before.frame;
            if let Some(found) = next.filter(|next| !steps[*next].searching) {
                part.frame = found_back(&steps[found - 1], &steps[found]);
            } else if let Some(own) = own {
                let there = before.frame.compose(&at.pose);
                let turned = off_grid(own + before.frame.theta_rad, first);
                let back = Pose2::new(there.x_m, there.y_m, there.theta_rad - turned);
                part.frame = frame_of(&at.pose, &back);
            }
        }
    }

    /// The part that a step is in.
    pub fn at(&self, step: usize) -> usize {
        self.parts.partition_point(|part| part.begin <= step).saturating_sub(1)
    }

    /// Direction of a part's grid in the first one's frame, radians.
    pub fn grid(&self, part: usize) -> Option<f64> {
        let part = self.parts.get(part)?;
        Some(part.alpha? + part.frame.theta_rad)
    }

    /// Where a part's frame lies in the first one's.
    pub fn frame(&self, part: usize) -> Pose2 {
        self.parts.get(part).map_or_else(Pose2::default, |part| part.frame)
    }

    /// Offset and direction of a wall in the first part's frame.
    pub fn place(&self, line: &Line) -> (f64, f64) {
        let frame = self.frame(line.part);
        let beta_rad = wrap(line.beta_rad + frame.theta_rad);
        let (s, c) = beta_rad.sin_cos();
        (line.rho_m + c * frame.x_m + s * frame.y_m, beta_rad)
    }
}

/// Where a frame lies in which a pose is this one, by where the same pose is.
fn frame_of(pose: &Pose2, there: &Pose2) -> Pose2 {
    there.compose(&pose.relative(&Pose2::default()))
}

/// Where the fresh map lies in which a robot was until it found itself in the one of before: what it drove in the step between, the odometry
/// says.
fn found_back(fresh: &Step, found: &Step) -> Pose2 {
    let driven = fresh.dead_reckoning.relative(&found.dead_reckoning);
    frame_of(&fresh.pose.compose(&driven), &found.pose)
}

/// The direction that walls have in common but for quarter turns: the mean of four times theirs, weighed by their readings. None where
/// that may be chance.
fn direction<'l>(lines: impl Iterator<Item = &'l Line>) -> Option<f64> {
    let (mut sum, mut squares) = ([0.0; 2], 0.0);
    for line in lines {
        let (s, c) = (4.0 * line.beta_rad).sin_cos();
        let weight = line.count as f64;
        sum = [sum[0] + weight * c, sum[1] + weight * s];
        squares += weight * weight;
    }
    let is_common = sum[0] * sum[0] + sum[1] * sum[1] > NO_CHANCE * squares;
    is_common.then(|| 0.25 * sum[1].atan2(sum[0]))
}

/// Angle from the nearest direction of the grid.
pub fn off_grid(beta_rad: f64, alpha_rad: f64) -> f64 {
    let difference = beta_rad - alpha_rad;
    difference - (difference / FRAC_PI_2).round() * FRAC_PI_2
}
