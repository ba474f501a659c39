//! From a point to go to and the readings of the moment to a forward speed and a turn rate.

use slam_core::angle::wrap;
use slam_core::{Pose, Rig};

use super::PilotConfig;

/// One sensor as the pilot sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Beam {
    pub mount_m: [f32; 2],
    pub direction: [f32; 2],
    pub min_m: f32,
    pub max_m: f32,
    /// Last reading, metres, and the number of steps since.
    pub range_m: f32,
    pub age: u8,
}

impl Beam {
    /// The beams of a rig, none of them read yet.
    pub(super) fn of_rig<const S: usize>(rig: &Rig<S>) -> [Beam; S] {
        let mut beams = [Beam { age: u8::MAX, ..Beam::default() }; S];
        for (beam, sensor) in beams.iter_mut().zip(&rig.sensors) {
            let (s, c) = slam_core::angle::sin_cos(sensor.mount.bearing_rad);
            beam.mount_m = [sensor.mount.x_m, sensor.mount.y_m];
            beam.direction = [c, s];
            beam.min_m = sensor.min_m;
            beam.max_m = sensor.max_m;
        }
        beams
    }

    /// Takes this step's reading, if there is one that the sensor can make.
    pub(super) fn take(&mut self, range_m: Option<f32>) {
        match range_m {
            Some(range_m) if range_m >= self.min_m && range_m <= self.max_m => {
                self.range_m = range_m;
                self.age = 0;
            }
            _ => self.age = self.age.saturating_add(1),
        }
    }

    /// A point on the beam in the robot's frame, metres.
    pub(super) fn point_m(&self, range_m: f32) -> [f32; 2] {
        [self.mount_m[0] + range_m * self.direction[0], self.mount_m[1] + range_m * self.direction[1]]
    }

    /// Where the beam ends in the robot's frame, if it was read in the last moments.
    fn hit_m(&self) -> Option<[f32; 2]> {
        (self.age <= 3).then(|| self.point_m(self.range_m))
    }
}

/// Free way straight ahead of the body (or behind it), metres.
pub(super) fn gap_m(beams: &[Beam], config: &PilotConfig, backwards: bool) -> f32 {
    let sign = if backwards { -1.0 } else { 1.0 };
    let half_width_m = config.radius_m + 0.03;
    let mut gap_m = f32::INFINITY;
    for [x_m, y_m] in beams.iter().filter_map(Beam::hit_m) {
        let ahead_m = sign * x_m;
        if ahead_m > 0.0 && y_m.abs() < half_width_m {
            let bow_m = libm::sqrtf((half_width_m * half_width_m - y_m * y_m).max(0.0));
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
pub(super) fn towards(point_m: [f32; 2], pose: &Pose, beams: &[Beam], config: &PilotConfig) -> (f32, f32) {
    let bearing_rad = libm::atan2f(point_m[1] - pose.y_m, point_m[0] - pose.x_m);
    let error_rad = wrap(bearing_rad - pose.theta_rad);
    let gap_m = gap_m(beams, config, false);
    let aligned = (1.0 - error_rad.abs() / 0.9).max(0.0);
    let forward_mps = (config.speed_mps * aligned).min(((gap_m - 0.04) * 1.5).max(0.0));
    let aside_radps = if forward_mps > 0.0 { 3.0 * push_left_m(beams, config) } else { 0.0 };
    let turn_radps = (2.5 * error_rad + aside_radps).clamp(-config.turn_radps, config.turn_radps);
    (forward_mps, turn_radps)
}
