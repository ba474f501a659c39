//! How the floor is swept.

use crate::pilot::PilotConfig;

/// How the floor is swept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorConfig {
    /// Size of the robot and manner of driving.
    pub drive: PilotConfig,
    /// Speed along lanes and on the way to them, m/s.
    pub open_mps: f32,
    /// Gap between body and wall when it goes along one, metres.
    pub gap_m: f32,
    /// Age of a reading when it is used, seconds.
    pub reading_age_s: f32,
    /// Voltage of the battery below which the robot goes home, volts.
    pub low_v: f32,
    /// Voltage of the battery below which it stops where it is, volts.
    pub empty_v: f32,
    /// Voltage of the battery above which it leaves the dock, volts.
    pub full_v: f32,
}

impl FloorConfig {
    /// Of the robot that this project builds.
    pub const DEFAULT: Self = Self {
        drive: PilotConfig { turn_radps: 1.2, ..PilotConfig::DEFAULT },
        open_mps: 0.3,
        // Nearer, more floor is swept and hardly more is bumped into, but beams begin deeper in the blind zone, where what the sensors show folds
        // back: robots whose sensors are mounted farther out drive farther for the same floor.
        gap_m: 0.012,
        reading_age_s: 0.038,
        // Three lithium cells: at 3.5 V a tenth of their charge is left, at 4.1 V they take up little more. Below 3.3 V the voltage falls
        // fast, to where it harms them.
        low_v: 10.5,
        empty_v: 10.0,
        full_v: 12.3,
    };
}

impl Default for FloorConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}
