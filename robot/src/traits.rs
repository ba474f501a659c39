//! What a board offers. Digital inputs, PWM and delays are `embedded-hal` traits; it has none for the things here.

use slam_core::{RangeInput, Ticks};

/// Every range sensor of the robot, in the rig's order: converter counts, metres, or some of each.
#[expect(async_fn_in_trait, reason = "one executor runs the task that reads: its futures need not be Send")]
pub trait RangeSensorBank<const S: usize> {
    /// What can go wrong on the bus or the converter.
    type Error;

    /// The latest reading of each sensor, or why this one could not be read; [`RangeInput::Missing`] where it sees nothing.
    async fn read(&mut self) -> [Result<RangeInput, Self::Error>; S];
}

/// A range sensor on a bus that reports metres, such as one that measures the light's time of flight.
#[expect(async_fn_in_trait, reason = "one executor runs the task that reads: its futures need not be Send")]
pub trait MetricSensor {
    /// What can go wrong on the bus.
    type Error;

    /// The latest range, metres; none where the sensor sees nothing.
    ///
    /// # Errors
    /// The sensor could not be read.
    async fn range_m(&mut self) -> Result<Option<f32>, Self::Error>;
}

/// The encoders of both wheels.
pub trait WheelEncoders {
    /// What can go wrong.
    type Error;

    /// Cumulative counts, forward positive. They may wrap at 32 bits.
    ///
    /// # Errors
    /// The counters could not be read.
    fn ticks(&mut self) -> Result<Ticks, Self::Error>;
}

/// Both motors.
pub trait DriveMotors {
    /// What can go wrong.
    type Error;

    /// Drive each wheel with a share of the supply; values outside -1 to 1 are limited, not-a-number stops the wheel.
    ///
    /// # Errors
    /// An output could not be set; the motors may be in any state and the caller should try to stop them.
    fn set_duty(&mut self, duty: Duty) -> Result<(), Self::Error>;

    /// Brake both wheels.
    ///
    /// # Errors
    /// As [`DriveMotors::set_duty`].
    fn stop(&mut self) -> Result<(), Self::Error> {
        self.set_duty(Duty::default())
    }
}

/// Share of the supply at each motor: -1 (full speed backwards) to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Duty {
    /// Left wheel.
    pub left: f32,
    /// Right wheel.
    pub right: f32,
}

/// Speed of each wheel over the ground, metres per second, forward positive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelSpeeds {
    /// Left wheel, m/s.
    pub left_mps: f32,
    /// Right wheel, m/s.
    pub right_mps: f32,
}

impl WheelSpeeds {
    /// Standing still.
    pub const STOP: Self = Self { left_mps: 0.0, right_mps: 0.0 };

    /// Wheel speeds for a forward speed (m/s) and a turn rate (rad/s, counter-clockwise) with this track (m).
    pub fn from_twist(forward_mps: f32, turn_radps: f32, track_m: f32) -> Self {
        let half_mps = 0.5 * track_m * turn_radps;
        Self { left_mps: forward_mps - half_mps, right_mps: forward_mps + half_mps }
    }

    /// Whether the axle's centre is to move forward.
    pub fn is_forward(&self) -> bool {
        self.left_mps + self.right_mps > 1e-4
    }
}

/// A memory that lasts over a reset, as backup RAM does. It may be written as often as one likes.
pub trait LastingMemory {
    /// The byte at this place; 0 where there is none.
    fn read(&self, place: usize) -> u8;
    /// Writes a byte at this place, if there is one.
    fn write(&mut self, place: usize, byte: u8);
}

impl<const N: usize> LastingMemory for [u8; N] {
    fn read(&self, place: usize) -> u8 {
        self.get(place).copied().unwrap_or(0)
    }

    fn write(&mut self, place: usize, byte: u8) {
        if let Some(cell) = self.get_mut(place) {
            *cell = byte;
        }
    }
}

/// One wheel's 16-bit hardware counter, unwrapped to 32 bits.
///
/// Right as long as less than half a turn of the counter (32768 ticks) passes between two readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WheelCounter {
    last: u16,
    total: i32,
}

impl WheelCounter {
    /// A counter that counts from zero, its hardware standing at `raw` now.
    pub fn starting_at(raw: u16) -> Self {
        Self { last: raw, total: 0 }
    }

    /// The cumulative count with the hardware standing at `raw`.
    pub fn update(&mut self, raw: u16) -> i32 {
        let step = raw.wrapping_sub(self.last).cast_signed();
        self.last = raw;
        self.total = self.total.wrapping_add(i32::from(step));
        self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counter_unwraps_in_both_directions() {
        let mut counter = WheelCounter::starting_at(65_530);
        assert_eq!(counter.update(4), 10);
        assert_eq!(counter.update(65_530), 0);
        assert_eq!(counter.update(32_770), -32_760);
        assert_eq!(counter.update(20), -65_510);
    }

    #[test]
    fn a_turn_to_the_left_runs_the_right_wheel_faster() {
        let speeds = WheelSpeeds::from_twist(0.2, 1.0, 0.2);
        assert!((speeds.left_mps - 0.1).abs() < 1e-6 && (speeds.right_mps - 0.3).abs() < 1e-6);
        assert!(speeds.is_forward());
        assert!(!WheelSpeeds::from_twist(0.0, 2.0, 0.2).is_forward());
    }
}
