//! Tables of an experiment: each variant's figures over the seeds of one plan and case.

use std::fmt::Write as _;

use crate::bar::Verdict;
use crate::file::Experiment;
use crate::row::{Metric, RunRow, quoted};
use lab::evaluate::statistics::{chi_square_mean_band, max, mean, median, quantile, rms, standard_error};

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

type Value = fn(&[f64]) -> Option<f64>;

/// A column of statistics: its name, its head where it is in the table for reading, and what it is of one metric over the runs.
struct Column {
    name: &'static str,
    head: &'static str,
    digits: usize,
    metric: Metric,
    value: Value,
}

impl Column {
    fn value(&self, line: &Line) -> Option<f64> {
        (self.value)(&line.figures(self.metric))
    }

    /// As a cell for reading, which says how many runs have a figure where not all do.
    fn cell(&self, line: &Line) -> String {
        let Some(value) = self.value(line) else { return "–".to_owned() };
        let (n, digits) = (line.figures(self.metric).len(), self.digits);
        if n < line.runs { format!("{value:.digits$} ({n} of {})", line.runs) } else { format!("{value:.digits$}") }
    }
}

const fn column(name: &'static str, head: &'static str, digits: usize, metric: Metric, value: Value) -> Column {
    Column { name, head, digits, metric, value }
}

fn times_100(value: Option<f64>) -> Option<f64> {
    value.map(|value| 100.0 * value)
}

const COLUMNS: [Column; 19] = [
    column("path_m", "path m", 0, Metric::Path, median),
    column("rooms_missed", "", 2, Metric::RoomsMissed, mean),
    column("ate_median_cm", "aligned RMSE cm", 2, Metric::Ate, |all| times_100(median(all))),
    column("ate_p90_cm", "90 % cm", 2, Metric::Ate, |all| times_100(quantile(all, 0.9))),
    column("ate_max_cm", "", 2, Metric::Ate, |all| times_100(max(all))),
    column("start_median_cm", "start-frame RMSE cm", 2, Metric::Start, |all| times_100(median(all))),
    column("heading_median_deg", "heading °", 2, Metric::Heading, median),
    column("nees_mean", "NEES", 2, Metric::Nees, mean),
    column("nees_standard_error", "its standard error", 2, Metric::Nees, standard_error),
    column("nees_max", "largest", 1, Metric::Nees, max),
    column("nees_band_low", "", 2, Metric::Nees, |all| nees_band(all).map(|band| band[0])),
    column("nees_band_high", "", 2, Metric::Nees, |all| nees_band(all).map(|band| band[1])),
    column("lost_mean_percent", "lost %", 1, Metric::Lost, |all| times_100(mean(all))),
    column("nis_mean", "NIS", 2, Metric::Nis, mean),
    column("map_offset_rms_cm", "map cm", 2, Metric::Offset, |all| times_100(rms(all))),
    column("missed_mean", "walls missed", 2, Metric::Missed, mean),
    column("invented_mean", "invented", 2, Metric::Invented, mean),
    column("invented_max", "", 0, Metric::Invented, max),
    column("step_us", "µs a step", 1, Metric::StepCost, median),
];

/// The 95 % band of the mean NEES over as many runs as these; none where there is no NEES.
fn nees_band(all: &[f64]) -> Option<[f64; 2]> {
    (!all.is_empty()).then(|| chi_square_mean_band(3, all.len()))
}

/// The table with every column, as CSV.
pub fn csv(lines: &[Line]) -> String {
    let mut text = COLUMNS.iter().fold("plan,case,variant,runs".to_owned(), |head, column| head + "," + column.name);
    text.push('\n');
    for line in lines {
        let _ = write!(text, "{},{},{},{}", quoted(&line.plan), quoted(&line.case), quoted(&line.variant), line.runs);
        for column in &COLUMNS {
            let _ = match column.value(line) {
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
    let has_figures = |column: &&Column| lines.iter().any(|line| column.value(line).is_some());
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
        cells.extend(shown.iter().map(|column| column.cell(line)));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::RunKey;

    #[test]
    fn a_cell_says_how_many_runs_have_its_figure_where_not_all_do() {
        let row = |(seed, ate_m): (u64, &f64)| {
            let key = RunKey { plan: "p".into(), case: "c".into(), seed, variant: "v".into() };
            let mut row = RunRow::new(key);
            row.set(Metric::Path, 100.0);
            row.set(Metric::Ate, *ate_m);
            row
        };
        let rows: Vec<RunRow> = (0..).zip(&[0.01, f64::NAN, 0.03]).map(row).collect();
        let line = Line { plan: "p".into(), case: "c".into(), variant: "v".into(), runs: rows.len(), rows };
        let (head, cells) = cells(&[line]);
        assert_eq!(head, ["plan", "variant", "runs", "path m", "aligned RMSE cm", "90 % cm"]);
        assert_eq!(cells[0][3..], ["100", "2.00 (2 of 3)", "2.80 (2 of 3)"]);
    }
}
