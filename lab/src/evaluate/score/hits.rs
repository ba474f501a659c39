//! Where beams ended, by one path or another.

use crate::recording::{Pose2, Recording, SensorInfo, Step};
use slam_core::ReadingReport;

/// One reading's end point.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Index into [`Recording::steps`].
    pub step: usize,
    /// In the frame of the path that it was projected with, metres.
    pub at_m: [f64; 2],
    /// Unit direction of the beam, in the same frame.
    pub direction: [f64; 2],
}

/// Every reading with a range of a robot that claims to know its place, where the estimator says that it ended: from where the robot was
/// when it was made. In the order of [`by_dead_reckoning`].
pub fn by_estimate(recording: &Recording) -> Vec<Hit> {
    project(recording, |step| step.pose, |reading| reading.hit_m)
}

/// The same ranges, projected with the dead-reckoned poses of the moment they came in.
pub fn by_dead_reckoning(recording: &Recording) -> Vec<Hit> {
    project(recording, |step| step.dead_reckoning, |_| None)
}

/// Projected with the poses of `path`, where the reading itself does not say where it ended.
fn project(
    recording: &Recording,
    path: fn(&Step) -> Pose2,
    reported: fn(&ReadingReport) -> Option<[f32; 2]>,
) -> Vec<Hit> {
    let along = |pose: &Pose2, sensor: &SensorInfo, range_m: f64| {
        let (s, c) = sensor.bearing_rad.sin_cos();
        pose.transform([sensor.x_m + range_m * c, sensor.y_m + range_m * s])
    };
    let mut hits = Vec::new();
    for (step, entry) in recording.steps.iter().enumerate().filter(|(_, step)| !step.searching) {
        let pose = path(entry);
        for (sensor, reading) in recording.sensors.iter().zip(recording.readings(step)) {
            let Some(range_m) = reading.range_m.map(f64::from) else { continue };
            let at_m = reported(reading).map_or_else(|| along(&pose, sensor, range_m), |hit| hit.map(f64::from));
            let (s, c) = (pose.theta_rad + sensor.bearing_rad).sin_cos();
            hits.push(Hit { step, at_m, direction: [c, s] });
        }
    }
    hits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_s_hits_are_where_it_says_and_dead_reckoning_s_where_the_beam_points() {
        let reading = |hit_m| ReadingReport { range_m: Some(2.0), hit_m, ..ReadingReport::default() };
        let recording = Recording {
            sensors: vec![SensorInfo { x_m: 0.1, ..SensorInfo::default() }; 3],
            steps: vec![Step { pose: Pose2 { x_m: 1.0, ..Pose2::default() }, ..Step::default() }],
            readings: vec![reading(Some([3.0, 0.25])), ReadingReport::default(), reading(None)],
            ..Recording::default()
        };
        let places = |hits: Vec<Hit>| hits.iter().map(|hit| hit.at_m).collect::<Vec<_>>();
        assert_eq!(places(by_estimate(&recording)), [[3.0, 0.25], [3.1, 0.0]]);
        assert_eq!(places(by_dead_reckoning(&recording)), [[2.1, 0.0], [2.1, 0.0]]);
    }
}
