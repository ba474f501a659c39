//! Where beams ended, by one path or another.

use crate::recording::{Pose2, Recording, Step};

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

/// Every reading with a range, projected with the poses of `path`; the order is the same for every path.
pub fn project(recording: &Recording, path: fn(&Step) -> Pose2) -> Vec<Hit> {
    let mut hits = Vec::new();
    for (step, entry) in recording.steps.iter().enumerate() {
        let pose = path(entry);
        for (sensor, reading) in recording.sensors.iter().zip(recording.readings(step)) {
            let Some(range_m) = reading.range_m.map(f64::from) else { continue };
            let (s, c) = sensor.bearing_rad.sin_cos();
            let at_m = pose.transform([sensor.x_m + range_m * c, sensor.y_m + range_m * s]);
            let (s, c) = (pose.theta_rad + sensor.bearing_rad).sin_cos();
            hits.push(Hit { step, at_m, direction: [c, s] });
        }
    }
    hits
}
