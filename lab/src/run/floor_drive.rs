//! One floor job from begin to end in a simulated home, with somebody who may meddle after each step, and what came of it.

use hal_sim::floor::FloorScore;
use hal_sim::{Plan, SimOptions};
use robot::FloorProgress;

use super::drive::Drive;
use super::session::Session;
use crate::input::built_in_robot;
use crate::input::rig_file::Robot;
use crate::input::settings::on_a_floor;
use crate::recording::Step;

/// A job that takes longer than an hour, and than a minute for each square metre, is ended.
const MINUTES: f64 = 60.0;

/// How a floor job ended.
#[derive(Clone, Debug)]
pub struct FloorDrive {
    /// How the floor was swept, by the true path.
    pub score: FloorScore,
    /// How far the job says it is.
    pub progress: FloorProgress,
    /// How long it took, minutes.
    pub minutes: f64,
    /// Largest distance between estimated and true position where the robot claimed a place, metres.
    pub worst_m: f64,
    /// How often its home, or a part of it, was in its map twice.
    pub second_copies: u32,
    /// How often it gave its place up.
    pub lost: usize,
    /// The map that is kept then.
    pub map: Option<Vec<u8>>,
}

/// Lets the built-in robot clean a home, from an empty map.
///
/// # Errors
/// The robot does not fit where the plan puts it.
pub fn clean(plan: &Plan, options: SimOptions, seed: u64) -> Result<FloorDrive, String> {
    clean_with(plan, options, seed, None, |_, _| ())
}

/// The same in this kept map where there is one, not knowing where; `meddle` gets each step when it is recorded.
///
/// # Errors
/// The robot does not fit where the plan puts it, or the map is none of its own.
pub fn clean_with(
    plan: &Plan,
    options: SimOptions,
    seed: u64,
    map: Option<Vec<u8>>,
    meddle: impl FnMut(&mut Drive, &Step),
) -> Result<FloorDrive, String> {
    let (robot, _) = built_in_robot().map_err(|error| error.to_string())?;
    clean_by(&robot, plan, options, seed, map, meddle)
}

/// The same by this robot.
///
/// # Errors
/// The rig is no good one, the robot does not fit where the plan puts it, or the map is none of its own.
pub fn clean_by(
    robot: &Robot,
    plan: &Plan,
    options: SimOptions,
    seed: u64,
    map: Option<Vec<u8>>,
    mut meddle: impl FnMut(&mut Drive, &Step),
) -> Result<FloorDrive, String> {
    let config = on_a_floor(robot);
    let mut session = Session::new(robot, config, plan.name.clone()).map_err(|error| format!("{error:?}"))?;
    if let Some(map) = map {
        session.begin_in(map)?;
    }
    let mut drive = Drive::cleaning(plan, robot, options, seed).map_err(|error| error.to_string())?;
    let (mut t_s, mut worst_m) = (0.0, 0.0_f64);
    let most_s = 60.0 * drive.floor().score().floor_m2.max(MINUTES);
    while t_s < most_s && !drive.is_over() {
        t_s = drive.step(&mut session).t_s;
        let Some(step) = session.recording().steps.last() else { break };
        worst_m = step.error().map_or(worst_m, |error| worst_m.max(error.x_m.hypot(error.y_m)));
        meddle(&mut drive, step);
    }
    let counters = session.slam().counters();
    Ok(FloorDrive {
        score: drive.floor().score(),
        progress: drive.progress().unwrap_or_default(),
        minutes: t_s / 60.0,
        worst_m,
        second_copies: counters.second_copies + counters.shifted_copies,
        lost: session.lost(),
        map: session.map(),
    })
}
