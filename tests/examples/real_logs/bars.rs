//! What should hold on real logs, and whether it does.

use std::fmt::Write as _;

use lab::recording::{Figures, Recording};

use super::cells::{back, median_and_worst, sharper_back_nats, sharper_nats};
use super::{Case, figures_of};

/// What is measured, how it is written, and what should hold.
struct Bar {
    name: &'static str,
    value: fn(&Figures) -> Option<f64>,
    /// Value as written, and its unit.
    scale: (f64, &'static str),
    limit: Limit,
}

#[derive(Clone, Copy)]
enum Limit {
    AtMost(f64),
    AtLeast(f64),
    Within(f64, f64),
}

impl Limit {
    fn holds(self, value: f64) -> bool {
        match self {
            Self::AtMost(most) => value <= most,
            Self::AtLeast(least) => value >= least,
            Self::Within(least, most) => (least..=most).contains(&value),
        }
    }

    fn text(self, (scale, unit): (f64, &str)) -> String {
        match self {
            Self::AtMost(most) => format!("at most {}{unit}", scale * most),
            Self::AtLeast(least) => format!("at least {}{unit}", scale * least),
            Self::Within(least, most) => format!("{} to {}{unit}", scale * least, scale * most),
        }
    }
}

const ALIGNED: Bar = Bar {
    name: "aligned RMSE",
    value: |figures| Some(figures.estimate?.ate_m),
    scale: (100.0, " cm"),
    limit: Limit::AtMost(0.12),
};

const NOT_WORSE: Bar = Bar {
    name: "aligned RMSE as a share of odometry's",
    value: |figures| Some(figures.estimate?.ate_m / figures.odometry?.ate_m),
    scale: (1.0, ""),
    limit: Limit::AtMost(1.0),
};

const GAP: Bar = Bar {
    name: "widest gap between visits",
    value: |figures| figures.consistency.as_ref()?.widest_gap_m,
    scale: (100.0, " cm"),
    limit: Limit::AtMost(0.15),
};

const AGREEING: Bar = Bar {
    name: "visits apart as a share of odometry's",
    value: |figures| {
        let score = figures.consistency.as_ref()?;
        Some(score.surfels?.median_m / score.odometry_surfels?.median_m)
    },
    scale: (1.0, ""),
    limit: Limit::AtMost(1.0),
};

const SHARPER: Bar =
    Bar { name: "sharper than odometry", value: sharper_nats, scale: (1.0, " nats"), limit: Limit::AtLeast(0.3) };

const ALIGNED_BACK: Bar = Bar {
    name: "looking back: aligned RMSE",
    value: |figures| Some(figures.looking_back.as_ref()?.estimate?.ate_m),
    ..ALIGNED
};

const GAP_BACK: Bar =
    Bar { name: "looking back: widest gap between visits", value: |figures| back(figures)?.widest_gap_m, ..GAP };

const SHARPER_BACK: Bar = Bar { name: "looking back: sharper than odometry", value: sharper_back_nats, ..SHARPER };

const NIS: Bar = Bar {
    name: "NIS before the gate, of the wall's own readings",
    value: |figures| figures.nis_associated,
    scale: (1.0, ""),
    limit: Limit::Within(0.7, 1.5),
};

const NIS_OF_ALL: Bar =
    Bar { name: "NIS before the gate, of all that met a wall", value: |figures| figures.nis_before_gate, ..NIS };

/// The bars of each log.
const BARS: [&[Bar]; 4] = [
    &[ALIGNED, ALIGNED_BACK, NOT_WORSE, AGREEING, NIS, NIS_OF_ALL],
    &[
        Bar { limit: Limit::AtMost(0.3), ..ALIGNED },
        Bar { limit: Limit::AtMost(0.3), ..ALIGNED_BACK },
        NOT_WORSE,
        NIS,
        NIS_OF_ALL,
    ],
    &[GAP, GAP_BACK, AGREEING, SHARPER, SHARPER_BACK, NIS, NIS_OF_ALL],
    &[GAP, GAP_BACK, AGREEING, SHARPER, SHARPER_BACK, NIS, NIS_OF_ALL],
];

/// The table of bars; `defaults` are the replays with the estimator's defaults, log by log.
pub fn write(text: &mut String, defaults: &[(Vec<Recording>, Case)]) -> std::fmt::Result {
    writeln!(text, "## What should hold\n\n| log | figure | bar | median | worst | held |\n|---|---|---|---|---|---|")?;
    for ((recordings, case), bars) in defaults.iter().zip(BARS) {
        let runs = figures_of(recordings);
        for bar in bars {
            row(text, case, bar, &runs)?;
        }
    }
    writeln!(text)
}

fn row(text: &mut String, case: &Case, bar: &Bar, runs: &[Figures]) -> std::fmt::Result {
    let values: Vec<f64> = runs.iter().filter_map(bar.value).collect();
    let (held, n) = (values.iter().filter(|value| bar.limit.holds(**value)).count(), values.len());
    let more_is_better = matches!(bar.limit, Limit::AtLeast(_));
    let Some((median, worst)) = median_and_worst(&values, more_is_better) else { return Ok(()) };
    let (scale, unit) = bar.scale;
    let number = |value: f64| {
        let digits = if scale > 1.0 || scale * value >= 10.0 { 0 } else { 2 };
        format!("{:.digits$}{unit}", scale * value)
    };
    let (title, limit) = (case.title, bar.limit.text(bar.scale));
    writeln!(text, "| {title} | {} | {limit} | {} | {} | {held} of {n} |", bar.name, number(median), number(worst))
}
