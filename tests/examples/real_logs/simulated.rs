//! What each part costs, or is worth, in simulated homes.

use std::fmt::Write as _;

use lab::input::log::Row;
use lab::input::part::Part;
use lab::recording::Figures;
use slam_core::Config;
use tests::simulated::{estimated, rows};

use super::cells::{centimetres, spread};

const PLANS: [&str; 2] = ["flat", "clutter"];
const MINUTES: f64 = 5.0;
const SEEDS: std::ops::RangeInclusive<u64> = 1..=9;

/// One table: each plan's drives, recorded once and given to each estimator.
pub fn write(text: &mut String, parts: &[&Part]) -> std::fmt::Result {
    writeln!(
        text,
        "## Simulated homes\n\n\
         {MINUTES} minutes of each of {} seeds; every estimator gets the same drives.\n\n\
         | estimator | {} |\n|---|{}",
        SEEDS.count(),
        PLANS.map(|plan| format!("{plan}: aligned RMSE | NEES | NIS")).join(" | "),
        "---|".repeat(3 * PLANS.len())
    )?;
    let drives: Vec<Vec<Vec<Row>>> =
        PLANS.iter().map(|plan| SEEDS.map(|seed| rows(plan, MINUTES, seed)).collect()).collect();
    let variants = parts.iter().map(|part| (format!("without {}", part.name), part.off(Config::real_rooms())));
    let whole = [("as on the robot", Config::default()), ("default", Config::real_rooms())];
    for (name, config) in whole.map(|(name, config)| (name.to_owned(), config)).into_iter().chain(variants) {
        let cells: Vec<String> = drives.iter().map(|drives| cells(drives, config)).collect();
        writeln!(text, "| {name} | {} |", cells.join(" | "))?;
    }
    writeln!(text)
}

fn cells(drives: &[Vec<Row>], config: Config) -> String {
    let runs: Vec<Figures> = drives.iter().map(|rows| estimated(rows, config)).collect();
    let of = |value: &dyn Fn(&Figures) -> Option<f64>| runs.iter().filter_map(value).collect::<Vec<f64>>();
    let plain = |value: f64| format!("{value:.1}");
    [
        centimetres(of(&|figures| Some(figures.estimate?.ate_m))),
        spread(of(&|figures| figures.estimate?.nees), false, plain, ""),
        spread(of(&|figures| figures.mean_nis), false, |nis| format!("{nis:.2}"), ""),
    ]
    .join(" | ")
}
