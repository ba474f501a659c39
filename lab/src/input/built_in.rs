//! The robot that is simulated when no rig file is given.

use std::path::Path;

use crate::error::FileError;
use crate::input::rig_file::Robot;

/// Names of the built-in robot's sensors, in their order.
const BUILT_IN_NAMES: [&str; 8] =
    ["front", "front_left", "left", "back_left", "back", "back_right", "right", "front_right"];

/// The robot that is simulated when no rig file is given, and its rig file's text.
///
/// # Errors
/// Never for the built-in robot as it is; what is wrong with it otherwise.
pub fn built_in_robot() -> Result<(Robot, String), FileError> {
    let robot = Robot { rig: hal_sim::default_rig(), names: BUILT_IN_NAMES.map(str::to_owned).to_vec() };
    let text = robot.to_toml();
    // A replay reads this text: the run must use the same values.
    Ok((Robot::parse(Path::new("built-in rig"), &text)?, text))
}
