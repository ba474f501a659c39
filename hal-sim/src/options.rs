//! Settings of the simulation that are not the rig's and not the plan's.

use crate::pose::Pose2;

/// Behaviour of the simulated Sharp sensors beyond what the rig says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpOptions {
    /// Mean length of a measuring cycle, seconds.
    pub period_s: f64,
    /// Largest difference of one unit's mean cycle from `period_s`, seconds.
    pub period_spread_s: f64,
    /// 1-sigma from cycle to cycle, seconds.
    pub jitter_s: f64,
    /// Output for walls far away or none, volts; by default the law's voltage at 1.2 x the sensor's maximum range.
    pub floor_v: Option<f64>,
    /// Probability of a supply spike in one conversion.
    pub spike_probability: f64,
    /// Largest spike, volts; the smallest is a tenth of it.
    pub spike_v: f64,
    /// 1-sigma of the output as it really is, volts; by default what the rig states.
    pub noise_v: Option<f64>,
    /// What every conversion shows; by default the sensor's measuring cycle.
    pub age: Option<Age>,
    /// Time constant of the board's first-order low-pass behind each sensor, seconds; zero: none.
    pub filter_s: f64,
}

/// An output without a cycle: each conversion is a new reading, of how things were some time before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Age {
    /// Mean age of a reading when it is converted, seconds.
    pub mean_s: f64,
    /// Largest difference of one sensor's age from that, seconds; each sensor draws its own.
    pub spread_s: f64,
}

impl SharpOptions {
    /// Where the output reaches its floor, in multiples of the sensor's maximum range.
    pub const FLOOR_RANGE_RATIO: f64 = 1.2;

    /// The floor of the sensor in [`measured_rig`](crate::rig::measured_rig).
    pub fn measured() -> Self {
        Self { floor_v: Some(0.47), ..Self::default() }
    }
}

impl Default for SharpOptions {
    fn default() -> Self {
        Self {
            period_s: 0.0383,
            period_spread_s: 0.0096,
            jitter_s: 0.001,
            floor_v: None,
            spike_probability: 0.0005,
            spike_v: 0.8,
            noise_v: None,
            age: None,
            filter_s: 0.0,
        }
    }
}

/// Behaviour of the simulated drive beyond what the rig says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveOptions {
    /// Speed of a wheel at full duty, m/s.
    pub full_speed_mps: f64,
    /// Time constant of a motor, seconds.
    pub lag_s: f64,
    /// Duty below which a motor does not turn.
    pub dead_duty: f64,
    /// Wheel slips per metre driven: for a short while one wheel turns without pulling. Zero: never.
    pub slips_per_m: f64,
    /// Mean travel lost in one slip, metres.
    pub slip_m: f64,
    /// How uneven slips are: 1-sigma of the logarithm of the travel lost in one. Zero: all are alike.
    pub slip_tail: f64,
    /// Turn per metre driven that unequal wheels make beyond what the rig's `scale_sigma` draws, radians.
    pub drift_rad_per_m: f64,
}

impl Default for DriveOptions {
    fn default() -> Self {
        Self {
            full_speed_mps: 0.6,
            lag_s: 0.08,
            dead_duty: 0.04,
            slips_per_m: 0.0,
            slip_m: 0.01,
            slip_tail: 0.0,
            drift_rad_per_m: 0.0,
        }
    }
}

/// Every setting of the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimOptions {
    /// Where the robot stands at first, in the plan's frame, which it is not told; the plan's start where not given. Truths stay
    /// in the frame of the plan's start.
    pub start: Option<Pose2>,
    /// Samples per second.
    pub rate_hz: f64,
    /// Radius of the robot's body, metres.
    pub body_radius_m: f64,
    /// The drive.
    pub drive: DriveOptions,
    /// The analogue range sensors.
    pub sharp: SharpOptions,
    /// Angle from a wall's normal beyond which nothing comes back, radians; by default each sensor's own limit.
    pub lost_beyond_rad: Option<f64>,
    /// The gains, wheel scales and track are drawn with so many times the sigmas that the rig states.
    pub error_ratio: f64,
    /// Longest step of the physics, seconds.
    pub tick_s: f64,
    /// 1-sigma of the error of a sample's time stamp, seconds; stamps still increase.
    pub stamp_jitter_s: f64,
    /// Samples have dead-reckoned motion instead of ticks: the wheels' pose, published so many times a second, of which a
    /// sample has the latest.
    pub odometry_hz: Option<f64>,
}

impl Default for SimOptions {
    fn default() -> Self {
        Self {
            start: None,
            rate_hz: 25.0,
            body_radius_m: crate::rig::BODY_RADIUS_M,
            drive: DriveOptions::default(),
            sharp: SharpOptions::default(),
            lost_beyond_rad: None,
            error_ratio: 1.0,
            tick_s: 0.01,
            stamp_jitter_s: 0.0,
            odometry_hz: None,
        }
    }
}
