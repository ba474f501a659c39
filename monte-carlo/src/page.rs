//! What an experiment ends with: tables, figures and a page, all made from the rows and samples of its folder.

use std::fmt::Write as _;
use std::path::Path;

use crate::bar::Verdict;
use crate::figures::{self, Figure};
use crate::file::Experiment;
use crate::store;
use crate::table::{self, Line};
use input_file::FileError;
use lab::show::svg::escape;

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:1100px;margin:2rem auto;padding:0 1rem;\
color:#24292f;background:#fff}table{border-collapse:collapse;font-size:13px;display:block;overflow-x:auto}\
th,td{padding:.3rem .6rem;border-bottom:1px solid #d0d7de;text-align:right}th:first-child,td:first-child{text-align:left}td{white-space:nowrap}\
figure{margin:2rem 0}figure svg{max-width:100%;height:auto}pre{overflow-x:auto;background:#f6f8fa;padding:1rem}\
.no{color:#cf222e;font-weight:600}@media(prefers-color-scheme:dark){body{color:#e6edf3;background:#0d1117}\
th,td{border-color:#30363d}pre{background:#161b22}.no{color:#ff7b72}}";

const TABLE_CSV: &str = "table.csv";
const TABLE_MD: &str = "table.md";
const PAGE: &str = "index.html";

/// The files beside those of the rows.
pub const FILES: [&str; 3] = [TABLE_CSV, TABLE_MD, PAGE];

/// What was made of an experiment's rows.
pub struct Written {
    /// The table.
    pub lines: Vec<Line>,
    /// What must hold.
    pub verdicts: Vec<Verdict>,
}

/// Writes tables, figures and the page into an experiment's folder.
///
/// # Errors
/// The rows cannot be read, or a file cannot be written.
pub fn write(folder: &Path, experiment: &Experiment) -> Result<Written, FileError> {
    let rows = store::read(&folder.join(store::RUNS))?;
    let samples = store::read_samples(&folder.join(store::SAMPLES))?;
    let lines = table::lines(experiment, &rows);
    let verdicts: Vec<Verdict> = experiment.bars.iter().flat_map(|bar| bar.judge(&rows, &experiment.cases)).collect();
    let mut figures = figures::all(experiment, &lines, &samples);
    figures::write(folder, &figures)?;
    figures.extend(figures::read_series(folder)?);
    let put = |name: &str, text: &str| {
        let file = folder.join(name);
        std::fs::write(&file, text).map_err(|cause| FileError::system(&file, "write", &cause))
    };
    put(TABLE_CSV, &table::csv(&lines))?;
    let mut text = format!("# {}\n\n{}\n\n{}", experiment.title, experiment.about.trim(), table::markdown(&lines));
    if !verdicts.is_empty() {
        let _ = write!(text, "\n{}", table::verdicts_markdown(&verdicts));
    }
    put(TABLE_MD, &text)?;
    put(PAGE, &page(experiment, &lines, &verdicts, &figures))?;
    Ok(Written { lines, verdicts })
}

fn page(experiment: &Experiment, lines: &[Line], verdicts: &[Verdict], figures: &[Figure]) -> String {
    let title = escape(&experiment.title);
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\
         <meta name=\"viewport\" content=\"width=device-width\"><meta name=\"color-scheme\" content=\"light dark\">\
         <style>{STYLE}</style></head><body><h1>{title}</h1><p>{}</p>",
        escape(&experiment.about)
    );
    if !lines.is_empty() {
        let (head, cells) = table::cells(lines);
        html.push_str("<h2>Figures of all runs</h2>");
        write_table(&mut html, &head, &cells);
    }
    if !verdicts.is_empty() {
        html.push_str("<h2>What must hold</h2>");
        let cells: Vec<Vec<String>> = verdicts.iter().map(verdict_cells).collect();
        write_table(&mut html, &["plan", "must hold", "found", "holds"], &cells);
    }
    for figure in figures {
        let _ = write!(html, "<figure>{}<figcaption>{}</figcaption></figure>", figure.svg, escape(&figure.caption));
    }
    let _ = writeln!(html, "<h2>The experiment file</h2><pre>{}</pre></body></html>", escape(&experiment.text));
    html
}

fn verdict_cells(verdict: &Verdict) -> Vec<String> {
    let found = verdict.found.map_or_else(|| "–".to_owned(), |found| format!("{found:.4}"));
    vec![verdict.plan.clone(), verdict.bar.clone(), found, if verdict.holds { "yes" } else { "no" }.to_owned()]
}

fn write_table(html: &mut String, head: &[&str], cells: &[Vec<String>]) {
    html.push_str("<table><thead><tr>");
    for name in head {
        let _ = write!(html, "<th>{}</th>", escape(name));
    }
    html.push_str("</tr></thead><tbody>");
    for row in cells {
        html.push_str("<tr>");
        for cell in row {
            let class = if cell == "no" { " class=\"no\"" } else { "" };
            let _ = write!(html, "<td{class}>{}</td>", escape(cell));
        }
        html.push_str("</tr>");
    }
    html.push_str("</tbody></table>");
}
