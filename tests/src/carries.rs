//! Robots that are put down somewhere in a simulated home: a drive, and where it really is.

use hal_sim::rng::Rng;
use hal_sim::world::World;
use hal_sim::{ClosedLoop, Estimate, Plan, Pose2, SimOptions, Simulation, default_rig, mishap};
use robot::PilotConfig;
use slam_core::{Config, HostSlam, Rig, Sample, StepReport};

/// Most range sensors of a simulated robot.
pub const SENSORS: usize = hal_sim::MAX_SENSORS;

/// What a robot knows and where it is, after each of its steps.
pub struct Driven<'a> {
    /// The estimator.
    pub slam: &'a mut HostSlam,
    /// The last sample.
    pub sample: &'a Sample<SENSORS>,
    /// What became of it.
    pub report: &'a StepReport<SENSORS>,
    /// How far the robot really went, metres.
    pub path_m: f64,
    /// Where it is in the plan's frame.
    pub in_plan: Pose2,
}

/// Drives through a home for so long; `each` sees every step, and ends the drive where it says false.
///
/// # Panics
/// The rig cannot be simulated in the plan.
pub fn drive(
    plan: &Plan,
    rig: &Rig<SENSORS>,
    seconds: f64,
    seed: u64,
    each: impl FnMut(Driven) -> bool,
) -> Box<HostSlam> {
    drive_altered(plan, rig, seconds, seed, |_| {}, each)
}

/// The same with samples that are altered before the estimator has them.
///
/// # Panics
/// The rig cannot be simulated in the plan.
pub fn drive_altered(
    plan: &Plan,
    rig: &Rig<SENSORS>,
    seconds: f64,
    seed: u64,
    mut alter: impl FnMut(&mut Sample<SENSORS>),
    mut each: impl FnMut(Driven) -> bool,
) -> Box<HostSlam> {
    let simulation = Simulation::new(plan, rig, SimOptions::default(), seed).unwrap_or_else(|error| panic!("{error}"));
    let mut slam = Box::new(HostSlam::with_config(rig.clone(), Config::for_rig(rig)).expect("a rig that can be"));
    let mut robot = ClosedLoop::new(simulation, rig, PilotConfig::default());
    let (mut path_m, mut last) = (0.0, None::<Pose2>);
    while robot.simulation.time_s() < seconds {
        let mut done = None;
        let frame = robot.step(&mut |sample| {
            let mut sample = *sample;
            alter(&mut sample);
            let report = slam.step(&sample);
            done = Some(report);
            Estimate::new(slam.pose(), &report)
        });
        let moved = last.replace(frame.truth).map_or(Pose2::default(), |last| last.relative(&frame.truth));
        path_m += moved.x_m.hypot(moved.y_m);
        let in_plan = robot.simulation.pose_in_plan();
        let Some(report) = &done else { break };
        if !each(Driven { slam: &mut slam, sample: &frame.sample, report, path_m, in_plan }) {
            break;
        }
    }
    slam
}

/// The plan with the robot put down in one of its rooms, by the seed.
///
/// # Panics
/// There is no room for it.
pub fn carried(plan: &Plan, seed: u64) -> Plan {
    let mut rng = Rng::stream(seed, "carry", 0);
    let place = mishap::free_place(&plan.rooms, &mut rng, &World::new(plan), &SimOptions::default());
    Plan { start: place.expect("a free place"), ..plan.clone() }
}

/// A robot's rig with fewer sensors: every second of eight.
pub fn rig(sensors: usize) -> Rig<SENSORS> {
    let mut rig = default_rig();
    let step = rig.sensors.len() / sensors.max(1);
    let few = rig.sensors.iter().step_by(step.max(1)).copied().collect();
    rig.sensors = few;
    rig
}
