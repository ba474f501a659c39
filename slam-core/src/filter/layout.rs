//! Which state stands where: names for the indices.
//!
//! `[x, y, theta, alpha, motion calibration (0 to 3), gains (0 to S), latency (0 or 1), offset of the row (0 or 1), walls ...]`

use crate::filter::ekf::EkfView;
use crate::geometry::matrix::Matrix;
use crate::geometry::pose::Pose;

/// Robot's x in the map, metres.
pub const X: usize = 0;
/// Robot's y in the map, metres.
pub const Y: usize = 1;
/// Robot's heading in the map, radians.
pub const THETA: usize = 2;
/// Direction of the wall grid, radians; variance zero until there is a grid.
pub const ALPHA: usize = 3;
/// The pose's states.
pub const POSE: [Option<usize>; 3] = [Some(X), Some(Y), Some(THETA)];

/// The estimated pose in the filter's frame.
pub fn pose(ekf: &EkfView) -> Pose {
    Pose { x_m: ekf.mean(X), y_m: ekf.mean(Y), theta_rad: ekf.mean(THETA) }
}

/// Covariance of the pose in the filter's frame: m^2, m rad, rad^2.
pub fn pose_covariance(ekf: &EkfView) -> Matrix {
    covariances(ekf, &POSE, &POSE)
}

/// Covariances of some states with others. What is known is no state, and goes with nothing.
#[inline(never)]
pub fn covariances(ekf: &EkfView, some: &[Option<usize>; 3], others: &[Option<usize>; 3]) -> Matrix {
    some.map(|state| others.map(|other| covariance(ekf, state, other)))
}

#[inline(never)]
fn covariance(ekf: &EkfView, a: Option<usize>, b: Option<usize>) -> f32 {
    a.zip(b).map_or(0.0, |(i, j)| ekf.covariance(i, j))
}
