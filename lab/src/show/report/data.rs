//! A recording as compact JSON: columns of whole numbers in small units, each stored as its difference from the one
//! before, `null` where a value is absent or not finite. `js/decode.js` is the other end.

use super::frames::Frames;
use super::{counts, events, floor, series};
use crate::evaluate::score::path::nees;
use crate::recording::{Consistency, Figures, MapScore, PathScore, Pose2, Recording, SeenWall, Step};
use serde_json::{Value, json};
use slam_core::{Outcome, ReadingReport, Refusal, WallKind, WallView};
use std::collections::BTreeMap;

const MM: f64 = 1e3;
const TENTH_MM: f64 = 1e4;
const TENTH_MRAD: f64 = 1e4;
const TEN_URAD: f64 = 1e5;
const HUNDREDTHS: f64 = 1e2;

/// Steps times sensors on one page: more, and only every second, third, ... step is shown.
const READINGS_MAX: usize = 160_000;

/// A wall's ends are stored again when one moved this far, metres.
const WALL_MOVED_M: f64 = 0.004;

/// Everything that the page shows.
pub fn page_data(recording: &Recording) -> Value {
    let stride = (recording.steps.len() * recording.sensors.len().max(4)).div_ceil(READINGS_MAX).max(1);
    let shown = shown_steps(recording.steps.len(), stride);
    let frames = Frames::of(recording);
    json!({
        "title": recording.title,
        "seed": recording.seed,
        "program": concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")),
        "stride": stride,
        "figures": figures(&recording.figures),
        "refusals": Refusal::ALL.map(refusal_text),
        "counts": counts::of_all(recording),
        "sensor_counts": counts::of_sensors(recording),
        "steps": steps(recording, &shown, &frames),
        "sensors": sensors(recording, &shown),
        "walls": walls(recording, &shown, &frames),
        "calibration": calibration(recording),
        "floor": recording.swept_floor().map(floor::floor),
        "events": events::events(recording, &shown),
        "plan": recording.true_walls.iter().map(|s| [s.from_m[0], s.from_m[1], s.to_m[0], s.to_m[1]].map(millimetre))
            .collect::<Vec<_>>(),
    })
}

/// Every `stride`-th step, and the last.
fn shown_steps(count: usize, stride: usize) -> Vec<usize> {
    let mut shown: Vec<usize> = (0..count).step_by(stride).collect();
    if count > 0 && shown.last() != Some(&(count - 1)) {
        shown.push(count - 1);
    }
    shown
}

/// Index of the first shown step at or after `step`.
pub(super) fn shown_index(shown: &[usize], step: usize) -> usize {
    shown.partition_point(|&s| s < step).min(shown.len().saturating_sub(1))
}

/// Values in units of 1 / `per_unit`, as differences.
fn column(values: impl IntoIterator<Item = Option<f64>>, per_unit: f64) -> Vec<Option<i64>> {
    let mut before = 0;
    values
        .into_iter()
        .map(|value| {
            let now = (value.filter(|v| v.is_finite())? * per_unit).round() as i64;
            let difference = now.saturating_sub(before);
            before = now;
            Some(difference)
        })
        .collect()
}

/// Rounded to a millimetre.
fn millimetre(value_m: f64) -> f64 {
    (value_m * MM).round() / MM
}

