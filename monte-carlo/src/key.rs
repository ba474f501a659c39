//! The quantities that an experiment can set, sweep or draw.

use input_file::{Allowed, Limits as _, NotNegative};

/// A quantity that an experiment can set, sweep or draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Key {
    /// 1-sigma of the range sensors' gains; the true gains are drawn from it.
    GainSigma,
    /// 1-sigma of the wheels' scales; the true scales are drawn from it.
    ScaleSigma,
    /// 1-sigma of the track; the true track is drawn from it.
    TrackSigma,
    /// True gains, scales and track are drawn with so many times the sigmas that the estimator is told.
    ErrorRatio,
    /// 1-sigma of the range sensors' output, volts.
    NoiseV,
    /// The same as it really is, where the estimator is told another one, volts.
    TrueNoiseV,
    /// Longest range that is a reading, metres.
    MaxRange,
    /// Number of range sensors: 8, 6, 4 or 2.
    Sensors,
    /// Mean age of an analogue reading that is new at each sample, milliseconds; not set: the sensors' measuring cycle.
    Age,
    /// Largest difference of one sensor's age from that, milliseconds.
    AgeSpread,
    /// Time constant of the board's low-pass behind each analogue sensor, milliseconds.
    Filter,
    /// Cruising speed, m/s.
    Speed,
    /// Samples per second.
    Rate,
    /// 1-sigma of the error of a sample's time stamp, milliseconds.
    StampJitter,
    /// Poses per second of the dead reckoning that samples have instead of ticks.
    OdometryRate,
    /// Longest step of the physics, milliseconds.
    Tick,
    /// Wheel slips per metre.
    Slips,
    /// Mean travel lost in one slip, metres.
    SlipLength,
    /// 1-sigma of the logarithm of that travel.
    SlipTail,
    /// Turn per metre driven by unequal wheels, beyond what `scale_sigma` draws, degrees.
    Drift,
    /// Chair legs strewn over the rooms.
    ChairLegs,
    /// People walking in the rooms.
    People,
    /// Angle by which the walls miss the right angle, degrees.
    Skew,
    /// Angle by which inner walls are turned against the outer ones, degrees.
    Inner,
    /// Largest angle by which each piece of furniture is turned about its middle, degrees.
    Furniture,
    /// 1-sigma of the angle by which each face of a wall or thing is off where it should stand, degrees.
    Scatter,
    /// When the plan's doors of the experiment close, seconds.
    DoorCloses,
    /// When they open again, seconds.
    DoorOpens,
    /// Length of the drive, minutes.
    Minutes,
}

const RELATIVE: Allowed =
    Allowed { below_max: true, ..Allowed::within(0.0, 0.5, "a ratio of at least 0 and less than 0.5") };
const VOLTS: Allowed = Allowed::within(0.001, 1.0, "volts from 0.001 to 1");
const AGE: Allowed = Allowed::within(0.0, 200.0, "milliseconds from 0 to 200");
const ANGLE: Allowed = Allowed::within(-20.0, 20.0, "degrees from -20 to 20");
const MINUTES: Allowed = Allowed { above_min: true, ..Allowed::within(0.0, 240.0, "minutes above 0 and up to 240") };

impl Key {
    /// Every key.
    pub const ALL: [Key; 29] = [
        Self::GainSigma,
        Self::ScaleSigma,
        Self::TrackSigma,
        Self::ErrorRatio,
        Self::NoiseV,
        Self::TrueNoiseV,
        Self::MaxRange,
        Self::Sensors,
        Self::Age,
        Self::AgeSpread,
        Self::Filter,
        Self::Speed,
        Self::Rate,
        Self::StampJitter,
        Self::OdometryRate,
        Self::Tick,
        Self::Slips,
        Self::SlipLength,
        Self::SlipTail,
        Self::Drift,
        Self::ChairLegs,
        Self::People,
        Self::Skew,
        Self::Inner,
        Self::Furniture,
        Self::Scatter,
        Self::DoorCloses,
        Self::DoorOpens,
        Self::Minutes,
    ];

