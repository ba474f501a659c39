//! Writes `docs/results/summary.md`: `cargo run --release --package tests --example results`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

use hal_sim::{SimOptions, default_rig};
use lab::evaluate::statistics::median;
use lab::recording::{Figures, LookingBack, PathScore};
use slam_core::{Config, HostSlam, RobotSlam};
use tests::frames::recorded;
use tests::real_logs::{CORRIDOR, FREIBURG, HALLWAYS};
use tests::simulated::drive;

const SEEDS: std::ops::RangeInclusive<u64> = 1..=5;
const MINUTES: f64 = 10.0;

/// Walls at which the bar for one step of the estimator is set.
const BUSY_WALLS: usize = 30;

/// Times are the shortest of so many passes.
const PASSES: usize = 5;

const HEAD: &str = "# Results\n\n\
    Written by `cargo run --release --package tests --example results`. [formats.md](../formats.md) says what each figure means.\n\n";

fn main() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/summary.md");
    let mut page = HEAD.to_owned();
    simulated(&mut page).and_then(|()| real(&mut page)).and_then(|()| speed(&mut page)).expect("a String takes it all");
    fs::write(&path, page).expect("docs/results/summary.md can be written");
}

fn simulated(text: &mut String) -> std::fmt::Result {
    writeln!(
        text,
        "## Simulated homes\n\n\
         The built-in robot (eight Sharp sensors, two encoders; 1 % gain and 0.5 % wheel errors, drawn anew by each\n\
         seed) explores for {MINUTES} minutes; medians of {} seeds, walls missed and invented in all of them. One such\n\
         drive, with its page: `cargo run --release -- run --plan flat --seed 2 --hand-overs false`.\n\n\
         | plan | path | aligned RMSE | dead reckoning's | start-frame RMSE | heading RMSE | NEES | NIS | walls | \
         wall offsets | missed | invented |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|",
        SEEDS.count()
    )?;
    for (plan, _) in hal_sim::plan_file::BUILT_IN {
        let runs: Vec<Figures> = SEEDS.map(|seed| drive(plan, MINUTES, seed).figures).collect();
        let middle = |value: &dyn Fn(&Figures) -> Option<f64>| {
            median(&runs.iter().filter_map(value).collect::<Vec<_>>()).expect("each run has it")
        };
        let sum = |value: &dyn Fn(&Figures) -> Option<usize>| runs.iter().filter_map(value).sum::<usize>();
        writeln!(
            text,
            "| {plan} | {:.0} m | {:.1} cm | {:.0} cm | {:.1} cm | {:.2}° | {:.1} | {:.2} | {:.0} | {:.1} cm | {} | {} |",
            middle(&|f| Some(f.path_m)),
            100.0 * middle(&|f| Some(f.estimate?.ate_m)),
            100.0 * middle(&|f| Some(f.odometry?.ate_m)),
            100.0 * middle(&|f| f.estimate?.start_m),
            middle(&|f| Some(f.estimate?.heading_deg)),
            middle(&|f| f.estimate?.nees),
            middle(&|f| f.mean_nis),
            middle(&|f| Some(f.walls as f64)),
            100.0 * middle(&|f| f.map?.offset_m),
            sum(&|f| Some(f.map?.missed)),
            sum(&|f| Some(f.map?.invented)),
        )?;
    }
    writeln!(text)
}

fn real(text: &mut String) -> std::fmt::Result {
    writeln!(
        text,
        "## Logs of real robots\n\n\
         The logs are not part of this project. The same estimator with its defaults; a rig file is all that differs:\n\
         `cargo run --release -- replay LOG --rig RIG --out DIR`. Entropy is the mean map entropy of the readings' end\n\
         points (radius 0.4 m), less is sharper; a gap is the distance between the means of one wall's points on two\n\
         visits more than 30 s apart.\n\n\
         | log | path | aligned RMSE | odometry's | heading RMSE | NIS | walls | readings used | unexplained | entropy | \
         odometry's | widest gap |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|"
    )?;
    let logs = [FREIBURG, HALLWAYS, CORRIDOR];
    let mut looking_back = Vec::new();
    for log in logs {
        let figures = log.replay().recording.figures;
        let consistency = figures.consistency.unwrap_or_default();
        writeln!(
            text,
            "| {} | {:.0} m | {} | {} | {} | {:.2} | {} | {} | {} | {:.2} | {:.2} | {:.0} cm |",
            log.name,
            figures.path_m,
            centimetres(figures.estimate),
            centimetres(figures.odometry),
            figures.estimate.map_or("no truth".to_owned(), |score| format!("{:.1}°", score.heading_deg)),
            figures.mean_nis.unwrap_or(f64::NAN),
            figures.walls,
            figures.updates,
            figures.outliers,
            consistency.entropy_nats,
            consistency.odometry_entropy_nats,
            100.0 * consistency.widest_gap_m.unwrap_or(0.0),
        )?;
        looking_back.push((log.name, figures.looking_back.expect("a replay looks back")));
    }
    writeln!(text)?;
    hindsight(text, looking_back)?;
    for log in logs {
        writeln!(text, "- {}: {}", log.name, log.about)?;
    }
    writeln!(text)
}

