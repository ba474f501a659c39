//! Along what stands on the floor.

use slam_core::Pose;

use super::hug::Hug;
use super::{BARREN_M, FloorJob, Phase};
use crate::pilot::PilotConfig;

/// With nothing beside it for so long a path an edge is lost, metres.
const LOST_M: f32 = 0.5;
/// An edge that was come for has its floor where it begins: after a brush's width without any it is done, metres.
const COME_FOR_M: f32 = 0.25;
/// Something this near to the robot's centre is gone along, metres.
const MEET_M: f32 = 0.32;

impl<const S: usize> FloorJob<S> {
    pub(super) fn hug(&self) -> Hug {
        let PilotConfig { radius_m, speed_mps, turn_radps, .. } = self.config.drive;
        Hug { radius_m, gap_m: self.config.gap_m, speed_mps, turn_radps }
    }

    pub(super) fn seek(&mut self, to_m: Option<[f32; 2]>, pose: &Pose, now_us: u64) -> (f32, f32) {
        let along = self.hug().along(self.near.seen_from(pose, now_us), 1.0);
        let is_there = |to_m: [f32; 2]| slam_core::pose::length(to_m[0] - pose.x_m, to_m[1] - pose.y_m) < 0.05;
        if along.nearest_m < MEET_M {
            self.begin_edge(self.better_side(pose, now_us), now_us);
        } else if to_m.map_or_else(|| self.is_at_brink(pose), is_there) {
            self.finish_target(now_us);
        }
        to_m.map_or((self.config.drive.speed_mps, 0.0), |to_m| self.towards(to_m, pose, now_us))
    }

    /// On which side to have what is near: 1 on the right, -1 on the left, by where more is left to sweep along it.
    pub(super) fn better_side(&self, pose: &Pose, now_us: u64) -> f32 {
        let square = |[x, y]: &[f32; 2]| x * x + y * y;
        let points = self.near.seen_from(pose, now_us);
        let Some([x, y]) = points.min_by(|a, b| square(a).total_cmp(&square(b))) else { return 1.0 };
        let scale = 1.0 / float::sqrtf(square(&[x, y])).max(0.01);
        // With it on the right the robot goes to the left of where it is.
        let way = [-y * scale, x * scale];
        let left = |sign: f32| -> u32 {
            [0.25, 0.4, 0.55]
                .map(|ahead_m| {
                    let [x_m, y_m] =
                        pose.transform([0.5 * x + sign * ahead_m * way[0], 0.5 * y + sign * ahead_m * way[1]]);
                    self.sheet.swept.left_in(self.sheet.picture.cell_at(x_m, y_m))
                })
                .iter()
                .sum()
        };
        if left(-1.0) > left(1.0) { -1.0 } else { 1.0 }
    }

    pub(super) fn begin_edge(&mut self, side: f32, now_us: u64) {
        self.credit_m = self.barren_m();
        self.beside_m = self.path_m;
        self.begin(Phase::Edge { side }, now_us);
    }

    /// Without new floor for so long a path an edge is done, metres.
    pub(super) fn barren_m(&self) -> f32 {
        if self.target.is_some() { COME_FOR_M } else { BARREN_M }
    }

    pub(super) fn edge(&mut self, side: f32, pose: &Pose, now_us: u64) -> (f32, f32) {
        let along = self.hug().along(self.near.seen_from(pose, now_us), side);
        if along.is_beside {
            self.beside_m = self.path_m;
        }
        if self.credit_m < 0.0 || self.path_m - self.beside_m > LOST_M || self.is_at_brink(pose) {
            self.finish_target(now_us);
        }
        (along.forward_mps, along.turn_radps)
    }
}
