//! The dock: a place in the map that a contact tells.

use crate::geometry::pose::length;
use crate::slam::Slam;

/// A dock so near to where the first drive started is where it started, metres: it forgives three centimetres, and the pose is known to one.
const SAME_PLACE_M: f32 = 0.06;

/// Straight in front of the dock is what is so near to the line out of it, metres, and looks so nearly along it, radians. Tries to get into it
/// begin on that line, and go farther aside only where some were in vain.
const BESIDE_M: f32 = 0.3;
const ASKEW_RAD: f32 = 0.3;

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// The robot, which knows where it is, stands in a dock: where its map's first drive started there is one from now on, if it is there.
    pub fn stands_in_dock(&mut self) {
        self.map.has_dock |= self.is_at_start();
    }

    /// The robot does not know where it is and stands in the dock: its fresh map starts there. Whether that is another one than it had.
    pub fn begin_in_dock(&mut self) -> bool {
        if self.map.walls().is_empty() && self.is_at_start() {
            return false;
        }
        let has_dock = self.map.has_dock;
        self.restart_elsewhere();
        self.map.has_dock = has_dock;
        true
    }

    /// How far the robot is before the dock that its map has, metres, where it looks to it from straight in front of it.
    pub fn before_dock_m(&self) -> Option<f32> {
        let seen = self.map.has_dock.then(|| self.start_pose().inverse().compose(&self.pose()))?;
        let is_in_front = seen.y_m.abs() < BESIDE_M && seen.theta_rad.abs() < ASKEW_RAD;
        is_in_front.then_some(-seen.x_m)
    }

    fn is_at_start(&self) -> bool {
        let (pose, start) = (self.pose(), self.start_pose());
        length(pose.x_m - start.x_m, pose.y_m - start.y_m) < SAME_PLACE_M
    }
}
