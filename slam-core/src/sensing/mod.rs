//! From a range sensor's input to a reading, and what is known of the errors of readings.

pub mod bend;
pub mod correlation;
pub mod latency;
pub mod noise_level;
pub mod output_noise;
pub mod range;
pub mod sign;
pub mod stamps;
pub mod surface;

/// What is learned of the errors of readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensingSettings {
    /// Estimate sensor gains whose prior sigma is not zero.
    pub calibrate_gains: bool,
    /// Estimate how late the readings of sensors that report metres are.
    pub calibrate_latency: bool,
    /// Estimate how far each row's readings in metres are from the moment of its motion, and how far they are as a rule.
    pub stamps: bool,
    /// Estimate how late the readings of analogue sensors are, where none reports metres.
    pub calibrate_age: bool,
    /// Learn from the innovations how large the noise is, where sensors report metres.
    pub learn_noise: bool,
    /// Readings of one stretch of wall repeat its surface's error, where the sensor reports metres.
    pub repeats: bool,
    /// A wall whose readings turn the robot one way counts for less, where the sensor reports metres.
    pub bends: bool,
}

impl SensingSettings {
    pub(crate) const IDLE: Self = Self {
        calibrate_gains: false,
        calibrate_latency: false,
        stamps: false,
        calibrate_age: false,
        learn_noise: false,
        repeats: false,
        bends: false,
    };

    /// For sensors whose readings are late, and rigs whose noise is a guess.
    pub fn real_rooms() -> Self {
        Self { calibrate_latency: true, stamps: true, learn_noise: true, ..Self::default() }
    }
}

impl Default for SensingSettings {
    fn default() -> Self {
        Self {
            calibrate_gains: true,
            calibrate_latency: false,
            stamps: false,
            calibrate_age: true,
            learn_noise: false,
            repeats: true,
            bends: true,
        }
    }
}
