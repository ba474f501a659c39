//! What a reading's noise is told by.

use slam_core::{Mount, Outcome, Pose, RangeModel, RangeSensor, ReadingReport, Rig};

use super::drive::DRIVE;
use crate::frame::Frame;
use crate::gains::Gains;
use crate::record::{Known, expected_m, hit};

fn sensor(model: RangeModel) -> RangeSensor {
    let mount = Mount { x_m: 0.06, y_m: 0.0, bearing_rad: 0.0 };
    RangeSensor { mount, min_m: 0.15, max_m: 1.5, max_incidence_rad: 1.2, gain_sigma: 0.01, model }
}

fn read(range_m: f32, outcome: Outcome) -> ReadingReport {
    ReadingReport { outcome, range_m: Some(range_m), hit_m: None }
}

fn known(gain: f32, last_m: f32, output_level: f32) -> Known {
    Known { gain, last_m, output_level }
}

/// The first readings of a drive are of no wall yet, and tell where the start is.
#[test]
fn what_is_learned_of_an_output_counts_where_there_is_no_wall_yet() {
    let sharp = sensor(RangeModel::Sharp { scale_m: 0.6, exponent: -1.16, noise_v: 0.012 });
    let reading = ReadingReport { hit_m: Some([0.86, 0.0]), ..read(0.8, Outcome::Unexplained) };
    let variance_m2 = |level| {
        let seen = hit(&Frame::of(&Pose::ORIGIN), &known(1.0, 0.8, level), 0, &sharp, &reading).expect("a hit");
        seen.variance_m2 - slam_core::SURFACE_M * slam_core::SURFACE_M
    };
    let ratio = variance_m2(14.0) / variance_m2(1.0);
    assert!((ratio - 14.0).abs() < 0.01, "{ratio}");
}

/// Analogue readings of one range, short and long ones, have one variance: else they would pull their wall towards the robot.
#[test]
fn the_noise_of_an_analogue_reading_does_not_depend_on_the_reading() {
    let sharp = sensor(RangeModel::Sharp { scale_m: 0.6, exponent: -1.16, noise_v: 0.012 });
    for off_m in [-0.05, 0.0, 0.05] {
        let met = Outcome::Updated { wall: 1, innovation_m: 1.01 * off_m, variance_m2: 1e-3, noise_m2: 7e-4 };
        let reading = ReadingReport { hit_m: Some([1.26 + off_m, 0.0]), ..read(1.2 + off_m, met) };
        let found = hit(&Frame::of(&Pose::ORIGIN), &known(1.01, 0.0, 1.0), 0, &sharp, &reading).expect("a hit");
        assert_eq!((found.variance_m2, found.alike), (7e-4, 1.0), "as the filter took it");
        let new = read(1.2 + off_m, Outcome::Unexplained);
        assert_eq!(expected_m(&sharp, &new, 1.21), Some(1.21));
        assert_eq!(expected_m(&sharp, &new, 0.6), new.range_m, "another surface");
    }
}

#[test]
fn a_sensor_that_reports_metres_tells_its_noise() {
    let metric = sensor(RangeModel::Metric { noise_m: 0.01, noise_rel: 0.01 });
    let met = Outcome::Updated { wall: 1, innovation_m: 0.05, variance_m2: 1e-3, noise_m2: 7e-4 };
    assert_eq!(expected_m(&metric, &read(1.2, met), 1.21), Some(1.2));
}

/// Of a surface at a sensor's largest range only the readings that came out short are any, and would draw a new wall near.
#[test]
fn readings_of_no_wall_near_the_largest_range_are_not_kept() {
    let sharp = sensor(RangeModel::Sharp { scale_m: 0.6, exponent: -1.16, noise_v: 0.012 });
    let metric = sensor(RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 });
    let met = Outcome::Updated { wall: 1, innovation_m: 0.0, variance_m2: 1e-3, noise_m2: 7e-4 };
    let kept = |sensor: &RangeSensor, range_m: f32, outcome| {
        let reading = ReadingReport { hit_m: Some([0.06 + range_m, 0.0]), ..read(range_m, outcome) };
        hit(&Frame::of(&Pose::ORIGIN), &known(1.0, range_m, 1.0), 0, sensor, &reading).is_some()
    };
    assert!(kept(&sharp, 1.2, Outcome::Unexplained) && !kept(&sharp, 1.49, Outcome::Unexplained));
    assert!(kept(&sharp, 1.49, met) && kept(&metric, 1.49, Outcome::Unexplained));
}

/// A gain that the look back does not look for stays corrected: that of a sensor past those which it has room for.
#[test]
fn hits_are_where_the_gain_has_them_that_is_not_looked_for() {
    let sensor = sensor(RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 });
    let robot = Frame::of(&Pose::ORIGIN);
    let reading = ReadingReport { hit_m: Some([1.1, 0.0]), ..read(1.0, Outcome::Unexplained) };
    let end_m = |number| hit(&robot, &known(1.05, 0.0, 1.0), number, &sensor, &reading).expect("a hit").end_m[0];
    assert_eq!(end_m(8), 1.1);
    assert!(end_m(7) > 1.14);
    let sensors = core::iter::repeat_n(sensor, 10).collect();
    let rig = Gains::of_rig::<16>(&Rig { drive: DRIVE, adc: None, sensors });
    assert_eq!([7, 8].map(|sensor| rig.of(sensor).is_some()), [true, false]);
}
