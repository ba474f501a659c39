//! The floor job by itself, without a home around it.

use super::*;
use crate::condition::Condition;
use crate::contact::Contacts;

#[test]
fn the_job_of_the_robot_fits_in_12_kib() {
    assert!(size_of::<FloorJob<8>>() <= 12_288, "{}", size_of::<FloorJob<8>>());
}

#[test]
fn whatever_it_is_told_the_speeds_are_finite_and_limited() {
    let config = FloorConfig::default();
    let mut job: FloorJob<8> = FloorJob::new(config, &crate::rig::default_rig());
    let mut bits = 1_u32;
    let mut random = move || {
        bits ^= bits << 13;
        bits ^= bits >> 17;
        bits ^= bits << 5;
        bits
    };
    let limit_mps = config.drive.speed_mps + 0.5 * config.drive.track_m * config.drive.turn_radps + 1e-6;
    for step in 0..20_000 {
        let mut value = || match random() % 8 {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => f32::from_bits(random()),
            3 => -1.0,
            _ => (random() % 1000) as f32 * 0.005,
        };
        let pose = Pose { x_m: value(), y_m: value(), theta_rad: value() };
        let ranges_m = [(); 8].map(|()| Some(value()));
        let battery_v = Some(value());
        let [is_charging, is_stalled, is_lost] = [(); 3].map(|()| random() % 60 == 0);
        let condition = Condition { battery_v, is_charging, is_stalled, is_lost };
        let contacts = Contacts { bump_left: random() % 9 == 0, bump_right: random() % 9 == 0, ..Contacts::default() };
        if step == 5000 {
            job.align(f32::NAN);
            job.align(0.3);
        }
        let time_us = if step % 100 == 0 { u64::MAX } else { u64::from(random()) };
        let speeds = job.step(&Senses { time_us, pose, ranges_m, contacts, condition });
        for speed_mps in [speeds.left_mps, speeds.right_mps] {
            assert!(speed_mps.abs() <= limit_mps, "{step}: {speeds:?}");
        }
    }
}
