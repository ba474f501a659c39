//! Writes `docs/results/floor-again.md`: `cargo run --release --package lab --example second_runs`. With `-- SEEDS HOME...`, as in
//! `-- 11-13 flat random-101`, it prints the rows of these homes instead.
//!
//! Each home is swept from an empty map, and then once more in the map that the robot kept.

use std::convert::Infallible;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use hal_sim::floor::FloorScore;
use hal_sim::{Plan, SimOptions, plan_file};
use lab::input::built_in_robot;
use lab::run::{Drive, Session};
use slam_core::Config;

const SEEDS: std::ops::RangeInclusive<u64> = 1..=5;

/// A job that takes longer than this is ended, minutes.
const MINUTES: f64 = 60.0;

const HEAD: &str = "# Floors swept again\n\n\
    Written by `cargo run --release --package lab --example second_runs`. The built-in robot sweeps each home twice: from an empty map, and\n\
    from the same place once more in the map that it kept, not knowing where it is, with other noise (seeds 1 to 5, then 101 to 105). Mean, and in\n\
    brackets the worst. What is aimed at: overlap at most 1.5 in the first run and 1.35 in the second. *Found after* is the time until the\n\
    robot knows its place in the kept map; [what counts](../explanation/floor-job.md#what-counts).\n\n\
    | home | run | back within 20 cm | swept, % | overlap | largest hole, m2 | minutes | found after, s |\n\
    |---|---|---|---|---|---|---|---|\n";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some((seeds, homes)) = arguments.split_first() {
        let (first, last) = seeds.split_once('-').unwrap_or((seeds, seeds));
        let seed = |text: &str| text.parse::<u64>().expect("SEEDS is a number, or two as in 11-13");
        for home in homes {
            let mut rows = String::new();
            home_rows(&mut rows, home, seed(first)..=seed(last));
            print!("{rows}");
        }
        return;
    }
    let mut page = HEAD.to_owned();
    for (name, _) in plan_file::BUILT_IN {
        home_rows(&mut page, name, SEEDS);
        eprint!("{page}");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/floor-again.md");
    fs::write(&path, page).expect("docs/results/floor-again.md can be written");
}

/// The rows of a home.
fn home_rows(page: &mut String, name: &str, seeds: std::ops::RangeInclusive<u64>) {
    let plan = plan_file::load(name).expect("a built-in plan, or random-SEED");
    let runs: Vec<[Done; 2]> = seeds
        .map(|seed| {
            let (first, map) = sweep(&plan, seed, None);
            let (second, _) = sweep(&plan, seed + 100, map);
            [first, second]
        })
        .collect();
    row(page, name, "first", &runs.iter().map(|[first, _]| first).collect::<Vec<_>>());
    row(page, "", "second", &runs.iter().map(|[_, second]| second).collect::<Vec<_>>());
}

/// How a job ended.
struct Done {
    score: FloorScore,
    minutes: f64,
    /// When the robot knew its place, seconds; none where it never did.
    found_s: Option<f64>,
}

/// Sweeps a home, in this kept map where there is one; gives the map that is kept then.
fn sweep(plan: &Plan, seed: u64, map: Option<Vec<u8>>) -> (Done, Option<Vec<u8>>) {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    let mut session = Session::new(&robot, Config::for_rig(&robot.rig), plan.name.clone()).expect("a good rig");
    if let Some(map) = map {
        session.begin_in(map).expect("its own map");
    }
    let mut drive = Drive::cleaning(plan, &robot, SimOptions::default(), seed).expect("the robot fits");
    let mut found_s = None;
    let done = drive.run(&mut session, 60.0 * MINUTES, |row, recording, _| -> Result<(), Infallible> {
        if found_s.is_none() && recording.steps.last().is_some_and(|step| !step.searching) {
            found_s = Some(row.t_s);
        }
        Ok(())
    });
    done.expect("nothing can fail");
    let minutes = session.recording().steps.last().map_or(0.0, |step| step.t_s / 60.0);
    (Done { score: drive.floor().score(), minutes, found_s }, session.map())
}

fn row(page: &mut String, home: &str, run: &str, runs: &[&Done]) {
    let values = |value: fn(&Done) -> f64| runs.iter().map(|done| value(done)).collect::<Vec<_>>();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let high = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let swept = values(|done| 100.0 * done.score.swept);
    let overlap = values(|done| done.score.overlap);
    let hole = values(|done| done.score.largest_hole_m2);
    let minutes = values(|done| done.minutes);
    let back = runs.iter().filter(|done| done.score.home_m < 0.2).count();
    let found: Vec<f64> = runs.iter().filter_map(|done| done.found_s).collect();
    let found = if found.len() < runs.len() {
        format!("{} of {} never", runs.len() - found.len(), runs.len())
    } else {
        format!("{:.0} ({:.0})", mean(&found), high(&found))
    };
    let line = writeln!(
        page,
        "| {home} | {run} | {back} of {} | {:.1} ({:.1}) | {:.2} ({:.2}) | {:.3} ({:.3}) | {:.1} ({:.1}) | {found} |",
        runs.len(),
        mean(&swept),
        swept.iter().copied().fold(f64::INFINITY, f64::min),
        mean(&overlap),
        high(&overlap),
        mean(&hole),
        high(&hole),
        mean(&minutes),
        high(&minutes),
    );
    line.expect("a String takes it all");
}
