//! Writes `docs/results/real-logs.md`: `cargo run --release --package tests --example real_logs`.
//!
//! Each part of the estimator that can be switched off (`lab::input::part::PARTS`) is a row of each table. `-- NAME...` shows
//! the rows of these parts only, on the standard output, and leaves the page alone; `-- default` shows no part's, and `-- wheels`
//! nothing but logs with real odometry.

mod bars;
mod cells;
mod directions;
mod outcomes;
mod simulated;
mod wheels;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use lab::input::part::{PARTS, Part};
use lab::recording::{Figures, Recording};
use slam_core::Config;
use tests::real_logs::{CORRIDOR, FREIBURG, HALLWAYS, RealLog};
use tests::trial::{LoadedLog, NOISES, Trial};

/// How the page begins.
const HEAD: &str = r#"# Real logs

Written by `cargo run --release --package tests --example real_logs`.

Every row is nine replays that differ only in the range noise that the rig file states, by up to 4 %: a change that should
not matter. The first figure is their median, the one in brackets the worst. Where the two are far apart, single replays
tell nothing. "Without" a part is the estimator with that part switched off.
[Your own log](../guide/own-log.md#how-a-map-is-scored-without-a-truth) says what the scores mean,
[the notes](../notes/real-logs.md) what was found.

"#;

/// A log, and what is done with it.
struct Case {
    title: &'static str,
    log: RealLog,
    trial: fn(Trial) -> Trial,
}

/// The logs that parts are judged by.
const LOGS: [Case; 4] = [
    Case { title: "fr079-first", log: FREIBURG, trial: |trial| trial },
    Case { title: "fr079-first up to 1.5 m", log: FREIBURG, trial: |trial| Trial { cap_m: 1.5, ..trial } },
    Case { title: "olsson-demo", log: HALLWAYS, trial: |trial| trial },
    Case { title: "wean-1", log: CORRIDOR, trial: |trial| trial },
];

/// The same logs begun later, with fewer sensors and fewer rows: what no part was made for.
const VARIATIONS: [Case; 10] = [
    Case { title: "fr079-first from 120 s", log: FREIBURG, trial: |trial| Trial { from_s: 120.0, ..trial } },
    Case { title: "fr079-first, four beams", log: FREIBURG, trial: |trial| Trial { every: 2, ..trial } },
    Case { title: "fr079-first up to 2 m", log: FREIBURG, trial: |trial| Trial { cap_m: 2.0, ..trial } },
    Case { title: "fr079-first, every second row", log: FREIBURG, trial: |trial| Trial { rows: 2, ..trial } },
    Case { title: "olsson-demo from 60 s", log: HALLWAYS, trial: |trial| Trial { from_s: 60.0, ..trial } },
    Case { title: "olsson-demo up to 1.5 m", log: HALLWAYS, trial: |trial| Trial { cap_m: 1.5, ..trial } },
    Case { title: "olsson-demo, every third row", log: HALLWAYS, trial: |trial| Trial { rows: 3, ..trial } },
    Case { title: "wean-1, four beams", log: CORRIDOR, trial: |trial| Trial { every: 2, ..trial } },
    Case { title: "wean-1 up to 2 m", log: CORRIDOR, trial: |trial| Trial { cap_m: 2.0, ..trial } },
    Case { title: "wean-1, every fourth row", log: CORRIDOR, trial: |trial| Trial { rows: 4, ..trial } },
];

impl Case {
    /// The replays of one row.
    fn replay(&self, config: Config) -> Vec<Recording> {
        self.replay_with(config, Trial::default())
    }

    /// The replays of one row whose trials begin as this one.
    fn replay_with(&self, config: Config, trial: Trial) -> Vec<Recording> {
        let log = LoadedLog::read(self.log);
        let replay = |noise: &f32| log.replay(&(self.trial)(Trial { config, noise: *noise, ..trial }));
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let some = |noises: &[f32]| noises.iter().map(replay).collect::<Vec<Recording>>();
        std::thread::scope(|scope| {
            let begun: Vec<_> =
                NOISES.chunks(NOISES.len().div_ceil(threads)).map(|noises| scope.spawn(|| some(noises))).collect();
            begun.into_iter().flat_map(|thread| thread.join().expect("a replay ends")).collect()
        })
    }

    fn figures(&self, config: Config) -> Vec<Figures> {
        self.replay(config).into_iter().map(|recording| recording.figures).collect()
    }
}

/// A part's name on the command line that stands for the estimator with all of its parts.
const DEFAULT: &str = "default";

/// And for the logs with real odometry alone.
const WHEELS: &str = "wheels";

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    if wanted == [WHEELS] {
        let mut text = String::new();
        wheels::write(&mut text).expect("a String takes it all");
        print!("{text}");
        return;
    }
    let part = |name: &String| {
        Part::of_name(name).unwrap_or_else(|| {
            eprintln!("error: no part {name}; it must be {DEFAULT} or one of {}", lab::input::part::names());
            std::process::exit(2)
        })
    };
    let parts: Vec<&Part> = if wanted.is_empty() {
        PARTS.iter().collect()
    } else {
        wanted.iter().filter(|name| *name != DEFAULT).map(part).collect()
    };
    let defaults = LOGS.map(|case| (case.replay(Config::real_rooms()), case));
    let mut text = String::new();
    write_all(&mut text, &defaults, &parts).expect("a String takes it all");
    if !wanted.is_empty() {
        print!("{text}");
        return;
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/real-logs.md");
    fs::write(&path, format!("{HEAD}{}\n", text.trim_end())).expect("docs/results/real-logs.md can be written");
}

fn write_all(text: &mut String, defaults: &[(Vec<Recording>, Case)], parts: &[&Part]) -> std::fmt::Result {
    bars::write(text, defaults)?;
    variations(text)?;
    wheels::write(text)?;
    outcomes::write(text, defaults)?;
    directions::write(text, defaults)?;
    for (recordings, case) in defaults {
        table(text, case, recordings, parts)?;
    }
    if parts.is_empty() { Ok(()) } else { simulated::write(text, parts) }
}

fn figures_of(recordings: &[Recording]) -> Vec<Figures> {
    recordings.iter().map(|recording| recording.figures.clone()).collect()
}

/// A table for each log: the default, dead reckoning, and the default without each part.
fn table(text: &mut String, case: &Case, default: &[Recording], parts: &[&Part]) -> std::fmt::Result {
    let default = figures_of(default);
    writeln!(text, "## {}\n\n{}", case.title, cells::header("estimator"))?;
    writeln!(text, "| default | {} |", cells::of(&default).join(" | "))?;
    writeln!(text, "| odometry | {} |", cells::of_odometry(&default[0]).join(" | "))?;
    let mut idle = Vec::new();
    for part in parts {
        let cells = cells::of(&case.figures(part.off(Config::real_rooms())));
        if cells == cells::of(&default) {
            idle.push(part.name);
        } else {
            writeln!(text, "| without {} | {} |", part.name, cells.join(" | "))?;
        }
    }
    if !idle.is_empty() {
        write!(text, "\nNo difference: without {}.\n", idle.join(", "))?;
    }
    writeln!(text)
}

fn variations(text: &mut String) -> std::fmt::Result {
    writeln!(
        text,
        "## The same logs otherwise\n\nBegun later, with every second sensor, with shorter ranges, with rows left out as of a faster robot.\n\n{}",
        cells::header("log")
    )?;
    for case in VARIATIONS {
        let runs = case.figures(Config::real_rooms());
        writeln!(text, "| {} | {} |", case.title, cells::of(&runs).join(" | "))?;
        if runs[0].odometry.is_some() {
            writeln!(text, "| its odometry | {} |", cells::of_odometry(&runs[0]).join(" | "))?;
        }
    }
    writeln!(text)
}
