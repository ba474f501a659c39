//! Writes `docs/results/floor-again.md`: `cargo run --release --package lab --example second_runs`. With `-- SEEDS HOME...`, as in
//! `-- 11-13 flat random-101`, it prints the rows of these homes instead, and with `-- cuts 61-80` the section on power cuts in those random homes.
//!
//! Each home is swept from an empty map, and then once more in the map that the robot kept; random homes from a dock as well, from another one,
//! without, and with a power cut in the middle.

mod power_cuts;

use std::fmt::Write as _;
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;

use hal_sim::random_home::with_dock;
use hal_sim::{Plan, SimOptions, plan_file};
use lab::run::{FloorDrive, clean_with};

const SEEDS: RangeInclusive<u64> = 1..=5;

const HEAD: &str = "# Floors swept again\n\n\
    Written by `cargo run --release --package lab --example second_runs`. The built-in robot sweeps each home twice: from an empty map, and\n\
    from the same place once more in the map that it kept, not knowing where it is, with other noise (seeds 1 to 5, then 101 to 105). Mean, and in\n\
    brackets the worst. What is aimed at: overlap at most 1.5 in the first run and 1.35 in the second. *Found after* is the time until the\n\
    robot knows its place in the kept map; [what counts](../explanation/floor-job.md#what-counts).\n\n\
    | home | run | back within 20 cm | swept, % | overlap | largest hole, m2 | minutes | found after, s |\n\
    |---|---|---|---|---|---|---|---|\n";

/// Random homes.
const RANDOM: RangeInclusive<u64> = 41..=60;

const FROM_A_DOCK: &str = "\n## From a dock\n\n\
    The random homes 41 to 60, one of each, from a place at a wall that is drawn: once more from where the robot has swept it before, with a dock there and without one, and\n\
    with the dock at another wall, from there. *Found* is when the robot claims a place for good, the median and the worst, seconds; *wrong* is in how many it claimed one that was\n\
    more than 0.3 m off.\n\n\
    | second run | homes | found | wrong | back within 20 cm | swept, % | overlap |\n\
    |---|---|---|---|---|---|---|\n";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => write_page(),
        ["cuts", homes] => {
            let mut rows = String::new();
            power_cuts::section(&mut rows, numbers(homes));
            print!("{rows}");
        }
        [seeds, ref homes @ ..] => {
            for home in homes {
                let mut rows = String::new();
                home_rows(&mut rows, home, numbers(seeds));
                print!("{rows}");
            }
        }
    }
}

/// A number, or two as in 11-13.
fn numbers(text: &str) -> RangeInclusive<u64> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let number = |text: &str| text.parse::<u64>().expect("a number, or two as in 11-13");
    number(first)..=number(last)
}

fn write_page() {
    let mut page = HEAD.to_owned();
    for (name, _) in plan_file::BUILT_IN {
        home_rows(&mut page, name, SEEDS);
        eprint!("{page}");
    }
    page.push_str(FROM_A_DOCK);
    dock_rows(&mut page);
    power_cuts::section(&mut page, RANDOM);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/floor-again.md");
    fs::write(&path, page).expect("docs/results/floor-again.md can be written");
}

/// The rows of a home.
fn home_rows(page: &mut String, name: &str, seeds: RangeInclusive<u64>) {
    let plan = plan_file::load(name).expect("a built-in plan, or random-SEED");
    let runs: Vec<[Done; 2]> = seeds
        .map(|seed| {
            let first = sweep(&plan, seed, None);
            let second = sweep(&plan, seed + 100, first.0.map.clone());
            [first, second]
        })
        .collect();
    row(page, name, "first", &runs.iter().map(|[first, _]| first).collect::<Vec<_>>());
    row(page, "", "second", &runs.iter().map(|[_, second]| second).collect::<Vec<_>>());
}

/// A second run from a dock: how it ended, when the robot claimed a place for good, seconds, and whether it claimed a wrong one before.
type Docked = (FloorDrive, f64, bool);

