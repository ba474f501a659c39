//! The floor job by itself, without a home around it.

use super::swept::CELLS;
use super::*;
use crate::condition::Condition;
use crate::contact::Contacts;
use crate::pilot::memory::Cell;
use crate::wild::Wild;

#[test]
fn the_job_of_the_robot_fits_in_12_kib() {
    assert!(size_of::<FloorJob<8>>() <= 12_288, "{}", size_of::<FloorJob<8>>());
}

#[test]
fn floor_swept_before_the_grid_was_known_counts_once() {
    let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    let sweep = |job: &mut FloorJob<8>, steps: core::ops::Range<u16>| {
        for step in steps {
            let pose = Pose::new(0.02 * f32::from(step), 0.0, 0.0);
            let (contacts, condition) = (Contacts::default(), Condition::default());
            job.step(&Senses { time_us: 40_000 * u64::from(step), pose, ranges_m: [None; 8], contacts, condition });
        }
    };
    sweep(&mut job, 0..100);
    job.align(0.3);
    assert_eq!((job.progress().swept_m2, job.trail.last_m()), (0.0, None));
    sweep(&mut job, 0..100);
    let cells = (0..CELLS as i16).flat_map(|row| (0..CELLS as i16).map(move |col| Cell { col, row }));
    let swept: u32 = cells.map(|cell| 4 - job.sheet.swept.left_in(cell)).sum();
    assert_eq!(job.tally.swept(), swept);
    assert!(swept > 0);
}

#[test]
fn where_nothing_leads_on_it_goes_back_the_way_that_it_came() {
    let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    let (mut pose, mut jitter) = (Pose::default(), Wild::new());
    for step in 0..3000_u64 {
        let retreats = matches!(job.phase, Phase::Retreat { .. });
        let seen = Pose { x_m: pose.x_m + 0.004 * jitter.share(), ..pose };
        let (contacts, condition) = (Contacts::default(), Condition::default());
        let speeds = job.step(&Senses { time_us: 40_000 * step, pose: seen, ranges_m: [None; 8], contacts, condition });
        // A metre and a half along a corridor to where it is barred but for the way back.
        let forward_m = 0.02 * (speeds.left_mps + speeds.right_mps);
        if step < 100 {
            pose.x_m += 0.015;
        } else if retreats {
            pose.x_m += forward_m;
        }
    }
    assert!(pose.x_m < 0.9, "{pose:?}");
}

#[test]
fn whatever_it_is_told_the_speeds_are_finite_and_limited() {
    let config = FloorConfig::default();
    let mut job: FloorJob<8> = FloorJob::new(config, &crate::rig::default_rig());
    let mut wild = Wild::new();
    let limit_mps = config.drive.speed_mps + 0.5 * config.drive.track_m * config.drive.turn_radps + 1e-6;
    for step in 0..20_000 {
        let (pose, ranges_m, battery_v) = (wild.pose(), wild.ranges(), Some(wild.value()));
        let [is_charging, is_stalled, is_lost] = [(); 3].map(|()| wild.once_in(60));
        let condition = Condition { battery_v, is_charging, is_stalled, is_lost };
        let contacts = wild.contacts();
        if step == 5000 {
            job.align(f32::NAN);
            job.align(0.3);
        }
        let time_us = if step % 100 == 0 { u64::MAX } else { u64::from(wild.bits()) };
        let speeds = job.step(&Senses { time_us, pose, ranges_m, contacts, condition });
        for speed_mps in [speeds.left_mps, speeds.right_mps] {
            assert!(speed_mps.abs() <= limit_mps, "{step}: {speeds:?}");
        }
    }
}
