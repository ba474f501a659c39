//! A rig's values that cannot be, and the key that each is called by.

use std::vec::Vec;

use crate::{Adc, Config, DriveModel, Mount, RangeModel, RangeSensor, Rig, Slam};

const WHEELS: [f32; 5] = [0.235, 0.0, 0.000_445, 0.005, 1e-5];
const ODOMETRY: [f32; 4] = [0.05, 4e-4, 2e-4, 1e-3];

fn wheels([track_m, track_sigma, metres_per_tick, scale_sigma, noise_m2_per_m]: [f32; 5]) -> DriveModel {
    DriveModel::Wheels { track_m, track_sigma, metres_per_tick, scale_sigma, noise_m2_per_m }
}

fn odometry([scale_sigma, noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad]: [f32; 4]) -> DriveModel {
    DriveModel::Odometry { scale_sigma, noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, veer_sigma: 0.05 }
}

const SHARP: RangeModel = RangeModel::Sharp { scale_m: 0.6, exponent: -1.16, noise_v: 0.012 };
const METRIC: RangeModel = RangeModel::Metric { noise_m: 0.01, noise_rel: 0.02 };

fn sensor(model: RangeModel) -> RangeSensor {
    RangeSensor {
        mount: Mount { x_m: 0.1, y_m: -0.05, bearing_rad: 0.5 },
        min_m: 0.2,
        max_m: 1.5,
        max_incidence_rad: 1.2,
        gain_sigma: 0.01,
        model,
    }
}

/// One good sensor of each kind.
fn rig() -> Rig<4> {
    let sensors = [sensor(METRIC), sensor(SHARP)].into_iter().collect();
    Rig { drive: wheels(WHEELS), adc: Some(Adc { bits: 12, vref_v: 3.3 }), sensors }
}

/// The error of a rig after `spoil`, which the constructor reports too.
fn error(spoil: impl Fn(&mut Rig<4>)) -> Option<(Option<u8>, &'static str)> {
    let mut rig = rig();
    spoil(&mut rig);
    let error = rig.validate().err();
    let of_slam = Slam::<4, 4, 16, { crate::ekf::storage(24) }>::with_config(rig, Config::default()).err();
    assert_eq!(error, of_slam);
    assert!(error.is_none_or(|e| !e.allowed.is_empty()));
    error.map(|e| (e.sensor, e.key))
}

const NO_NUMBERS: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

fn and_no_numbers(values: &[f32]) -> Vec<f32> {
    values.iter().copied().chain(NO_NUMBERS).collect()
}

#[test]
fn good_rigs_are_good() {
    assert_eq!(error(|_| {}), None);
    assert_eq!(error(|rig| rig.drive = odometry(ODOMETRY)), None);
    assert_eq!(error(|rig| rig.drive = odometry([0.0; 4])), None);
    assert_eq!(error(|rig| rig.sensors.clear()), None);
    assert_eq!(
        error(|rig| {
            rig.adc = None;
            rig.sensors.truncate(1);
        }),
        None,
        "metric sensors need no converter"
    );
    assert_eq!(error(|rig| rig.adc = Some(Adc { bits: 16, vref_v: 1.8 })), None);
    assert_eq!(error(|rig| rig.sensors[0].model = RangeModel::Metric { noise_m: 0.0, noise_rel: 0.02 }), None);
}

#[test]
fn each_value_of_the_drive_is_named() {
    let no_length = and_no_numbers(&[0.0, -0.1, 11.0]);
    let no_noise = and_no_numbers(&[-1e-9, 1.1]);
    let not_relative = and_no_numbers(&[-0.01, 0.5, 3.0]);
    let of_wheels = [
        ("track_m", &no_length),
        ("track_sigma", &not_relative),
        ("metres_per_tick", &no_length),
        ("scale_sigma", &not_relative),
        ("noise_m2_per_m", &no_noise),
    ];
    for (i, (key, values)) in of_wheels.into_iter().enumerate() {
        for value in values {
            let mut spoilt = WHEELS;
            spoilt[i] = *value;
            assert_eq!(error(|rig| rig.drive = wheels(spoilt)), Some((None, key)), "{value}");
        }
    }
    let of_odometry = [
        ("scale_sigma", &not_relative),
        ("noise_m2_per_m", &no_noise),
        ("noise_rad2_per_m", &no_noise),
        ("noise_rad2_per_rad", &no_noise),
    ];
    for (i, (key, values)) in of_odometry.into_iter().enumerate() {
        for value in values {
            let mut spoilt = ODOMETRY;
            spoilt[i] = *value;
            assert_eq!(error(|rig| rig.drive = odometry(spoilt)), Some((None, key)), "{value}");
        }
    }
}

