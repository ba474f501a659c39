//! A robot that is kicked finds out by its readings, and goes on in its map.

use hal_sim::mishap::Kick;
use hal_sim::{Plan, Pose2, plan_file};
use relocate::{Event, Locator, State, Step, agreement};
use slam_core::HostSlam;
use tests::carries::{Driven, drive, rig};

/// When it is kicked, and until when it may be lost, seconds.
const KICK_S: f64 = 150.0;
const FOUND_S: f64 = KICK_S + 20.0;

/// Until when it is to be back in its kept map, seconds.
const BACK_S: f64 = KICK_S + 100.0;

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

/// Error of the pose in the kept map of the same home at the end of a drive that began in it, and the jolts that the estimator
/// found; none where the robot does not know its place.
fn lost_in_kept(plan: &Plan, kept: &HostSlam, seed: u64) -> (Option<f64>, u32) {
    let mut locator = Locator::new(State::Searching);
    let (mut error_m, mut last_m) = (None, 0.0);
    let slam = drive(plan, &rig(8), BACK_S, seed, |Driven { slam, report, path_m, in_plan, .. }| {
        let position_m = [slam.state_mean(0), slam.state_mean(1)];
        let travelled_m = (path_m - std::mem::replace(&mut last_m, path_m)) as f32;
        match locator.step(&*slam, kept, &Step { position_m, travelled_m, readings: agreement(report) }, usize::MAX) {
            Some(Event::Found(place)) => slam.take_up(kept, &place).expect("a map to go on in"),
            Some(Event::Lost) => slam.restart_map(),
            None => {}
        }
        let off = plan.start.relative(&in_plan).relative(&slam.pose().into());
        error_m = locator.state().is_located().then_some(off.x_m.hypot(off.y_m));
        true
    });
    (error_m, slam.counters().jolts)
}

#[test]
fn a_kick_that_readings_do_not_tell_is_told_by_the_kept_map() {
    let kept = drive(&flat(false), &rig(8), 600.0, 1, |_| true);
    let kicked: Vec<_> = (2..=9).map(|seed| lost_in_kept(&flat(true), &kept, seed)).collect();
    assert!(kicked.iter().any(|(_, jolts)| *jolts == 0), "every kick was told by readings: {kicked:?}");
    assert!(kicked.iter().all(|(off_m, _)| off_m.is_some_and(|off_m| off_m < 0.05)), "{kicked:?}");
}
