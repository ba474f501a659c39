//! The robot's size, and how it drives.

/// Size of the robot and manner of driving.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PilotConfig {
    /// Cruising speed, m/s.
    pub speed_mps: f32,
    /// Fastest turn, rad/s. A Sharp reading is some 40 ms old: at 0.8 rad/s its beam has turned by 2 degrees since.
    pub turn_radps: f32,
    /// Radius of the body, metres.
    pub radius_m: f32,
    /// Distance between the wheels, metres.
    pub track_m: f32,
    /// Distance that the robot's centre keeps from walls beside it, metres: beyond the sensors' minimum range.
    pub standoff_m: f32,
    /// Edge of a cell of the picture, metres.
    pub cell_m: f32,
    /// Readings beyond this range are too noisy to place a wall, metres.
    pub trusted_m: f32,
}

impl PilotConfig {
    /// Of a pilot that is yet to be prepared.
    pub(super) const ZEROS: Self = Self {
        speed_mps: 0.0,
        turn_radps: 0.0,
        radius_m: 0.0,
        track_m: 0.0,
        standoff_m: 0.0,
        cell_m: 0.0,
        trusted_m: 0.0,
    };

    /// Of the robot that this project builds.
    pub const DEFAULT: Self = Self {
        speed_mps: 0.25,
        turn_radps: 0.8,
        radius_m: 0.17,
        track_m: 0.235,
        standoff_m: 0.33,
        cell_m: 0.15,
        trusted_m: 1.1,
    };
}

impl Default for PilotConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}
