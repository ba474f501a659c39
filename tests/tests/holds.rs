//! A robot whose wheels turn while something holds it stays where it is.

use hal_sim::mishap::Hold;
use hal_sim::{Plan, Pose2, plan_file};
use tests::carries::{Driven, drive, rig};

/// Since when it is held, for how long, and until when it may be lost, seconds.
const HOLD_S: f64 = 150.0;
const HELD_S: f64 = 4.0;
const FREE_S: f64 = HOLD_S + HELD_S + 10.0;

fn home(name: &str, is_held: bool) -> Plan {
    let mut plan = plan_file::load(name).unwrap_or_else(|error| panic!("{error}"));
    plan.mishaps.holds.extend(is_held.then_some(Hold { at_s: HOLD_S, held_s: HELD_S, is_jammed: false }));
    plan
}

/// Error of the pose, metres and radians, at the end of the drive, and how often the estimator took it to be held.
fn lost(plan: &Plan, seed: u64) -> (f64, f64, u32) {
    let mut error = Pose2::default();
    let slam = drive(plan, &rig(8), FREE_S, seed, |Driven { slam, in_plan, .. }| {
        error = plan.start.relative(&in_plan).relative(&slam.pose().into());
        true
    });
    (error.x_m.hypot(error.y_m), error.theta_rad.abs(), slam.counters().holds)
}

#[test]
fn most_holds_are_found_and_none_where_there_is_none() {
    for name in ["flat", "l-shape"] {
        let plan = home(name, true);
        let held: Vec<_> = (1..=8).map(|seed| lost(&plan, seed)).collect();
        // Without it the wheels carry the pose most of a metre away.
        let stayed = held.iter().filter(|(off_m, off_rad, holds)| *off_m < 0.1 && *off_rad < 0.1 && *holds > 0).count();
        assert!(stayed >= 5, "{name}: {stayed} of 8: {held:?}");
        for seed in 1..=4 {
            let (off_m, _, holds) = lost(&home(name, false), seed);
            assert!(holds == 0 && off_m < 0.06, "{name}, seed {seed}: {holds} holds, {off_m} m");
        }
    }
}
