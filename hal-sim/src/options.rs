//! Settings of the simulation that are not the rig's and not the plan's.

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
    /// Travel lost in one slip, metres.
    pub slip_m: f64,
}

impl Default for DriveOptions {
    fn default() -> Self {
        Self { full_speed_mps: 0.6, lag_s: 0.08, dead_duty: 0.04, slips_per_m: 0.0, slip_m: 0.01 }
    }
}

/// Every setting of the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimOptions {
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
}

impl Default for SimOptions {
    fn default() -> Self {
        Self {
            rate_hz: 25.0,
            body_radius_m: crate::rig::BODY_RADIUS_M,
            drive: DriveOptions::default(),
            sharp: SharpOptions::default(),
            lost_beyond_rad: None,
        }
    }
}
