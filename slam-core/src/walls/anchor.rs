//! The anchor: where the filter's frame lies in the frame of the start pose, and how well that is known.
//!
//! A robot that drives far before it meets its first wall knows that wall well and the start badly. A filter that carries
//! both in one frame knows small things as differences of large ones, which f32 does not hold, and takes the turn of the
//! whole map that later calibration brings for a straight line, which it is not. So there the filter begins anew at the first
//! wall, with its calibration: its frame is the robot's pose of that moment, as in robocentric mapping (Castellanos et al.
//! 2007), and the anchor keeps what was known of that pose.

use crate::filter::ekf::EkfView;
use crate::filter::layout::{self, THETA};
use crate::geometry::angle::sin_cos;
use crate::geometry::pose::Pose;

/// Heading sigma from which on the start is left behind, radians: four degrees. Beyond it a turn differs from its tangent by
/// more than a centimetre in four metres.
const UNKNOWN_RAD: f32 = 0.07;

/// Variance of a pose of which nothing is known, (100 m)^2 and as good as every heading.
const NOWHERE: f32 = 1e4;

/// A pose with its covariance.
#[derive(Clone, Copy, Debug)]
pub struct Anchor {
    /// The pose.
    pub pose: Pose,
    /// Covariance of (x, y, theta): m^2, m rad, rad^2.
    pub covariance: [[f32; 3]; 3],
}

impl Anchor {
    /// The start pose itself.
    pub const START: Self = Self { pose: Pose::ORIGIN, covariance: [[0.0; 3]; 3] };

    /// Whether the start is known so badly that a filter without walls had better begin where it is.
    pub fn is_due(ekf: &EkfView) -> bool {
        ekf.covariance(THETA, THETA) >= UNKNOWN_RAD * UNKNOWN_RAD
    }

    /// Puts the filter's frame where the robot is; `noise` is the variance of (x, y, theta) that it starts with.
    pub fn drop_at(&self, ekf: &mut EkfView, noise: [f32; 3]) -> Self {
        let anchor = self.compose(&layout::pose(ekf), &layout::pose_covariance(ekf));
        let mut start = [[0.0; 3]; 3];
        for (i, variance) in noise.into_iter().enumerate() {
            start[i][i] = variance;
        }
        ekf.predict([0.0; 3], &Default::default(), &start);
        anchor
    }

    /// An anchor where a filter has the robot whose covariance is none: its variances count, where they are any.
    pub fn beyond_doubt(&self, ekf: &EkfView) -> Self {
        let pose = layout::pose(ekf);
        let is_pose = [pose.x_m, pose.y_m, pose.theta_rad].iter().all(|value| value.is_finite());
        let known = layout::pose_covariance(ekf);
        let mut covariance = [[0.0; 3]; 3];
        for (i, row) in covariance.iter_mut().enumerate() {
            let variance = known[i][i];
            row[i] = if is_pose && variance > 0.0 { variance.min(NOWHERE) } else { NOWHERE };
        }
        self.compose(if is_pose { &pose } else { &Pose::ORIGIN }, &covariance)
    }

    /// A pose of this frame, with its covariance there, in the frame of the start pose. The errors of both are taken for
    /// independent. The mean squares are those of an arm that is turned by a normally distributed angle, not by its
    /// tangent.
    pub fn compose(&self, pose: &Pose, covariance: &[[f32; 3]; 3]) -> Self {
        let (s, c) = sin_cos(self.pose.theta_rad);
        let rotate = |[x, y, theta]: [f32; 3]| [c * x - s * y, s * x + c * y, theta];
        let arm = rotate([pose.x_m, pose.y_m, 0.0]);
        let across = [-arm[1], arm[0], 0.0];
        let turn = TurnMoments::of(self.covariance[2][2]);
        let half = covariance.map(rotate);
        let mut sum = self.covariance;
        for i in 0..3 {
            let column = rotate([half[0][i], half[1][i], half[2][i]]);
            for j in 0..3 {
                let (by_i, by_j) = (self.covariance[i][2], self.covariance[j][2]);
                sum[j][i] += column[j] + turn.along2 * arm[i] * arm[j] + turn.across2 * across[i] * across[j];
                sum[j][i] += turn.shrink * (by_i * across[j] + by_j * across[i]);
            }
        }
        // The two halves are rounded apart.
        let covariance = core::array::from_fn(|i| core::array::from_fn(|j| sum[i.min(j)][i.max(j)]));
        Self { pose: self.pose.compose(pose), covariance }
    }
}

/// Moments of a normally distributed angle.
struct TurnMoments {
    /// Mean of its cosine.
    shrink: f32,
    /// Mean square of one less its cosine.
    along2: f32,
    /// Mean square of its sine.
    across2: f32,
}

impl TurnMoments {
    fn of(variance: f32) -> Self {
        let shrink = libm::expf(-0.5 * variance);
        // The closed form of the first loses all digits where the angle is small.
        if variance < 0.01 {
            return Self { shrink, along2: 0.75 * variance * variance, across2: variance };
        }
        let fourth = shrink * shrink * shrink * shrink;
        Self { shrink, along2: 1.5 - 2.0 * shrink + 0.5 * fourth, across2: 0.5 - 0.5 * fourth }
    }
}
