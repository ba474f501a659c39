//! The robot that the workbench simulates when no rig file is given.

use slam_core::{DriveModel, RangeModel, Rig};

/// Radius of the default robot's body, metres.
pub const BODY_RADIUS_M: f64 = 0.17;

/// The robot of [`robot::rig::default_rig`].
pub fn default_rig() -> Rig<16> {
    robot::rig::default_rig()
}

/// The default robot with sensors as one was found on a real robot, instead of its data sheet's: a GP2Y0A21 moved along
/// a rail in front of a wall (4,800 samples against true range). Between 0.15 and 0.7 m its range is 0.322 m x
/// volts^-1.18 within 3 cm; the noise is white, close to normal, and five times the data sheet's. Beyond a metre the
/// output stays near 0.47 V ([`SharpOptions::measured`](crate::SharpOptions::measured)), so that only ranges up to
/// 0.55 m stand clear of it.
pub fn measured_rig() -> Rig<16> {
    let mut rig = default_rig();
    for sensor in &mut rig.sensors {
        sensor.min_m = 0.12;
        sensor.max_m = 0.55;
        sensor.model = RangeModel::Sharp { scale_m: 0.322, exponent: -1.18, noise_v: 0.065 };
    }
    rig
}

/// The default robot with sensors that reach half as far: the GP2Y0A21YK0F, 0.1 to 0.8 m. The curve is the one through its
/// data sheet's 2.3 V at 0.1 m and 0.4 V at 0.8 m.
pub fn short_rig() -> Rig<16> {
    let mut rig = default_rig();
    for sensor in &mut rig.sensors {
        sensor.min_m = 0.1;
        sensor.max_m = 0.8;
        sensor.model = RangeModel::Sharp { scale_m: 0.269, exponent: -1.189, noise_v: 0.012 };
    }
    rig
}

/// The default rig with the sensors at these indices only, in this order: for robots with fewer of them.
pub fn default_rig_with(sensors: &[usize]) -> Rig<16> {
    let full = default_rig();
    let kept = sensors.iter().filter_map(|&i| full.sensors.get(i).copied()).take(16).collect();
    Rig { sensors: kept, ..full }
}

/// The robot of [`robot::rig::time_of_flight_rig`] with a dead-reckoned pose instead of ticks, as a driver publishes it.
pub fn odometry_rig() -> Rig<16> {
    let drive = DriveModel::Odometry {
        scale_sigma: 0.02,
        noise_m2_per_m: 1e-4,
        noise_rad2_per_m: 1e-4,
        noise_rad2_per_rad: 2e-4,
        veer_sigma: 0.0,
    };
    Rig { drive, ..robot::rig::time_of_flight_rig() }
}
