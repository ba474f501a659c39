//! Cumulative dead-reckoned poses to body-frame increments.

use slam_core::Increment;

use crate::recording::Pose2;

/// Differences successive poses, in f64: a cumulative pose far from its origin has no digits to spare in f32.
#[derive(Debug, Default)]
pub struct Differencer {
    last: Option<Pose2>,
}

impl Differencer {
    /// The motion since the previous pose, in that pose's frame; zero for the first.
    pub fn step(&mut self, pose: Pose2) -> Increment {
        let Some(last) = self.last.replace(pose) else { return Increment::default() };
        let moved = last.relative(&pose);
        Increment { forward_m: moved.x_m as f32, left_m: moved.y_m as f32, turn_rad: moved.theta_rad as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn motion_is_in_the_previous_robots_frame_and_turns_are_wrapped() {
        let mut differencer = Differencer::default();
        let far = 1e6;
        assert_eq!(differencer.step(Pose2 { x_m: far, y_m: 5.0, theta_rad: FRAC_PI_2 }), Increment::default());
        let step = differencer.step(Pose2 { x_m: far - 0.001, y_m: 5.002, theta_rad: PI - 0.001 });
        assert!((step.forward_m - 0.002).abs() < 1e-9, "{step:?}");
        assert!((step.left_m - 0.001).abs() < 1e-9, "{step:?}");
        let step = differencer.step(Pose2 { x_m: far - 0.001, y_m: 5.002, theta_rad: -PI + 0.001 });
        assert!((step.turn_rad - 0.002).abs() < 1e-6, "{step:?}");
    }
}
