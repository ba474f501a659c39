//! Whether the robot can get away from where it is.

use slam_core::Pose;

/// So many attempts that end where they began are enough: rounds with nothing left to visit, and targets given up. In a home
/// whose every corner was visited a round leads away.
const ATTEMPTS: u8 = 20;

/// Attempts in vain, and where.
#[derive(Clone, Copy, Debug)]
pub(super) struct Confinement {
    place_m: [f32; 2],
    attempts: u8,
}

impl Confinement {
    pub(super) const NONE: Self = Self { place_m: [0.0; 2], attempts: 0 };

    /// An attempt ended here; true where the robot did not get away by as much as its radius in twenty of them.
    pub(super) fn attempt(&mut self, pose: &Pose, radius_m: f32) -> bool {
        let [dx, dy] = [pose.x_m - self.place_m[0], pose.y_m - self.place_m[1]];
        if dx * dx + dy * dy > radius_m * radius_m {
            *self = Self { place_m: [pose.x_m, pose.y_m], attempts: 0 };
        }
        self.attempts = self.attempts.saturating_add(1);
        self.attempts > ATTEMPTS
    }

    /// Whatever was in the way may be gone.
    pub(super) fn forget(&mut self) {
        self.attempts = 0;
    }
}
