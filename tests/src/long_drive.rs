//! Drives of hours and days, whose figures are kept hour by hour.

use hal_sim::{ClosedLoop, Estimate, Plan, SimOptions, Simulation};
use lab::evaluate::score::path;
use lab::input::rig_file::Robot;
use lab::recording::{Pose2, Step};
use lab::run::Session;
use robot::PilotConfig;
use slam_core::Config;

use crate::positivity::{flaw, least_correlation_pivot};

/// The covariance is looked at once in so many steps: ten times a minute.
const LOOK_EVERY: u32 = 150;

/// What one hour of a drive was like.
#[derive(Clone, Debug, Default)]
pub struct Hour {
    /// Which, from 1.
    pub number: u32,
    /// Root mean square of the position's error in the start frame, metres, where the robot claimed a place.
    pub rmse_m: f64,
    /// The same where the path of the hour is laid over the true one: what is left are the map's own errors.
    pub aligned_m: f64,
    /// Mean NEES of the pose there: three for an honest filter.
    pub nees: f64,
    /// For how long the robot did not know where it is, seconds.
    pub lost_s: f64,
    /// How often it gave its map up.
    pub restarts: u32,
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

/// Sums over one hour: of every step, of those in which the robot claimed a place, and of those of them whose covariance can be inverted.
#[derive(Default)]
struct Sums {
    steps: u32,
    square_m2: f64,
    nees: f64,
    scored: u32,
    /// The poses there, estimated and true.
    pairs: Vec<(Pose2, Pose2)>,
    hour: Hour,
}

impl Sums {
    /// An hour of which nothing is known yet.
    fn of_hour(number: u32) -> Self {
        Self { hour: Hour { number, least_pivot: f64::INFINITY, ..Hour::default() }, ..Self::default() }
    }

    /// Adds a step that took so long, seconds.
    fn add(&mut self, step: &Step, is_located: bool, took_s: f64) {
        self.steps += 1;
        if !is_located {
            self.hour.lost_s += took_s;
            return;
        }
        self.square_m2 += step.error().map_or(0.0, |e| e.x_m * e.x_m + e.y_m * e.y_m);
        self.pairs.extend(step.truth.map(|truth| (step.pose, truth)));
        if let Some(nees) = path::nees(step) {
            self.nees += nees;
            self.scored += 1;
        }
    }
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

/// A robot drives through a home for so many hours, as robots do: with a map that is kept where readings contradict it, and in which
/// it finds itself again. `each` gets every hour as it ends.
pub fn drive(robot: &Robot, plan: &Plan, hours: f64, seed: u64, mut each: impl FnMut(&Hour)) {
    let rig = &robot.rig;
    let simulation = Simulation::new(plan, rig, SimOptions::default(), seed).expect("the robot fits");
    let mut session = Session::new(robot, Config::for_rig(rig), plan.name.clone()).expect("a good rig");
    let mut driven = ClosedLoop::new(simulation, rig, PilotConfig::default());
    let mut sums = Sums::of_hour(1);
    let mut before = *session.slam().counters();
    let (mut last, mut last_s) = (None, 0.0);
    loop {
        // Not recorded, as a drive of the workbench is: three days would be gigabytes.
        let frame = driven.step_in(&mut |sample| {
            let report = session.estimate(sample);
            (Estimate::new(session.slam().pose(), &report), session.whereabouts())
        });
        let time_s = driven.simulation.time_s();
        let slam = session.slam();
        let estimate = slam.estimate();
        let step = Step {
            pose: estimate.pose.into(),
            start: slam.start_pose().into(),
            covariance: estimate.covariance.into(),
            truth: Some(frame.truth),
            ..Step::default()
        };
        sums.add(&step, session.is_located(), time_s - last_s);
        sums.hour.path_m += path::length_m([last.unwrap_or(frame.truth), frame.truth].into_iter());
        (last, last_s) = (Some(frame.truth), time_s);
        if sums.steps.is_multiple_of(LOOK_EVERY) {
            sums.hour.least_pivot = sums.hour.least_pivot.min(least_correlation_pivot(slam));
            sums.hour.flaw = sums.hour.flaw.take().or_else(|| flaw(slam));
        }
        let time_h = time_s / 3600.0;
        let is_end = time_h >= hours - 1e-9;
        if is_end || time_h >= f64::from(sums.hour.number) - 1e-9 {
            let counters = *slam.counters();
            let number = sums.hour.number;
            each(&Hour {
                rmse_m: (sums.square_m2 / sums.pairs.len() as f64).sqrt(),
                aligned_m: path::score(&sums.pairs).map_or(f64::NAN, |score| score.ate_m),
                nees: sums.nees / f64::from(sums.scored),
                births: counters.births - before.births,
                holds: counters.holds - before.holds,
                jolts: counters.jolts - before.jolts,
                restarts: counters.restarts - before.restarts,
                walls: slam.walls().count(),
                ..sums.hour
            });
            before = counters;
            sums = Sums::of_hour(number + 1);
        }
        if is_end {
            return;
        }
    }
}
