//! A planar pose.

use crate::geometry::angle::{sin_cos, wrap};

/// Position and heading of one planar frame in another: metres and radians, heading counter-clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pose {
    /// x in the outer frame, metres.
    pub x_m: f32,
    /// y in the outer frame, metres.
    pub y_m: f32,
    /// Heading in the outer frame, radians in (-pi, pi].
    pub theta_rad: f32,
}

impl Pose {
    /// The outer frame itself.
    pub const ORIGIN: Self = Self { x_m: 0.0, y_m: 0.0, theta_rad: 0.0 };

    /// A pose from its three coordinates; the heading is wrapped.
    pub fn new(x_m: f32, y_m: f32, theta_rad: f32) -> Self {
        Self { x_m, y_m, theta_rad: wrap(theta_rad) }
    }

    /// The pose that `inner`, given in this pose's frame, has in the outer frame.
    // Inlined, the sines of so many places take kilobytes of flash.
    #[inline(never)]
    pub fn compose(&self, inner: &Pose) -> Pose {
        let [x_m, y_m] = self.transform([inner.x_m, inner.y_m]);
        Pose::new(x_m, y_m, self.theta_rad + inner.theta_rad)
    }

    /// The outer frame seen from this pose: `p.compose(&p.inverse())` is the identity.
    #[inline(never)]
    pub fn inverse(&self) -> Pose {
        let (s, c) = sin_cos(self.theta_rad);
        Pose::new(-c * self.x_m - s * self.y_m, s * self.x_m - c * self.y_m, -self.theta_rad)
    }

    /// A point given in this pose's frame, in the outer frame (metres).
    pub fn transform(&self, point_m: [f32; 2]) -> [f32; 2] {
        let (s, c) = sin_cos(self.theta_rad);
        [self.x_m + c * point_m[0] - s * point_m[1], self.y_m + s * point_m[0] + c * point_m[1]]
    }
}

/// Length of a vector. `libm` computes it in f64, which a Cortex-M4F has only in software, two kilobytes of it.
pub fn length(x: f32, y: f32) -> f32 {
    float::sqrtf(x * x + y * y)
}
