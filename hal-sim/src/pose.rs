//! A planar pose in double precision: the truth, and what the workbench computes with.

use core::f64::consts::PI;
use slam_core::Pose;

/// A planar pose: metres, radians counter-clockwise in (-pi, pi].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose2 {
    /// x, metres.
    pub x_m: f64,
    /// y, metres.
    pub y_m: f64,
    /// Heading, radians.
    pub theta_rad: f64,
}

/// The angle in (-pi, pi] that equals `angle_rad` modulo a full turn.
pub fn wrap(angle_rad: f64) -> f64 {
    let wrapped = angle_rad - 2.0 * PI * libm::round(angle_rad / (2.0 * PI));
    if wrapped <= -PI { wrapped + 2.0 * PI } else { wrapped }
}

impl Pose2 {
    /// A pose; the heading is wrapped.
    pub fn new(x_m: f64, y_m: f64, theta_rad: f64) -> Self {
        Self { x_m, y_m, theta_rad: wrap(theta_rad) }
    }

    /// A point given in this pose's frame, in the outer frame (metres).
    pub fn transform(&self, point_m: [f64; 2]) -> [f64; 2] {
        let (s, c) = libm::sincos(self.theta_rad);
        [self.x_m + c * point_m[0] - s * point_m[1], self.y_m + s * point_m[0] + c * point_m[1]]
    }

    /// A point of the outer frame, seen from this pose (metres).
    pub fn inverse_transform(&self, point_m: [f64; 2]) -> [f64; 2] {
        let (s, c) = libm::sincos(self.theta_rad);
        let (dx, dy) = (point_m[0] - self.x_m, point_m[1] - self.y_m);
        [c * dx + s * dy, c * dy - s * dx]
    }

    /// `other`, given in the same frame as this pose, in this pose's own frame.
    pub fn relative(&self, other: &Pose2) -> Pose2 {
        let [x_m, y_m] = self.inverse_transform([other.x_m, other.y_m]);
        Pose2::new(x_m, y_m, other.theta_rad - self.theta_rad)
    }

    /// `inner`, which is in this pose's frame, in the frame that this pose is in.
    pub fn compose(&self, inner: &Pose2) -> Pose2 {
        let [x_m, y_m] = self.transform([inner.x_m, inner.y_m]);
        Pose2::new(x_m, y_m, self.theta_rad + inner.theta_rad)
    }

    /// The pose a share (0 to 1) of the way to `to`, the short way round.
    pub fn interpolate(&self, to: &Pose2, share: f64) -> Pose2 {
        Pose2::new(
            self.x_m + share * (to.x_m - self.x_m),
            self.y_m + share * (to.y_m - self.y_m),
            self.theta_rad + share * wrap(to.theta_rad - self.theta_rad),
        )
    }

    /// The same pose in the estimator's precision.
    pub fn to_pose(&self) -> Pose {
        Pose::new(self.x_m as f32, self.y_m as f32, self.theta_rad as f32)
    }
}

impl From<Pose> for Pose2 {
    fn from(pose: Pose) -> Self {
        Self { x_m: pose.x_m.into(), y_m: pose.y_m.into(), theta_rad: pose.theta_rad.into() }
    }
}
