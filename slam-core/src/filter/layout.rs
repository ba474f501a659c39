//! Which state stands where: names for the indices.
//!
//! `[x, y, theta, alpha, motion calibration (0 to 3), gains (0 to S), latency (0 or 1), walls ...]`

use crate::config::Config;
use crate::rig::{DriveModel, RangeModel, Rig};

/// Robot's x in the map, metres.
pub const X: usize = 0;
/// Robot's y in the map, metres.
pub const Y: usize = 1;
/// Robot's heading in the map, radians.
pub const THETA: usize = 2;
/// Direction of the wall grid, radians; variance zero until there is a grid.
pub const ALPHA: usize = 3;
const CALIBRATION: usize = 4;

/// How late a reading may be before any tells, 1-sigma, seconds: time-of-flight sensors measure for 20 to 100 ms, and wait
/// to be asked.
const LATENCY_SIGMA_S: f32 = 0.05;

/// Indices of the calibration states; a parameter without an index is known exactly: a factor is 1, a latency none.
#[derive(Clone, Debug)]
pub struct Layout<const S: usize> {
    /// Scale of the left wheel, or of distance.
    pub first_scale: Option<usize>,
    /// Scale of the right wheel, or of turning.
    pub second_scale: Option<usize>,
    /// Factor of the track.
    pub track: Option<usize>,
    /// Gain of each range sensor.
    pub gains: [Option<usize>; S],
    /// Age of the readings that come in metres, seconds.
    pub latency: Option<usize>,
}

impl<const S: usize> Layout<S> {
    /// Gives an index to every parameter that is to be estimated and whose prior is not zero; calls `add` with the prior
    /// mean and sigma of each, in the order of their indices.
    pub fn new(rig: &Rig<S>, config: &Config, mut add: impl FnMut(f32, f32)) -> Self {
        let mut next = CALIBRATION;
        let mut allot = |wanted: bool, mean: f32, sigma: f32| {
            (wanted && sigma > 0.0).then(|| {
                add(mean, sigma);
                next += 1;
                next - 1
            })
        };
        let (scale_sigma, track_sigma) = match rig.drive {
            DriveModel::Wheels { scale_sigma, track_sigma, .. } => (scale_sigma, track_sigma),
            DriveModel::Odometry { scale_sigma, .. } => (scale_sigma, 0.0),
        };
        let first_scale = allot(config.calibrate_scales, 1.0, scale_sigma);
        let second_scale = allot(config.calibrate_scales, 1.0, scale_sigma);
        let track = allot(config.calibrate_track, 1.0, track_sigma);
        let mut gains = [None; S];
        for (gain, sensor) in gains.iter_mut().zip(&rig.sensors) {
            *gain = allot(config.calibrate_gains, 1.0, sensor.gain_sigma);
        }
        let reports_metres = rig.sensors.iter().any(|sensor| matches!(sensor.model, RangeModel::Metric { .. }));
        let latency = allot(config.calibrate_latency && reports_metres, 0.0, LATENCY_SIGMA_S);
        Self { first_scale, second_scale, track, gains, latency }
    }
}
