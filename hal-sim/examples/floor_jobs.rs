//! Writes `docs/results/floor.md`: `cargo run --release --package hal-sim --example floor_jobs`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use hal_sim::floor::{FloorRaster, FloorScore, Moment};
use hal_sim::{ClosedLoop, Estimate, Plan, SimOptions, Simulation, default_rig, plan_file};
use robot::{FloorConfig, FloorState};
use slam_core::{Config, HostSlam};

const SEEDS: std::ops::RangeInclusive<u64> = 1..=10;
const RANDOM_HOMES: std::ops::RangeInclusive<u64> = 1..=40;

/// A job that takes longer than this is ended, minutes.
const MINUTES: f64 = 60.0;

const HEAD: &str = "# Floors swept\n\n\
    Written by `cargo run --release --package hal-sim --example floor_jobs`. The built-in robot sweeps each home once, from an empty map,\n\
    without a dock; [what counts](../explanation/floor-job.md#what-counts). Mean, and in brackets the worst: of ten seeds a built-in\n\
    plan, and of the random homes 1 to 40 (`--plan random-SEED`), one drive each. *Bars* are what is aimed at: at least 96 % swept (93 %\n\
    in clutter), overlap at most 1.5, no hole over 0.05 m2, back within 20 cm, the flat in 20 minutes.\n\n\
    | home | drives | done and back | floor, m2 | swept, % | overlap | largest hole, m2 | holes over 0.05 m2 | minutes | bumps a m2 | from the start, m |\n\
    |---|---|---|---|---|---|---|---|---|---|---|\n";

fn main() {
    let mut page = HEAD.to_owned();
    for (name, _) in plan_file::BUILT_IN {
        let plan = plan_file::load(name).expect("a built-in plan");
        let jobs: Vec<Done> = SEEDS.map(|seed| clean(&plan, seed)).collect();
        row(&mut page, name, &jobs);
    }
    let homes = RANDOM_HOMES.map(|seed| plan_file::load(&format!("random-{seed}")).expect("a random home"));
    let jobs: Vec<Done> = homes.map(|plan| clean(&plan, 1)).collect();
    row(&mut page, "random", &jobs);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/floor.md");
    fs::write(&path, page).expect("docs/results/floor.md can be written");
}

/// How a job ended.
struct Done {
    score: FloorScore,
    state: FloorState,
    minutes: f64,
}

fn clean(plan: &Plan, seed: u64) -> Done {
    let rig = default_rig();
    let simulation = Simulation::new(plan, &rig, SimOptions::default(), seed).expect("the robot fits");
    let mut slam = HostSlam::with_config(rig.clone(), Config::default()).expect("a good rig");
    let mut floor = FloorRaster::new(plan, simulation.options().body_radius_m, simulation.pose_in_plan());
    let mut robot = ClosedLoop::cleaning(simulation, &rig, FloorConfig::default());
    while !robot.is_over() && robot.simulation.time_s() < 60.0 * MINUTES {
        robot.step(&mut |sample| {
            let report = slam.step(sample);
            Estimate { pose: slam.pose(), ranges_m: report.readings.map(|reading| reading.range_m) }
        });
        if let (Some((alpha_rad, _)), Some(job)) = (slam.alpha(), &mut robot.floor_job) {
            job.align(alpha_rad);
        }
        let contacts = robot.simulation.contacts();
        floor.record(&Moment {
            t_s: robot.simulation.time_s(),
            pose: robot.simulation.pose_in_plan(),
            doing: robot.doing(),
            is_pressed: contacts.bump_left || contacts.bump_right,
            is_on_floor: !contacts.lifted,
        });
    }
    let state = robot.floor_job.as_ref().map_or(FloorState::Away, |job| job.state());
    Done { score: floor.score(), state, minutes: robot.simulation.time_s() / 60.0 }
}

fn row(page: &mut String, name: &str, jobs: &[Done]) {
    let values = |value: fn(&Done) -> f64| jobs.iter().map(value).collect::<Vec<_>>();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let high = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let swept = values(|done| 100.0 * done.score.swept);
    let overlap = values(|done| done.score.overlap);
    let hole = values(|done| done.score.largest_hole_m2);
    let minutes = values(|done| done.minutes);
    let bumps = values(|done| f64::from(done.score.bumps) / done.score.floor_m2);
    let home = values(|done| done.score.home_m);
    let back = jobs.iter().filter(|done| done.state == FloorState::Done).count();
    let line = writeln!(
        page,
        "| {name} | {} | {back} | {:.1} | {:.1} ({:.1}) | {:.2} ({:.2}) | {:.3} ({:.3}) | {} | {:.1} ({:.1}) | {:.1} ({:.1}) | {:.2} ({:.2}) |",
        jobs.len(),
        mean(&values(|done| done.score.floor_m2)),
        mean(&swept),
        low(&swept),
        mean(&overlap),
        high(&overlap),
        mean(&hole),
        high(&hole),
        hole.iter().filter(|hole| **hole > 0.05).count(),
        mean(&minutes),
        high(&minutes),
        mean(&bumps),
        high(&bumps),
        mean(&home),
        high(&home),
    );
    line.expect("a String takes it all");
}
