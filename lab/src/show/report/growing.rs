//! A run for a page that shows it as it grows: what has come since the page last asked. The other end is the studio's
//! `live.js`.

use super::data::{code, hit_range, kind_text, refusal_text, wall_ends};
use super::series::RunningNis;
use crate::evaluate::score::path::nees;
use crate::recording::{CalibrationSnapshot, MapSnapshot, Pose2, Recording, Step};
use serde_json::{Value, json};
use slam_core::kept::{Kept, KeptWall};
use slam_core::{Outcome, Refusal, WallKind, WallView};

/// Numbers of a step before those of its sensors.
pub const STEP_NUMBERS: usize = 24;
/// Numbers of each sensor's reading in a step.
pub const READING_NUMBERS: usize = 5;

/// What a page has got of a run.
#[derive(Default)]
pub struct Growing {
    steps: usize,
    maps: usize,
    nis: RunningNis,
    hides_truth: bool,
}

impl Growing {
    /// For a run whose true poses are in a frame that is not known yet.
    pub fn without_truth() -> Self {
        Self { hides_truth: true, ..Self::default() }
    }

    /// The page has shown another run meanwhile: it gets everything once more.
    pub fn tell_again(&mut self) {
        *self = Self { hides_truth: self.hides_truth, ..Self::default() };
    }

    /// What stays as it is over the run: its title, its sensors, the words for refusals, the calibration's parameters.
    pub fn head(recording: &Recording) -> Value {
        let sensors = recording.sensors.iter().map(|sensor| {
            json!({ "name": sensor.name, "x": sensor.x_m, "y": sensor.y_m, "bearing": sensor.bearing_rad, "span": sensor.span_m })
        });
        let parameters = recording.parameters.iter().map(|parameter| parameter.name.as_str());
        json!({
            "title": recording.title,
            "program": concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")),
            "refusals": Refusal::ALL.map(refusal_text),
            "sensors": sensors.collect::<Vec<_>>(),
            "parameters": parameters.collect::<Vec<_>>(),
            "step_numbers": STEP_NUMBERS,
            "reading_numbers": READING_NUMBERS,
        })
    }

    /// The steps that the page has not got: [`STEP_NUMBERS`] numbers each and [`READING_NUMBERS`] for each sensor, NaN for what
    /// is not known. Metres, radians, seconds, in the map frame.
    pub fn steps(&mut self, recording: &Recording) -> Vec<f64> {
        let mut numbers = Vec::new();
        for index in self.steps..recording.steps.len() {
            let step = &recording.steps[index];
            let readings = recording.readings(index);
            let (used, all) = self.nis.push(step.t_s, readings);
            let error = step.error().filter(|_| !self.hides_truth);
            let nees = nees(step).filter(|_| !self.hides_truth);
            numbers.extend(of_step(step, error, nees, [used, all]));
            for (sensor, reading) in readings.iter().enumerate() {
                let range_m = hit_range(recording, index, sensor, reading);
                let (wall, sigmas, sigma_m) = match reading.outcome {
                    Outcome::Updated { wall, innovation_m, variance_m2, .. }
                    | Outcome::Gated { wall, innovation_m, variance_m2 } => {
                        let sigma_m = f64::from(variance_m2).sqrt();
                        (f64::from(wall), f64::from(innovation_m) / sigma_m, sigma_m)
                    }
                    _ => (-1.0, f64::NAN, f64::NAN),
                };
                let code = code(&reading.outcome) as f64;
                numbers.extend([code, wall, range_m.unwrap_or(f64::NAN), sigmas, sigma_m]);
            }
        }
        self.steps = recording.steps.len();
        numbers
    }

    /// Map and calibration as they were recorded last, where the page has older ones.
    pub fn map(&mut self, recording: &Recording) -> Option<Value> {
        let count = recording.maps.len();
        if count == core::mem::replace(&mut self.maps, count) {
            return None;
        }
        Some(map_of(recording.maps.last()?, recording.calibration.last()?))
    }

    /// Every map and calibration that was recorded, in order.
    pub fn maps(recording: &Recording) -> Value {
        recording.maps.iter().zip(&recording.calibration).map(|(map, calibration)| map_of(map, calibration)).collect()
    }

    /// The walls of a kept map: their ends.
    pub fn kept_walls(map: &impl Kept) -> Value {
        let view = |wall: KeptWall| {
            let [rho_m, beta_rad] = map.line(&wall);
            let KeptWall { id, lo_m, hi_m, updates, .. } = wall;
            WallView { id, kind: WallKind::Grid, rho_m, beta_rad, lo_m, hi_m, sigma_rho_m: 0.0, updates }
        };
        let walls = (0..usize::from(map.frame().walls)).filter_map(|index| map.wall(index));
        walls.map(|wall| json!(wall_ends(&view(wall)))).collect()
    }

    /// Walls that a look back over so many steps found: their ends.
    pub fn looked_back(steps: usize, walls: &[WallView]) -> Value {
        json!({ "steps": steps, "walls": walls.iter().map(wall_ends).collect::<Vec<_>>() })
    }
}

fn map_of(map: &MapSnapshot, calibration: &CalibrationSnapshot) -> Value {
    let walls = map.walls.iter().map(|wall| {
        json!({
            "id": wall.id,
            "kind": kind_text(wall.kind),
            "ends": wall_ends(wall),
            "sigma": wall.sigma_rho_m,
            "updates": wall.updates,
        })
    });
    json!({ "step": map.step, "walls": walls.collect::<Vec<_>>(), "calibration": calibration.values })
}

fn of_step(step: &Step, error: Option<Pose2>, nees: Option<f64>, nis: [Option<f64>; 2]) -> [f64; STEP_NUMBERS] {
    let known = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let sigma = |axis: usize| f64::from(step.covariance[axis][axis]).sqrt();
    let scale = sigma(0) * sigma(1);
    let correlation = if scale > 0.0 { f64::from(step.covariance[0][1]) / scale } else { 0.0 };
    let error_of = |axis: fn(&Pose2) -> f64| known(error.as_ref().map(axis));
    [
        step.t_s,
        step.pose.x_m,
        step.pose.y_m,
        step.pose.theta_rad,
        step.start.x_m,
        step.start.y_m,
        step.start.theta_rad,
        step.dead_reckoning.x_m,
        step.dead_reckoning.y_m,
        step.dead_reckoning.theta_rad,
        error_of(|error| error.x_m),
        error_of(|error| error.y_m),
        error_of(|error| error.theta_rad),
        sigma(0),
        sigma(1),
        sigma(2),
        correlation,
        known(step.alpha.map(|(alpha_rad, _)| alpha_rad.into())),
        known(step.alpha.map(|(_, sigma_rad)| sigma_rad.into())),
        known(nees),
        known(nis[0]),
        known(nis[1]),
        step.walls as f64,
        f64::from(u8::from(step.searching)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_is_given_once() {
        let mut recording = Recording { steps: vec![Step::default(); 3], ..Recording::default() };
        let mut growing = Growing::default();
        assert_eq!(growing.steps(&recording).len(), 3 * STEP_NUMBERS);
        assert!(growing.steps(&recording).is_empty());
        recording.steps.push(Step { t_s: 7.0, ..Step::default() });
        let fourth = growing.steps(&recording);
        assert_eq!((fourth.len(), fourth[0]), (STEP_NUMBERS, 7.0));
        assert!(growing.map(&recording).is_none());
    }
}
