//! A robot that somebody pushes along again and again, unseen by its wheels, finds out and finds itself again.

use std::thread;

use hal_sim::random_home::somebody;
use hal_sim::{SimOptions, plan_file};
use lab::run::clean_with;
use robot::FloorState;

/// Farther off than this a robot is not where it claims to be, metres.
const OFF_M: f64 = 0.3;

/// A floor job in this random home, where somebody walks to and fro who does not give way: for what share of the time in which it claims a
/// place it is not there, and whether it came home, to 20 cm; none where nobody has room to walk.
fn job(home: u64) -> Option<(f64, bool)> {
    let mut plan = plan_file::load(&format!("random-{home}")).expect("a random home");
    plan.people.push(somebody(&plan, home, false)?);
    let (mut claimed, mut off) = (0u32, 0u32);
    let drive = clean_with(&plan, SimOptions::default(), home, None, |_, step| {
        if let Some(error) = step.error() {
            claimed += 1;
            off += u32::from(error.x_m.hypot(error.y_m) > OFF_M);
        }
    });
    let drive = drive.expect("the robot fits");
    let is_over = matches!(drive.progress.state, FloorState::Done | FloorState::Away);
    let is_home = is_over && drive.score.home_m < 0.2;
    Some((f64::from(off) / f64::from(claimed), is_home))
}

#[test]
fn who_is_pushed_along_again_and_again_finds_out() {
    let halves = [117..125, 125..133].map(|homes| thread::spawn(move || homes.filter_map(job).collect::<Vec<_>>()));
    let jobs: Vec<(f64, bool)> = halves.into_iter().flat_map(|half| half.join().expect("no panic")).collect();
    let wrong = jobs.iter().map(|(wrong, _)| wrong).sum::<f64>() / jobs.len() as f64;
    let home = jobs.iter().filter(|(_, is_home)| *is_home).count();
    println!("{wrong:.2} {home} of {}: {jobs:.2?}", jobs.len());
    // Half of the time, and 8 of 16; of a robot that doubts its place after five metres in which nothing fits, and believes in what it drew
    // meanwhile, three quarters and none.
    assert!(wrong < 0.67 && 4 * home >= jobs.len(), "{jobs:?}");
}
