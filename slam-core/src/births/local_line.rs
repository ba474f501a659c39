//! A line through outliers as the filter takes it: in the robot's frame, with its derivatives by the calibration.

use crate::births::buffer::Outlier;
use crate::births::line_fit::{FittedLine, Influence};
use crate::filter::ekf::EkfView;
use crate::geometry::angle::sin_cos;
use crate::measurement::sensor::SensorState;
use crate::motion::drive::Drive;
use crate::rig::MAX_SENSORS;
use crate::sensing::correlation;
use crate::sensing::latency::Latency;
use heapless::Vec;

/// The line in the robot's present frame, with its derivatives by the calibration.
#[derive(Clone, Debug)]
pub struct LocalLine {
    /// Centroid, metres, robot frame.
    pub centroid_m: [f32; 2],
    /// Direction of the normal, radians, robot frame.
    pub normal_rad: f32,
    /// Variance of the centroid along the normal, m^2; of the readings and of the odometry since.
    pub variance_m2: f32,
    /// Variance of the direction, rad^2; likewise.
    pub direction_variance: f32,
    /// The part of it that is of the readings alone, rad^2: how well the line is known relative to the robot that saw it.
    pub seen_direction_variance: f32,
    /// Length, metres.
    pub length_m: f32,
    /// Number of points.
    pub count: u32,
    /// Centroid in the frame of dead reckoning, metres.
    pub seen_m: [f32; 2],
    /// Path length when it was found, metres.
    pub path_m: f32,
    /// (calibration state, d centroid, d direction): three of the drive, up to 16 gains, and the latency.
    pub by_calibration: Vec<(usize, f32, f32), 20>,
}

impl LocalLine {
    /// The plane of a wall whose surface has this relief, metres, is known less well than the line through its points: as
    /// many of them as there are relief's lengths in the line have errors of their own.
    pub fn add_relief(&mut self, relief_m: f32) {
        let stretches = 1.0 + self.length_m * (1.0 / correlation::LENGTH_M);
        let variance_m2 = relief_m * relief_m / stretches;
        self.variance_m2 += variance_m2;
        // Points spread evenly over a length have a variance of a twelfth of its square.
        self.direction_variance += 12.0 * variance_m2 / (self.length_m * self.length_m).max(1e-4);
    }
}

/// What a line depends on beside its points.
#[derive(Clone, Copy)]
pub struct Origin<'a> {
    /// The state.
    pub ekf: &'a EkfView,
    /// The robot's motion so far.
    pub drive: &'a Drive,
    /// The sensors that the points were read with.
    pub sensors: &'a [SensorState],
    /// How late their readings were.
    pub latency: &'a Latency,
}

impl LocalLine {
    /// A fitted line from the odometry frame into the robot's, with the odometry's noise since its points were seen.
    pub fn new<'p>(origin: &Origin, line: &FittedLine, points: impl Iterator<Item = &'p Outlier>) -> Self {
        let odometry = &origin.drive.dead_reckoning;
        let centroid_m = odometry.pose.inverse().transform(line.centroid_m);
        let normal_rad = line.normal_rad - odometry.pose.theta_rad;
        let heading = (odometry.heading_variance - line.heading_variance).max(0.0);
        let position = (odometry.position_variance - line.position_variance).max(0.0);
        let (s, c) = sin_cos(normal_rad);
        let lever_m = centroid_m[1] * c - centroid_m[0] * s;
        Self {
            centroid_m,
            normal_rad,
            // A heading that walks randomly over a stretch moves its end by a third of the lever squared.
            variance_m2: line.variance_m2 + position + heading * lever_m * lever_m * (1.0 / 3.0),
            direction_variance: line.direction_variance + heading,
            seen_direction_variance: line.direction_variance,
            length_m: line.length_m(),
            count: line.count,
            seen_m: line.centroid_m,
            path_m: odometry.path_m,
            by_calibration: by_calibration(origin, line, points),
        }
    }
}

/// Derivatives of the line by every calibration state that shifts some of its points.
fn by_calibration<'p>(
    origin: &Origin,
    line: &FittedLine,
    points: impl Iterator<Item = &'p Outlier>,
) -> Vec<(usize, f32, f32), 20> {
    let Origin { ekf, drive, sensors, latency } = *origin;
    let (mut by_gain, mut by_drive) = ([Influence::default(); MAX_SENSORS], [Influence::default(); 3]);
    let mut by_latency = Influence::default();
    let mut gains = [1.0; MAX_SENSORS];
    for (gain, sensor) in gains.iter_mut().zip(sensors) {
        *gain = sensor.gain(ekf);
    }
    for p in points {
        let weight = line.weight(p);
        let sensor = usize::from(p.sensor);
        if let (Some(influence), Some(gain)) = (by_gain.get_mut(sensor), gains.get(sensor)) {
            // hit = origin + range / gain * direction
            line.add_shift(influence, weight, p.direction.map(|d| -p.range_m / (gain * gain) * d));
        }
        // What moves the point moves the robot too: what counts is the difference.
        let now = drive.dead_reckoning.by_factor(p.hit_m);
        for ((influence, then), now) in by_drive.iter_mut().zip(p.by_factor).zip(now) {
            line.add_shift(influence, weight, [then[0] - now[0], then[1] - now[1]]);
        }
        line.add_shift(&mut by_latency, weight, p.by_latency);
    }
    let gains = sensors.iter().map(|sensor| sensor.gain_state()).zip(&by_gain);
    let states = gains.chain(drive.states.in_order().into_iter().zip(&by_drive)).chain([(latency.state, &by_latency)]);
    let mut by_calibration = Vec::new();
    for (state, influence) in states {
        let (offset, direction) = line.by_parameter(influence);
        if let Some(state) = state
            && (offset != 0.0 || direction != 0.0)
        {
            let _ = by_calibration.push((state, offset, direction));
        }
    }
    by_calibration
}
