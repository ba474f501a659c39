//! Tables of an experiment: each variant's figures over the seeds of one plan and case.

use std::fmt::Write as _;

use crate::bar::Verdict;
use crate::file::Experiment;
use crate::row::{Metric, RunRow, quoted};
use lab::evaluate::statistics::{chi_square_mean_band, max, mean, median, quantile, rms};

/// One line of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The plan.
    pub plan: String,
    /// The case.
    pub case: String,
    /// The variant.
    pub variant: String,
    /// Number of runs.
    pub runs: usize,
    rows: Vec<RunRow>,
}

impl Line {
    /// The figures of one metric, one a run.
    pub fn figures(&self, metric: Metric) -> Vec<f64> {
        self.rows.iter().filter_map(|row| row.get(metric)).collect()
    }
}

/// The lines of an experiment in the order of its file.
pub fn lines(experiment: &Experiment, rows: &[RunRow]) -> Vec<Line> {
    let mut lines = Vec::new();
    for case in &experiment.cases {
        for plan in &case.plans {
            for variant in &experiment.variants {
                let own = |row: &&RunRow| {
                    row.key.plan == *plan && row.key.case == case.name && row.key.variant == variant.name
                };
                let mut rows: Vec<RunRow> = rows.iter().filter(own).cloned().collect();
                rows.sort_by_key(|row| row.key.seed);
                if !rows.is_empty() {
                    lines.push(Line {
                        plan: plan.clone(),
                        case: case.name.clone(),
                        variant: variant.name.clone(),
                        runs: rows.len(),
                        rows,
                    });
                }
            }
        }
    }
    lines
}

/// A column of statistics: its name, its unit's factor and what it is over the runs.
struct Column {
    name: &'static str,
    head: &'static str,
    digits: usize,
    value: fn(&Line) -> Option<f64>,
}

const fn column(name: &'static str, head: &'static str, digits: usize, value: fn(&Line) -> Option<f64>) -> Column {
    Column { name, head, digits, value }
}

fn scaled(value: Option<f64>, factor: f64) -> Option<f64> {
    value.map(|value| factor * value)
}

const COLUMNS: [Column; 18] = [
    column("path_m", "path m", 0, |line| median(&line.figures(Metric::Path))),
    column("rooms_missed", "", 2, |line| mean(&line.figures(Metric::RoomsMissed))),
    column("ate_median_cm", "aligned RMSE cm", 2, |line| scaled(median(&line.figures(Metric::Ate)), 100.0)),
    column("ate_p90_cm", "90 % cm", 2, |line| scaled(quantile(&line.figures(Metric::Ate), 0.9), 100.0)),
    column("ate_max_cm", "", 2, |line| scaled(max(&line.figures(Metric::Ate)), 100.0)),
    column("start_median_cm", "start-frame RMSE cm", 2, |line| scaled(median(&line.figures(Metric::Start)), 100.0)),
    column("heading_median_deg", "heading °", 2, |line| median(&line.figures(Metric::Heading))),
    column("nees_mean", "NEES", 2, |line| mean(&line.figures(Metric::Nees))),
    column("nees_max", "largest", 1, |line| max(&line.figures(Metric::Nees))),
    column("nees_band_low", "", 2, |line| nees_band(line).map(|band| band[0])),
    column("nees_band_high", "", 2, |line| nees_band(line).map(|band| band[1])),
    column("lost_mean_percent", "lost %", 1, |line| scaled(mean(&line.figures(Metric::Lost)), 100.0)),
    column("nis_mean", "NIS", 2, |line| mean(&line.figures(Metric::Nis))),
    column("map_offset_rms_cm", "map cm", 2, |line| scaled(rms(&line.figures(Metric::Offset)), 100.0)),
    column("missed_mean", "walls missed", 2, |line| mean(&line.figures(Metric::Missed))),
    column("invented_mean", "invented", 2, |line| mean(&line.figures(Metric::Invented))),
    column("invented_max", "", 0, |line| max(&line.figures(Metric::Invented))),
    column("step_us", "µs a step", 1, |line| median(&line.figures(Metric::StepCost))),
];

/// The 95 % band of the mean NEES over this many runs; none where there is no NEES.
fn nees_band(line: &Line) -> Option<[f64; 2]> {
    let runs = line.figures(Metric::Nees).len();
    (runs > 0).then(|| chi_square_mean_band(3, runs))
}

/// The table with every column, as CSV.
pub fn csv(lines: &[Line]) -> String {
    let mut text = COLUMNS.iter().fold("plan,case,variant,runs".to_owned(), |head, column| head + "," + column.name);
    text.push('\n');
    for line in lines {
        let _ = write!(text, "{},{},{},{}", quoted(&line.plan), quoted(&line.case), quoted(&line.variant), line.runs);
        for column in &COLUMNS {
            let _ = match (column.value)(line) {
                Some(value) => write!(text, ",{value:.4}"),
                None => write!(text, ","),
            };
        }
        text.push('\n');
    }
    text
}

/// The table for reading: head and cells, of the columns that any line has a figure in.
pub fn cells(lines: &[Line]) -> (Vec<&'static str>, Vec<Vec<String>>) {
    let has_figures = |column: &&Column| lines.iter().any(|line| (column.value)(line).is_some());
    let shown: Vec<&Column> = COLUMNS.iter().filter(|column| !column.head.is_empty()).filter(has_figures).collect();
    let one_case = lines.iter().all(|line| line.case == lines[0].case);
    let mut head = if one_case { vec!["plan"] } else { vec!["plan", "case"] };
    head.extend(["variant", "runs"]);
    head.extend(shown.iter().map(|column| column.head));
    let cells = lines.iter().map(|line| {
        let mut cells = vec![line.plan.clone()];
        if !one_case {
            cells.push(line.case.clone());
        }
        cells.extend([line.variant.clone(), line.runs.to_string()]);
        cells.extend(shown.iter().map(|column| {
            (column.value)(line).map_or_else(|| "–".to_owned(), |value| format!("{value:.*}", column.digits))
        }));
        cells
    });
    (head, cells.collect())
}

/// The table for reading, as Markdown.
pub fn markdown(lines: &[Line]) -> String {
    let (head, cells) = cells(lines);
    let mut text = format!("| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
    for row in cells {
        let _ = writeln!(text, "| {} |", row.join(" | "));
    }
    text
}

/// The verdicts on what must hold, as Markdown; empty where nothing must.
pub fn verdicts_markdown(verdicts: &[Verdict]) -> String {
    if verdicts.is_empty() {
        return String::new();
    }
    let mut text = "| plan | must hold | found | holds |\n|---|---|---|---|\n".to_owned();
    for verdict in verdicts {
        let found = verdict.found.map_or_else(|| "–".to_owned(), |found| format!("{found:.4}"));
        let holds = if verdict.holds { "yes" } else { "**no**" };
        let _ = writeln!(text, "| {} | {} | {found} | {holds} |", verdict.plan, verdict.bar);
    }
    text
}
