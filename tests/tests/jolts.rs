//! A robot that is kicked finds out by its readings, and goes on in its map.

use hal_sim::mishap::Kick;
use hal_sim::{Plan, Pose2, plan_file};
use tests::carries::{Driven, drive, rig};

/// When it is kicked, and until when it may be lost, seconds.
const KICK_S: f64 = 150.0;
const FOUND_S: f64 = KICK_S + 20.0;

/// Four rooms, with a kick of 10 cm and 15 degrees or without.
fn flat(is_kicked: bool) -> Plan {
    let mut plan = plan_file::load("flat").unwrap_or_else(|error| panic!("{error}"));
    let kick = Kick { at_s: KICK_S, slide_m: 0.10, turn_rad: 15.0_f64.to_radians() };
    plan.mishaps.kicks.extend(is_kicked.then_some(kick));
    plan
}

/// Error of the pose, metres and radians, at the end of the drive, and the jolts that the estimator found.
fn lost(plan: &Plan, seed: u64) -> (f64, f64, u32) {
    let mut error = Pose2::default();
    let slam = drive(plan, &rig(8), FOUND_S, seed, |Driven { slam, in_plan, .. }| {
        error = plan.start.relative(&in_plan).relative(&slam.pose().into());
        true
    });
    (error.x_m.hypot(error.y_m), error.theta_rad.abs(), slam.counters().jolts)
}

#[test]
fn most_kicks_are_found_and_undone_and_none_where_there_is_none() {
    let plan = flat(true);
    let kicked: Vec<_> = (1..=8).map(|seed| lost(&plan, seed)).collect();
    // Without a search the robot is 10 cm and 15 degrees off, and more by and by.
    let found = kicked.iter().filter(|(off_m, off_rad, jolts)| *off_m < 0.05 && *off_rad < 0.05 && *jolts > 0).count();
    assert!(found >= 5, "{found} of 8: {kicked:?}");
    for seed in 1..=4 {
        let (off_m, _, jolts) = lost(&flat(false), seed);
        assert!(jolts == 0 && off_m < 0.05, "seed {seed}: {jolts} jolts, {off_m} m");
    }
}
