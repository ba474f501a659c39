//! Simulated drives, scored.

use std::convert::Infallible;

use hal_sim::SimOptions;
use lab::evaluate::score;
use lab::input::built_in_robot;
use lab::input::log::Row;
use lab::input::rig_file::Robot;
use lab::recording::{Figures, Recording};
use lab::run::Drive;
use lab::run::Session;
use slam_core::Config;

/// The built-in robot's drive through a built-in plan.
pub fn drive(plan: &str, minutes: f64, seed: u64) -> Recording {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    drive_of(&robot, plan, minutes, seed, |_| ())
}

/// The log of such a drive, with the true poses.
pub fn rows(plan: &str, minutes: f64, seed: u64) -> Vec<Row> {
    disturbed_rows(SimOptions::default(), plan, minutes, seed)
}

/// The same where the world is not as the rig says.
pub fn disturbed_rows(options: SimOptions, plan: &str, minutes: f64, seed: u64) -> Vec<Row> {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    let mut rows = Vec::new();
    driven(&robot, options, plan, minutes, seed, |row| rows.push(row.clone()));
    rows
}

/// How often another estimator takes the robot to be held in such a log.
pub fn holds(rows: &[Row], config: Config) -> u32 {
    replayed(rows, config).slam().counters().holds
}

fn replayed(rows: &[Row], config: Config) -> Session {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    let mut session = Session::new(&robot, config, "").expect("a good rig");
    for row in rows {
        session.push(row);
    }
    session
}

/// What another estimator makes of such a log.
pub fn estimated(rows: &[Row], config: Config) -> Figures {
    let mut recording = replayed(rows, config).finish();
    let times_s: Vec<f64> = rows.iter().map(|row| row.t_s).collect();
    score::score(&mut recording, &times_s, None);
    recording.figures
}

/// Any robot's drive through a built-in plan.
pub fn drive_of(robot: &Robot, plan: &str, minutes: f64, seed: u64, see: impl FnMut(&Row)) -> Recording {
    let (drive, session) = driven(robot, SimOptions::default(), plan, minutes, seed, see);
    drive.finish(session)
}

fn driven(
    robot: &Robot,
    options: SimOptions,
    plan: &str,
    minutes: f64,
    seed: u64,
    mut see: impl FnMut(&Row),
) -> (Drive, Session) {
    let home = hal_sim::plan_file::load(plan).expect("a built-in plan");
    let mut drive = Drive::new(&home, robot, options, seed).expect("the robot fits");
    let mut session = Session::new(robot, Config::default(), plan).expect("a good rig");
    let driven = drive.run(&mut session, 60.0 * minutes, |row, _, _| {
        see(row);
        Ok::<(), Infallible>(())
    });
    driven.expect("nothing can fail");
    (drive, session)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_estimator_makes_the_same_of_a_drives_log() {
        let (driven, again) = (drive("room", 1.0, 1).figures, estimated(&rows("room", 1.0, 1), Config::default()));
        assert_eq!((driven.estimate, driven.walls, driven.mean_nis), (again.estimate, again.walls, again.mean_nis));
        let free = Config { walls: slam_core::WallPolicy::Free.into(), ..Config::default() };
        assert_ne!(estimated(&rows("room", 1.0, 1), free).estimate, again.estimate);
    }
}
