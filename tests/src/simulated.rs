//! Simulated drives, scored.

use std::convert::Infallible;

use hal_sim::SimOptions;
use lab::drive::Drive;
use lab::recording::Recording;
use lab::run::built_in_robot;
use lab::session::Session;
use slam_core::Config;

/// The built-in robot's drive through a built-in plan.
pub fn drive(plan: &str, minutes: f64, seed: u64) -> Recording {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    let home = hal_sim::plan_file::load(plan).expect("a built-in plan");
    let mut drive = Drive::new(&home, &robot, SimOptions::default(), seed).expect("the robot fits");
    let mut session = Session::new(&robot, Config::default(), plan).expect("a good rig");
    let driven = drive.run(&mut session, 60.0 * minutes, |_, _| Ok::<(), Infallible>(()));
    driven.expect("nothing can fail");
    drive.finish(session)
}
