//! Every score of a summary, what is better, and by how much one side is.

use serde_json::{Value, json};

/// What makes a score better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Better {
    /// A smaller value.
    Less,
    /// A larger value.
    More,
    /// Nearer to this one, as a ratio: half of it is as far off as twice.
    Near(f64),
    /// It says nothing by itself.
    Neither,
}

/// How a value is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    Metres,
    /// Degrees.
    Degrees,
    /// Nats.
    Nats,
    /// A share, written in percent.
    Share,
    /// A plain number.
    Plain,
    /// A count.
    Count,
}

/// One score of both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Heading that it stands under.
    pub group: &'static str,
    /// For people.
    pub label: String,
    /// Where it is in the summary: a JSON pointer; several are joined by what is done with them.
    pub key: String,
    /// How it is written.
    pub unit: Unit,
    /// What is better.
    pub better: Better,
    /// The first side's, where it has it.
    pub a: Option<f64>,
    /// The second side's.
    pub b: Option<f64>,
}

const CONSISTENCY: &str = "map against itself";
const BACK: &str = "looking back";
const READINGS: &str = "readings";
const FLOOR: &str = "floor";

type Score = (&'static str, &'static str, &'static str, Unit, Better);

const SCORES: [Score; 55] = [
    ("log", "rows", "/rows", Unit::Count, Better::Neither),
    ("log", "path by dead reckoning", "/path_m", Unit::Metres, Better::Neither),
    ("log", "rows without a place", "/lost", Unit::Share, Better::Less),
    (TRUTH, "position, best alignment (RMSE)", "/ate_m", Unit::Metres, Better::Less),
    (TRUTH, "  odometry's", "/odometry/ate_m", Unit::Metres, Better::Neither),
    (TRUTH, "position, start frame (RMSE)", "/start_m", Unit::Metres, Better::Less),
    (TRUTH, "  odometry's", "/odometry/start_m", Unit::Metres, Better::Neither),
    (TRUTH, "heading (RMSE)", "/heading_deg", Unit::Degrees, Better::Less),
    (TRUTH, "  odometry's", "/odometry/heading_deg", Unit::Degrees, Better::Neither),
    (TRUTH, "pose NEES (mean, 3 is ideal)", "/nees", Unit::Plain, Better::Near(3.0)),
    (TRUTH, "wall offsets (RMS)", "/map/offset_m", Unit::Metres, Better::Less),
    (TRUTH, "true walls found", "/map/matched", Unit::Count, Better::Neither),
    (TRUTH, "walls missed", "/map/missed", Unit::Count, Better::Less),
    (TRUTH, "walls invented", "/map/invented", Unit::Count, Better::Less),
    ("innovations", "NIS of readings used (1 is ideal)", "/mean_nis", Unit::Plain, Better::Near(1.0)),
    ("innovations", "NIS before the gate (1 is ideal)", "/nis_before_gate", Unit::Plain, Better::Near(1.0)),
    ("innovations", "  its median (0.45 is ideal)", "/median_nis_before_gate", Unit::Plain, Better::Near(0.455)),
    ("innovations", "  of their wall's own (1 is ideal)", "/nis_associated", Unit::Plain, Better::Near(1.0)),
    (CONSISTENCY, "map entropy", "/consistency/entropy_nats", Unit::Nats, Better::Less),
    (CONSISTENCY, "  odometry's", "/consistency/odometry_entropy_nats", Unit::Nats, Better::Neither),
    (CONSISTENCY, "  below odometry's", BELOW_ODOMETRY, Unit::Nats, Better::More),
    (CONSISTENCY, "visits apart (median)", "/consistency/surfels/median_m", Unit::Metres, Better::Less),
    (CONSISTENCY, "  odometry's", "/consistency/odometry_surfels/median_m", Unit::Metres, Better::Neither),
    (CONSISTENCY, "  nine in ten at most", "/consistency/surfels/p90_m", Unit::Metres, Better::Less),
    (CONSISTENCY, "  over 15 cm", "/consistency/surfels/wide_share", Unit::Share, Better::Less),
    (CONSISTENCY, "walls seen again", "/consistency/revisited_walls", Unit::Count, Better::Neither),
    (CONSISTENCY, "widest gap between two visits", "/consistency/widest_gap_m", Unit::Metres, Better::Less),
    (CONSISTENCY, "mean gap", "/consistency/mean_gap_m", Unit::Metres, Better::Less),
    (CONSISTENCY, "thickness of walls seen again (RMS)", "/consistency/thickness_m", Unit::Metres, Better::Less),
    (CONSISTENCY, "first visit to last (RMS)", "/consistency/closure_m", Unit::Metres, Better::Less),
    (CONSISTENCY, "  odometry's", "/consistency/odometry_closure_m", Unit::Metres, Better::Neither),
    (BACK, "position, best alignment (RMSE)", "/looking_back/ate_m", Unit::Metres, Better::Less),
    (BACK, "heading (RMSE)", "/looking_back/heading_deg", Unit::Degrees, Better::Less),
    (BACK, "map entropy", "/looking_back/consistency/entropy_nats", Unit::Nats, Better::Less),
    (BACK, "visits apart (median)", "/looking_back/consistency/surfels/median_m", Unit::Metres, Better::Less),
    (BACK, "widest gap between two visits", "/looking_back/consistency/widest_gap_m", Unit::Metres, Better::Less),
    (BACK, "mean gap", "/looking_back/consistency/mean_gap_m", Unit::Metres, Better::Less),
    (BACK, "first visit to last (RMS)", "/looking_back/consistency/closure_m", Unit::Metres, Better::Less),
    (READINGS, "readings", "/readings/all", Unit::Count, Better::Neither),
    (READINGS, "used", "/readings/shares/used", Unit::Share, Better::More),
    (READINGS, "outside the gate", "/readings/shares/outside_gate", Unit::Share, Better::Less),
    (READINGS, "  of those that met a wall", REFUSED_BY_GATE, Unit::Share, Better::Less),
    (READINGS, "unexplained", "/readings/shares/unexplained", Unit::Share, Better::Less),
    (READINGS, "refused", "/readings/shares/refused", Unit::Share, Better::Neither),
    (FLOOR, "floor that it can reach, m2", "/floor/floor_m2", Unit::Plain, Better::Neither),
    (FLOOR, "swept", "/floor/swept", Unit::Share, Better::More),
    (FLOOR, "swept again later", "/floor/twice", Unit::Share, Better::Less),
    (FLOOR, "largest piece missed, m2", "/floor/largest_hole_m2", Unit::Plain, Better::Less),
    (FLOOR, "true path", "/floor/path_m", Unit::Metres, Better::Less),
    (FLOOR, "path over swept floor", "/floor/overlap", Unit::Plain, Better::Less),
    (FLOOR, "bumps", "/floor/bumps", Unit::Count, Better::Less),
    (FLOOR, "bumps per m2", "/floor/bumps_per_m2", Unit::Plain, Better::Less),
    (FLOOR, "end of the drive from its start", "/floor/home_m", Unit::Metres, Better::Less),
    ("map", "walls", "/walls", Unit::Count, Better::Neither),
    ("map", "estimator's time, s", "/estimator_s", Unit::Plain, Better::Neither),
];

const TRUTH: &str = "against the truth";

/// Odometry's entropy less the estimate's.
const BELOW_ODOMETRY: &str = "/consistency/odometry_entropy_nats - /consistency/entropy_nats";

/// Share of the associated readings that the gate refused.
const REFUSED_BY_GATE: &str = "/readings/shares/outside_gate / (/readings/shares/used + /readings/shares/outside_gate)";

fn value(summary: &Value, key: &str) -> Option<f64> {
    let at = |pointer: &str| summary.pointer(pointer).and_then(Value::as_f64);
    match key {
        BELOW_ODOMETRY => Some(at("/consistency/odometry_entropy_nats")? - at("/consistency/entropy_nats")?),
        REFUSED_BY_GATE => {
            let (gated, used) = (at("/readings/shares/outside_gate")?, at("/readings/shares/used")?);
            (gated + used > 0.0).then(|| gated / (gated + used))
        }
        pointer => at(pointer),
    }
}

/// Every score that either summary has.
pub fn rows(a: &Value, b: &Value) -> Vec<Row> {
    let row = |(group, label, key, unit, better): Score| Row {
        group,
        label: label.to_owned(),
        key: key.to_owned(),
        unit,
        better,
        a: value(a, key),
        b: value(b, key),
    };
    let fixed = SCORES.into_iter().map(row);
    let named = |group, pointer: &'static str, unit, skip: &'static [&'static str]| {
        names(a, b, pointer).into_iter().filter(|name| !skip.contains(&name.as_str())).map(move |name| {
            let key = format!("{pointer}/{name}");
            let (a, b) = (value(a, &key), value(b, &key));
            Row { group, label: format!("  {}", name.replace('_', " ")), key, unit, better: Better::Neither, a, b }
        })
    };
    let shares = named(READINGS, "/readings/shares", Unit::Share, &["used", "outside_gate", "unexplained", "refused"]);
    let counters = named("map", "/counters", Unit::Count, &["refused"]);
    let times = named(FLOOR, "/floor/time_s", Unit::Plain, &[]);
    let mut rows: Vec<Row> =
        fixed.chain(times).chain(shares).chain(counters).filter(|row| row.a.is_some() || row.b.is_some()).collect();
    let mut groups: Vec<&str> = Vec::new();
    for row in &rows {
        if !groups.contains(&row.group) {
            groups.push(row.group);
        }
    }
    rows.sort_by_key(|row| groups.iter().position(|group| *group == row.group));
    rows
}

/// The names under a place of either summary, in their order there.
fn names(a: &Value, b: &Value, pointer: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for side in [a, b] {
        for (name, _) in side.pointer(pointer).and_then(Value::as_object).into_iter().flatten() {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
    }
    names
}

impl Row {
    /// The second side's less the first's.
    pub fn difference(&self) -> Option<f64> {
        Some(self.b? - self.a?)
    }

    /// Which side is better: "a", "b" or "same"; none where that has no meaning.
    pub fn winner(&self) -> Option<&'static str> {
        let cost = |value: f64| match self.better {
            Better::Less => Some(value),
            Better::More => Some(-value),
            // A figure of zero or below is as far off as can be.
            Better::Near(ideal) => Some(if value > 0.0 { (value / ideal).ln().abs() } else { f64::INFINITY }),
            Better::Neither => None,
        };
        let (a, b) = (cost(self.a?)?, cost(self.b?)?);
        Some(match a.total_cmp(&b) {
            std::cmp::Ordering::Less => "a",
            std::cmp::Ordering::Equal => "same",
            std::cmp::Ordering::Greater => "b",
        })
    }

    /// For other programs.
    pub fn json(&self) -> Value {
        let unit = match self.unit {
            Unit::Metres => "m",
            Unit::Degrees => "deg",
            Unit::Nats => "nats",
            Unit::Share => "share",
            Unit::Plain | Unit::Count => "",
        };
        json!({
            "key": self.key,
            "label": self.label.trim(),
            "group": self.group,
            "unit": unit,
            "a": self.a,
            "b": self.b,
            "difference": self.difference(),
            "better": self.winner(),
        })
    }
}
