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

/// With analogue sensors nothing is handed over, and in a home that nothing contradicts no map is searched: filter and robot are one.
#[test]
fn the_whole_robot_is_its_filter_where_nothing_goes_wrong() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("quiet.toml");
    let text = "title = \"Quiet\"\nplans = [\"room\"]\nseeds = 2\nvariants = [\"grid, calibrated\", \"whole robot\"]\n\
                [setting]\nminutes = 3\n[[case]]\nname = \"nothing\"\n";
    std::fs::write(&file, text).expect("a file that can be written");
    let experiment = Experiment::read(&file).expect("a good file");
    let out = folder.path().join("out");
    Runner { out: out.clone(), shard: Shard::WHOLE, jobs: 2 }.run(&experiment, &|_, _| {}).expect("it runs");
    let lines = page::write(&out, &experiment).expect("it is written").lines;
    let [filter, robot] = &lines[..] else { panic!("{} lines", lines.len()) };
    for metric in [Metric::Ate, Metric::Nees, Metric::Offset] {
        assert_eq!(filter.figures(metric), robot.figures(metric), "{metric:?}");
    }
    assert_eq!((filter.figures(Metric::Lost), robot.figures(Metric::Lost)), (vec![], vec![0.0; 2]));
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
