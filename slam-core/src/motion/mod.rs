//! From ticks or dead-reckoned increments to the predicted pose (Rousse & Qiu 3.1).

pub mod dead_reckoning;
pub mod drive;
pub mod mean_motion;
pub mod shortfall;
pub mod step;
pub mod travel;

/// How much wheels and dead reckoning slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Slip {
    /// Not at all beyond the noise that the rig states.
    Stated,
    /// By as much more as the readings put right: where the rig states what a clean floor does.
    Learned,
    /// In runs and in turns, by what was measured on floors: where whoever wrote the rig guessed.
    OfFloors,
}

/// How motion is predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotionSettings {
    /// Estimate wheel scales or odometry scales whose prior sigma is not zero.
    pub calibrate_scales: bool,
    /// Estimate the track where its prior sigma is not zero.
    pub calibrate_track: bool,
    /// How much wheels and dead reckoning slip beyond the noise that the rig states.
    pub slip: Slip,
    /// Scales, track and veer multiply the mean motion of the last while, which has less noise than that of a step.
    pub mean_travel: bool,
    /// Odometry may have no sign and say forwards where the robot drove backwards: the ranges of sensors that report metres tell.
    pub find_sign: bool,
    /// The readings tell when something holds the robot while its wheels turn. With wheels alone: where a pose is logged, what
    /// turned is not known.
    pub find_holds: bool,
}

impl MotionSettings {
    pub(crate) const IDLE: Self = Self {
        calibrate_scales: false,
        calibrate_track: false,
        slip: Slip::Stated,
        mean_travel: false,
        find_sign: false,
        find_holds: false,
    };

    /// For floors and odometry as they are.
    pub fn real_rooms() -> Self {
        Self { slip: Slip::OfFloors, find_sign: true, ..Self::default() }
    }
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            calibrate_scales: true,
            calibrate_track: true,
            slip: Slip::Learned,
            mean_travel: true,
            find_holds: true,
            ..Self::IDLE
        }
    }
}
