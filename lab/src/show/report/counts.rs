//! What became of the readings of a run, counted; `tables.js` of the view modules is the other end.

use std::collections::BTreeMap;

use super::data::code;
use crate::recording::Recording;

/// Pairs of outcome code and number of readings.
pub(super) type Counts = Vec<(usize, usize)>;

/// Over all steps and sensors.
pub(super) fn of_all(recording: &Recording) -> Counts {
    of(recording.readings.iter().map(|reading| code(&reading.outcome)))
}

/// Over all steps, of each sensor.
pub(super) fn of_sensors(recording: &Recording) -> Vec<Counts> {
    let sensors = recording.sensors.len();
    let codes = |sensor| recording.readings.iter().skip(sensor).step_by(sensors).map(|reading| code(&reading.outcome));
    (0..sensors).map(|sensor| of(codes(sensor))).collect()
}

fn of(codes: impl Iterator<Item = usize>) -> Counts {
    let mut counts = BTreeMap::new();
    codes.for_each(|code| *counts.entry(code).or_insert(0) += 1);
    counts.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::SensorInfo;
    use slam_core::{Outcome, ReadingReport};

    #[test]
    fn each_sensor_s_readings_are_its_own() {
        let [none, met] = [Outcome::Missing, Outcome::Unexplained];
        let reading = |outcome| ReadingReport { outcome, ..ReadingReport::default() };
        let readings = [none, met, met, met].map(reading).to_vec();
        let recording = Recording { sensors: vec![SensorInfo::default(); 2], readings, ..Recording::default() };
        assert_eq!(of_all(&recording), [(0, 1), (3, 3)]);
        assert_eq!(of_sensors(&recording), [vec![(0, 1), (3, 1)], vec![(3, 2)]]);
        assert!(of_sensors(&Recording::default()).is_empty());
    }
}
