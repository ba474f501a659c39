//! A pose with the sine and cosine of its heading.

use slam_core::Pose;
use slam_core::angle::{sin_cos, wrap};

/// Where a frame is in the map, and how it is turned.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    origin_m: [f32; 2],
    sin: f32,
    cos: f32,
}

impl Frame {
    /// Of a pose.
    pub fn of(pose: &Pose) -> Self {
        let (sin, cos) = sin_cos(pose.theta_rad);
        Self { origin_m: [pose.x_m, pose.y_m], sin, cos }
    }

    /// A direction in this frame, in the map.
    pub fn turn(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    /// A direction in the map, in this frame.
    pub fn turn_back(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        [self.cos * x + self.sin * y, self.cos * y - self.sin * x]
    }

    /// A point in this frame, in the map, metres.
    pub fn point(&self, point_m: [f32; 2]) -> [f32; 2] {
        let [x, y] = self.turn(point_m);
        [self.origin_m[0] + x, self.origin_m[1] + y]
    }

    /// A point in the map, in this frame, metres.
    pub fn seen(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        self.turn_back([x - self.origin_m[0], y - self.origin_m[1]])
    }

    /// A symmetric matrix (xx, xy, yy) in this frame, in the map.
    pub fn scatter(&self, [xx, xy, yy]: [f32; 3]) -> [f32; 3] {
        let (s, c) = (self.sin, self.cos);
        let cross = c * s * (xx - yy) + (c * c - s * s) * xy;
        let twice = 2.0 * c * s * xy;
        [c * c * xx - twice + s * s * yy, cross, s * s * xx + twice + c * c * yy]
    }
}

/// A pose that goes on, step by step, with the sine and cosine of its heading.
#[derive(Clone, Copy, Debug)]
pub struct Moving {
    frame: Frame,
    theta_rad: f32,
}

impl Moving {
    /// No pose yet; every byte is zero.
    pub const NONE: Self = Self { frame: Frame { origin_m: [0.0; 2], sin: 0.0, cos: 0.0 }, theta_rad: 0.0 };

    /// Not gone yet.
    pub const ORIGIN: Self = Self { frame: Frame { origin_m: [0.0; 2], sin: 0.0, cos: 1.0 }, theta_rad: 0.0 };

    /// Goes by so much in its own frame, metres and radians.
    pub fn go_on(&mut self, by_m: [f32; 2], turn_rad: f32) {
        let origin_m = self.point(by_m);
        self.theta_rad = wrap(self.theta_rad + turn_rad);
        let (sin, cos) = sin_cos(self.theta_rad);
        self.frame = Frame { origin_m, sin, cos };
    }

    /// A point in its frame, in the frame that it is given in, metres.
    pub fn point(&self, point_m: [f32; 2]) -> [f32; 2] {
        self.frame.point(point_m)
    }

    /// Where it is.
    pub fn pose(&self) -> Pose {
        let [x_m, y_m] = self.frame.origin_m;
        Pose::new(x_m, y_m, self.theta_rad)
    }
}

/// The product of two directions.
pub fn dot(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

/// `other` in the frame of `pose`, both in one frame.
pub fn relative(pose: &Pose, other: &Pose) -> Pose {
    let apart = [other.x_m - pose.x_m, other.y_m - pose.y_m];
    let [x_m, y_m] = Frame::of(pose).turn_back(apart);
    Pose::new(x_m, y_m, other.theta_rad - pose.theta_rad)
}
