//! The figures of an experiment.

mod series;

use std::collections::BTreeMap;
use std::path::Path;

use crate::file::Experiment;
use crate::key::Key;
use crate::row::Metric;
use crate::samples::{ErrorSample, TIMES};
use crate::table::Line;
use input_file::FileError;
use lab::evaluate::statistics::{chi_square_mean_band, max, mean, median, normal_density, quantile};
use lab::show::chart::{Axis, Panel, svg};

pub use series::{copy_series, read_series, write_series};

/// The folder of the figures inside the output folder.
pub const FOLDER: &str = "figures";

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 340.0;

/// A figure: its file's name, what it shows, and its SVG.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of the file in the folder of figures.
    pub name: String,
    /// What it shows, for people.
    pub caption: String,
    /// The picture.
    pub svg: String,
}

/// Every figure that is made from rows and samples.
pub fn all(experiment: &Experiment, lines: &[Line], samples: &[ErrorSample]) -> Vec<Figure> {
    let mut figures = Vec::new();
    for case in experiment.cases.iter().filter(|case| case.point.is_none()) {
        let own: Vec<&Line> = lines.iter().filter(|line| line.case == case.name).collect();
        figures.extend(by_plan(experiment, &case.name, &case.plans, &own));
        for plan in &case.plans {
            let own: Vec<&ErrorSample> =
                samples.iter().filter(|sample| sample.key.case == case.name && sample.key.plan == *plan).collect();
            figures.extend(nees_over_time(experiment, &case.name, plan, &own));
            figures.extend(experiment.series.iter().filter_map(|name| histogram(&case.name, plan, name, &own)));
        }
    }
    let mut keys: Vec<Key> = experiment.cases.iter().filter_map(|case| Some(case.point?.0)).collect();
    keys.dedup();
    figures.extend(keys.into_iter().flat_map(|key| sweeps(experiment, key, lines)));
    figures
}

fn legend(experiment: &Experiment) -> Vec<(usize, String)> {
    experiment.variants.iter().enumerate().map(|(i, variant)| (i, variant.name.clone())).collect()
}

/// A name as part of a file's name.
pub fn slug(text: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c.to_ascii_lowercase() } else { '-' };
    let text: String = text.chars().map(letter).collect();
    let words: Vec<&str> = text.split('-').filter(|word| !word.is_empty()).collect();
    words.join("-")
}

/// A figure over runs at one place: its middle, and from where to where 80 % of the runs are.
fn draw_spread(panel: &mut Panel, x: f64, figures: &[f64], middle: Option<f64>, colour: usize) {
    let all = (middle, quantile(figures, 0.1), quantile(figures, 0.9));
    if let (Some(middle), Some(low), Some(high)) = all {
        panel.whisker(x, low, high, colour);
        panel.dots(&[(x, middle)], 4.0, colour);
    }
}

fn by_plan(experiment: &Experiment, case: &str, plans: &[String], lines: &[&Line]) -> Vec<Figure> {
    let mut panels = Vec::new();
    let shown = [(Metric::Ate, 100.0, "aligned RMSE of position, cm"), (Metric::Nees, 1.0, "mean NEES of the pose")];
    for (metric, factor, label) in shown {
        let figures = |line: &Line| -> Vec<f64> { line.figures(metric).iter().map(|v| factor * v).collect() };
        let everything: Vec<f64> = lines.iter().flat_map(|line| figures(line)).collect();
        let mut panel = Panel::new(label, Axis::named("", plans), Axis::log(label, everything), WIDTH, HEIGHT);
        if metric == Metric::Nees {
            let runs = lines.first().map_or(1, |line| line.runs);
            let [low, high] = chi_square_mean_band(3, runs);
            panel.band(&[(-0.5, low, high), (plans.len() as f64 - 0.5, low, high)], 0);
        }
        for (i, variant) in experiment.variants.iter().enumerate() {
            let offset = 0.7 * ((i as f64 + 0.5) / experiment.variants.len() as f64 - 0.5);
            for (place, plan) in plans.iter().enumerate() {
                let own = lines.iter().find(|line| line.plan == *plan && line.variant == variant.name);
                if let Some(line) = own {
                    let figures = figures(line);
                    // The band is of means.
                    let middle = if metric == Metric::Nees { mean(&figures) } else { median(&figures) };
                    draw_spread(&mut panel, place as f64 + offset, &figures, middle, i);
                }
            }
        }
        panels.push(panel);
    }
    vec![Figure {
        name: format!("{}-accuracy.svg", slug(case)),
        caption: format!(
            "{case}: aligned RMSE and mean NEES of every variant on every plan. Dots are medians of the RMSE and \
             means of the NEES over the seeds, strokes hold 80 % of them; the shaded band has 95 % of the means \
             of as many independent draws of an honest filter's NEES, of which a run's mean over time differs less."
        ),
        svg: svg(&panels, &legend(experiment)),
    }]
}

