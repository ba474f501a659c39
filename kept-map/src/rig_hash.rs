//! Which robot made a record.

use crate::record::CRC;
use slam_core::{DriveModel, RangeModel, Rig};

/// A number that differs for rigs that differ in anything that the estimator is told: CRC-32 of all their values' bits.
pub fn rig_hash<const S: usize>(rig: &Rig<S>) -> u32 {
    let mut digest = CRC.digest();
    let mut add = |values: &[f32]| {
        digest.update(&(values.len() as u32).to_le_bytes());
        values.iter().for_each(|value| digest.update(&value.to_le_bytes()));
    };
    match rig.drive {
        DriveModel::Wheels { track_m, track_sigma, metres_per_tick, scale_sigma, noise_m2_per_m } => {
            add(&[track_m, track_sigma, metres_per_tick, scale_sigma, noise_m2_per_m]);
        }
        DriveModel::Odometry { scale_sigma, noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, veer_sigma } => {
            add(&[scale_sigma, noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, veer_sigma, 0.0]);
        }
    }
    if let Some(adc) = rig.adc {
        add(&[f32::from(adc.bits), adc.vref_v]);
    }
    for sensor in &rig.sensors {
        let mount = sensor.mount;
        add(&[mount.x_m, mount.y_m, mount.bearing_rad]);
        add(&[sensor.min_m, sensor.max_m, sensor.max_incidence_rad, sensor.gain_sigma]);
        match sensor.model {
            RangeModel::Sharp { scale_m, exponent, noise_v } => add(&[scale_m, exponent, noise_v]),
            RangeModel::Metric { noise_m, noise_rel } => add(&[noise_m, noise_rel]),
        }
    }
    digest.finalize()
}
