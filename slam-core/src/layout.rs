//! Which state stands where: names for the indices.
//!
//! `[x, y, theta, alpha, motion calibration (0 to 3), gains (0 to S), walls ...]`

use crate::{Config, DriveModel, Rig};

/// Robot's x in the map, metres.
pub const X: usize = 0;
/// Robot's y in the map, metres.
pub const Y: usize = 1;
/// Robot's heading in the map, radians.
pub const THETA: usize = 2;
/// Direction of the wall grid, radians; variance zero until there is a grid.
pub const ALPHA: usize = 3;
const CALIBRATION: usize = 4;

/// Indices of the calibration states; a parameter without an index is known exactly and is 1.
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
}

impl<const S: usize> Layout<S> {
    /// Gives an index to every parameter that is to be estimated and whose prior is not zero; calls `add` with the prior
    /// sigma of each, in the order of their indices.
    pub fn new(rig: &Rig<S>, config: &Config, mut add: impl FnMut(f32)) -> Self {
        let mut next = CALIBRATION;
        let mut allot = |wanted: bool, sigma: f32| {
            (wanted && sigma > 0.0).then(|| {
                add(sigma);
                next += 1;
                next - 1
            })
        };
        let (scale_sigma, track_sigma) = match rig.drive {
            DriveModel::Wheels { scale_sigma, track_sigma, .. } => (scale_sigma, track_sigma),
            DriveModel::Odometry { scale_sigma, .. } => (scale_sigma, 0.0),
        };
        let first_scale = allot(config.calibrate_scales, scale_sigma);
        let second_scale = allot(config.calibrate_scales, scale_sigma);
        let track = allot(config.calibrate_track, track_sigma);
        let mut gains = [None; S];
        for (gain, sensor) in gains.iter_mut().zip(&rig.sensors) {
            *gain = allot(config.calibrate_gains, sensor.gain_sigma);
        }
        Self { first_scale, second_scale, track, gains }
    }
}
