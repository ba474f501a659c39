//! `summary.json`: the figures of a run, and what is needed to repeat it.

use hal_sim::floor::FloorScore;
use serde_json::{Map, Value, json};
use slam_core::{Clustering, Config, Health, Linearisation, NotTaken, Refusal, WallPolicy};

use crate::input::part::{PARTS, Part};
use crate::recording::health::{self, Freeze, Illness};
use crate::recording::{Consistency, HandOver, MapScore, PathScore, Recording, SeenWall, SurfelScore};

/// What was run, for `summary.json`.
#[derive(Clone, Debug)]
pub struct Origin {
    /// The command and its arguments, by name.
    pub arguments: Vec<(&'static str, Value)>,
    /// The rig file's text.
    pub rig_toml: String,
    /// The estimator's settings.
    pub config: Config,
    /// Those that suit its rig, which it has where nothing else is asked for.
    pub suits: Config,
    /// Whether every reading is to be written, too.
    pub trace: bool,
    /// What ended the run early.
    pub error: Option<String>,
}

/// The whole summary.
pub fn summary(recording: &Recording, origin: &Origin) -> Value {
    let figures = &recording.figures;
    let mut summary = Map::new();
    let mut put = |key: &str, value: Value| summary.insert(key.to_owned(), value);
    put("finished", json!(origin.error.is_none()));
    if let Some(error) = &origin.error {
        put("error", json!(error));
    }
    put("title", json!(recording.title));
    put("rows", json!(recording.steps.len()));
    put("path_m", json!(figures.path_m));
    put("duration_s", json!(figures.duration_s));
    put("lost", json!(figures.lost));
    put("notes", json!(recording.notes));
    put("estimator_s", json!(figures.estimator_s));
    put("walls", json!(figures.walls));
    let start = recording.start();
    put("health", health(recording));
    put("frozen_sensors", frozen_sensors(recording));
    put("stuck_from_s", json!(recording.stuck_from_s));
    put("start", json!([start.x_m, start.y_m, start.theta_rad]));
    put("updates", json!(figures.updates));
    put("latency_s", json!(figures.latency_s.map(|(value, sigma)| [value, sigma])));
    put("outliers", json!(figures.outliers));
    put("mean_nis", json!(figures.mean_nis));
    put("nis_before_gate", json!(figures.nis_before_gate));
    put("median_nis_before_gate", json!(figures.median_nis_before_gate));
    put("nis_associated", json!(figures.nis_associated));
    put("readings", readings(recording));
    if let Some(score) = &figures.estimate {
        for (key, value) in path(score) {
            put(key, value);
        }
        put("nees", json!(score.nees));
    }
    if let Some(score) = &figures.odometry {
        put("odometry", Value::Object(path(score).map(|(key, value)| (key.to_owned(), value)).into_iter().collect()));
    }
    if let Some(score) = &figures.map {
        put("map", map(score));
    }
    if let Some(score) = &figures.consistency {
        put("consistency", consistency(score));
    }
    if let Some(score) = &figures.looking_back {
        let mut back: Map<String, Value> = Map::new();
        for (key, value) in score.estimate.iter().flat_map(path) {
            back.insert(key.to_owned(), value);
        }
        back.insert("consistency".to_owned(), json!(score.consistency.as_ref().map(consistency)));
        put("looking_back", Value::Object(back));
    }
    if let Some(score) = &figures.floor {
        put("floor", floor(score));
    }
    put("counters", counters(recording));
    put("hand_overs", recording.hand_overs.iter().map(|found| hand_over(recording, found)).collect());
    put("seed", json!(recording.seed));
    put("configuration", configuration(origin));
    Value::Object(summary)
}

fn health(recording: &Recording) -> Value {
    let illness = |illness: Illness| json!({"what": health::name(illness.health), "begin_s": illness.begin_s, "end_s": illness.end_s});
    let illnesses: Vec<Value> = recording.illnesses().into_iter().map(illness).collect();
    let at_end = recording.steps.last().map_or(Health::Well, |step| step.health);
    json!({"at_end": health::name(at_end), "unwell": illnesses})
}

fn frozen_sensors(recording: &Recording) -> Value {
    let freeze = |freeze: Freeze| {
        let name = recording.sensors.get(freeze.sensor).map(|sensor| &sensor.name);
        json!({"sensor": name, "begin_s": freeze.begin_s, "end_s": freeze.end_s, "refused": freeze.refused})
    };
    recording.freezes().into_iter().map(freeze).collect()
}

fn path(score: &PathScore) -> [(&'static str, Value); 4] {
    [
        ("ate_m", json!(score.ate_m)),
        ("start_m", json!(score.start_m)),
        ("heading_deg", json!(score.heading_deg)),
        ("poses_compared", json!(score.poses)),
    ]
}

fn map(score: &MapScore) -> Value {
    json!({
        "offset_m": score.offset_m,
        "matched": score.matched,
        "missed": score.missed,
        "invented": score.invented,
    })
}

fn floor(score: &FloorScore) -> Value {
    let time: Map<String, Value> = score.time.iter().map(|(name, sum_s)| (name.clone(), json!(sum_s))).collect();
    json!({
        "floor_m2": score.floor_m2,
        "swept": score.swept,
        "twice": score.twice,
        "largest_hole_m2": score.largest_hole_m2,
        "largest_hole_box_m": score.hole_m,
        "path_m": score.path_m,
        "overlap": score.overlap,
        "bumps": score.bumps,
        "bumps_per_m2": f64::from(score.bumps) / score.floor_m2,
        "home_m": score.home_m,
        "time_s": time,
    })
}

fn consistency(score: &Consistency) -> Value {
    json!({
        "entropy_nats": score.entropy_nats,
        "odometry_entropy_nats": score.odometry_entropy_nats,
        "revisited_walls": score.revisited,
        "widest_gap_m": score.widest_gap_m,
        "mean_gap_m": score.mean_gap_m,
        "thickness_m": score.thickness_m,
        "closure_m": score.closure_m,
        "odometry_closure_m": score.odometry_closure_m,
        "surfels": score.surfels.as_ref().map(surfels),
        "odometry_surfels": score.odometry_surfels.as_ref().map(surfels),
        "walls": score.walls.iter().filter(|wall| wall.visits.len() > 1).map(seen_wall).collect::<Vec<_>>(),
    })
}

fn surfels(score: &SurfelScore) -> Value {
    json!({
        "found": score.found,
        "compared": score.compared,
        "median_m": score.median_m,
        "p90_m": score.p90_m,
        "wide_share": score.wide_share,
    })
}

fn seen_wall(wall: &SeenWall) -> Value {
    let visits: Vec<Value> = wall
        .visits
        .iter()
        .map(|visit| {
            json!({
                "begin_s": visit.begin_s,
                "end_s": visit.end_s,
                "readings": visit.readings,
                "mean_m": visit.mean_m,
            })
        })
        .collect();
    json!({
        "wall": wall.wall,
        "readings": wall.readings,
        "thickness_m": wall.thickness_m,
        "gap_m": wall.gap_m,
        "closure_m": wall.closure_m,
        "odometry_closure_m": wall.odometry_closure_m,
        "visits": visits,
    })
}

/// What became of the readings: their number, and shares of it.
fn readings(recording: &Recording) -> Value {
    let counters = &recording.counters;
    let refused: u64 = counters.refused.iter().map(|n| u64::from(*n)).sum();
    let kept = [counters.updates, counters.gated, counters.unexplained].map(u64::from);
    let all = refused + kept.iter().sum::<u64>();
    let share = |n: u64| if all > 0 { n as f64 / all as f64 } else { 0.0 };
    let mut shares = Map::new();
    for (name, n) in ["used", "outside_gate", "unexplained"].into_iter().zip(kept) {
        shares.insert(name.to_owned(), json!(share(n)));
    }
    shares.insert("refused".to_owned(), json!(share(refused)));
    for (refusal, n) in Refusal::ALL.iter().zip(counters.refused).filter(|(_, n)| *n > 0) {
        shares.insert(refusal_name(*refusal).to_owned(), json!(share(n.into())));
    }
    json!({ "all": all, "shares": shares })
}

fn counters(recording: &Recording) -> Value {
    let counters = &recording.counters;
    let refused: Map<String, Value> = Refusal::ALL
        .iter()
        .zip(counters.refused)
        .map(|(refusal, n)| (refusal_name(*refusal).to_owned(), json!(n)))
        .collect();
    json!({
        "refused": refused,
        "buffered": counters.buffered,
        "overwritten": counters.overwritten,
        "births": counters.births,
        "map_full": counters.map_full,
        "merges": counters.merges,
        "prunes": counters.prunes,
        "bad_motion": counters.bad_motion,
        "restarts": counters.restarts,
        "jolts": counters.jolts,
        "second_copies": counters.second_copies,
        "shifted_copies": counters.shifted_copies,
        "holds": counters.holds,
        "frozen": counters.frozen,
    })
}

/// What a look back found while the robot drove, and what came of it.
fn hand_over(recording: &Recording, found: &HandOver) -> Value {
    json!({
        "t_s": recording.steps.get(found.step).map(|step| step.t_s),
        "refused": found.refused.map(refused_name),
        "moved_m": found.moved.x_m.hypot(found.moved.y_m),
        "turned_rad": found.moved.theta_rad,
    })
}

/// Why a hand-over was refused, as the outputs call it.
pub fn refused_name(reason: NotTaken) -> &'static str {
    match reason {
        NotTaken::Outdated => "outdated",
        NotTaken::Unsupported => "unsupported",
        NotTaken::Unsound => "unsound",
        NotTaken::Apart => "apart",
        NotTaken::LessSure => "less_sure",
    }
}

/// A reason of refusal as the outputs call it.
pub fn refusal_name(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::Invalid => "invalid",
        Refusal::TooNear => "too_near",
        Refusal::TooFar => "too_far",
        Refusal::Floor => "floor",
        Refusal::Held => "held",
        Refusal::FoldBack => "fold_back",
        Refusal::Incidence => "incidence",
        Refusal::Ambiguous => "ambiguous",
        Refusal::Degenerate => "degenerate",
        Refusal::Frozen => "frozen",
    }
}

