//! The anchor: where the filter's frame lies in the frame of the start pose, and how well that is known.
//!
//! A robot that drives far before it meets its first wall knows that wall well and the start badly. A filter that carries
//! both in one frame knows small things as differences of large ones, which f32 does not hold, and takes the turn of the
//! whole map that later calibration brings for a straight line, which it is not. So there the filter begins anew at the first
//! wall, with its calibration: its frame is the robot's pose of that moment, as in robocentric mapping (Castellanos et al.
//! 2007), and the anchor keeps what was known of that pose. What later readings tell of the calibration moves it.

use crate::filter::ekf::EkfView;
use crate::filter::layout::{self, THETA};
use crate::geometry::matrix::{Matrix, Triangle, diagonal, propagated, rotation, sum};
use crate::geometry::pose::Pose;
use crate::motion::drive::DriveStates;
use crate::walls::hindsight::Hindsight;

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
    /// Covariance of (x, y, theta) beyond what the calibration's errors add: m^2, m rad, rad^2.
    pub covariance: Triangle,
    /// What the calibration tells of it.
    pub hindsight: Hindsight,
}

impl Anchor {
    /// The start pose itself.
    pub const START: Self = Self::new(Pose::ORIGIN, [[0.0; 3]; 3]);

    /// Of which the calibration tells nothing.
    pub const fn new(pose: Pose, covariance: Matrix) -> Self {
        Self { pose, covariance: Triangle::of(&covariance), hindsight: Hindsight::NONE }
    }

    /// Whether the start is known so badly that a filter without walls had better begin where it is.
    pub fn is_due(ekf: &EkfView) -> bool {
        ekf.covariance(THETA, THETA) >= UNKNOWN_RAD * UNKNOWN_RAD
    }

    /// Puts the filter's frame where the robot is; `noise` is the variance of (x, y, theta) that it starts with.
    #[inline(never)]
    pub fn drop_at(&self, ekf: &mut EkfView, noise: [f32; 3], states: &DriveStates) -> Self {
        let pose = layout::pose(ekf);
        let (hindsight, covariance) = Hindsight::of_pose(ekf, states);
        let covariance = Triangle::of(&self.covariance_beyond(&self.covariance.matrix(), &pose, &covariance));
        let hindsight = hindsight.within(&self.hindsight, &self.pose, &pose);
        ekf.predict([0.0; 3], &Default::default(), &diagonal(noise));
        Self { pose: self.pose.compose(&pose), covariance, hindsight }
    }

    /// Where a filter has the robot whose covariance is none: its variances count, where they are any.
    pub fn beyond_doubt(ekf: &EkfView) -> ([f32; 3], Matrix) {
        let pose = [0, 1, 2].map(|i| ekf.mean(i));
        if !pose.iter().all(|value| value.is_finite()) {
            return ([0.0; 3], diagonal([NOWHERE; 3]));
        }
        let variances = [0, 1, 2].map(|i| ekf.covariance(i, i));
        let known = variances.map(|variance| if variance > 0.0 { variance.min(NOWHERE) } else { NOWHERE });
        (pose, diagonal(known))
    }

    /// Its whole covariance, as the calibration is known now.
    #[inline(never)]
    pub fn whole_covariance(&self, ekf: &EkfView, states: &DriveStates) -> Matrix {
        sum(&self.covariance.matrix(), &self.hindsight.covariance(ekf, states), 1.0)
    }

    /// Goes where the calibration, as it is known now, tells that it is.
    pub fn follow(&mut self, ekf: &EkfView, states: &DriveStates) {
        let [x_m, y_m, turn_rad] = self.hindsight.follow(ekf, states);
        self.pose.x_m += x_m;
        self.pose.y_m += y_m;
        self.pose.theta_rad += turn_rad;
    }

    /// Covariance in the frame of the start pose of a pose of this frame, by this one's covariance and that one's own. The errors of both are
    /// taken for independent. The mean squares are those of an arm that is turned by a normally distributed angle, not by its tangent.
    #[inline(never)]
    pub fn covariance_beyond(&self, known: &Matrix, pose: &Pose, covariance: &Matrix) -> Matrix {
        let rotation = rotation(self.pose.theta_rad);
        let arm = rotation.map(|row| row[0] * pose.x_m + row[1] * pose.y_m);
        let across = [-arm[1], arm[0], 0.0];
        let turn = TurnMoments::of(known[2][2]);
        let mut sum = sum(known, &propagated(&rotation, covariance), 1.0);
        for i in 0..3 {
            for j in 0..3 {
                let (by_i, by_j) = (known[i][2], known[j][2]);
                sum[i][j] += turn.along2 * arm[i] * arm[j] + turn.across2 * across[i] * across[j];
                sum[i][j] += turn.shrink * (by_i * across[j] + by_j * across[i]);
            }
        }
        // The two halves are rounded apart.
        Triangle::of(&sum).matrix()
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
