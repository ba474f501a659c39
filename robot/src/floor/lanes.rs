//! Lanes: straight lines along the axes of the job's frame.

use slam_core::Pose;
use slam_core::angle::wrap;

use super::near::free_ahead_m;
use super::sheet::Axis;
use super::{FloorJob, Phase};
use crate::pilot::memory::Cell;
use crate::pilot::steer::limited;

/// A lane is begun this near to where it begins, metres: from there the brush still covers the corners of its first quarters.
const BEGUN_M: f32 = 0.02;
/// Speed there, m/s, and how it grows with the distance from there, 1/s: within one step it comes no farther than that.
const ARRIVAL_MPS: f32 = 0.04;
const ARRIVAL_PER_S: f32 = 3.0;

/// A lane: a straight line along an axis of the job's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lane {
    pub axis: Axis,
    /// Where it is across the axis, metres.
    pub across_m: f32,
    /// 1 towards larger coordinates, -1 towards smaller ones.
    pub sign: i16,
    /// On which side the next lane is preferred.
    pub side: i16,
}

impl Lane {
    /// Direction in the job's frame, radians.
    fn heading_rad(&self) -> f32 {
        let along_rad = match self.axis {
            Axis::X => 0.0,
            Axis::Y => core::f32::consts::FRAC_PI_2,
        };
        if self.sign > 0 { along_rad } else { along_rad - core::f32::consts::PI }
    }

    /// How far across it a pose came that the wheels did not bring there, metres.
    pub(super) fn jump_m(&self, from: &Pose, to: &Pose) -> f32 {
        let (s, c) = slam_core::angle::sin_cos(to.theta_rad);
        let aside_m = c * (to.y_m - from.y_m) - s * (to.x_m - from.x_m);
        match self.axis {
            Axis::X => c * aside_m,
            Axis::Y => -s * aside_m,
        }
    }
}

impl<const S: usize> FloorJob<S> {
    /// The lane along the border of the floor that is left about a cell, and where it begins: along the axis on which it sweeps more.
    pub(super) fn first_lane(&self, cell: Cell, pose: &Pose) -> Option<(Lane, [f32; 2])> {
        let centre_m = self.sheet.picture.centre_m(cell);
        let mut best: Option<(i16, Lane, [f32; 2])> = None;
        for axis in [Axis::X, Axis::Y] {
            let [near, row] = self.sheet.place(axis, centre_m);
            let [here, _] = self.sheet.place(axis, [pose.x_m, pose.y_m]);
            let Some((near, [low, high])) = self.sheet.rows_left(axis, near, row) else { continue };
            // The middle row of three at that border that is nearer, or of what there is.
            let (across, side) = if high - low < 3 {
                (low + (high - low) / 2, 1)
            } else if (row - low).abs() <= (row - high).abs() {
                (low + 1, 1)
            } else {
                (high - 1, -1)
            };
            let stretch = self.sheet.stretch(axis, across, near, 2);
            let Some(stretch) = stretch.and_then(|stretch| self.before_brink(axis, across, stretch)) else { continue };
            let is_from_low = (here - stretch.from).abs() <= (here - stretch.to).abs();
            let sign = if is_from_low { 1 } else { -1 };
            let at_m = self.sheet.begin_m(axis, across, &stretch, sign);
            let [_, across_m] = axis.split(at_m);
            let bonus = if axis == self.axis { stretch.count / 4 } else { 0 };
            if best.is_none_or(|(count, ..)| stretch.count + bonus > count) {
                best = Some((stretch.count + bonus, Lane { axis, across_m, sign, side }, at_m));
            }
        }
        best.map(|(_, lane, at_m)| (lane, at_m))
    }

