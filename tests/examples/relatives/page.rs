//! The page: tables, figures, and a paragraph a system.

use std::fmt::Write as _;
use std::fs;

use lab::evaluate::statistics::{mean, median, quantile};
use lab::show::chart::{Axis, Panel, svg};
use monte_carlo::file::Experiment;
use monte_carlo::row::{Metric, RunRow};
use monte_carlo::table::{self, Line};
use relatives::Kind;
use tests::trial::NOISES;

use crate::logs::{Found, LOGS, OURS};
use crate::{verdict, words};

/// A run whose aligned path is off by more than this is lost, metres: in another room beside a door.
const LOST_M: f64 = 0.5;

/// Writes the page and its figures.
///
/// # Errors
/// What the system says, or a text that cannot be written.
pub fn write(
    done: &[(Vec<RunRow>, Experiment)],
    logs: &[Found],
    (components, carried): (&str, &str),
) -> Result<(), Box<dyn std::error::Error>> {
    let folder = crate::root().join("docs/results");
    let figures = folder.join("relatives");
    fs::create_dir_all(&figures)?;
    let [main, rays] = done else { return Err("two experiments make the page".into()) };
    let mut text = words::HEAD.to_owned();
    let seeds = |(rows, experiment): &(Vec<RunRow>, Experiment)| {
        let all: std::collections::BTreeSet<u64> = rows.iter().map(|row| row.key.seed).collect();
        format!("`experiments/{}`: {} of {} seeds", experiment_file(experiment), all.len(), 50)
    };
    writeln!(text, "Measured for this page: {}; {}.\n", seeds(main), seeds(rays))?;
    let lines = table::lines(&main.1, &main.0);
    for case in ["nominal", "calibrated"] {
        simulated(&mut text, case, &lines)?;
    }
    for (name, title, shown, key) in [
        ("calibration", "How wrong may the calibration be?", &words::SHOWN, "error_ratio"),
        ("drift", "How far may the odometry drift?", &words::SHOWN, "drift_deg_per_m"),
    ] {
        let point =
            |line: &Line| Some((line.variant.clone(), sweep_value(&line.case, key)?)).filter(|_| line.plan == "flat");
        figure(&mut text, &figures, (name, title, words::axis(key)), shown, &lines, &point, false)?;
    }
    let lines = table::lines(&rays.1, &rays.0);
    let point = |line: &Line| {
        let (name, rest) = line.variant.rsplit_once(", ")?;
        Some((name.to_owned(), rest.strip_suffix(" rays")?.parse().ok()?))
    };
    let title = ("rays", "How many rays?", "rays of the laser");
    figure(&mut text, &figures, title, &words::BY_RAYS, &lines, &point, true)?;
    real(&mut text, logs)?;
    text += components;
    text += &verdict::losses(&main.0, logs, carried);
    text += &verdict::paragraphs(&main.0, logs);
    fs::write(folder.join("relatives.md"), text.trim_end().to_owned() + "\n")?;
    Ok(())
}

fn experiment_file(experiment: &Experiment) -> &'static str {
    if experiment.title == "Relatives" { "relatives.toml" } else { "relatives-rays.toml" }
}

/// Where a case is on the axis of a quantity; the two cases without a sweep are points of each.
fn sweep_value(case: &str, key: &str) -> Option<f64> {
    match (case, key) {
        ("nominal", "error_ratio") => return Some(1.0),
        ("calibrated", "error_ratio") | ("nominal", _) => return Some(0.0),
        _ => {}
    }
    case.strip_prefix(key)?.strip_prefix(" = ")?.parse().ok()
}

fn centimetres(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |metres| format!("{:.*}", usize::from(metres < 0.1), 100.0 * metres))
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
}

fn simulated(text: &mut String, case: &str, lines: &[Line]) -> std::fmt::Result {
    writeln!(text, "## Simulated homes, {case}\n\n{}\n", words::case(case))?;
    writeln!(
        text,
        "| plan | system | runs | aligned RMSE cm | 90 % cm | lost | end points cm | NEES | walls missed | invented | looking back cm | \
         µs a step | kB |\n|---|---|{}",
        "---|".repeat(11)
    )?;
    for line in lines.iter().filter(|line| line.case == case) {
        let of = |metric: Metric| line.figures(metric);
        let ate = of(Metric::Ate);
        let lost = ate.iter().filter(|ate| **ate > LOST_M).count() + line.runs - ate.len();
        let has_walls = of(Metric::Offset).iter().any(|offset| *offset > 0.0);
        let walls = |metric: Metric| number(mean(&of(metric)).filter(|_| has_walls), 1);
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {lost} | {} | {} | {} | {} | {} | {} | {} |",
            line.plan,
            line.variant,
            line.runs,
            centimetres(median(&ate)),
            centimetres(quantile(&ate, 0.9)),
            centimetres(median(&of(Metric::EndPoints))),
            number(median(&of(Metric::Nees)), 1),
            walls(Metric::Missed),
            walls(Metric::Invented),
            centimetres(median(&of(Metric::Back))),
            number(median(&of(Metric::StepCost)), 0),
            number(median(&of(Metric::Memory)).filter(|kb| *kb > 0.0), 0),
        )?;
    }
    writeln!(text)
}