/// A variant's mean over runs, over time.
struct Curve {
    variant: usize,
    points: Vec<(f64, f64)>,
    runs: usize,
}

/// Each bin's middle and mean NEES; the bins are this wide, in seconds. Runs whose times are their own, by a drawn rate or by jitter, have
/// no moment in common.
fn binned(variant: usize, samples: &[&&ErrorSample], width_s: f64) -> Curve {
    let mut bins: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for sample in samples {
        bins.entry((sample.t_s / width_s).round() as u64).or_default().push(sample.nees);
    }
    let runs = bins.values().map(Vec::len).max().unwrap_or(0);
    let points = bins.iter().filter_map(|(bin, nees)| Some((*bin as f64 * width_s, mean(nees)?))).collect();
    Curve { variant, points, runs }
}

fn nees_over_time(experiment: &Experiment, case: &str, plan: &str, samples: &[&ErrorSample]) -> Option<Figure> {
    let end_s = max(&samples.iter().map(|sample| sample.t_s).collect::<Vec<_>>())?;
    let width_s = (end_s / TIMES as f64).max(f64::MIN_POSITIVE);
    let curves: Vec<Curve> = experiment
        .variants
        .iter()
        .enumerate()
        .map(|(i, variant)| {
            let own: Vec<&&ErrorSample> = samples.iter().filter(|sample| sample.key.variant == variant.name).collect();
            binned(i, &own, width_s)
        })
        .filter(|curve| curve.runs > 0)
        .collect();
    let runs = curves.iter().map(|curve| curve.runs).max()?;
    let points = || curves.iter().flat_map(|curve| curve.points.iter().copied());
    let x = Axis::linear("time, s", points().map(|point| point.0));
    let y = Axis::log("mean NEES over the runs", points().map(|point| point.1).chain([1.0, 5.0]));
    let mut panel = Panel::new(&format!("{plan}, {case}: {runs} runs"), x, y, WIDTH, HEIGHT);
    let [low, high] = chi_square_mean_band(3, runs);
    let (from, to) = points().fold((f64::INFINITY, 0.0), |(from, to): (f64, f64), p| (from.min(p.0), to.max(p.0)));
    panel.band(&[(from, low, high), (to, low, high)], 0);
    for curve in &curves {
        panel.line(&curve.points, curve.variant);
    }
    Some(Figure {
        name: format!("{}-{}-nees-over-time.svg", slug(plan), slug(case)),
        caption: format!(
            "{plan}, {case}: NEES of the pose over time, mean over {runs} runs in bins of {width_s:.1} s. Band: 95 % of an \
             honest filter's."
        ),
        svg: svg(&[panel], &legend(experiment)),
    })
}

/// Bars of a histogram from -5 to 5 in steps of 0.25, as densities; what is beyond is put into the last ones.
pub fn density_bars(values: &[f64]) -> Vec<(f64, f64, f64)> {
    const BINS: usize = 40;
    let mut counts = [0usize; BINS];
    for value in values {
        counts[(((value + 5.0) / 0.25).floor().max(0.0) as usize).min(BINS - 1)] += 1;
    }
    let scale = 1.0 / (0.25 * values.len().max(1) as f64);
    let bar = |(i, count): (usize, &usize)| {
        let from = -5.0 + 0.25 * i as f64;
        (from, from + 0.25, scale * *count as f64)
    };
    counts.iter().enumerate().map(bar).collect()
}

/// A histogram with the standard normal density over it.
pub fn density_panel(title: &str, label: &str, values: &[f64], width: f64, height: f64) -> Panel {
    let bars = density_bars(values);
    let top = bars.iter().map(|bar| bar.2).fold(0.42, f64::max);
    let y = Axis::from_zero("density", top);
    let mut panel = Panel::new(title, Axis::linear(label, [-5.0, 5.0]), y, width, height);
    panel.bars(&bars, 5);
    let normal: Vec<(f64, f64)> = (-50..=50).map(|i| 0.1 * f64::from(i)).map(|z| (z, normal_density(z))).collect();
    panel.line(&normal, 1);
    panel
}

