//! How fast the estimator and a whole simulated drive are: `cargo bench --package lab`.

use divan::Bencher;
use divan::counter::ItemsCount;
use hal_sim::SimOptions;
use lab::input::built_in_robot;
use lab::input::log::Row;
use lab::input::rig_file::Robot;
use lab::run::Drive;
use lab::run::Session;
use slam_core::{Config, HostSlam, Sample};

fn main() {
    divan::main();
}

fn robot() -> Robot {
    built_in_robot().expect("the built-in rig is good").0
}

/// Drives through the four-room flat, estimating, for this long.
fn drive(robot: &Robot, minutes: f64) -> (Session, Vec<Row>) {
    let plan = hal_sim::plan_file::load("flat").expect("a built-in plan");
    let mut drive = Drive::new(&plan, robot, SimOptions::default(), 1).expect("the built-in robot fits");
    let mut session = Session::new(robot, Config::default(), "bench").expect("a good rig");
    let mut rows: Vec<Row> = Vec::new();
    let kept = drive.run(&mut session, 60.0 * minutes, |row, _, _| {
        rows.push(row.clone());
        Ok::<(), std::convert::Infallible>(())
    });
    kept.expect("nothing can fail");
    (session, rows)
}

/// Ten minutes of eight sensors at 25 Hz: simulation, pilot, estimation and recording. The bar is 2 s.
#[divan::bench(sample_count = 10)]
fn ten_minutes_simulated_and_estimated(bencher: Bencher) {
    let robot = robot();
    bencher.bench_local(|| drive(&robot, 10.0).1.len());
}

/// One estimator step while the map has this many walls or a few more. The bar is 10 microseconds at 30 walls.
#[divan::bench(args = [10, 20, 30], sample_count = 20)]
fn one_step(bencher: Bencher, walls: usize) {
    const STEPS: usize = 500;
    let robot = robot();
    let samples: Vec<Sample<16>> = drive(&robot, 10.0).1.iter().map(|row| row.sample).collect();
    let fresh = || Box::new(HostSlam::with_config(robot.rig.clone(), Config::default()).expect("a good rig"));
    let mut slam = fresh();
    let reached = |sample| {
        slam.step(sample);
        slam.walls().count() >= walls
    };
    let begin = samples.iter().position(reached).expect("the flat has that many walls") + 1;
    let (before, rest) = samples.split_at(begin);
    let timed = &rest[..STEPS.min(rest.len())];
    bencher
        .counter(ItemsCount::new(timed.len()))
        .with_inputs(|| {
            let mut slam = fresh();
            for sample in before {
                slam.step(sample);
            }
            slam
        })
        .bench_local_values(|mut slam| {
            for sample in timed {
                divan::black_box(slam.step(sample));
            }
            slam
        });
}
