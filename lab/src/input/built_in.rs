//! The robots that need no rig file.

use std::path::Path;

use robot::rig::BuiltIn;
use slam_core::{RangeSensor, Rig};

use crate::input::rig_file::{MAX_SENSORS, Robot};
use input_file::FileError;

/// The robot that is simulated when no other is named, and its rig file's text.
///
/// # Errors
/// Never for the built-in robot as it is; what is wrong with it otherwise.
pub fn built_in_robot() -> Result<(Robot, String), FileError> {
    built_in(BuiltIn::default())
}

/// What the simulated robot with a dead-reckoned pose is called.
const ODOMETRY: &str = "odometry";

/// A built-in robot, and its rig file's text.
///
/// # Errors
/// Never for the built-in robots as they are; what is wrong with one otherwise.
pub fn built_in(kind: BuiltIn) -> Result<(Robot, String), FileError> {
    named(kind.name(), kind.rig())
}

fn named(name_of_rig: &str, rig: Rig<MAX_SENSORS>) -> Result<(Robot, String), FileError> {
    let names = rig.sensors.iter().map(|sensor| name(sensor).to_owned()).collect();
    let text = Robot { rig, names, hand_overs: None }.to_toml();
    // A replay reads this text: the run must use the same values.
    Ok((Robot::parse(Path::new(name_of_rig), &text)?, text))
}

/// The robot that is called so, or that this rig file describes, and its rig file's text.
///
/// # Errors
/// The rig file cannot be used.
pub fn robot(rig: &Path) -> Result<(Robot, String), FileError> {
    if let Some(kind) = BuiltIn::ALL.into_iter().find(|kind| Path::new(kind.name()) == rig) {
        return built_in(kind);
    }
    if rig == Path::new(ODOMETRY) {
        return named(ODOMETRY, hal_sim::odometry_rig());
    }
    if !rig.exists() {
        let names = BuiltIn::ALL.map(BuiltIn::name).join(", ");
        let what = format!(
            "cannot read: there is no such file, and no such built-in robot; built in are {names} and {ODOMETRY}"
        );
        return Err(FileError::new(rig, what));
    }
    let text = input_file::read(rig)?;
    Ok((Robot::parse(rig, &text)?, text))
}

/// What a sensor is called by its bearing, in eighth turns.
fn name(sensor: &RangeSensor) -> &'static str {
    const NAMES: [&str; 8] = ["front", "front_left", "left", "back_left", "back", "back_right", "right", "front_right"];
    let eighths = (sensor.mount.bearing_rad.to_degrees() / 45.0).round() as i32;
    NAMES[eighths.rem_euclid(8) as usize]
}