fn histogram(case: &str, plan: &str, variant: &str, samples: &[&ErrorSample]) -> Option<Figure> {
    let own: Vec<&&ErrorSample> = samples.iter().filter(|sample| sample.key.variant == variant).collect();
    if own.is_empty() {
        return None;
    }
    let panels = [("x", 0), ("y", 1), ("heading", 2)].map(|(name, axis)| {
        let values: Vec<f64> = own.iter().map(|sample| sample.normalised[axis]).collect();
        density_panel(&format!("{plan}, {variant}: {name}"), "error / sigma", &values, WIDTH, 220.0)
    });
    Some(Figure {
        name: format!("{}-{}-{}-normalised.svg", slug(plan), slug(case), slug(variant)),
        caption: format!(
            "{plan}, {case}, {variant}: errors of the pose over the filter's own sigmas at 30 times of every run. The line \
             is the standard normal density, which an honest filter's errors follow."
        ),
        svg: svg(&panels, &[]),
    })
}

fn sweeps(experiment: &Experiment, key: Key, lines: &[Line]) -> Vec<Figure> {
    let points: Vec<(&str, f64, &[String])> = experiment
        .cases
        .iter()
        .filter_map(|case| case.point.filter(|p| p.0 == key).map(|p| (case.name.as_str(), p.1, &case.plans[..])))
        .collect();
    let mut plans: Vec<&String> = points.iter().flat_map(|point| point.2).collect();
    plans.sort();
    plans.dedup();
    plans.into_iter().map(|plan| sweep(experiment, key, plan, &points, lines)).collect()
}

fn sweep(experiment: &Experiment, key: Key, plan: &str, points: &[(&str, f64, &[String])], lines: &[Line]) -> Figure {
    let find = |case: &str, variant: &str| {
        lines.iter().find(|line| line.case == case && line.plan == plan && line.variant == variant)
    };
    let mut panels = Vec::new();
    for (metric, factor, label) in
        [(Metric::Ate, 100.0, "aligned RMSE, cm"), (Metric::Nees, 1.0, "mean NEES of the pose")]
    {
        let figures = |line: &Line| -> Vec<f64> { line.figures(metric).iter().map(|v| factor * v).collect() };
        let own = lines.iter().filter(|line| line.plan == plan && points.iter().any(|point| point.0 == line.case));
        let y = Axis::log(label, own.flat_map(figures));
        let x = Axis::linear(key.label(), points.iter().map(|point| point.1));
        let mut panel = Panel::new(&format!("{plan}: {label}"), x, y, WIDTH, 300.0);
        for (i, variant) in experiment.variants.iter().enumerate() {
            let mut curve = Vec::new();
            for (case, value, _) in points {
                let Some(line) = find(case, &variant.name) else { continue };
                let figures = figures(line);
                let middle = median(&figures);
                curve.extend(middle.map(|middle| (*value, middle)));
                draw_spread(&mut panel, *value, &figures, middle, i);
            }
            panel.line(&curve, i);
        }
        panels.push(panel);
    }
    Figure {
        name: format!("{}-{}.svg", slug(plan), slug(key.name())),
        caption: format!(
            "{plan}: {} swept. Lines join medians over the seeds, strokes hold 80 % of them.",
            key.label()
        ),
        svg: svg(&panels, &legend(experiment)),
    }
}

/// Writes the figures into their folder.
///
/// # Errors
/// A file cannot be written.
pub fn write(out: &Path, figures: &[Figure]) -> Result<(), FileError> {
    let folder = out.join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(|cause| FileError::system(&folder, "create", &cause))?;
    for figure in figures {
        let file = folder.join(&figure.name);
        std::fs::write(&file, &figure.svg).map_err(|cause| FileError::system(&file, "write", &cause))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::RunKey;

    #[test]
    fn nees_over_time_is_of_all_runs_though_each_has_its_own_times() {
        let sample = |seed: u64, i: u64| ErrorSample {
            key: RunKey { plan: "p".into(), case: "c".into(), seed, variant: "v".into() },
            t_s: 20.0 * i as f64 - 0.01 * seed as f64,
            error_m: 0.0,
            sigma_m: 0.0,
            nees: seed as f64,
            normalised: [0.0; 3],
        };
        let samples: Vec<ErrorSample> = (1..=3).flat_map(|seed| (1..=30).map(move |i| sample(seed, i))).collect();
        let samples: Vec<&ErrorSample> = samples.iter().collect();
        let curve = binned(0, &samples.iter().collect::<Vec<_>>(), 20.0);
        assert_eq!((curve.runs, curve.points.len()), (3, 30));
        assert!(curve.points.iter().all(|point| point.1 == 2.0));
    }
}
