//! Writes `docs/results/relatives.md` and its figures: `cargo run --release --package tests --example relatives`.
//!
//! What was done before is in `out/relatives` and is not done again: it may be stopped and goes on. `--seeds N` and
//! `--replays N` do a part (50 and 9), `--jobs N` sets the threads, `--page` makes the page of what is there. The logs of real
//! robots are left out where they are not at hand.

mod carried;
mod corners;
mod extractors;
mod grid;
mod lines;
mod logs;
mod page;
mod rows;
mod systems;
mod verdict;
mod words;

use std::path::{Path, PathBuf};

use monte_carlo::file::Experiment;
use monte_carlo::runner::{Runner, Shard};
use monte_carlo::store;
use tests::trial::NOISES;

/// What is asked for on the command line.
pub struct Asked {
    seeds: u64,
    replays: usize,
    jobs: usize,
    only_page: bool,
    out: PathBuf,
}

impl Asked {
    fn read() -> Result<Self, String> {
        let jobs = std::thread::available_parallelism().map_or(1, usize::from);
        let out = root().join("out/relatives");
        let mut asked = Self { seeds: 50, replays: NOISES.len(), jobs, only_page: false, out };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            if argument == "--page" {
                asked.only_page = true;
                continue;
            }
            let value = arguments.next().ok_or_else(|| format!("{argument} needs a value"))?;
            let number = || value.parse::<usize>().ok().filter(|n| *n > 0).ok_or(format!("{argument} needs a number"));
            match argument.as_str() {
                "--seeds" => asked.seeds = number()? as u64,
                "--replays" => asked.replays = number()?.min(NOISES.len()),
                "--jobs" => asked.jobs = number()?,
                "--out" => asked.out = PathBuf::from(value),
                _ => return Err(format!("{argument} is not known; --seeds, --replays, --jobs, --out and --page are")),
            }
        }
        Ok(asked)
    }
}

/// The repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// An experiment of the page: its file and its folder.
const EXPERIMENTS: [(&str, &str); 2] = [("relatives.toml", "main"), ("relatives-rays.toml", "rays")];

fn run() -> Result<(), String> {
    let asked = Asked::read()?;
    std::fs::create_dir_all(&asked.out).map_err(|error| format!("{}: {error}", asked.out.display()))?;
    if !asked.only_page {
        logs::run(&asked.out.join(logs::FILE), asked.replays)?;
        components(&asked)?;
    }
    let mut done = Vec::new();
    for (file, folder) in EXPERIMENTS {
        let said = |error: input_file::FileError| error.to_string();
        let mut experiment = read(file)?;
        experiment.seeds = experiment.seeds.min(asked.seeds);
        let out = asked.out.join(folder);
        if !asked.only_page {
            let runner = Runner { out: out.clone(), shard: Shard::WHOLE, jobs: asked.jobs };
            runner.run(&experiment, &|done, of| eprintln!("{file}: {done} of {of} drives")).map_err(said)?;
        }
        done.push((store::read(&out.join(store::RUNS)).map_err(said)?, experiment));
    }
    let logs = logs::read(&asked.out.join(logs::FILE));
    let of = |file: &str| rows::read(&asked.out.join(file));
    let sections = [
        carried::section(&of(carried::FILE)),
        corners::section(&of(corners::FILE)),
        extractors::section(&of(extractors::FILE)),
    ];
    let carried = carried::losses(&of(carried::FILE));
    page::write(&done, &logs, (&sections.concat(), &carried)).map_err(|error| format!("docs/results: {error}"))
}

fn read(file: &str) -> Result<Experiment, String> {
    Experiment::read(&root().join("experiments").join(file)).map_err(|error| error.to_string())
}

/// What is measured beside the drives: extractors, edges, robots that are put down somewhere.
fn components(asked: &Asked) -> Result<(), String> {
    let experiment = read(EXPERIMENTS[0].0)?;
    extractors::run(&asked.out.join(extractors::FILE), &experiment, asked.seeds)?;
    corners::run(&asked.out.join(corners::FILE), &experiment, asked.seeds)?;
    carried::run(&asked.out.join(carried::FILE), asked.seeds)
}

fn main() {
    if let Err(error) = run() {
        eprintln!("error: {error}");
        std::process::exit(1);
    }
}