/// The parts that are switched off. What an estimator that suits the rig has not either is no part of it: `walls` tells.
fn without(config: &Config, suits: &Config) -> Vec<&'static str> {
    let is_off = |part: &&Part| part.is_off(config) && !part.is_off(suits);
    PARTS.iter().filter(is_off).map(|part| part.name).collect()
}

fn configuration(origin: &Origin) -> Value {
    let arguments: Map<String, Value> =
        origin.arguments.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    let config = &origin.config;
    let walls = match config.walls.policy {
        WallPolicy::Free => "free",
        WallPolicy::Snapped { theta_moves: false } => "snapped",
        WallPolicy::Snapped { theta_moves: true } => "snapped, theta moves",
        WallPolicy::Grid => "grid",
        WallPolicy::NearGrid => "near-grid",
    };
    let clustering = match config.births.clustering {
        Clustering::BySensor => "by sensor",
        Clustering::Dbscan => "dbscan",
    };
    let jacobians = match config.measurement.linearisation {
        Linearisation::Latest => "latest",
        Linearisation::FirstEstimates => "first",
    };
    json!({
        "arguments": arguments,
        "estimator": {
            "walls": walls,
            "clustering": clustering,
            "calibrate_gains": config.sensing.calibrate_gains,
            "calibrate_scales": config.motion.calibrate_scales,
            "calibrate_track": config.motion.calibrate_track,
            "gate": config.measurement.gate,
            "jacobians": jacobians,
            "hand_overs": config.hand_overs,
            "without": without(config, &origin.suits),
        },
        "rig_toml": origin.rig_toml,
    })
}
