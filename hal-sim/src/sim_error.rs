//! Why a simulation cannot start.

use core::fmt;

/// Why a simulation cannot start.
#[derive(Clone, Debug, PartialEq)]
pub enum SimError {
    /// The rig has an analogue sensor (its index) and no converter.
    NeedsAdc(usize),
    /// The sample rate is not in 1 to 100 Hz.
    Rate(f64),
    /// The robot would start inside something: nearest thing and body radius, metres.
    StartBlocked(f64, f64),
    /// A kidnapped robot (index of the kidnap) would be put down inside something: nearest thing and body radius, metres.
    PlaceBlocked(usize, f64, f64),
    /// A range sensor that fails (index of the fault, and of the sensor) is none of the rig, which has so many.
    NoSuchSensor(usize, usize, usize),
}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NeedsAdc(sensor) => {
                write!(
                    f,
                    "rig: range_sensor {sensor} is analogue (scale_m, exponent, noise_v): an [adc] section is needed"
                )
            }
            Self::Rate(rate_hz) => write!(f, "sample rate {rate_hz} Hz: 1 to 100 is allowed"),
            Self::StartBlocked(clearance_m, radius_m) => write!(
                f,
                "the start ([start] of the plan, or --start) is {clearance_m:.2} m from the nearest wall or thing; the robot's radius is {radius_m:.2} m"
            ),
            Self::PlaceBlocked(kidnap, clearance_m, radius_m) => write!(
                f,
                "kidnap[{kidnap}].to_m is {clearance_m:.2} m from the nearest wall or thing; the robot's radius is {radius_m:.2} m"
            ),
            Self::NoSuchSensor(fault, sensor, sensors) => {
                write!(f, "fault[{fault}].sensor is {sensor}; the rig has {sensors} range sensors, counted from 0")
            }
        }
    }
}

impl std::error::Error for SimError {}
