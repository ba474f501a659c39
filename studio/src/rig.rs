//! The robot with some of its numbers changed, as a rig file.

use std::path::Path;

use lab::input::rig_file::Robot;
use lab::input::{built_in, built_in_robot};
use robot::rig::BuiltIn;
use serde::Deserialize;
use slam_core::{DriveModel, RangeModel};

/// What is changed of a built-in robot.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Knobs {
    /// So many of its sensors are left, spread evenly.
    pub sensors: usize,
    /// Longest range, as a factor.
    pub reach: f32,
    /// Noise of the ranges, as a factor.
    pub noise: f32,
    /// 1-sigma of the sensors' gains, which are drawn with it.
    pub gain_sigma: f32,
    /// 1-sigma of the wheels' scales, which are drawn with it.
    pub wheel_sigma: f32,
}

impl Default for Knobs {
    fn default() -> Self {
        Self { sensors: usize::MAX, reach: 1.0, noise: 1.0, gain_sigma: f32::NAN, wheel_sigma: f32::NAN }
    }
}

/// The robot of this name, or of this rig file's text, and its rig file's text.
///
/// # Errors
/// What is wrong with the text.
pub fn robot_of(rig: &str) -> Result<(Robot, String), String> {
    let named = BuiltIn::ALL.into_iter().find(|kind| kind.name() == rig);
    let found = match (named, rig) {
        (Some(kind), _) => built_in(kind),
        (None, "") => built_in_robot(),
        (None, text) => Robot::parse(Path::new("rig"), text).map(|robot| (robot, text.to_owned())),
    };
    found.map_err(|error| error.to_string())
}

/// The rig file of a robot with some of its numbers changed.
///
/// # Errors
/// There is no such robot, or what is changed makes it impossible.
pub fn tuned(rig: &str, knobs: Knobs) -> Result<String, String> {
    let (mut robot, _) = robot_of(rig)?;
    let all = robot.rig.sensors.len();
    let kept = knobs.sensors.clamp(1, all);
    let is_kept = |index: usize| index * kept % all < kept;
    let mut index = 0..all;
    robot.names.retain(|_| index.next().is_some_and(is_kept));
    let mut index = 0..all;
    robot.rig.sensors.retain(|_| index.next().is_some_and(is_kept));
    for sensor in &mut robot.rig.sensors {
        sensor.max_m *= knobs.reach;
        match &mut sensor.model {
            RangeModel::Sharp { noise_v, .. } => *noise_v *= knobs.noise,
            RangeModel::Metric { noise_m, noise_rel } => {
                *noise_m *= knobs.noise;
                *noise_rel *= knobs.noise;
            }
        }
        if knobs.gain_sigma.is_finite() {
            sensor.gain_sigma = knobs.gain_sigma;
        }
    }
    if let DriveModel::Wheels { scale_sigma, .. } | DriveModel::Odometry { scale_sigma, .. } = &mut robot.rig.drive
        && knobs.wheel_sigma.is_finite()
    {
        *scale_sigma = knobs.wheel_sigma;
    }
    let text = robot.to_toml();
    robot_of(&text).map(|_| text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_sensors_are_left_as_are_asked_for() {
        for sensors in 1..=8 {
            let text = tuned("sharp", Knobs { sensors, ..Knobs::default() }).unwrap();
            assert_eq!(robot_of(&text).unwrap().0.names.len(), sensors, "{text}");
        }
    }

    #[test]
    fn numbers_are_changed_and_impossible_ones_refused() {
        let knobs = Knobs { reach: 0.5, noise: 3.0, gain_sigma: 0.1, wheel_sigma: 0.02, ..Knobs::default() };
        let (before, _) = robot_of("time-of-flight").unwrap();
        let (after, _) = robot_of(&tuned("time-of-flight", knobs).unwrap()).unwrap();
        assert_eq!(after.rig.sensors[0].max_m, 0.5 * before.rig.sensors[0].max_m);
        assert_eq!(after.rig.sensors[1].gain_sigma, 0.1);
        let error = tuned("sharp", Knobs { reach: 0.01, ..Knobs::default() }).unwrap_err();
        assert!(error.contains("max_m"), "{error}");
    }
}
