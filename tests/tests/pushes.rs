//! A robot that somebody pushes along again and again, unseen by its wheels, finds out and finds itself again.

use std::convert::Infallible;
use std::thread;

use hal_sim::random_home::somebody;
use hal_sim::{SimOptions, plan_file};
use lab::input::built_in_robot;
use lab::run::{Drive, Session};
use slam_core::Config;

/// A job that takes longer than this is ended, seconds.
const FOR_S: f64 = 3600.0;

/// Farther off than this a robot is not where it claims to be, metres.
const OFF_M: f64 = 0.3;

/// A floor job in this random home, where somebody walks to and fro who does not give way: for what share of the time in which it claims a
/// place it is not there, and whether it came home, to 20 cm; none where nobody has room to walk.
fn job(home: u64) -> Option<(f64, bool)> {
    let mut plan = plan_file::load(&format!("random-{home}")).expect("a random home");
    plan.people.push(somebody(&plan, home, false)?);
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    let mut session = Session::new(&robot, Config::for_rig(&robot.rig), "").expect("a good rig");
    let mut drive = Drive::cleaning(&plan, &robot, SimOptions::default(), 1).expect("the robot fits");
    let (mut claimed, mut off) = (0u32, 0u32);
    let driven = drive.run(&mut session, FOR_S, |_, recording, _| -> Result<(), Infallible> {
        if let Some(error) = recording.steps.last().and_then(lab::recording::Step::error) {
            claimed += 1;
            off += u32::from(error.x_m.hypot(error.y_m) > OFF_M);
        }
        Ok(())
    });
    driven.expect("nothing can fail");
    Some((f64::from(off) / f64::from(claimed), drive.is_over() && drive.floor().score().home_m < 0.2))
}

#[test]
fn who_is_pushed_along_again_and_again_finds_out() {
    let halves = [101..105, 105..109].map(|homes| thread::spawn(move || homes.filter_map(job).collect::<Vec<_>>()));
    let jobs: Vec<(f64, bool)> = halves.into_iter().flat_map(|half| half.join().expect("no panic")).collect();
    let wrong = jobs.iter().map(|(wrong, _)| wrong).sum::<f64>() / jobs.len() as f64;
    let home = jobs.iter().filter(|(_, is_home)| *is_home).count();
    println!("{wrong:.2} {home} of {}: {jobs:.2?}", jobs.len());
    // A quarter of the time, and four of eight; of a robot that doubts its place after five metres in which nothing fits, and believes in what
    // it drew meanwhile, three quarters and none.
    assert!(wrong < 0.5 && 4 * home >= jobs.len(), "{jobs:?}");
}
