//! Rigs of any numbers: refused with words, or good enough for a drive.

use slam_core::{Adc, Config, DriveModel, HostSlam, Mount, RangeModel, RangeSensor, Rig};

use super::drive::drive;
use super::source::Source;

/// A number as a rig has it, or one a thousand times off, or an odd one.
fn value(source: &mut Source, usual: f64) -> f32 {
    match source.below(8) {
        0 => source.odd(),
        1 => (usual * source.decades(1e-6, 1e6)) as f32,
        2 => 0.0,
        _ => (usual * source.decades(0.3, 3.0)) as f32,
    }
}

/// Builds a rig of the bytes' numbers, and drives with it where it passes the checks; the number of steps.
pub fn rigs(bytes: &[u8]) -> u64 {
    let mut source = Source::new(bytes);
    let s = &mut source;
    let drive_model = if s.chance(128) {
        DriveModel::Wheels {
            track_m: value(s, 0.2),
            track_sigma: value(s, 0.01),
            metres_per_tick: value(s, 5e-4),
            scale_sigma: value(s, 0.01),
            noise_m2_per_m: value(s, 1e-5),
        }
    } else {
        DriveModel::Odometry {
            scale_sigma: value(s, 0.05),
            noise_m2_per_m: value(s, 1e-4),
            noise_rad2_per_m: value(s, 1e-4),
            noise_rad2_per_rad: value(s, 1e-3),
            veer_sigma: value(s, 0.05),
        }
    };
    let adc = Some(Adc { bits: s.byte() % 20, vref_v: value(s, 3.3) });
    let sensors = (0..s.below(9)).map(|_| sensor(s)).collect();
    let rig = Rig { drive: drive_model, adc, sensors };
    let gate = if s.chance(32) { s.odd() } else { 10.83 };
    let mut config = Config::for_rig(&rig);
    config.measurement.gate = gate;
    match HostSlam::with_config(rig.clone(), config) {
        Ok(slam) => drive(slam, &rig, source),
        Err(error) => {
            assert!(!error.key.is_empty() && !error.allowed.is_empty(), "{error:?}");
            1
        }
    }
}

fn sensor(s: &mut Source) -> RangeSensor {
    let model = if s.chance(128) {
        RangeModel::Sharp { scale_m: value(s, 0.6), exponent: -value(s, 1.16), noise_v: value(s, 0.01) }
    } else {
        RangeModel::Metric { noise_m: value(s, 0.01), noise_rel: value(s, 0.01) }
    };
    RangeSensor {
        mount: Mount { x_m: value(s, 0.1), y_m: -value(s, 0.1), bearing_rad: value(s, 1.0) },
        min_m: value(s, 0.1),
        max_m: value(s, 2.0),
        max_incidence_rad: value(s, 1.0),
        gain_sigma: value(s, 0.01),
        model,
    }
}
