//! Prints `docs/results/hand-overs.md`: drives and logs with hand-overs and without.
//! `cargo run --release --package tests --example hand_overs -- FOLDER...`, each folder with a log and its `rig.toml`.

mod apart;
mod readings;

use std::convert::Infallible;
use std::path::{Path, PathBuf};

use hal_sim::SimOptions;
use lab::evaluate::statistics::median;
use lab::evaluate::{score, smoother};
use lab::input::log::{self, Row};
use lab::input::rig_file::Robot;
use lab::recording::{Pose2, Recording};
use lab::run::{Drive, Session};
use slam_core::Config;

use apart::{aligned_m, mean_nees};
use readings::{Distances, distances};

/// Names that a log may have in its folder.
const LOGS: [&str; 2] = ["log.csv", "wean.log.gz"];

/// Robots with sensors that report metres, and with analogue ones.
const RIGS: [&str; 3] = ["time-of-flight", "odometry", "sharp"];
const PLANS: [&str; 3] = ["flat", "room", "corridor-loop"];
const SEEDS: std::ops::RangeInclusive<u64> = 1..=4;
const MINUTES: f64 = 6.0;

/// Replays of a log, each beginning a second later.
const REPLAYS: u32 = 5;

const HEAD: &str = "\
# Hand-overs

