//! Writes `docs/results/floor.md`: `cargo run --release --package hal-sim --example floor_jobs`. With `-- SEEDS HOME...`, as in
//! `-- 11-13 flat random-101`, it prints the rows of these homes instead, and what the path was driven for.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use hal_sim::{FloorDrive, SimOptions, clean, plan_file};
use robot::FloorState;

const SEEDS: std::ops::RangeInclusive<u64> = 1..=10;
const RANDOM_HOMES: std::ops::RangeInclusive<u64> = 41..=80;

/// A job that takes longer than this is ended, minutes.
const MINUTES: f64 = 60.0;

const HEAD: &str = "# Floors swept\n\n\
    Written by `cargo run --release --package hal-sim --example floor_jobs`. The built-in robot sweeps each home once, from an empty map,\n\
    without a dock; [what counts](../explanation/floor-job.md#what-counts). Mean, and in brackets the worst: of ten seeds a built-in\n\
    plan, and of the random homes 41 to 80 (`--plan random-SEED`), one drive each. *Bars* are what is aimed at: at least 96 % swept (93 %\n\
    in clutter), overlap at most 1.5, no hole over 0.05 m2, back within 20 cm, the flat in 20 minutes.\n\n\
    | home | drives | done and back | floor, m2 | swept, % | overlap | largest hole, m2 | holes over 0.05 m2 | minutes | bumps a m2 | from the start, m |\n\
    |---|---|---|---|---|---|---|---|---|---|---|\n";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some((seeds, homes)) = arguments.split_first() {
        let (first, last) = seeds.split_once('-').unwrap_or((seeds, seeds));
        let seed = |text: &str| text.parse::<u64>().expect("SEEDS is a number, or two as in 11-13");
        return homes.iter().for_each(|home| print_home(home, seed(first)..=seed(last)));
    }
    let mut page = HEAD.to_owned();
    for (name, _) in plan_file::BUILT_IN {
        let jobs: Vec<FloorDrive> = SEEDS.map(|seed| job(name, seed)).collect();
        row(&mut page, name, &jobs);
    }
    let jobs: Vec<FloorDrive> = RANDOM_HOMES.map(|home| job(&format!("random-{home}"), 1)).collect();
    row(&mut page, "random", &jobs);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/floor.md");
    fs::write(&path, page).expect("docs/results/floor.md can be written");
}

fn job(home: &str, seed: u64) -> FloorDrive {
    let plan = plan_file::load(home).expect("a built-in plan, or random-SEED");
    clean(&plan, SimOptions::default(), seed, MINUTES).expect("the robot fits")
}

/// The row of one home, and what its path was driven for: metres, and square metres swept for the first time.
fn print_home(home: &str, seeds: std::ops::RangeInclusive<u64>) {
    let jobs: Vec<FloorDrive> = seeds.map(|seed| job(home, seed)).collect();
    let mut text = String::new();
    row(&mut text, home, &jobs);
    for way in jobs.iter().flat_map(|job| &job.score.ways) {
        let _ = write!(text, "{} {:.1}/{:.2}  ", way.doing, way.path_m, way.new_m2);
    }
    for job in &jobs {
        let seconds = FloorState::ALL.iter().zip(job.progress.seconds_in).filter(|(_, seconds)| *seconds > 0);
        let _ = write!(text, "\n{:?} off by {:.2} m, ", job.progress.state, job.worst_m);
        seconds.for_each(|(state, seconds)| text.push_str(&format!("{} {seconds} s, ", state.name())));
    }
    println!("{text}");
}

fn row(page: &mut String, name: &str, jobs: &[FloorDrive]) {
    let values = |value: fn(&FloorDrive) -> f64| jobs.iter().map(value).collect::<Vec<_>>();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let high = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let swept = values(|done| 100.0 * done.score.swept);
    let overlap = values(|done| done.score.overlap);
    let hole = values(|done| done.score.largest_hole_m2);
    let minutes = values(|done| done.minutes);
    let bumps = values(|done| f64::from(done.score.bumps) / done.score.floor_m2);
    let home = values(|done| done.score.home_m);
    let back = jobs.iter().filter(|done| done.progress.state == FloorState::Done).count();
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
