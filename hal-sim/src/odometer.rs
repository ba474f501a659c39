//! Dead-reckoned poses, as a robot's driver publishes them: at a rate of its own, by the nominal wheels.

use slam_core::Increment;

use crate::pose::TruePose;
use crate::rng::Rng;

/// What publishes the wheels' pose.
#[derive(Clone, Debug)]
pub(crate) struct Odometer {
    period_s: f64,
    next_s: f64,
    track_m: f64,
    /// By the encoders, now.
    pose: TruePose,
    turned_m: [f64; 2],
    /// As published last.
    latest: TruePose,
    /// What the last sample had.
    given: TruePose,
}

impl Odometer {
    /// Standing at its origin, in a random phase.
    pub(crate) fn new(rate_hz: f64, track_m: f64, seed: u64) -> Self {
        let period_s = 1.0 / rate_hz;
        let next_s = period_s * Rng::stream(seed, "odometry-phase", 0).unit();
        let still = TruePose::default();
        Self { period_s, next_s, track_m, pose: still, turned_m: [0.0; 2], latest: still, given: still }
    }

    /// Takes in the encoders' travel since the start, metres, and publishes what is due.
    pub(crate) fn advance(&mut self, time_s: f64, turned_m: [f64; 2]) {
        let [left_m, right_m] = [0, 1].map(|wheel| turned_m[wheel] - self.turned_m[wheel]);
        self.turned_m = turned_m;
        let (forward_m, turn_rad) = (0.5 * (left_m + right_m), (right_m - left_m) / self.track_m);
        let (s, c) = libm::sincos(self.pose.theta_rad + 0.5 * turn_rad);
        self.pose =
            TruePose::new(self.pose.x_m + forward_m * c, self.pose.y_m + forward_m * s, self.pose.theta_rad + turn_rad);
        if time_s >= self.next_s {
            self.latest = self.pose;
            self.next_s += self.period_s * libm::floor(1.0 + (time_s - self.next_s) / self.period_s);
        }
    }

    /// Motion from the pose that the last sample had to the one published last.
    pub(crate) fn take(&mut self) -> Increment {
        let moved = self.latest.relative_to(&self.given);
        self.given = self.latest;
        Increment { forward_m: moved.x_m as f32, left_m: moved.y_m as f32, turn_rad: moved.theta_rad as f32 }
    }
}
