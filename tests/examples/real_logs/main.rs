//! Writes the tables of `docs/real-logs.md`: `cargo run --release --package tests --example real_logs`.
//!
//! Each part of the estimator that can be switched off (`lab::part::PARTS`) is a row of each table. `-- NAME...` shows
//! the rows of these parts only, on the standard output, and leaves the page alone.

mod bars;
mod cells;
mod outcomes;
mod simulated;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use lab::part::{PARTS, Part};
use lab::recording::Figures;
use slam_core::Config;
use tests::real_logs::{CORRIDOR, FREIBURG, HALLWAYS, RealLog, Trial};

/// Real logs are chaotic: a change that should not matter can decide which wall a reading goes to. So each row is the
/// median and the worst of replays whose range noise is off by so much.
const NOISES: [f64; 9] = [1.0, 0.99, 1.01, 0.98, 1.02, 0.97, 1.03, 0.96, 1.04];

/// What stands between these two lines is written here; everything around them is kept.
const BEGIN: &str = "<!-- Written by cargo run --release --package tests --example real_logs -->\n";
const END: &str = "<!-- End of what that command writes -->\n";

/// A log with a cap on its ranges, metres.
#[derive(Clone, Copy)]
struct Capped {
    log: RealLog,
    cap_m: f64,
}

const LOGS: [Capped; 4] = [
    Capped { log: FREIBURG, cap_m: f64::INFINITY },
    Capped { log: FREIBURG, cap_m: 1.5 },
    Capped { log: HALLWAYS, cap_m: f64::INFINITY },
    Capped { log: CORRIDOR, cap_m: f64::INFINITY },
];

impl Capped {
    fn title(&self) -> String {
        let cap = if self.cap_m.is_finite() { format!(" up to {} m", self.cap_m) } else { String::new() };
        format!("{}{cap}", self.log.name)
    }

    /// The replays of one row.
    fn replay(&self, config: Config) -> Vec<Figures> {
        let replay = |noise| {
            let trial = Trial { config, cap_m: self.cap_m, noise };
            self.log.replay_as(&trial).expect("this page shows the real logs").recording.figures
        };
        NOISES.into_iter().map(replay).collect()
    }
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let part = |name: &String| {
        Part::of_name(name).unwrap_or_else(|| panic!("no part {name}; there are {}", lab::part::names()))
    };
    let parts: Vec<&Part> = if wanted.is_empty() { PARTS.iter().collect() } else { wanted.iter().map(part).collect() };
    let defaults = LOGS.map(|capped| capped.replay(Config::default()));
    let mut text = String::new();
    bars::write(&mut text, &defaults).and_then(|()| outcomes::write(&mut text)).expect("a String takes it all");
    for (capped, default) in LOGS.iter().zip(&defaults) {
        table(&mut text, capped, default, &parts).expect("a String takes it all");
    }
    simulated::write(&mut text, &parts).expect("a String takes it all");
    if !wanted.is_empty() {
        print!("{text}");
        return;
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/real-logs.md");
    let page = fs::read_to_string(&path).expect("docs/real-logs.md is there");
    let (before, rest) = page.split_once(BEGIN).expect("docs/real-logs.md has the line at which the tables begin");
    let (_, after) = rest.split_once(END).expect("docs/real-logs.md has the line at which the tables end");
    fs::write(&path, format!("{before}{BEGIN}\n{text}{END}{after}")).expect("docs/real-logs.md can be written");
}

fn table(text: &mut String, capped: &Capped, default: &[Figures], parts: &[&Part]) -> std::fmt::Result {
    writeln!(text, "### {}\n\n{}", capped.title(), cells::header())?;
    writeln!(text, "| default | {} |", cells::of(default).join(" | "))?;
    writeln!(text, "| odometry | {} |", cells::of_odometry(&default[0]).join(" | "))?;
    let mut idle = Vec::new();
    for part in parts {
        let cells = cells::of(&capped.replay(part.off(Config::default())));
        if cells == cells::of(default) {
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
