//! What the rows say of each system, beside the estimator and beside the motion alone.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use lab::evaluate::statistics::median;
use monte_carlo::row::{Metric, RunRow};
use relatives::Kind;

use crate::logs::{Found, LOGS, OURS};
use crate::systems::{NEXT, SYSTEMS, System};

/// The estimator among the variants, and the motion alone.
const ESTIMATOR: &str = "grid, calibrated";
const MOTION: &str = "dead reckoning";

/// The cases that systems are judged on.
const JUDGED: [&str; 2] = ["nominal", "calibrated"];

/// Errors of one variant by drive: plan, case and seed.
type Errors<'a> = BTreeMap<(&'a str, &'a str, u64), f64>;

fn errors<'a>(rows: &'a [RunRow], variant: &str) -> Errors<'a> {
    let own = rows.iter().filter(|row| row.key.variant == variant && JUDGED.contains(&row.key.case.as_str()));
    own.filter_map(|row| Some(((&*row.key.plan, &*row.key.case, row.key.seed), row.get(Metric::Ate)?))).collect()
}

/// Drives in which the one is nearer to the truth than the other, and drives that both have.
fn wins(one: &Errors<'_>, other: &Errors<'_>) -> [usize; 2] {
    let both = || one.iter().filter_map(|(drive, error)| Some((error, other.get(drive)?)));
    [both().filter(|(a, b)| a < b).count(), both().count()]
}

/// How good a path is on a log: by the truth where it is known, else by how sharp the end points lie.
struct Figure {
    name: &'static str,
    /// Places in [`Found::figures`]: at the time, and looking back.
    places: [usize; 2],
    /// Whether more is better.
    is_more: bool,
}

const BY_TRUTH: Figure = Figure { name: "cm", places: [0, 4], is_more: false };
const BY_SHARPNESS: Figure = Figure { name: "nats sharper than odometry", places: [2, 5], is_more: true };
const WHEN: [&str; 2] = ["at the time", "looking back"];

impl Figure {
    /// What a log is judged by.
    fn of(logs: &[Found], log: &str) -> Self {
        let has_truth = value(logs, log, OURS, 0).is_some();
        if has_truth { BY_TRUTH } else { BY_SHARPNESS }
    }

    /// Whether one is better in the digits that are shown.
    fn is_better(&self, one: f64, other: f64) -> bool {
        self.say(one) != self.say(other) && (one > other) == self.is_more
    }

    fn say(&self, value: f64) -> String {
        if self.is_more { format!("{value:.2}") } else { format!("{:.0}", 100.0 * value) }
    }
}

/// The median over the replays.
fn value(logs: &[Found], log: &str, system: &str, figure: usize) -> Option<f64> {
    let own = logs.iter().filter(|found| found.log == log && found.system == system);
    median(&own.map(|found| found.figures[figure]).filter(|value| value.is_finite()).collect::<Vec<_>>())
}

/// The paragraphs of the page, one a system.
pub fn paragraphs(rows: &[RunRow], logs: &[Found]) -> String {
    let mut text = "## System by system\n\n".to_owned();
    for system in &SYSTEMS {
        let _ = write!(
            text,
            "**{}.** {} *Good at:* {} *Short:* {}\n\n",
            system.title, system.what, system.good, system.short
        );
        for variant in system.variants {
            text += &simulated(rows, variant);
        }
        text += &on_logs(logs, system);
        if !text.ends_with("\n\n") {
            text.push('\n');
        }
    }
    text
}

fn simulated(rows: &[RunRow], variant: &str) -> String {
    let own = errors(rows, variant);
    let [over_motion, drives] = wins(&own, &errors(rows, MOTION));
    let [over_ours, both] = wins(&own, &errors(rows, ESTIMATOR));
    if drives == 0 {
        return String::new();
    }
    format!(
        "- {variant}: of {drives} simulated drives nearer to the truth than the motion alone in {over_motion}, of {both} than the \
         estimator in {over_ours}.\n"
    )
}

