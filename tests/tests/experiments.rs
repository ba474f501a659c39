//! The committed experiment files: all can be read, and what the smaller sweep must hold holds.

use std::path::{Path, PathBuf};

use monte_carlo::file::Experiment;
use monte_carlo::row::Metric;
use monte_carlo::runner::{Runner, Shard};
use monte_carlo::{page, table};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments")
}

#[test]
fn every_file_is_good() {
    let mut read = 0;
    for entry in std::fs::read_dir(folder()).expect("the folder") {
        let file = entry.expect("an entry").path();
        if file.extension().is_some_and(|extension| extension == "toml") {
            Experiment::read(&file).unwrap_or_else(|error| panic!("{error}"));
            read += 1;
        }
    }
    assert!(read >= 4, "{read}");
}

#[test]
fn the_smaller_sweep_holds() {
    holds("ci.toml", 40);
}

#[test]
fn each_relative_beats_the_motion_alone() {
    holds("relatives-small.toml", 3);
}

/// In homes whose partitions stand askew a robot that looks back is nearer to where it is than its filter alone, and knows how near; where it has
/// no reason to doubt its map it is never lost.
#[test]
fn a_robot_that_looks_back_is_better_off_among_walls_askew() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("askew.toml");
    let text = "title = \"Askew\"\nplans = [\"flat\"]\nseeds = 4\nfirst_seed = 2001\n\
                variants = [\"grid, calibrated\", \"whole robot\"]\n\
                [setting]\nminutes = 6\n[[case]]\nname = \"askew\"\ndraw = { inner_deg = [-5, 5] }\n";
    std::fs::write(&file, text).expect("a file that can be written");
    let experiment = Experiment::read(&file).expect("a good file");
    let out = folder.path().join("out");
    Runner { out: out.clone(), shard: Shard::WHOLE, jobs: 2 }.run(&experiment, &|_, _| {}).expect("it runs");
    let lines = page::write(&out, &experiment).expect("it is written").lines;
    let [filter, robot] = &lines[..] else { panic!("{} lines", lines.len()) };
    let mean = |line: &table::Line, metric| {
        let figures = line.figures(metric);
        figures.iter().sum::<f64>() / figures.len() as f64
    };
    let [alone_m, looking_back_m] = [filter, robot].map(|line| mean(line, Metric::Ate));
    println!("{alone_m} {looking_back_m} {} {}", mean(filter, Metric::Nees), mean(robot, Metric::Nees));
    assert!(looking_back_m < 0.9 * alone_m, "{looking_back_m} m, of the filter alone {alone_m} m");
    assert!(mean(robot, Metric::Nees) < 12.0, "NEES {}", mean(robot, Metric::Nees));
    assert_eq!(robot.figures(Metric::Lost), vec![0.0; 4]);
}

/// Runs an experiment, and all of its bars, at least so many, hold.
fn holds(file: &str, bars: usize) {
    let experiment = Experiment::read(&folder().join(file)).expect("a good file");
    let out = tempfile::tempdir().expect("a temporary folder");
    let jobs = std::thread::available_parallelism().map_or(1, usize::from);
    let runner = Runner { out: out.path().to_owned(), shard: Shard::WHOLE, jobs };
    runner.run(&experiment, &|_, _| {}).expect("it runs");
    let written = page::write(out.path(), &experiment).expect("it is written");
    println!("{}\n{}", table::markdown(&written.lines), table::verdicts_markdown(&written.verdicts));
    assert!(written.verdicts.len() >= bars, "{}", written.verdicts.len());
    let broken: Vec<_> = written.verdicts.iter().filter(|verdict| !verdict.holds).collect();
    assert!(broken.is_empty(), "{broken:#?}");
}