fn dock_rows(page: &mut String) {
    let names = ["from its dock", "from there, without a dock", "from a dock that was moved"];
    let mut runs: [Vec<Docked>; 3] = Default::default();
    for home in RANDOM {
        let plan = plan_file::load(&format!("random-{home}")).expect("a random home");
        let [first, other] =
            [home, home + 1000].map(|seed| with_dock(&plan, seed).expect("a wall with room for a dock"));
        let without = Plan { has_dock: false, ..first.clone() };
        let [docked, free] = [&first, &without].map(|plan| sweep(plan, 1, None).0.map);
        let second = [(&first, docked.clone()), (&without, free), (&other, docked)];
        for ((plan, map), runs) in second.into_iter().zip(&mut runs) {
            runs.push(sweep_from(&first, plan, map));
        }
    }
    for (name, runs) in names.iter().zip(&runs) {
        let mut found: Vec<f64> = runs.iter().map(|(_, found_s, _)| *found_s).collect();
        found.sort_by(f64::total_cmp);
        let mean =
            |value: fn(&FloorDrive) -> f64| runs.iter().map(|(done, ..)| value(done)).sum::<f64>() / runs.len() as f64;
        let worst_s = found.iter().copied().fold(0.0, f64::max);
        let worst = if worst_s.is_finite() { format!("{worst_s:.0}") } else { "never".to_owned() };
        let line = writeln!(
            page,
            "| {name} | {} | {:.0} ({worst}) | {} | {} | {:.1} | {:.2} |",
            runs.len(),
            found[found.len() / 2],
            runs.iter().filter(|(.., was_wrong)| *was_wrong).count(),
            runs.iter().filter(|(done, ..)| done.score.home_m < 0.2).count(),
            mean(|done| 100.0 * done.score.swept),
            mean(|done| done.score.overlap),
        );
        line.expect("a String takes it all");
    }
}

/// Sweeps a home whose robot has this map of it, which was made from where `mapped` begins.
fn sweep_from(mapped: &Plan, plan: &Plan, map: Option<Vec<u8>>) -> Docked {
    let (mut found_s, mut is_wrong, mut was_wrong) = (None, false, false);
    let drive = clean_with(plan, SimOptions::default(), 2, map, |drive, step| {
        if step.searching {
            (found_s, was_wrong) = (None, was_wrong || is_wrong);
            is_wrong = false;
        } else if found_s.is_none() {
            found_s = Some(step.t_s);
            let truth = mapped.start.relative(&drive.simulation().pose_in_plan());
            let estimate = step.start.relative(&step.pose);
            is_wrong = (truth.x_m - estimate.x_m).hypot(truth.y_m - estimate.y_m) > 0.3;
        }
    });
    let drive = drive.expect("the robot fits, and goes on in its own map");
    (drive, found_s.unwrap_or(f64::INFINITY), was_wrong || is_wrong)
}

/// How a job ended, and when the robot knew its place, seconds; none where it never did.
type Done = (FloorDrive, Option<f64>);

/// Sweeps a home, in this kept map where there is one.
fn sweep(plan: &Plan, seed: u64, map: Option<Vec<u8>>) -> Done {
    let mut found_s = None;
    let drive = clean_with(plan, SimOptions::default(), seed, map, |_, step| {
        found_s = found_s.or((!step.searching).then_some(step.t_s));
    });
    (drive.expect("the robot fits, and goes on in its own map"), found_s)
}

fn row(page: &mut String, home: &str, run: &str, runs: &[&Done]) {
    let values = |value: fn(&FloorDrive) -> f64| runs.iter().map(|(done, _)| value(done)).collect::<Vec<_>>();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let high = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let swept = values(|done| 100.0 * done.score.swept);
    let overlap = values(|done| done.score.overlap);
    let hole = values(|done| done.score.largest_hole_m2);
    let minutes = values(|done| done.minutes);
    let back = runs.iter().filter(|(done, _)| done.score.home_m < 0.2).count();
    let found: Vec<f64> = runs.iter().filter_map(|(_, found_s)| *found_s).collect();
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
