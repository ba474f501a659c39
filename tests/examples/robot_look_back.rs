//! Prints `docs/results/look-back.md`: the look back in a robot's memory beside the workbench's, which has no bounds.
//! `cargo run --release --package tests --example robot_look_back -- FOLDER...`, each folder with a log and its `rig.toml`.

use std::path::{Path, PathBuf};

use lab::evaluate::robot_look_back::RobotLooksBack;
use lab::evaluate::score;
use lab::input::log;
use lab::input::rig_file::Robot;
use lab::input::settings::Settings;
use lab::recording::{Consistency, Figures, PathScore};
use lab::run::Replay;
use look_back::Progress;
use slam_core::Config;

/// Names that a log may have in its folder.
const LOGS: [&str; 2] = ["log.csv", "wean.log.gz"];

const HEAD: &str = "\
# The look back in a robot's memory

Printed by `cargo run --release --package tests --example robot_look_back -- FOLDER...` for folders of
[real logs](real-logs.md). *Live* is the filter; *workbench* is its look back, with all of the log and no bounds on
memory; *robot's size* is the crate `look-back` with 256 keyframes, 1,016 groups of hits and 64 walls in f32, looking back
after every 64 new keyframes and at the end. [How it works](../explanation/look-back.md).
";

fn main() {
    println!("{HEAD}");
    println!(
        "| log | | aligned RMSE | visits apart | sharper than odometry | widest gap | walls |\n|---|---|---|---|---|---|---|"
    );
    let efforts: Vec<String> = std::env::args().skip(1).map(|folder| row(Path::new(&folder))).collect();
    println!(
        "\nA multiply-add is counted as the crate counts its work, to be asked for in slices.\n\n| log | keyframes begun | thinned | look backs | costliest, steps | multiply-adds | of its longest slice |\n\
         |---|---|---|---|---|---|---|"
    );
    efforts.iter().for_each(|effort| println!("{effort}"));
}

/// Prints the rows of a log; what its look backs took.
fn row(folder: &Path) -> String {
    let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let log = LOGS.map(|file| folder.join(file)).into_iter().find(|log| log.is_file()).expect("a log in the folder");
    let rig = folder.join("rig.toml");
    let robot = robot(&rig, &log);
    let out = tempfile::TempDir::new().expect("a temporary folder");
    let settings = Settings::Exactly(Config::for_rig(&robot.rig));
    let replay = Replay { log, rig, out: out.path().to_owned(), truth: None, map: None, settings, trace: false };
    let recording = replay.run(|_| ()).unwrap_or_else(|error| panic!("{error}")).recording;
    let mut robot_back = RobotLooksBack::new(&recording, &robot.rig).expect("a log with rows");
    while robot_back.work(&recording, &robot.rig, recording.steps.len()) {}
    let (mut back, diary, looks) = (robot_back.moved(&recording), robot_back.diary(), robot_back.looks());
    back.figures = Figures { estimate: None, map: None, ..back.figures };
    score::score(&mut back, &[], None);
    let live = &recording.figures;
    say(&name, "live", live.estimate, live.consistency.as_ref(), live.walls);
    if let Some(desk) = &live.looking_back {
        let walls = desk.consistency.as_ref().map_or(0, |consistency| consistency.walls.len());
        say("", "workbench", desk.estimate, desk.consistency.as_ref(), walls);
    }
    say("", "robot's size", back.figures.estimate, back.figures.consistency.as_ref(), back.figures.walls);
    assert!(looks.iter().all(|(progress, _)| *progress == Progress::Done), "{looks:?}");
    let most = looks.iter().map(|(_, effort)| *effort).max_by_key(|effort| effort.cost).expect("it looked back");
    let longest = looks.iter().map(|(_, effort)| effort.costliest).max().unwrap_or(0);
    format!(
        "| {name} | {} | {} | {} | {} | {:.0} million | {longest} |",
        diary.keyframes().len() + diary.losses().thinned as usize,
        diary.losses().thinned,
        looks.len(),
        most.steps,
        most.cost as f64 / 1e6,
    )
}

/// The robot of a rig file, with its beams as the log has them.
fn robot(rig: &PathBuf, log: &Path) -> Robot {
    let text = std::fs::read_to_string(rig).expect("a rig file");
    let mut robot = Robot::parse(rig, &text).unwrap_or_else(|error| panic!("{error}"));
    log::open(log, &mut robot).unwrap_or_else(|error| panic!("{error}"));
    robot
}

fn say(log: &str, which: &str, path: Option<PathScore>, map: Option<&Consistency>, walls: usize) {
    let rmse = path.map_or("no truth".to_owned(), |path| format!("{:.1} cm", 100.0 * path.ate_m));
    let map = map.cloned().unwrap_or_default();
    println!(
        "| {log} | {which} | {rmse} | {:.2} cm | {:.2} nats | {:.1} cm | {walls} |",
        100.0 * map.surfels.unwrap_or_default().median_m,
        map.odometry_entropy_nats - map.entropy_nats,
        100.0 * map.widest_gap_m.unwrap_or(f64::NAN),
    );
}
