//! From a point to go to and the readings of the moment to a forward speed and a turn rate.

use slam_core::Pose;
use slam_core::angle::wrap;

use super::PilotConfig;
use super::beam::Beam;

/// Free way straight ahead of the body (or behind it), metres.
pub(crate) fn gap_m(beams: &[Beam], config: &PilotConfig, backwards: bool) -> f32 {
    let sign = if backwards { -1.0 } else { 1.0 };
    let half_width_m = config.radius_m + 0.03;
    let mut gap_m = f32::INFINITY;
    for [x_m, y_m] in beams.iter().filter_map(Beam::hit_m) {
        let ahead_m = sign * x_m;
        if ahead_m > 0.0 && y_m.abs() < half_width_m {
            let bow_m = float::sqrtf((half_width_m * half_width_m - y_m * y_m).max(0.0));
            gap_m = gap_m.min(ahead_m - bow_m);
        }
    }
    gap_m
}

/// How much the walls beside the robot push it aside: positive to the left, metres missing to the standoff.
fn push_left_m(beams: &[Beam], config: &PilotConfig) -> f32 {
    let (mut left_m, mut right_m) = (config.standoff_m, config.standoff_m);
    for [x_m, y_m] in beams.iter().filter_map(Beam::hit_m) {
        if x_m > -0.1 && x_m < 0.35 {
            let side = if y_m > 0.0 { &mut left_m } else { &mut right_m };
            *side = side.min(y_m.abs());
        }
    }
    left_m - right_m
}

/// A forward speed (m/s) and a turn rate (rad/s) towards a point of the estimated frame.
pub(crate) fn towards(point_m: [f32; 2], pose: &Pose, beams: &[Beam], config: &PilotConfig) -> (f32, f32) {
    let bearing_rad = libm::atan2f(point_m[1] - pose.y_m, point_m[0] - pose.x_m);
    let error_rad = wrap(bearing_rad - pose.theta_rad);
    let gap_m = gap_m(beams, config, false);
    let aligned = (1.0 - error_rad.abs() / 0.9).max(0.0);
    let forward_mps = (config.speed_mps * aligned).min(((gap_m - 0.04) * 1.5).max(0.0));
    let aside_radps = if forward_mps > 0.0 { 3.0 * push_left_m(beams, config) } else { 0.0 };
    let turn_radps = (2.5 * error_rad + aside_radps).min(config.turn_radps).max(-config.turn_radps);
    (forward_mps, turn_radps)
}

/// What a value is within this limit to either side. Unlike `clamp` it never panics, whatever the limit is, and needs no text for that.
pub(crate) fn limited(value: f32, limit: f32) -> f32 {
    if value > limit {
        limit
    } else if value < -limit {
        -limit
    } else {
        value
    }
}
