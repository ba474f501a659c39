//! A robot whose wheels somebody turns while it is off the floor: its map is saved at once, not when they stand.

mod common;

use common::nor::Nor;
use firmware::Keeper;
use firmware::keeper::Circumstances;
use hal_sim::{ClosedLoop, Estimate, SimOptions, Simulation, plan_file};
use robot::PilotConfig;
use robot::rig::BuiltIn;
use slam_core::{Config, RobotSlam};
use wire::PlaceState;

/// Samples before its wheels hang: a minute; and until it is lifted, half a second.
const LIFTED: u32 = 1500;
const MOMENT: u32 = 12;

#[test]
fn wheels_that_turn_in_the_air_do_not_put_a_save_off() {
    let (plan, wide) = (plan_file::load("flat").expect("a built-in plan"), hal_sim::default_rig());
    let narrow = BuiltIn::Sharp.rig();
    let simulation = Simulation::new(&plan, &wide, SimOptions::default(), 1).expect("it can be simulated");
    let mut robot = ClosedLoop::new(simulation, &wide, PilotConfig::default());
    let config = Config::for_rig(&narrow);
    let mut slam = Box::new(RobotSlam::with_config(narrow, config).expect("the built-in rig"));
    let mut flash = Nor::new();
    let mut keeper = Keeper::start(&mut flash, &slam);
    let (mut driving, mut lifted) = (None, None);
    robot.record(62.0, &mut |sample| {
        let sent = wire::Sample::of(sample).expect("the built-in robot has encoders");
        let report = slam.step(&sent.to_slam());
        let is_lifted = slam.counters().steps > LIFTED;
        let now = Circumstances { is_lifted, is_docked: false, stands: false, is_off: is_lifted };
        let waits = keeper.step(&mut slam, &report, now);
        let told = (waits, keeper.place().state, keeper.place().saves);
        if slam.counters().steps > LIFTED + MOMENT {
            lifted = lifted.or(Some(told))
        } else {
            driving = Some(told)
        }
        Estimate::new(slam.pose(), &report)
    });
    assert_eq!(driving, Some((true, PlaceState::Fresh, 0)), "a robot that drives has to stand for it");
    assert_eq!(lifted, Some((false, PlaceState::Searching, 1)));
}
