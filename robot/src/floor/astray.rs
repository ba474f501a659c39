//! Where a robot goes that does not know where it is: along walls, and after a lap that did not tell it across the floor to others.

use core::f32::consts::{FRAC_PI_2, TAU};

use slam_core::Pose;
use slam_core::angle::wrap;

use crate::pilot::PilotConfig;
use crate::pilot::steer::limited;

/// All the way round an island, or the home's outermost wall, and a quarter more for where the lap began, radians.
const LAP_RAD: f32 = TAU + FRAC_PI_2;

/// Off by less than this the robot drives towards where it wants to go, radians.
const TOWARDS_RAD: f32 = 0.2;

/// Nearer to what is ahead than this it goes along that, metres.
const NEAR_M: f32 = 0.15;

/// How the robot has turned along walls, and where it crosses the floor to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Astray {
    /// Since it is along this wall, radians, counter-clockwise.
    turned_rad: f32,
    /// The heading in which it crosses the floor, radians.
    across_rad: Option<f32>,
}

impl Astray {
    /// Along the first wall.
    pub(super) const NEW: Self = Self { turned_rad: 0.0, across_rad: None };

    /// The robot turned by so much to where it is, with so much room ahead, metres: the heading in which it leaves the wall on its right;
    /// none where it goes along it.
    pub(super) fn heading_rad(&mut self, turned_rad: f32, pose: &Pose, free_m: f32) -> Option<f32> {
        self.turned_rad += turned_rad;
        if self.turned_rad.abs() > LAP_RAD {
            *self = Self { turned_rad: 0.0, across_rad: Some(pose.theta_rad + FRAC_PI_2) };
        }
        // Until there is something ahead, but not what it turns away from.
        self.across_rad = self.across_rad.filter(|heading| is_off(*heading, pose) || free_m > NEAR_M);
        if self.across_rad.is_some() {
            self.turned_rad = 0.0;
        }
        self.across_rad
    }
}

fn is_off(heading_rad: f32, pose: &Pose) -> bool {
    wrap(heading_rad - pose.theta_rad).abs() > TOWARDS_RAD
}

/// Speed and turn rate towards a heading.
pub(super) fn towards(heading_rad: f32, pose: &Pose, drive: &PilotConfig) -> (f32, f32) {
    let forward_mps = if is_off(heading_rad, pose) { 0.0 } else { drive.speed_mps };
    (forward_mps, limited(3.0 * wrap(heading_rad - pose.theta_rad), drive.turn_radps))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn after_a_lap_either_way_it_crosses_the_floor_until_something_is_ahead() {
        for side in [-1.0, 1.0] {
            let (mut astray, mut pose) = (Astray::NEW, Pose::ORIGIN);
            let mut steps = 0;
            let heading_rad = loop {
                let turned_rad = 0.1 * side;
                pose.theta_rad = wrap(pose.theta_rad + turned_rad);
                steps += 1;
                if let Some(heading_rad) = astray.heading_rad(turned_rad, &pose, 1.0) {
                    break heading_rad;
                }
            };
            assert_eq!(steps, 79, "a lap and a quarter");
            assert!((wrap(heading_rad - pose.theta_rad) - FRAC_PI_2).abs() < 1e-5, "away from what is on the right");
            assert!(astray.heading_rad(0.0, &pose, 0.0).is_some(), "it turns away whatever is ahead");
            pose.theta_rad = wrap(heading_rad);
            assert!(astray.heading_rad(FRAC_PI_2, &pose, 1.0).is_some());
            assert!(astray.heading_rad(0.0, &pose, 0.1).is_none(), "along what it has come to");
            assert!(astray.heading_rad(LAP_RAD - 0.1, &pose, 1.0).is_none(), "and round that");
        }
    }
}