    pub(super) fn enter(&mut self, lane: Lane, at_m: [f32; 2], pose: &Pose, now_us: u64) -> (f32, f32) {
        let [dx, dy] = [at_m[0] - pose.x_m, at_m[1] - pose.y_m];
        let left_m = slam_core::pose::length(dx, dy);
        let (forward_mps, turn_radps) = self.towards(at_m, pose, now_us);
        let is_blocked = forward_mps <= 0.01 && turn_radps.abs() < 0.1;
        if left_m < BEGUN_M {
            self.begin(Phase::Lane(lane), now_us);
        } else if is_blocked {
            if self.is_target_left() {
                self.give_up();
            }
            self.finish_target(now_us);
        }
        (forward_mps.min(ARRIVAL_MPS + ARRIVAL_PER_S * left_m), turn_radps)
    }

    pub(super) fn follow_lane(&mut self, lane: Lane, pose: &Pose, now_us: u64) -> (f32, f32) {
        self.axis = lane.axis;
        let drive = &self.config.drive;
        let [_, across_m] = lane.axis.split([pose.x_m, pose.y_m]);
        let off_rad = wrap(lane.heading_rad() - pose.theta_rad);
        let is_begun = self.path_m - self.begun_m > 0.02;
        if off_rad.abs() > if is_begun { 0.5 } else { 0.08 } {
            return (0.0, limited(3.0 * off_rad, drive.turn_radps));
        }
        // Left of the lane is positive.
        let left = match lane.axis {
            Axis::X => f32::from(lane.sign),
            Axis::Y => -f32::from(lane.sign),
        };
        let off_m = (left * (across_m - lane.across_m)).clamp(-0.06, 0.06);
        let turn_radps = limited(3.5 * off_rad - 14.0 * off_m, drive.turn_radps);
        let free_m = free_ahead_m(self.near.seen_from(pose, now_us), drive.radius_m + 0.004);
        let forward_mps = self.config.open_mps.min(2.0 * (free_m - 0.01)) * (1.0 - off_rad.abs() / 0.6).max(0.0);
        let [along, _] = self.sheet.place(lane.axis, [pose.x_m, pose.y_m]);
        let [_, across] = self.sheet.place(lane.axis, self.lane_point_m(&lane, pose));
        let is_more = self.sheet.is_more_ahead(lane.axis, along, across, lane.sign);
        if free_m < 0.025 || !is_more || self.is_at_brink(pose) {
            self.next_lane(lane, now_us);
            return (0.0, 0.0);
        }
        (forward_mps.max(0.0), turn_radps)
    }

    /// The point of the lane beside the robot, metres.
    pub(super) fn lane_point_m(&self, lane: &Lane, pose: &Pose) -> [f32; 2] {
        match lane.axis {
            Axis::X => [pose.x_m, lane.across_m],
            Axis::Y => [lane.across_m, pose.y_m],
        }
    }

    /// On to the lane beside this one, if there is anything to sweep.
    pub(super) fn next_lane(&mut self, lane: Lane, now_us: u64) {
        let Some(pose) = self.last else { return };
        let here_m = [pose.x_m, pose.y_m];
        let [along, across] = self.sheet.place(lane.axis, self.lane_point_m(&lane, &pose));
        let missed = self.trail.settle(lane.axis, self.path_m - self.begun_m, &mut self.sheet);
        self.tally.take_back(missed);
        for shift in [3 * lane.side, -3 * lane.side, 2 * lane.side, -2 * lane.side] {
            let stretch = self.sheet.stretch(lane.axis, across + shift, along, 6);
            let Some(stretch) = stretch.and_then(|stretch| self.before_brink(lane.axis, across + shift, stretch))
            else {
                continue;
            };
            if stretch.count < 8 {
                continue;
            }
            let is_from_low = (along - stretch.from).abs() <= (along - stretch.to).abs();
            let (first, sign) = if is_from_low { (stretch.from, 1) } else { (stretch.to, -1) };
            let at_m = self.sheet.begin_m(lane.axis, across + shift, &stretch, sign);
            if (along - first).abs() <= 12 && self.sheet.is_open(here_m, at_m) {
                let [_, across_m] = lane.axis.split(at_m);
                let lane = Lane { across_m, sign, side: shift.signum(), ..lane };
                self.begin(Phase::Enter { lane, at_m }, now_us);
                return;
            }
        }
        self.finish_target(now_us);
    }
}