#[test]
fn the_converter_is_named() {
    for bits in [0, 17, 255] {
        assert_eq!(error(|rig| rig.adc = Some(Adc { bits, vref_v: 3.3 })), Some((None, "bits")), "{bits}");
    }
    for vref_v in and_no_numbers(&[0.0, -3.3, 3300.0]) {
        assert_eq!(error(|rig| rig.adc = Some(Adc { bits: 12, vref_v })), Some((None, "vref_v")), "{vref_v}");
    }
    assert_eq!(error(|rig| rig.adc = None), Some((Some(1), "adc")), "the analogue sensor is the second");
}

#[test]
fn each_value_of_a_sensor_is_named_and_so_is_the_sensor() {
    type Spoil = fn(&mut RangeSensor, f32);
    let cases: [(&str, Spoil, Vec<f32>); 7] = [
        ("x_m", |s, v| s.mount.x_m = v, and_no_numbers(&[-60.0, 60.0])),
        ("y_m", |s, v| s.mount.y_m = v, and_no_numbers(&[-60.0, 60.0])),
        ("bearing_deg", |s, v| s.mount.bearing_rad = v, and_no_numbers(&[6.3, -90.0])),
        ("min_m", |s, v| s.min_m = v, and_no_numbers(&[0.0, -0.2, 200.0])),
        ("max_m", |s, v| s.max_m = v, and_no_numbers(&[0.2, 0.1, -1.0, 1500.0])),
        ("max_incidence_deg", |s, v| s.max_incidence_rad = v, and_no_numbers(&[0.0, -0.3, 1.58])),
        ("gain_sigma", |s, v| s.gain_sigma = v, and_no_numbers(&[-0.01, 0.5])),
    ];
    for (key, spoil, values) in cases {
        for value in values {
            for at in 0..2u8 {
                let found = error(|rig| spoil(&mut rig.sensors[usize::from(at)], value));
                assert_eq!(found, Some((Some(at), key)), "{value}");
            }
        }
    }
}

#[test]
fn each_value_of_a_range_model_is_named() {
    let sharp = |at: usize, value: f32| {
        let mut values = [0.6, -1.16, 0.012];
        values[at] = value;
        let [scale_m, exponent, noise_v] = values;
        error(|rig| rig.sensors[1].model = RangeModel::Sharp { scale_m, exponent, noise_v })
    };
    for value in and_no_numbers(&[0.0, -1.0, 600.0]) {
        assert_eq!(sharp(0, value), Some((Some(1), "scale_m")), "{value}");
        assert_eq!(sharp(2, value), Some((Some(1), "noise_v")), "{value}");
    }
    for value in and_no_numbers(&[0.0, 1.16, -0.01, -4.1]) {
        assert_eq!(sharp(1, value), Some((Some(1), "exponent")), "{value}");
    }
    let metric = |noise_m, noise_rel| error(|rig| rig.sensors[0].model = RangeModel::Metric { noise_m, noise_rel });
    for value in and_no_numbers(&[-0.01, 20.0]) {
        assert_eq!(metric(value, 0.02), Some((Some(0), "noise_m")), "{value}");
        assert_eq!(metric(0.01, value), Some((Some(0), "noise_rel")), "{value}");
    }
    assert_eq!(metric(0.0, 0.0), Some((Some(0), "noise_m")));
}

#[test]
fn each_setting_that_is_a_number_is_named() {
    let error =
        |config: Config| Slam::<4, 4, 16, { crate::ekf::storage(24) }>::with_config(rig(), config).err().map(|e| e.key);
    assert_eq!(error(Config::default()), None);
    assert_eq!(error(Config::real_rooms()), None);
    for gate in and_no_numbers(&[0.0, -1.0, 1e6]) {
        let mut config = Config::default();
        config.measurement.gate = gate;
        assert_eq!(error(config), Some("gate"), "{gate}");
    }
    for relief_m in and_no_numbers(&[-0.01, 1.0]) {
        let mut config = Config::default();
        config.walls.relief_m = relief_m;
        assert_eq!(error(config), Some("relief_m"), "{relief_m}");
    }
}