fn hindsight(text: &mut String, logs: Vec<(&str, LookingBack)>) -> std::fmt::Result {
    writeln!(
        text,
        "The same paths and maps placed with the whole log at hand ([looking back](../formats.md#looking-back)); visits apart is\n\
         the median over all places that were visited again.\n\n\
         | log | aligned RMSE | entropy | visits apart | widest gap |\n\
         |---|---|---|---|---|"
    )?;
    for (name, LookingBack { estimate, consistency }) in logs {
        let consistency = consistency.unwrap_or_default();
        writeln!(
            text,
            "| {name} | {} | {:.2} | {:.1} cm | {:.0} cm |",
            centimetres(estimate),
            consistency.entropy_nats,
            100.0 * consistency.surfels.unwrap_or_default().median_m,
            100.0 * consistency.widest_gap_m.unwrap_or(0.0),
        )?;
    }
    writeln!(text)
}

fn centimetres(score: Option<PathScore>) -> String {
    score.map_or("no truth".to_owned(), |score| format!("{:.0} cm", 100.0 * score.ate_m))
}

fn speed(text: &mut String) -> std::fmt::Result {
    let whole = |_| {
        let begin = Instant::now();
        drive("flat", MINUTES, 1);
        begin.elapsed().as_secs_f64()
    };
    let whole_s = (0..PASSES).map(whole).fold(f64::INFINITY, f64::min);
    let (mean_us, busy_us) = step_us();
    writeln!(
        text,
        "## Speed and size\n\n\
         On the machine that wrote this page, one core, the shortest of {PASSES} passes; `cargo bench --package lab` measures\n\
         the same with its spread.\n\n\
         | what | figure | bar |\n\
         |---|---|---|\n\
         | {MINUTES} minutes of the flat at 25 Hz, simulation and estimation | {whole_s:.2} s | 2 s |\n\
         | one step of the estimator, mean over that drive | {mean_us:.1} µs | |\n\
         | one step with {BUSY_WALLS} walls or more, mean | {busy_us:.1} µs | 10 µs |\n\
         | `size_of` the robot's estimator: 8 sensors, 64 grid walls, 128 buffered points | {} bytes | 32768 bytes |\n\
         | `size_of` the workbench's: 16 sensors, 64 walls of any kind | {} bytes | |",
        size_of::<RobotSlam>(),
        size_of::<HostSlam>()
    )
}

/// Mean time of one step over a drive through the flat, and over its steps with [`BUSY_WALLS`] walls or more.
///
/// Each step counts with its shortest time of several passes: what is longer is other work of this machine.
fn step_us() -> (f64, f64) {
    let frames = recorded("flat", MINUTES, 1, SimOptions::default());
    let mut steps: Vec<(f64, usize)> = vec![(f64::INFINITY, 0); frames.len()];
    for _ in 0..PASSES {
        let mut slam = HostSlam::with_config(default_rig(), Config::default()).expect("a good rig");
        for (frame, (shortest_s, walls)) in frames.iter().zip(&mut steps) {
            let begin = Instant::now();
            slam.step(&frame.sample);
            *shortest_s = shortest_s.min(begin.elapsed().as_secs_f64());
            *walls = slam.walls().count();
        }
    }
    let mean_us = |least: usize| {
        let times_s: Vec<f64> = steps.iter().filter(|(_, walls)| *walls >= least).map(|(step_s, _)| *step_s).collect();
        1e6 * times_s.iter().sum::<f64>() / times_s.len() as f64
    };
    (mean_us(0), mean_us(BUSY_WALLS))
}
