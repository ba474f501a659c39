//! Where the robot was when its power went: it looks for itself there first.

use robot::{COASTS_M, COASTS_RAD, LastingMemory, last_pose, read_last_pose};
use slam_core::{Pose, RobotSlam};

use crate::{Keeper, MapFlash};

impl<F: MapFlash> Keeper<F> {
    /// The robot starts, with what is in this memory.
    pub fn recall(&mut self, memory: &impl LastingMemory) {
        if let Some(last) = self.kept().and_then(|map| read_last_pose(map, memory)) {
            self.locator.stood(last);
        }
    }

    /// Writes down where the robot is, or that it is not sure of it. After a start what is there holds until it has moved farther than it may
    /// roll on: it may be reset again before that.
    pub fn note(&mut self, slam: &RobotSlam, memory: &mut impl LastingMemory) {
        let Pose { x_m, y_m, theta_rad } = self.last;
        let has_moved = slam_core::pose::length(x_m, y_m) > COASTS_M || theta_rad.abs() > COASTS_RAD;
        match (self.kept().filter(|_| self.is_sure()), last_pose(slam)) {
            (Some(map), Some(last)) => self.notes.write(&last, map, memory),
            _ if has_moved || self.is_lifted => self.notes.wipe(memory),
            _ => {}
        }
    }
}