/// A figure of the median error over a quantity; `point` says which curve a line is of, and where on it.
fn figure(
    text: &mut String,
    folder: &std::path::Path,
    (name, title, axis): (&str, &str, &str),
    shown: &[&str],
    lines: &[Line],
    point: &dyn Fn(&Line) -> Option<(String, f64)>,
    is_log: bool,
) -> std::io::Result<()> {
    let curve = |shown: &str| -> Vec<(f64, f64)> {
        let own = lines.iter().filter_map(|line| Some((point(line).filter(|(name, _)| name == shown)?.1, line)));
        let mut points: Vec<(f64, f64)> =
            own.filter_map(|(x, line)| Some((x, 100.0 * median(&line.figures(Metric::Ate))?))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let curves: Vec<Vec<(f64, f64)>> = shown.iter().map(|shown| curve(shown)).collect();
    // Two points are no curve: so little of the sweep was done.
    if curves.iter().all(|curve| curve.len() < 3) {
        return Ok(());
    }
    let all = || curves.iter().flatten();
    let label = "aligned RMSE, median, cm";
    let along = all().map(|point| point.0);
    let x = if is_log { Axis::log(axis, along) } else { Axis::linear(axis, along) };
    let mut panel = Panel::new(title, x, Axis::log(label, all().map(|point| point.1)), 860.0, 380.0);
    for (i, curve) in curves.iter().enumerate() {
        panel.line(curve, i);
        panel.dots(curve, 4.0, i);
    }
    let legend: Vec<(usize, String)> = shown.iter().enumerate().map(|(i, name)| (i, words::legend(name))).collect();
    fs::write(folder.join(format!("{name}.svg")), svg(&[panel], &legend))?;
    text.push_str(&format!("## {title}\n\n{}\n\n![{title}](relatives/{name}.svg)\n\n", words::about(name)));
    Ok(())
}

fn real(text: &mut String, logs: &[Found]) -> std::fmt::Result {
    let counts = LOGS.map(|log| logs.iter().filter(|f| f.log == log.name && f.system == OURS).count());
    let [least, most] = [counts.into_iter().min(), counts.into_iter().max()].map(Option::unwrap_or_default);
    let replays = if least == most { most.to_string() } else { format!("{least} to {most}") };
    writeln!(
        text,
        "## Logs of real robots\n\n{}\n",
        words::REAL.replace("REPLAYS", &format!("{replays} of {}", NOISES.len()))
    )?;
    writeln!(
        text,
        "| log | system | aligned RMSE cm | sharper than odometry, nats | visits apart cm | looking back: RMSE cm | sharper, nats | visits \
         apart cm | µs a step |\n|---|---|{}",
        "---|".repeat(7)
    )?;
    let mut cannot = std::collections::BTreeMap::<(String, String), Vec<String>>::new();
    for log in LOGS {
        for system in std::iter::once(OURS).chain(Kind::ALL.map(Kind::name)) {
            let own: Vec<&Found> =
                logs.iter().filter(|found| found.log == log.name && found.system == system).collect();
            let Some(first) = own.first() else { continue };
            if !first.cannot.is_empty() {
                cannot.entry((system.to_owned(), first.cannot.clone())).or_default().push(log.name.to_owned());
                continue;
            }
            let cell = |figure: usize, scale: f64, digits: usize, more: bool| {
                let values: Vec<f64> =
                    own.iter().map(|f| scale * f.figures[figure]).filter(|v| v.is_finite()).collect();
                let worst = quantile(&values, if more { 0.0 } else { 1.0 });
                match (median(&values), worst) {
                    (Some(median), Some(worst)) => format!("{median:.digits$} ({worst:.digits$})"),
                    _ => "–".to_owned(),
                }
            };
            let cells = [
                cell(0, 100.0, 0, false),
                cell(2, 1.0, 2, true),
                cell(3, 100.0, 1, false),
                cell(4, 100.0, 0, false),
                cell(5, 1.0, 2, true),
                cell(6, 100.0, 1, false),
                number(own.iter().map(|f| f.figures[7]).reduce(f64::min), 0),
            ];
            writeln!(text, "| {} | {system} | {} |", log.name, cells.join(" | "))?;
        }
    }
    writeln!(text, "\n| system | cannot run on | why |\n|---|---|---|")?;
    for ((system, why), logs) in cannot {
        writeln!(text, "| {system} | {} | {why} |", logs.join(", "))?;
    }
    writeln!(text)
}
