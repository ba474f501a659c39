//! The cells of a row: figures of several replays, median and worst.

use lab::evaluate::statistics::{median, quantile};
use lab::recording::{Consistency, Figures};

const COLUMNS: [&str; 15] = [
    "aligned RMSE",
    "lost",
    "heading RMSE",
    "NIS",
    "NIS before the gate",
    "outside the gate",
    "sharper than odometry",
    "visits apart",
    "widest gap",
    "mean gap",
    "walls",
    "looking back: aligned RMSE",
    "sharper than odometry",
    "visits apart",
    "widest gap",
];

/// The table's head; `first` is that of its first column.
pub fn header(first: &str) -> String {
    format!("| {first} | {} |\n|---|{}", COLUMNS.join(" | "), "---|".repeat(COLUMNS.len()))
}

/// The cells of a row after its name.
pub fn of(runs: &[Figures]) -> [String; 15] {
    let of = |value: &dyn Fn(&Figures) -> Option<f64>| runs.iter().filter_map(value).collect::<Vec<f64>>();
    let plain = |value: f64| format!("{value:.2}");
    [
        centimetres(of(&|figures| Some(figures.estimate?.ate_m))),
        lost(runs),
        spread(of(&|figures| Some(figures.estimate?.heading_deg)), false, |degrees| format!("{degrees:.1}"), "°"),
        spread(of(&|figures| figures.mean_nis), false, plain, ""),
        spread(of(&|figures| figures.nis_associated), false, plain, ""),
        spread(of(&|figures| figures.outside_gate), false, |share| format!("{:.0}", 100.0 * share), " %"),
        spread(of(&sharper_nats), true, plain, " nats"),
        centimetres(of(&|figures| Some(consistency(figures)?.surfels?.median_m))),
        centimetres(of(&|figures| consistency(figures)?.widest_gap_m)),
        centimetres(of(&|figures| consistency(figures)?.mean_gap_m)),
        spread(of(&|figures| Some(figures.walls as f64)), false, |walls| format!("{walls:.0}"), ""),
        centimetres(of(&|figures| Some(figures.looking_back.as_ref()?.estimate?.ate_m))),
        spread(of(&sharper_back_nats), true, plain, " nats"),
        centimetres(of(&|figures| Some(back(figures)?.surfels?.median_m))),
        centimetres(of(&|figures| back(figures)?.widest_gap_m)),
    ]
}

/// The cells of dead reckoning's row.
pub fn of_odometry(figures: &Figures) -> [String; 15] {
    let mut cells: [String; 15] = Default::default();
    if let Some(score) = figures.odometry {
        cells[0] = format!("{:.0} cm", 100.0 * score.ate_m);
        cells[2] = format!("{:.1}°", score.heading_deg);
    }
    if let Some(surfels) = consistency(figures).and_then(|score| score.odometry_surfels) {
        cells[7] = format!("{:.0} cm", 100.0 * surfels.median_m);
    }
    cells
}

/// How much of its rows a replay claims no place, which its errors are without.
pub fn lost(runs: &[Figures]) -> String {
    let shares = runs.iter().map(|figures| figures.lost).collect();
    spread(shares, false, |share| format!("{:.0}", 100.0 * share), " %")
}

fn consistency(figures: &Figures) -> Option<&Consistency> {
    figures.consistency.as_ref()
}

/// The map against itself as it looks from the end.
pub fn back(figures: &Figures) -> Option<&Consistency> {
    figures.looking_back.as_ref()?.consistency.as_ref()
}

/// Dead reckoning's map entropy less the estimate's, nats.
pub fn sharper_nats(figures: &Figures) -> Option<f64> {
    consistency(figures).map(sharper_by)
}

/// The same of the map as it looks from the end.
pub fn sharper_back_nats(figures: &Figures) -> Option<f64> {
    back(figures).map(sharper_by)
}

fn sharper_by(score: &Consistency) -> f64 {
    score.odometry_entropy_nats - score.entropy_nats
}

/// Lengths in metres as a cell.
pub fn centimetres(values_m: Vec<f64>) -> String {
    let digits = usize::from(values_m.iter().all(|metres| *metres < 0.05));
    spread(values_m, false, |metres| format!("{:.digits$}", 100.0 * metres), " cm")
}

/// The median, and in brackets the worst: the largest, or the smallest where more is better.
pub fn spread(values: Vec<f64>, more_is_better: bool, write: impl Fn(f64) -> String, unit: &str) -> String {
    match median_and_worst(&values, more_is_better) {
        Some((median, worst)) => format!("{}{unit} ({})", write(median), write(worst)),
        None => "no truth".to_owned(),
    }
}

/// The median of the values, and the largest, or the smallest where more is better.
pub fn median_and_worst(values: &[f64], more_is_better: bool) -> Option<(f64, f64)> {
    let worst = if more_is_better { 0.0 } else { 1.0 };
    Some((median(values)?, quantile(values, worst)?))
}
