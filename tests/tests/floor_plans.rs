//! Every built-in floor plan from start to end, beside the committed figures in `snapshots/floor_plans.csv`.

use tests::simulated::drive;
use tests::snapshot::{Column, check};

const fn figure(name: &'static str, absolute: f64, relative: f64) -> Column {
    Column { name, absolute, relative, is_error: false }
}

const fn error(name: &'static str, absolute: f64, relative: f64) -> Column {
    Column { name, absolute, relative, is_error: true }
}

/// Every change of the estimator, however small, changes where the pilot turns and so the whole drive: the tolerances
/// are what one drive differs from another, and the snapshot shows what a change does to all plans at once.
const COLUMNS: [Column; 10] = [
    figure("path_m", 0.0, 0.15),
    error("ate_m", 0.01, 0.5),
    error("start_m", 0.06, 0.5),
    error("heading_deg", 0.3, 0.5),
    error("nees", 8.0, 0.5),
    figure("mean_nis", 0.1, 0.0),
    figure("walls", 4.0, 0.0),
    error("offset_m", 0.015, 0.5),
    error("missed", 0.0, 0.0),
    error("invented", 4.0, 0.0),
];

#[test]
fn every_plan_is_mapped_as_before() {
    let rows: Vec<(String, Vec<f64>)> = hal_sim::plan_file::BUILT_IN
        .iter()
        .map(|(plan, _)| {
            let figures = drive(plan, 6.0, 1).figures;
            let score = figures.estimate.expect("there is a truth");
            let map = figures.map.expect("there is a plan");
            let numbers = vec![
                figures.path_m,
                score.ate_m,
                score.start_m,
                score.heading_deg,
                score.nees.expect("there is a covariance"),
                figures.mean_nis.expect("there are updates"),
                figures.walls as f64,
                map.offset_m,
                map.missed as f64,
                map.invented as f64,
            ];
            ((*plan).to_owned(), numbers)
        })
        .collect();
    check("floor_plans", &COLUMNS, &rows);
}
