//! Writes `docs/results.md`: `cargo run --release --package tests --example results > docs/results.md`.

use std::time::Instant;

use lab::recording::{Figures, Recording};
use lab::replay::Replay;
use slam_core::{Config, HostSlam, RobotSlam};
use tests::real_logs::folder;
use tests::simulated::drive;

const SEEDS: std::ops::RangeInclusive<u64> = 1..=5;
const MINUTES: f64 = 10.0;

const REAL_LOGS: [(&str, &str, &str); 3] = [
    ("fr079-first", "log.csv", "seven beams of a real laser in offices, up to 3 m; odometry with synthetic errors"),
    ("olsson-demo", "log.csv", "four time-of-flight beams of a drone in hallways, up to 2 m"),
    ("wean-1", "wean.log.gz", "seven beams of a real laser in a corridor, up to 5 m; real wheel odometry"),
];

fn main() {
    println!("# Results\n");
    println!(
        "Written by `cargo run --release --package tests --example results > docs/results.md`; docs/formats.md says what"
    );
    println!("each figure means.\n");
    simulated();
    real();
    speed();
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn simulated() {
    println!("## Simulated homes\n");
    println!(
        "The built-in robot (eight Sharp sensors, two encoders; 1 % gain and 0.5 % wheel errors, drawn anew by each"
    );
    println!(
        "seed) explores for {MINUTES} minutes; medians of {} seeds, walls missed and invented in all of them.\n",
        SEEDS.count()
    );
    println!(
        "| plan | path | aligned RMSE | dead reckoning's | start-frame RMSE | heading RMSE | NEES | NIS | walls | wall offsets | missed | invented |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (plan, _) in hal_sim::plan_file::BUILT_IN {
        let runs: Vec<Figures> = SEEDS.map(|seed| drive(plan, MINUTES, seed).figures).collect();
        let middle = |value: &dyn Fn(&Figures) -> Option<f64>| median(runs.iter().filter_map(value).collect());
        let sum = |value: &dyn Fn(&Figures) -> Option<usize>| runs.iter().filter_map(value).sum::<usize>();
        println!(
            "| {plan} | {:.0} m | {:.1} cm | {:.0} cm | {:.1} cm | {:.2}° | {:.1} | {:.2} | {:.0} | {:.1} cm | {} | {} |",
            middle(&|f| Some(f.path_m)),
            100.0 * middle(&|f| Some(f.estimate?.ate_m)),
            100.0 * middle(&|f| Some(f.odometry?.ate_m)),
            100.0 * middle(&|f| Some(f.estimate?.start_m)),
            middle(&|f| Some(f.estimate?.heading_deg)),
            middle(&|f| f.estimate?.nees),
            middle(&|f| f.mean_nis),
            middle(&|f| Some(f.walls as f64)),
            100.0 * middle(&|f| Some(f.map?.offset_m)),
            sum(&|f| Some(f.map?.missed)),
            sum(&|f| Some(f.map?.invented)),
        );
    }
    println!();
}

fn replay(name: &str, log: &str) -> Option<Recording> {
    let folder = folder(name)?;
    let out = tempfile::TempDir::new().expect("a temporary folder");
    let replay = Replay {
        log: folder.join(log),
        rig: folder.join("rig.toml"),
        out: out.path().to_owned(),
        truth: None,
        config: Config::default(),
        trace: false,
    };
    Some(replay.run(|_| ()).unwrap_or_else(|error| panic!("{error}")).recording)
}

fn real() {
    println!("## Logs of real robots\n");
    println!(
        "The logs are not part of this project. The same estimator with its defaults; a rig file is all that differs."
    );
    println!(
        "Entropy is the mean map entropy of the readings' end points (radius 0.4 m); a gap is the distance between the"
    );
    println!("means of one wall's points on two visits more than 30 s apart.\n");
    println!(
        "| log | path | aligned RMSE | odometry's | heading RMSE | NIS | walls | readings used | unexplained | entropy | odometry's | widest gap |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, log, _) in REAL_LOGS {
        let Some(figures) = replay(name, log).map(|recording| recording.figures) else { continue };
        let centimetres =
            |metres: Option<f64>| metres.map_or("no truth".to_owned(), |m| format!("{:.0} cm", 100.0 * m));
        let consistency = figures.consistency.unwrap_or_default();
        println!(
            "| {name} | {:.0} m | {} | {} | {} | {:.2} | {} | {} | {} | {:.2} | {:.2} | {:.0} cm |",
            figures.path_m,
            centimetres(figures.estimate.map(|score| score.ate_m)),
            centimetres(figures.odometry.map(|score| score.ate_m)),
            figures.estimate.map_or("no truth".to_owned(), |score| format!("{:.1}°", score.heading_deg)),
            figures.mean_nis.unwrap_or(f64::NAN),
            figures.walls,
            figures.updates,
            figures.outliers,
            consistency.entropy_nats,
            consistency.odometry_entropy_nats,
            100.0 * consistency.widest_gap_m,
        );
    }
    println!();
    for (name, _, what) in REAL_LOGS {
        println!("- {name}: {what}");
    }
    println!();
}

fn speed() {
    println!("## Speed and size\n");
    let begin = Instant::now();
    let run = drive("flat", MINUTES, 1);
    let whole_s = begin.elapsed().as_secs_f64();
    let steps = run.steps.len() as f64;
    println!("On the machine that wrote this page, one core:\n");
    println!("- {MINUTES} minutes of the flat at 25 Hz, simulation and estimation: {whole_s:.2} s");
    println!(
        "- of that the estimator: {:.1} microseconds a step, mean over the run (up to {} walls)",
        1e6 * run.figures.estimator_s / steps,
        run.steps.iter().map(|step| step.walls).max().unwrap_or(0)
    );
    println!(
        "- `size_of` the robot's estimator: {} bytes; the workbench's: {} bytes\n",
        size_of::<RobotSlam>(),
        size_of::<HostSlam>()
    );
    println!("`cargo bench --package lab` measures a step at 10, 20, 30 and 40 walls.\n");
    println!("On the robot's own processor: [on-target.md](on-target.md).");
}
