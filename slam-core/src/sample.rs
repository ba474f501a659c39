//! What the robot sensed in one step.

/// Cumulative encoder counts; they may wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ticks {
    /// Left wheel, forward positive.
    pub left: i32,
    /// Right wheel, forward positive.
    pub right: i32,
}

/// Motion since the previous sample, in the robot's frame at the previous sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Increment {
    /// Displacement along the previous heading, metres.
    pub forward_m: f32,
    /// Displacement to the left of the previous heading, metres.
    pub left_m: f32,
    /// Turn, radians counter-clockwise.
    pub turn_rad: f32,
}

/// The motion input of one sample; must fit the rig's [`DriveModel`](crate::DriveModel).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Motion {
    /// Cumulative counts; the first sample's are the reference.
    Ticks(Ticks),
    /// Dead-reckoned motion since the previous sample; the first sample's is ignored.
    Increment(Increment),
}

/// One range sensor's input in one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RangeInput {
    /// No reading.
    #[default]
    Missing,
    /// Raw converter counts of an analogue sensor.
    Counts(u16),
    /// A range in metres.
    Metres(f32),
}

/// Everything sensed at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const S: usize> {
    /// Time, microseconds since any fixed moment; must increase.
    pub time_us: u64,
    /// The motion input.
    pub motion: Motion,
    /// The range sensors, in the rig's order; entries past the rig's sensors are ignored.
    pub ranges: [RangeInput; S],
}

impl<const S: usize> Sample<S> {
    /// The same with nothing seen, as of a robot that tilts or is off the floor.
    pub fn without_ranges(self) -> Self {
        Self { ranges: [RangeInput::Missing; S], ..self }
    }
}