Printed by `cargo run --release --package tests --example hand_overs -- FOLDER...` for folders of [real logs](real-logs.md): the same
drives and logs without and with hand-overs (`--hand-overs true`). [How it works](../explanation/look-back.md#handing-over).

## Simulated drives

Means over four seeds of six minutes. *In the minute after* is the mean NEES of the poses within a minute after a hand-over (3 is ideal).

| rig | plan | | path | NEES | in the minute after | walls | missed | invented | taken over | refused |
|---|---|---|---|---|---|---|---|---|---|---|";

const LOGS_HEAD: &str = "
## Real logs

Medians of five replays. *Live, second half*: how far the poses of the second half of the log, as they were estimated at the time, are from
those of the workbench's look back, after the best rigid motion; *truth* is the same of the whole path against the truth.

| log | | truth | live, second half | worst | walls | taken over | refused |
|---|---|---|---|---|---|---|---|";

const READINGS_HEAD: &str = "
## Readings and their walls

How far the readings that the filter used end from their walls, medians over the second half of each log, and of five replays. *Own
map*: from the filter's walls, both as they were at the time. *Looked-back map*: from the nearest wall of the workbench's look back, where
the filter had the robot at the time after the best rigid motion, and where the look back has it. The ratios are to the last; the worst
of the five beside them.

| log | | own map | looked-back map, live | looked-back map, look back | own map, ratio | looked-back map, ratio |
|---|---|---|---|---|---|---|";

fn main() {
    println!("{HEAD}");
    for rig in RIGS {
        PLANS.iter().for_each(|plan| compare_drives(rig, plan));
    }
    println!("{LOGS_HEAD}");
    let readings: Vec<String> =
        std::env::args().skip(1).flat_map(|folder| compare_replays(Path::new(&folder))).collect();
    println!("{READINGS_HEAD}");
    readings.iter().for_each(|row| println!("{row}"));
}

fn robot(rig: &str) -> Robot {
    lab::input::robot(Path::new(rig)).expect("a built-in rig").0
}

fn config(robot: &Robot, hand_overs: bool) -> Config {
    Config { hand_overs, ..Config::for_rig(&robot.rig) }
}

/// Hand-overs that were taken over, and those that were refused.
fn handed(recording: &Recording) -> [f64; 2] {
    let refused = recording.hand_overs.iter().filter(|found| found.refused.is_some()).count();
    [(recording.hand_overs.len() - refused) as f64, refused as f64]
}

fn drive(plan: &str, robot: &Robot, hand_overs: bool, seed: u64) -> [f64; 8] {
    let home = hal_sim::plan_file::load(plan).expect("a built-in plan");
    let mut drive = Drive::new(&home, robot, SimOptions::default(), seed).expect("the robot fits");
    let mut session = Session::new(robot, config(robot, hand_overs), plan).expect("a good rig");
    drive.run(&mut session, 60.0 * MINUTES, |_, _, _| Ok::<(), Infallible>(())).expect("nothing can fail");
    let recording = drive.finish(session);
    let (path, map) = recording.figures.estimate.zip(recording.figures.map).expect("a truth and a plan");
    let taken_at = recording.hand_overs.iter().filter(|found| found.refused.is_none());
    let taken_at: Vec<f64> = taken_at.map(|found| recording.steps[found.step].t_s).collect();
    let is_after = |t_s: f64| taken_at.iter().any(|at_s| (0.0..60.0).contains(&(t_s - at_s)));
    let [taken, refused] = handed(&recording);
    let all = mean_nees(&recording, |_| true);
    [
        path.ate_m,
        all,
        mean_nees(&recording, is_after),
        map.offset_m.expect("a wall that matches"),
        map.missed as f64,
        map.invented as f64,
        taken,
        refused,
    ]
}

fn compare_drives(rig: &str, plan: &str) {
    let robot = robot(rig);
    for (hand_overs, name) in [(false, "without"), (true, "with")] {
        let drives: Vec<[f64; 8]> = SEEDS.map(|seed| drive(plan, &robot, hand_overs, seed)).collect();
        let mean = |i: usize| drives.iter().map(|figures| figures[i]).sum::<f64>() / drives.len() as f64;
        let after = if hand_overs { format!("{:.1}", mean(2)) } else { String::new() };
        println!(
            "| {rig} | {plan} | {name} | {:.2} cm | {:.1} | {after} | {:.2} cm | {:.2} | {:.2} | {:.1} | {:.1} |",
            100.0 * mean(0),
            mean(1),
            100.0 * mean(3),
            mean(4),
            mean(5),
            mean(6),
            mean(7),
        );
    }
}

/// A log's rows, its robot and its truth.
struct Log {
    robot: Robot,
    rows: Vec<Row>,
    truth: Option<log::truth::Truth>,
}

impl Log {
    fn read(folder: &Path) -> Self {
        let file: PathBuf = LOGS.map(|file| folder.join(file)).into_iter().find(|file| file.is_file()).expect("a log");
        let mut robot = Robot::read(&folder.join("rig.toml")).unwrap_or_else(|error| panic!("{error}"));
        let rows = log::open(&file, &mut robot).and_then(|rows| rows.collect::<Result<Vec<_>, _>>());
        let rows = rows.unwrap_or_else(|error| panic!("{error}"));
        let truth = folder.join("truth.csv");
        let truth = truth.is_file().then(|| log::truth::read(&truth).unwrap_or_else(|error| panic!("{error}")));
        Self { robot, rows, truth }
    }

    fn replay(&self, from_s: f64, hand_overs: bool) -> Recording {
        let mut session = Session::new(&self.robot, config(&self.robot, hand_overs), "").expect("a good rig");
        let rows = self.rows.iter().filter(|row| row.t_s >= self.rows[0].t_s + from_s);
        let mut times_s = Vec::new();
        for row in rows {
            session.push(row);
            times_s.push(row.t_s);
        }
        let mut recording = session.finish();
        score::score(&mut recording, &times_s, self.truth.as_ref());
        recording
    }
}

/// Prints the two rows of a log; those of its readings.
fn compare_replays(folder: &Path) -> [String; 2] {
    let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let log = Log::read(folder);
    let mut figures: [Vec<[f64; 5]>; 2] = Default::default();
    let mut readings: [Vec<Distances>; 2] = Default::default();
    for replay in 0..REPLAYS {
        let mut without = log.replay(replay.into(), false);
        let with = log.replay(replay.into(), true);
        let back = smoother::add(&mut without, &log.robot.rig, &mut |_| ()).expect("a log with walls");
        for (recording, readings) in [&without, &with].into_iter().zip(&mut readings) {
            readings.push(distances(recording, &back));
        }
        for (recording, figures) in [&without, &with].into_iter().zip(&mut figures) {
            let poses =
                |recording: &Recording| -> Vec<Pose2> { recording.steps.iter().map(|step| step.pose).collect() };
            let (live, back) = (poses(recording), poses(&back));
            let half = live.len() / 2;
            let truth_m = recording.figures.estimate.map_or(f64::NAN, |path| path.ate_m);
            let [taken, refused] = handed(recording);
            let walls = recording.figures.walls as f64;
            figures.push([truth_m, aligned_m(&live[half..], &back[half..]), walls, taken, refused]);
        }
    }
    for (which, figures) in ["without", "with"].iter().zip(&figures) {
        let all = |i: usize| -> Vec<f64> { figures.iter().map(|figures| figures[i]).collect() };
        let middle = |i: usize| median(&all(i)).unwrap_or(f64::NAN);
        let truth = if log.truth.is_some() { format!("{:.1} cm", 100.0 * middle(0)) } else { "not known".to_owned() };
        let worst_m = all(1).into_iter().fold(0.0, f64::max);
        println!(
            "| {name} | {which} | {truth} | {:.1} cm | {:.1} cm | {} | {} | {} |",
            100.0 * middle(1),
            100.0 * worst_m,
            middle(2),
            middle(3),
            middle(4),
        );
    }
    [0, 1].map(|i| readings_row(&name, ["without", "with"][i], &readings[i]))
}

fn readings_row(name: &str, which: &str, replays: &[Distances]) -> String {
    let all = |of: fn(&Distances) -> f64| -> Vec<f64> { replays.iter().map(of).collect() };
    let cm = |of| 100.0 * median(&all(of)).unwrap_or(f64::NAN);
    let ratio = |of| {
        let ratios = all(of);
        let worst = ratios.iter().copied().fold(0.0, f64::max);
        format!("{:.1} (worst {worst:.1})", median(&ratios).unwrap_or(f64::NAN))
    };
    format!(
        "| {name} | {which} | {:.2} cm | {:.2} cm | {:.2} cm | {} | {} |",
        cm(|found| found.own_m),
        cm(|found| found.live_m),
        cm(|found| found.back_m),
        ratio(|found| found.own_m / found.back_m),
        ratio(|found| found.live_m / found.back_m),
    )
}