fn steps(recording: &Recording, shown: &[usize], frames: &Frames) -> Value {
    let all = &recording.steps;
    let col = |value: &dyn Fn(usize) -> Option<f64>, per_unit| column(shown.iter().map(|&i| value(i)), per_unit);
    let pose = |pose: &dyn Fn(usize) -> Pose2| {
        json!({
            "x": col(&|i| Some(pose(i).x_m), MM),
            "y": col(&|i| Some(pose(i).y_m), MM),
            "theta": col(&|i| Some(pose(i).theta_rad), TENTH_MRAD),
        })
    };
    let sigma = |axis: usize| move |i: usize| Some(f64::from(all[i].covariance[axis][axis]).sqrt());
    let correlation = |i: usize| {
        let p = &all[i].covariance;
        let scale = (f64::from(p[0][0]) * f64::from(p[1][1])).sqrt();
        Some(if scale > 0.0 { f64::from(p[0][1]) / scale } else { 0.0 })
    };
    let known = all.iter().any(|step| step.truth.is_some());
    // A truth that is slower than the log must not fall between the steps shown.
    let latest = |value: &dyn Fn(&Step) -> Option<f64>, per_unit| {
        let begins = std::iter::once(0).chain(shown.iter().map(|i| i + 1));
        column(begins.zip(shown).map(|(begin, &end)| all[begin..=end].iter().rev().find_map(value)), per_unit)
    };
    let error = known.then(|| {
        json!({
            "x": latest(&|step| step.error().map(|e| e.x_m), TENTH_MM),
            "y": latest(&|step| step.error().map(|e| e.y_m), TENTH_MM),
            "theta": latest(&|step| step.error().map(|e| e.theta_rad), TEN_URAD),
        })
    });
    let (nis_used, nis_all) = series::running_nis(recording);
    json!({
        "t": col(&|i| Some(all[i].t_s), 1e3),
        "estimate": pose(&|i| frames.place(i).compose(&all[i].pose)),
        "start": all.iter().any(|step| step.start != Pose2::default()).then(|| pose(&|i| all[i].start)),
        "odometry": pose(&|i| all[i].dead_reckoning),
        "error": error,
        "sigma_x": col(&sigma(0), TENTH_MM),
        "sigma_y": col(&sigma(1), TENTH_MM),
        "sigma_theta": col(&sigma(2), TEN_URAD),
        "correlation": col(&correlation, HUNDREDTHS),
        "alpha": col(&|i| all[i].alpha.map(|(alpha, _)| f64::from(alpha)), TENTH_MRAD),
        "alpha_sigma": col(&|i| all[i].alpha.map(|(_, sigma)| f64::from(sigma)), TEN_URAD),
        "nees": (known && !recording.truth_begins_late()).then(|| latest(&nees, HUNDREDTHS)),
        "nis_used": col(&|i| nis_used[i], HUNDREDTHS),
        "nis_all": col(&|i| nis_all[i], HUNDREDTHS),
        "walls": col(&|i| Some(all[i].walls as f64), 1.0),
    })
}

/// 0 none, 1 used, 2 outside the gate, 3 met no wall, 4 and on: refused, in the order of [`Refusal::ALL`].
pub(super) fn code(outcome: &Outcome) -> usize {
    match outcome {
        Outcome::Missing => 0,
        Outcome::Updated { .. } => 1,
        Outcome::Gated { .. } => 2,
        Outcome::Unexplained => 3,
        Outcome::Refused(reason) => 4 + Refusal::ALL.iter().position(|r| r == reason).unwrap_or(0),
    }
}

pub(super) fn refusal_text(reason: Refusal) -> &'static str {
    match reason {
        Refusal::Invalid => "not a valid reading",
        Refusal::TooNear => "too near",
        Refusal::TooFar => "too far",
        Refusal::Floor => "sees nothing",
        Refusal::Held => "held from before",
        Refusal::FoldBack => "folded back",
        Refusal::Incidence => "too slanting",
        Refusal::Ambiguous => "ambiguous",
        Refusal::Degenerate => "no variance",
        Refusal::Frozen => "sensor frozen",
    }
}

fn sensors(recording: &Recording, shown: &[usize]) -> Vec<Value> {
    (0..recording.sensors.len()).map(|index| sensor(recording, shown, index)).collect()
}

/// One sensor's readings: runs of [code, wall or -1, whether there is a hit, length]; a range for each hit; innovation
/// (in sigmas) and its sigma for each reading that met a wall.
fn sensor(recording: &Recording, shown: &[usize], index: usize) -> Value {
    let info = &recording.sensors[index];
    let mut runs: Vec<[i64; 4]> = Vec::new();
    let mut ranges = Vec::new();
    let mut sigmas = Vec::new();
    let mut sigma = Vec::new();
    for &step in shown {
        let reading = recording.readings(step).get(index).copied().unwrap_or_default();
        let range = hit_range(recording, step, index, &reading);
        let (wall, innovation) = match reading.outcome {
            Outcome::Updated { wall, innovation_m, variance_m2, .. }
            | Outcome::Gated { wall, innovation_m, variance_m2 } => {
                (i64::from(wall), Some((f64::from(innovation_m), f64::from(variance_m2).sqrt())))
            }
            _ => (-1, None),
        };
        let key = [code(&reading.outcome) as i64, wall, i64::from(range.is_some())];
        match runs.last_mut() {
            Some(run) if run[..3] == key => run[3] += 1,
            _ => runs.push([key[0], key[1], key[2], 1]),
        }
        if range.is_some() {
            ranges.push(range);
        }
        if let Some((value, deviation)) = innovation {
            let ratio = value / deviation * HUNDREDTHS;
            sigmas.push(ratio.is_finite().then(|| ratio.round() as i64));
            sigma.push(Some(deviation));
        }
    }
    json!({
        "name": info.name,
        "x": info.x_m,
        "y": info.y_m,
        "bearing": info.bearing_rad,
        "runs": runs.concat(),
        "ranges": column(ranges, MM),
        "sigmas": sigmas,
        "sigma": column(sigma, TENTH_MM),
    })
}