/// The logs on which a system is ahead of the estimator, and those on which it is behind the motion alone.
fn on_logs(logs: &[Found], system: &System) -> String {
    let (mut ahead, mut behind, mut count) = (Vec::new(), Vec::new(), 0);
    for (log, kind) in LOGS.iter().flat_map(|log| system.kinds.iter().map(|kind| (log.name, *kind))) {
        let figure = Figure::of(logs, log);
        let of = |system: &str, place: usize| value(logs, log, system, place);
        if let (Some(own), Some(motion)) =
            (of(kind, figure.places[0]), of(Kind::DeadReckoning.name(), figure.places[0]))
        {
            count += 1;
            if figure.is_better(motion, own) {
                behind.push(format!(
                    "{log} ({kind}: {} against {} {})",
                    figure.say(own),
                    figure.say(motion),
                    figure.name
                ));
            }
        }
        for (place, when) in figure.places.into_iter().zip(WHEN) {
            if let (Some(own), Some(ours)) = (of(kind, place), of(OURS, place))
                && figure.is_better(own, ours)
            {
                let (own, ours, unit) = (figure.say(own), figure.say(ours), figure.name);
                ahead.push(format!("{log} {when} ({kind}: {own} against {ours} {unit})"));
            }
        }
    }
    if count == 0 {
        return String::new();
    }
    let list = |places: Vec<String>| if places.is_empty() { "none".to_owned() } else { places.join("; ") };
    format!("- Real logs, ahead of the estimator: {}. Behind the motion alone: {}.\n", list(ahead), list(behind))
}

/// Where some system is ahead of the estimator, and what would be tried next.
pub fn losses(rows: &[RunRow], logs: &[Found], carried: &str) -> String {
    let mut text = "## Where the estimator loses\n\nBy medians, against the best of the others: in simulated homes of those with the same sensors and no map, on logs of all (`psm` has the \
         whole scans). Next steps are plans, not promises.\n\n| drive or log | | the estimator | best of the others | which | next |\n|---|---|---|---|---|---|\n"
        .to_owned();
    let before = text.len();
    for (plan, case) in ["flat", "room"].into_iter().flat_map(|plan| JUDGED.map(|case| (plan, case))) {
        let of = |variant: &str| {
            let all = errors(rows, variant);
            median(&all.iter().filter(|(key, _)| (key.0, key.1) == (plan, case)).map(|(_, e)| *e).collect::<Vec<_>>())
        };
        let theirs = SYSTEMS.iter().flat_map(|system| system.variants).filter(|name| !has_more(name));
        let best = theirs.filter_map(|name| Some((of(name)?, *name))).min_by(|a, b| a.0.total_cmp(&b.0));
        if let (Some(ours), Some((best, name))) = (of(ESTIMATOR), best)
            && best < ours
        {
            let cells = [ours, best].map(|error| format!("{:.1} cm", 100.0 * error));
            let _ = writeln!(text, "| {plan} | {case} | {} | {} | {name} | |", cells[0], cells[1]);
        }
    }
    for log in LOGS.map(|log| log.name) {
        let figure = Figure::of(logs, log);
        for (place, when) in figure.places.into_iter().zip(WHEN) {
            let kinds =
                std::iter::once(Kind::DeadReckoning.name()).chain(SYSTEMS.iter().flat_map(|s| s.kinds).copied());
            let all: Vec<(f64, &str)> = kinds.filter_map(|kind| Some((value(logs, log, kind, place)?, kind))).collect();
            let best = all.into_iter().reduce(|a, b| if figure.is_better(b.0, a.0) { b } else { a });
            if let (Some(ours), Some((best, name))) = (value(logs, log, OURS, place), best)
                && figure.is_better(best, ours)
            {
                let next = NEXT.iter().find(|(name, _)| *name == log).map_or("", |(_, next)| next);
                let (ours, best) = (figure.say(ours), figure.say(best));
                let _ = writeln!(text, "| {log} | {when} | {ours} {0} | {best} {0} | {name} | {next} |", figure.name);
            }
        }
    }
    text += carried;
    if text.len() == before {
        text.push_str("| none | | | | | |\n");
    }
    text.push('\n');
    text
}

/// Whether a variant has more than the rig's own sensors and samples, or is the estimator with something changed.
fn has_more(variant: &str) -> bool {
    ["sonar", "laser", "given", "report", "grid"].iter().any(|word| variant.contains(word))
}
