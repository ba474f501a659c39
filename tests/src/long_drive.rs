//! Drives of hours and days, whose figures are kept hour by hour.

use hal_sim::{ClosedLoop, Estimate, Plan, SimOptions, Simulation, default_rig};
use lab::evaluate::score::path;
use lab::recording::Step;
use robot::PilotConfig;
use slam_core::{Config, HostSlam};

use crate::positivity::{flaw, least_correlation_pivot};

/// The covariance is looked at once in so many steps: ten times a minute.
const LOOK_EVERY: u32 = 150;

/// What one hour of a drive was like.
#[derive(Clone, Debug, Default)]
pub struct Hour {
    /// Which, from 1.
    pub number: u32,
    /// Root mean square of the position's error in the start frame, metres.
    pub rmse_m: f64,
    /// Mean NEES of the pose: three for an honest filter.
    pub nees: f64,
    /// Length of the true path, metres.
    pub path_m: f64,
    /// Walls born.
    pub births: u32,
    /// How often the robot was taken to be held, with and without reason.
    pub holds: u32,
    /// How often it was taken to be displaced.
    pub jolts: u32,
    /// Walls in the map at the end of the hour.
    pub walls: usize,
    /// Smallest pivot of the Cholesky factor of the correlation matrix with the jitter on its diagonal.
    pub least_pivot: f64,
    /// What was wrong with the covariance, where something was.
    pub flaw: Option<String>,
}

/// Sums over one hour.
#[derive(Default)]
struct Sums {
    steps: u32,
    square_m2: f64,
    nees: f64,
    scored: u32,
    hour: Hour,
}

/// An empty square with sides of so many metres, the robot in its middle.
pub fn square(side_m: f64) -> Plan {
    let (half, side) = (0.5 * side_m, side_m);
    let text = format!(
        "[start]\nx_m = {half:?}\ny_m = {half:?}\n[[outline]]\n\
         points_m = [[0.0, 0.0], [{side:?}, 0.0], [{side:?}, {side:?}], [0.0, {side:?}]]\n"
    );
    hal_sim::plan_file::parse("square", "square", &text).expect("a good plan")
}

/// The built-in robot drives through a home for so many hours; `each` gets every hour as it ends.
pub fn drive(plan: &Plan, hours: f64, seed: u64, mut each: impl FnMut(&Hour)) {
    let rig = default_rig();
    let simulation = Simulation::new(plan, &rig, SimOptions::default(), seed).expect("the robot fits");
    let mut slam = HostSlam::with_config(rig.clone(), Config::default()).expect("a good rig");
    let mut robot = ClosedLoop::new(simulation, &rig, PilotConfig::default());
    let mut sums = Sums { hour: Hour { number: 1, least_pivot: f64::INFINITY, ..Hour::default() }, ..Sums::default() };
    let mut before = *slam.counters();
    let mut last = None;
    loop {
        let frame = robot.step(&mut |sample| {
            let report = slam.step(sample);
            Estimate { pose: slam.pose(), ranges_m: report.readings.map(|reading| reading.range_m) }
        });
        let estimate = slam.estimate();
        let step = Step {
            pose: estimate.pose.into(),
            start: slam.start_pose().into(),
            covariance: estimate.covariance.into(),
            truth: Some(frame.truth),
            ..Step::default()
        };
        sums.steps += 1;
        sums.square_m2 += step.error().map_or(0.0, |e| e.x_m * e.x_m + e.y_m * e.y_m);
        if let Some(nees) = path::nees(&step) {
            sums.nees += nees;
            sums.scored += 1;
        }
        sums.hour.path_m += path::length_m([last.unwrap_or(frame.truth), frame.truth].into_iter());
        last = Some(frame.truth);
        if sums.steps.is_multiple_of(LOOK_EVERY) {
            sums.hour.least_pivot = sums.hour.least_pivot.min(least_correlation_pivot(&slam));
            sums.hour.flaw = sums.hour.flaw.take().or_else(|| flaw(&slam));
        }
        let time_h = robot.simulation.time_s() / 3600.0;
        let is_end = time_h >= hours - 1e-9;
        if is_end || time_h >= f64::from(sums.hour.number) - 1e-9 {
            let counters = *slam.counters();
            let number = sums.hour.number;
            each(&Hour {
                rmse_m: (sums.square_m2 / f64::from(sums.steps)).sqrt(),
                nees: sums.nees / f64::from(sums.scored),
                births: counters.births - before.births,
                holds: counters.holds - before.holds,
                jolts: counters.jolts - before.jolts,
                walls: slam.walls().count(),
                ..sums.hour
            });
            before = counters;
            sums = Sums {
                hour: Hour { number: number + 1, least_pivot: f64::INFINITY, ..Hour::default() },
                ..Sums::default()
            };
        }
        if is_end {
            return;
        }
    }
}
