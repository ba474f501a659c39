//! One floor job from begin to end in a simulated home, with the estimator that the robot has.

use robot::{FloorConfig, FloorProgress, Whereabouts};
use slam_core::{Config, HostSlam};

use crate::closed_loop::{ClosedLoop, Estimate};
use crate::floor::{FloorRaster, FloorScore, Moment};
use crate::options::SimOptions;
use crate::own_map::OwnMap;
use crate::plan::Plan;
use crate::rig::default_rig;
use crate::sim_error::SimError;
use crate::simulation::Simulation;

/// How a floor job ended.
#[derive(Clone, Debug)]
pub struct FloorDrive {
    /// How the floor was swept, by the true path.
    pub score: FloorScore,
    /// How far the job says it is.
    pub progress: FloorProgress,
    /// How long it took, minutes.
    pub minutes: f64,
    /// Largest distance between estimated and true position, metres.
    pub worst_m: f64,
    /// How often its home was in its map twice.
    pub second_copies: u32,
}

/// Lets the default robot clean a home, for so many minutes at most.
///
/// # Errors
/// The robot does not fit where the plan puts it.
pub fn clean(plan: &Plan, options: SimOptions, seed: u64, minutes: f64) -> Result<FloorDrive, SimError> {
    clean_with(plan, options, seed, minutes, |_| ())
}

/// The same with somebody who may meddle after each step.
///
/// # Errors
/// The robot does not fit where the plan puts it.
pub fn clean_with(
    plan: &Plan,
    options: SimOptions,
    seed: u64,
    minutes: f64,
    mut meddle: impl FnMut(&mut ClosedLoop),
) -> Result<FloorDrive, SimError> {
    let rig = default_rig();
    let simulation = Simulation::new(plan, &rig, options, seed)?;
    let mut slam = HostSlam::with_config(rig.clone(), Config::default()).expect("the default rig is a valid one");
    let mut floor = FloorRaster::new(plan, simulation.options().body_radius_m, simulation.pose_in_plan());
    let mut robot = ClosedLoop::cleaning(simulation, &rig, FloorConfig::default());
    let (mut worst_m, mut own) = (0.0_f64, OwnMap::new());
    while !robot.job.is_over() && robot.simulation.time_s() < 60.0 * minutes {
        let frame = robot.step_in(&mut |sample| {
            let report = slam.step(sample);
            own.watch(&mut slam);
            let grid_rad = slam.alpha().map(|(alpha_rad, _)| alpha_rad);
            let redrawn = slam.counters().second_copies;
            let estimate = Estimate { pose: slam.pose(), ranges_m: report.readings.map(|reading| reading.range_m) };
            (estimate, Whereabouts { grid_rad, redrawn, ..Whereabouts::START })
        });
        let pose = slam.pose();
        worst_m =
            worst_m.max(libm::hypot(f64::from(pose.x_m) - frame.truth.x_m, f64::from(pose.y_m) - frame.truth.y_m));
        let contacts = robot.simulation.contacts();
        floor.record(&Moment {
            t_s: robot.simulation.time_s(),
            pose: robot.simulation.pose_in_plan(),
            doing: robot.job.doing(),
            is_pressed: contacts.bump_left || contacts.bump_right,
            is_on_floor: !contacts.lifted,
        });
        meddle(&mut robot);
    }
    let progress = robot.job.floor().unwrap_or_default();
    Ok(FloorDrive {
        score: floor.score(),
        progress,
        minutes: robot.simulation.time_s() / 60.0,
        worst_m,
        second_copies: slam.counters().second_copies,
    })
}