    /// As experiment files write it, as the axis of a figure says it, and what its values may be.
    const fn facts(self) -> (&'static str, &'static str, Allowed) {
        match self {
            Self::GainSigma => ("gain_sigma", "1-sigma error of the sensors' gains", RELATIVE),
            Self::ScaleSigma => ("scale_sigma", "1-sigma error of the wheels' scales", RELATIVE),
            Self::TrackSigma => ("track_sigma", "1-sigma error of the track", RELATIVE),
            Self::ErrorRatio => (
                "error_ratio",
                "calibration errors over those stated",
                Allowed::within(0.0, 5.0, "a ratio from 0 to 5"),
            ),
            Self::NoiseV => ("noise_v", "noise of the sensors' output, V", VOLTS),
            Self::TrueNoiseV => ("true_noise_v", "true noise of the sensors' output, V", VOLTS),
            Self::MaxRange => ("max_m", "range limit, m", Allowed::within(0.2, 10.0, "metres from 0.2 to 10")),
            Self::Sensors => ("sensors", "range sensors", Allowed::within(2.0, 8.0, "8, 6, 4 or 2")),
            Self::Age => ("age_ms", "age of readings, ms", AGE),
            Self::AgeSpread => ("age_spread_ms", "ages differ by up to, ms", AGE),
            Self::Filter => ("filter_ms", "time constant of the board's filter, ms", AGE),
            Self::Speed => ("speed_mps", "speed, m/s", Allowed::within(0.05, 0.55, "m/s from 0.05 to 0.55")),
            Self::Rate => ("rate_hz", "samples per second", Allowed::within(1.0, 100.0, "a rate from 1 to 100")),
            Self::StampJitter => ("stamp_jitter_ms", "jitter of time stamps, ms", AGE),
            Self::OdometryRate => {
                ("odometry_hz", "odometry poses per second", Allowed::within(1.0, 100.0, "a rate from 1 to 100"))
            }
            Self::Tick => (
                "tick_ms",
                "longest step of the physics, ms",
                Allowed::within(0.1, 20.0, "milliseconds from 0.1 to 20"),
            ),
            Self::Slips => ("slips_per_m", "wheel slips per metre", Allowed::within(0.0, 100.0, "slips from 0 to 100")),
            Self::SlipLength => {
                ("slip_m", "travel lost in a slip, m", Allowed::within(0.0, 0.2, "metres from 0 to 0.2"))
            }
            Self::SlipTail => {
                ("slip_tail", "1-sigma of a slip's logarithm", Allowed::within(0.0, 2.0, "a number from 0 to 2"))
            }
            Self::Drift => ("drift_deg_per_m", "drift, degrees per metre", ANGLE),
            Self::ChairLegs => {
                ("chair_legs", "chair legs added", Allowed::within(0.0, 200.0, "a number from 0 to 200"))
            }
            Self::People => ("people", "people walking", Allowed::within(0.0, 200.0, "a number from 0 to 200")),
            Self::Skew => ("skew_deg", "walls off the right angle, degrees", ANGLE),
            Self::Inner => ("inner_deg", "inner walls off the outer ones, degrees", ANGLE),
            Self::Furniture => (
                "furniture_deg",
                "furniture askew by up to, degrees",
                Allowed::within(0.0, 45.0, "degrees from 0 to 45"),
            ),
            Self::Scatter => (
                "scatter_deg",
                "scatter of the walls' directions, degrees",
                Allowed::within(0.0, 5.0, "degrees from 0 to 5"),
            ),
            Self::DoorCloses => ("door_closes_s", "door closes at, s", NotNegative::ALLOWED),
            Self::DoorOpens => ("door_opens_s", "door opens at, s", NotNegative::ALLOWED),
            Self::Minutes => ("minutes", "drive, minutes", MINUTES),
        }
    }

    /// As experiment files write it.
    pub const fn name(self) -> &'static str {
        self.facts().0
    }

    /// As the axis of a figure says it.
    pub const fn label(self) -> &'static str {
        self.facts().1
    }

    /// The limits of its values.
    pub const fn allowed(self) -> Allowed {
        self.facts().2
    }

    /// Whether it can have this value.
    pub fn holds(self, value: f64) -> bool {
        self.allowed().holds(value) && (self != Self::Sensors || value % 2.0 == 0.0)
    }

    /// The key of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|key| key.name() == name)
    }
}
