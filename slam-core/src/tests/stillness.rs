//! Readings that stay while the wheels turn the robot.

use crate::geometry::pose::Pose;
use crate::holds::stillness::Stillness;
use crate::measurement::sensor::{Sensor, SensorState};
use crate::rig::{Mount, RangeModel, RangeSensor};

/// One that reads ranges between these, metres.
fn sensor([min_m, max_m]: [f32; 2]) -> RangeSensor {
    RangeSensor {
        mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: 0.0 },
        min_m,
        max_m,
        max_incidence_rad: 1.0,
        gain_sigma: 0.0,
        model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.03 },
    }
}

/// Whether a robot is held whose wheels turn it by two radians while two sensors read this, of at most 1.5 m.
fn is_held(range_m: f32) -> bool {
    let limits = sensor([0.2, 1.5]);
    let mut stillness = Stillness::<4>::NONE;
    stillness.settle(Pose::ORIGIN);
    for step in 0..100 {
        stillness.follow(&Pose { theta_rad: 0.02, ..Pose::ORIGIN }, 0.01);
        for index in 0..2 {
            let off_m = 0.02 * ((step + index) % 5) as f32 - 0.04;
            stillness.note(&Sensor { index, limits: &limits, state: &SensorState::NONE }, range_m + off_m, 0.045);
        }
        stillness.settle(Pose::ORIGIN);
    }
    stillness.held_at().is_some()
}

#[test]
fn what_is_read_at_the_end_of_the_range_says_nothing() {
    assert!(is_held(1.2));
    assert!(!is_held(1.43), "what is farther was not read");
}

/// Three sensors that look at walls half a metre away read the same at both ends of a turn about the walls' feet.
#[test]
fn a_robot_that_turns_between_walls_at_right_angles_is_not_held() {
    let limits = sensor([0.05, 3.0]);
    let is_held = |turns: bool, steps: i16| {
        let mut stillness = Stillness::<4>::NONE;
        stillness.settle(Pose::ORIGIN);
        for step in -30..steps {
            let turned_rad = 0.015 * f32::from(step);
            stillness.follow(&Pose { theta_rad: 0.015, ..Pose::ORIGIN }, 0.01);
            for (index, range_m) in [0.3, 0.4, 0.5].into_iter().enumerate() {
                let seen_m = if turns { range_m / libm::cosf(turned_rad) } else { range_m };
                stillness.note(&Sensor { index, limits: &limits, state: &SensorState::NONE }, seen_m, 0.01);
            }
            stillness.settle(Pose::ORIGIN);
        }
        stillness.held_at().is_some()
    };
    assert!(!is_held(true, 31), "it turns by 0.9 radians");
    assert!(is_held(false, 101), "it stands while its wheels turn by two");
}

#[test]
fn a_claim_ends_with_the_first_reading_that_changes() {
    let limits = sensor([0.2, 1.5]);
    let mut stillness = Stillness::<4>::NONE;
    stillness.settle(Pose::ORIGIN);
    let mut read = |range_m: f32| {
        stillness.follow(&Pose { x_m: 0.01, ..Pose::ORIGIN }, 0.01);
        for index in 0..2 {
            let range_m = if index == 0 { range_m } else { 0.8 };
            stillness.note(&Sensor { index, limits: &limits, state: &SensorState::NONE }, range_m, 0.01);
        }
        let is_as_before = !stillness.is_changed() && stillness.begun(0.1).is_some();
        let told = [is_as_before, stillness.is_witnessed()];
        stillness.settle(Pose::ORIGIN);
        told
    };
    let still: [[bool; 2]; 30] = core::array::from_fn(|_| read(0.6));
    assert_eq!(still[29], [true, true]);
    assert!(!read(0.4)[0], "in the step of the reading");
    assert_eq!(read(0.4), [false, false], "and from there on");
}