/// Length of the beam from the sensor to its hit, metres. The page finds the hit again from pose, mount and this.
pub(super) fn hit_range(recording: &Recording, step: usize, index: usize, reading: &ReadingReport) -> Option<f64> {
    let [hit_x, hit_y] = reading.hit_m?.map(f64::from);
    let pose = recording.steps[step].pose;
    let mount = &recording.sensors[index];
    let [x, y] = pose.transform([mount.x_m, mount.y_m]);
    Some((hit_x - x).hypot(hit_y - y)).filter(|range| range.is_finite())
}

/// A wall's ends in the map frame, metres: x0, y0, x1, y1.
pub fn wall_ends(wall: &WallView) -> [f64; 4] {
    let (s, c) = f64::from(wall.beta_rad).sin_cos();
    let rho = f64::from(wall.rho_m);
    let (lo, hi) = (f64::from(wall.lo_m), f64::from(wall.hi_m));
    [rho * c - lo * s, rho * s + lo * c, rho * c - hi * s, rho * s + hi * c]
}

/// The life of one wall.
struct Track {
    kind: WallKind,
    updates: u32,
    born: usize,
    gone: Option<usize>,
    /// Shown step, ends, sigma of rho.
    states: Vec<(usize, [f64; 4], f64)>,
}

fn walls(recording: &Recording, shown: &[usize], frames: &Frames) -> Vec<Value> {
    let mut tracks: BTreeMap<(usize, u16), Track> = BTreeMap::new();
    for (n, map) in recording.maps.iter().enumerate() {
        let at = shown_index(shown, map.step);
        let last = n + 1 == recording.maps.len();
        let (frame, place) = (frames.of_step(map.step), frames.place(map.step));
        for wall in &map.walls {
            let [x0, y0, x1, y1] = wall_ends(wall);
            let [[x0, y0], [x1, y1]] = [place.transform([x0, y0]), place.transform([x1, y1])];
            let state = (at, [x0, y0, x1, y1], f64::from(wall.sigma_rho_m));
            let fresh = Track { kind: wall.kind, updates: 0, born: at, gone: None, states: vec![state] };
            let track = tracks.entry((frame, wall.id)).or_insert(fresh);
            track.updates = wall.updates;
            track.kind = wall.kind;
            let before = track.states[track.states.len() - 1].1;
            let moved = before.iter().zip(state.1).any(|(a, b)| (a - b).abs() > WALL_MOVED_M);
            if moved || last {
                track.states.push(state);
            }
        }
        for (id, track) in &mut tracks {
            if track.gone.is_none() && !map.walls.iter().any(|wall| (frame, wall.id) == *id) {
                track.gone = Some(at);
            }
        }
    }
    let seen = recording.figures.consistency.as_ref().map_or(&[][..], |score| &score.walls);
    let seen: BTreeMap<u16, &SeenWall> = seen.iter().map(|wall| (wall.wall, wall)).collect();
    let is_final = |frame: usize| frame == frames.of_step(recording.steps.len());
    let seen = |(frame, id): &(usize, u16)| seen.get(id).copied().filter(|_| is_final(*frame));
    tracks.iter().map(|(key, track)| track_json(key.1, track, seen(key))).collect()
}

/// The word for a kind of wall.
pub(super) fn kind_text(kind: WallKind) -> &'static str {
    match kind {
        WallKind::Free => "free",
        WallKind::Snapped => "snapped",
        WallKind::Grid => "grid",
    }
}

