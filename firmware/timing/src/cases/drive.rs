//! Whole steps at 25 Hz with eight readings each: up the stairs until the map is full, then down through known walls.

use super::home::{Drive, rig};
use core::ops::Range;
use instruction_count::Bench;
use slam_core::{Clustering, Config, Outcome, RobotSlam, StepReport};
use static_cell::ConstStaticCell;

/// What the map holds.
const WALLS: usize = 64;
/// More steps than the way up takes.
const MOST_STEPS: u32 = 4_000;
/// Steps of the way down.
const DOWN_STEPS: u32 = 200;
/// Steps in which every sensor sees things that are no walls: they fill the outlier buffer.
const CLUTTER: Range<u32> = 1_000..1_040;
/// The same on the way down, where every wall there is room for is about.
const DOWN_CLUTTER: Range<u32> = 100..140;

static ESTIMATOR: ConstStaticCell<RobotSlam> = ConstStaticCell::new(RobotSlam::IDLE);

/// The costliest steps of each kind.
#[derive(Default)]
struct Worst {
    /// All eight readings update a map of 64 walls, and no wall is looked for.
    full: u32,
    /// A wall is born.
    birth: u32,
    /// The outlier buffer is full of clutter.
    clutter: u32,
    /// Of all.
    any: u32,
}

/// One drive for each clustering.
pub fn run(bench: &Bench) {
    let slam = ESTIMATOR.take();
    let by_sensor = drive(bench, slam, Clustering::BySensor);
    bench.print("step_n79_8_updates", by_sensor.full);
    bench.print("step_birth", by_sensor.birth);
    bench.print("step_clutter", by_sensor.clutter);
    bench.print("step_worst", by_sensor.any);
    let dbscan = drive(bench, slam, Clustering::Dbscan);
    bench.print("step_birth_dbscan", dbscan.birth);
    bench.print("step_clutter_dbscan", dbscan.clutter);
    bench.print("step_worst_dbscan", dbscan.any);
}

fn drive(bench: &Bench, slam: &mut RobotSlam, clustering: Clustering) -> Worst {
    let config = Config { births: clustering.into(), ..Config::default() };
    slam.start_with_config(rig(), config).expect("the rig is a valid one");
    let mut worst = Worst::default();
    let mut home = Drive::new();
    let mut down_from = None;
    for step in 0..MOST_STEPS {
        let full = slam.walls().count() == WALLS;
        if full && down_from.is_none() {
            home.turn_back();
            down_from = Some(step);
        }
        if down_from.is_some_and(|start| step > start + DOWN_STEPS) {
            return worst;
        }
        let down = down_from.and_then(|start| step.checked_sub(start));
        let is_clutter = CLUTTER.contains(&step) || down.is_some_and(|down| DOWN_CLUTTER.contains(&down));
        let sample = home.next(is_clutter);
        let (report, cost) = bench.measure(|| slam.step(&sample));
        if full && updates(&report) == 8 {
            worst.full = worst.full.max(cost);
        }
        if report.births > 0 {
            worst.birth = worst.birth.max(cost);
        }
        if is_clutter {
            worst.clutter = worst.clutter.max(cost);
        }
        worst.any = worst.any.max(cost);
    }
    panic!("the map has {} walls after {MOST_STEPS} steps, not {WALLS}", slam.walls().count())
}

fn updates(report: &StepReport<8>) -> usize {
    report.readings.iter().filter(|reading| matches!(reading.outcome, Outcome::Updated { .. })).count()
}
