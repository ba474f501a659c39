//! A robot that keeps no map looks for its home in its own map a second time, as the firmware does.

use relocate::{Event, Locator, State, Step};
use slam_core::{HostSlam, Pose};

/// Looks for the home in the robot's own map a second time.
#[derive(Clone, Debug)]
pub struct OwnMap {
    locator: Locator,
    last: Pose,
}

impl OwnMap {
    /// Of a robot at its start.
    pub fn new() -> Self {
        Self { locator: Locator::new(State::Tracking), last: Pose::ORIGIN }
    }

    /// Takes in a step of the estimator; true where a second copy was given up.
    pub fn watch(&mut self, slam: &mut HostSlam) -> bool {
        let now = slam.dead_reckoning();
        let last = core::mem::replace(&mut self.last, now);
        let travelled_m = libm::hypotf(now.x_m - last.x_m, now.y_m - last.y_m);
        let step = Step { position_m: [slam.state_mean(0), slam.state_mean(1)], travelled_m, readings: [0; 2] };
        match self.locator.step(&*slam, None, &step, u32::MAX) {
            // A copy whose walls went in this step is found again.
            Some(Event::Copied(copy, found)) => slam.give_up_copy(&copy, &found).is_ok(),
            _ => false,
        }
    }
}

impl Default for OwnMap {
    fn default() -> Self {
        Self::new()
    }
}