fn track_json(id: u16, track: &Track, seen: Option<&SeenWall>) -> Value {
    let states = &track.states;
    let end = |k: usize| column(states.iter().map(|state| Some(state.1[k])), MM);
    json!({
        "id": id,
        "kind": kind_text(track.kind),
        "updates": track.updates,
        "visits": seen.map_or(0, |wall| wall.visits.len()),
        "thickness": seen.map(|wall| wall.thickness_m),
        "gap": seen.and_then(|wall| wall.gap_m),
        "born": track.born,
        "gone": track.gone,
        "at": column(states.iter().map(|state| Some(state.0 as f64)), 1.0),
        "x0": end(0),
        "y0": end(1),
        "x1": end(2),
        "y1": end(3),
        "sigma": column(states.iter().map(|state| Some(state.2)), TENTH_MM),
    })
}

fn calibration(recording: &Recording) -> Value {
    let snapshots = &recording.calibration;
    let time = |step: usize| recording.steps.get(step).map(|s| s.t_s);
    let parameters = recording.parameters.iter().enumerate().map(|(k, parameter)| {
        let value = |i: usize| snapshots[i].values.get(k).copied();
        json!({
            "name": parameter.name,
            "truth": parameter.truth,
            "value": column((0..snapshots.len()).map(|i| value(i).map(|(v, _)| f64::from(v))), 1e5),
            "sigma": column((0..snapshots.len()).map(|i| value(i).map(|(_, s)| f64::from(s))), 1e5),
        })
    });
    json!({
        "t": column(snapshots.iter().map(|s| time(s.step)), 1e3),
        "parameters": parameters.collect::<Vec<_>>(),
    })
}

/// The figures as the page has them.
pub fn figures(figures: &Figures) -> Value {
    json!({
        "path_m": figures.path_m,
        "duration_s": figures.duration_s,
        "lost": figures.lost,
        "estimator_s": figures.estimator_s,
        "walls": figures.walls,
        "updates": figures.updates,
        "outliers": figures.outliers,
        "mean_nis": figures.mean_nis,
        "estimate": figures.estimate.as_ref().map(score),
        "odometry": figures.odometry.as_ref().map(score),
        "map": figures.map.as_ref().map(map_score),
        "consistency": figures.consistency.as_ref().map(consistency),
    })
}

fn score(score: &PathScore) -> Value {
    let PathScore { ate_m, start_m, heading_deg, nees, alignment: Pose2 { x_m: x, y_m: y, theta_rad: theta }, .. } =
        score;
    let alignment = json!({ "x": x, "y": y, "theta": theta });
    json!({ "ate_m": ate_m, "start_m": start_m, "heading_deg": heading_deg, "nees": nees, "alignment": alignment })
}

fn consistency(score: &Consistency) -> Value {
    json!({
        "entropy_nats": score.entropy_nats,
        "odometry_entropy_nats": score.odometry_entropy_nats,
        "revisited": score.revisited,
        "widest_gap_m": score.widest_gap_m,
        "mean_gap_m": score.mean_gap_m,
        "apart_m": score.surfels.map(|surfels| surfels.median_m),
        "odometry_apart_m": score.odometry_surfels.map(|surfels| surfels.median_m),
        "closure_m": score.closure_m,
    })
}

fn map_score(score: &MapScore) -> Value {
    json!({ "offset_m": score.offset_m, "matched": score.matched, "missed": score.missed, "invented": score.invented })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_differences_and_absent_values_stay_absent() {
        let values = [Some(1.0), Some(1.5), None, Some(f64::NAN), Some(1.0)];
        assert_eq!(column(values, 10.0), [Some(10), Some(5), None, None, Some(-5)]);
    }

    #[test]
    fn the_last_step_is_always_shown() {
        assert_eq!(shown_steps(8, 3), [0, 3, 6, 7]);
        assert_eq!(shown_steps(7, 3), [0, 3, 6]);
        assert_eq!(shown_steps(0, 3), [0; 0]);
        assert_eq!(shown_index(&[0, 3, 6, 7], 4), 2);
        assert_eq!(shown_index(&[0, 3, 6, 7], 9), 3);
    }

    #[test]
    fn a_wall_runs_along_its_tangent() {
        let wall = WallView {
            id: 1,
            kind: WallKind::Grid,
            rho_m: 2.0,
            beta_rad: std::f32::consts::FRAC_PI_2,
            lo_m: -1.0,
            hi_m: 3.0,
            sigma_rho_m: 0.01,
            updates: 1,
        };
        // The normal points along +y, the tangent along -x.
        for (found, expected) in wall_ends(&wall).iter().zip([1.0, 2.0, -3.0, 2.0]) {
            assert!((found - expected).abs() < 1e-6, "{found} is not {expected}");
        }
    }
}
