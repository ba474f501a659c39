//! Writes the tables of `docs/real-logs.md`: `cargo run --release --package tests --example real_logs`.
//!
//! Each part of the estimator that can be switched off (`lab::part::PARTS`) is a row of each table. `-- NAME...` shows
//! the rows of these parts only, on the standard output, and leaves the page alone.

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

/// The logs, each with its cap.
const LOGS: [(RealLog, f64); 4] =
    [(FREIBURG, f64::INFINITY), (FREIBURG, 1.5), (HALLWAYS, f64::INFINITY), (CORRIDOR, f64::INFINITY)];

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let parts: Vec<&Part> = match wanted.as_slice() {
        [] => PARTS.iter().collect(),
        names => {
            let part = |name: &String| {
                Part::of_name(name).unwrap_or_else(|| panic!("no part {name}; there are {}", lab::part::names()))
            };
            names.iter().map(part).collect()
        }
    };
    let mut text = String::new();
    for (log, cap_m) in LOGS {
        table(&mut text, log, cap_m, &parts).expect("a String takes it all");
    }
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

fn table(text: &mut String, log: RealLog, cap_m: f64, parts: &[&Part]) -> std::fmt::Result {
    let title =
        if cap_m.is_finite() { format!("{} with ranges up to {cap_m} m", log.name) } else { log.name.to_owned() };
    writeln!(
        text,
        "### {title}\n\n\
         | estimator | aligned RMSE | heading RMSE | NIS | NIS before the gate, median | sharper than odometry | \
         widest gap | mean gap | first to last | walls |\n\
         |---|---|---|---|---|---|---|---|---|---|"
    )?;
    let rows = parts.iter().map(|part| (format!("without {}", part.name), part.off(Config::default())));
    for (name, config) in std::iter::once(("default".to_owned(), Config::default())).chain(rows) {
        let replay = |noise: f64| {
            let trial = Trial { config, cap_m, noise };
            log.replay_as(&trial).expect("this page shows the real logs").recording.figures
        };
        let runs: Vec<Figures> = NOISES.into_iter().map(replay).collect();
        writeln!(text, "| {name} | {} |", cells(&runs).join(" | "))?;
        if name == "default" {
            odometry(text, &runs[0])?;
        }
    }
    writeln!(text)
}

/// What dead reckoning does on the same log.
fn odometry(text: &mut String, figures: &Figures) -> std::fmt::Result {
    let (rmse, heading) = figures.odometry.map_or((String::new(), String::new()), |score| {
        (format!("{:.0} cm", 100.0 * score.ate_m), format!("{:.1}°", score.heading_deg))
    });
    let closure = figures.consistency.as_ref().and_then(|score| score.odometry_closure_m);
    let closure = closure.map_or(String::new(), |closure_m| format!("{:.0} cm", 100.0 * closure_m));
    writeln!(text, "| odometry | {rmse} | {heading} | | | | | | {closure} | |")
}

fn cells(runs: &[Figures]) -> [String; 9] {
    let of = |value: &dyn Fn(&Figures) -> Option<f64>| runs.iter().filter_map(value).collect::<Vec<f64>>();
    let centimetres = |values: Vec<f64>| spread(values, false, |metres| format!("{:.0}", 100.0 * metres), " cm");
    let consistency = |value: fn(&lab::recording::Consistency) -> Option<f64>| {
        centimetres(of(&|figures| value(figures.consistency.as_ref()?)))
    };
    let plain = |value: f64| format!("{value:.2}");
    [
        centimetres(of(&|figures| Some(figures.estimate?.ate_m))),
        spread(of(&|figures| Some(figures.estimate?.heading_deg)), false, |degrees| format!("{degrees:.1}"), "°"),
        spread(of(&|figures| figures.mean_nis), false, plain, ""),
        spread(of(&|figures| figures.median_nis_before_gate), false, plain, ""),
        spread(of(&|figures| sharper_nats(figures)), true, plain, " nats"),
        consistency(|score| score.widest_gap_m),
        consistency(|score| score.mean_gap_m),
        consistency(|score| score.closure_m),
        spread(of(&|figures| Some(figures.walls as f64)), false, |walls| format!("{walls:.0}"), ""),
    ]
}

fn sharper_nats(figures: &Figures) -> Option<f64> {
    let score = figures.consistency.as_ref()?;
    Some(score.odometry_entropy_nats - score.entropy_nats)
}

/// The median, and in brackets the worst: the largest, or the smallest where more is better.
fn spread(mut values: Vec<f64>, more_is_better: bool, write: impl Fn(f64) -> String, unit: &str) -> String {
    values.sort_by(f64::total_cmp);
    if more_is_better {
        values.reverse();
    }
    match values.last() {
        Some(worst) => format!("{}{unit} ({})", write(values[values.len() / 2]), write(*worst)),
        None => "no truth".to_owned(),
    }
}
