//! The measurement model: what a beam should read on a wall, with exact derivatives.
//!
//! Eq. 1 of Rousse & Qiu with its sign put right and the sensor anywhere on the robot:
//! `h = g (rho - o . n) / cos(beta - phi)` for a beam from o in direction phi, and a sensor of gain g.

use crate::geometry::angle::sin_cos;
use crate::geometry::line::Line;
use crate::rig::Mount;

/// A mount with the sine and cosine of its bearing.
#[derive(Clone, Copy, Debug)]
pub struct FixedMount {
    origin_m: [f32; 2],
    sin_cos: (f32, f32),
}

impl FixedMount {
    /// Nowhere, for an estimator that has not started.
    pub const NONE: Self = Self { origin_m: [0.0; 2], sin_cos: (0.0, 0.0) };

    /// From the rig.
    pub fn new(mount: &Mount) -> Self {
        Self { origin_m: [mount.x_m, mount.y_m], sin_cos: sin_cos(mount.bearing_rad) }
    }

    /// Sine of its beam's bearing.
    pub fn sin(&self) -> f32 {
        self.sin_cos.0
    }

    /// How far along its beam it is beyond a point so far to the left of the axle's centre, both metres.
    pub fn along_m(&self, left_m: f32) -> f32 {
        let ([x, y], (s, c)) = (self.origin_m, self.sin_cos);
        c * x + s * (y - left_m)
    }

    /// As it was `turn_rad` and `moved_m` (in the robot's present frame) ago: a reading of age is a reading of now from
    /// a mount that lags behind. First order in the turn, which is a small one.
    pub fn lagging(&self, moved_m: [f32; 2], turn_rad: f32) -> Self {
        let [x, y] = self.origin_m;
        let (s, c) = self.sin_cos;
        let (s, c) = (s - turn_rad * c, c + turn_rad * s);
        // Keeps the direction a unit vector to second order.
        let norm = 1.0 - 0.5 * turn_rad * turn_rad;
        Self { origin_m: [x + turn_rad * y - moved_m[0], y - turn_rad * x - moved_m[1]], sin_cos: (s * norm, c * norm) }
    }

    /// The beam of a robot at `position_m` with this sine and cosine of its heading, in the map.
    pub fn beam(&self, position_m: [f32; 2], (sin, cos): (f32, f32)) -> Beam {
        let [x, y] = self.origin_m;
        let (ms, mc) = self.sin_cos;
        let arm = [cos * x - sin * y, sin * x + cos * y];
        Beam {
            arm,
            origin: [position_m[0] + arm[0], position_m[1] + arm[1]],
            direction: [cos * mc - sin * ms, sin * mc + cos * ms],
        }
    }
}

/// A beam in the map frame.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// From the robot's position to the beam's origin, metres.
    pub arm: [f32; 2],
    /// Where it starts, metres.
    pub origin: [f32; 2],
    /// Unit vector.
    pub direction: [f32; 2],
}

/// Predicted range on a wall and its derivatives by the quantities of the model.
#[derive(Clone, Copy, Debug)]
pub struct Prediction {
    /// True range, metres (without the gain).
    pub range_m: f32,
    /// d(range)/dx and dy.
    pub by_position: [f32; 2],
    /// d(range)/dtheta of the robot.
    pub by_heading: f32,
    /// d(range)/dbeta.
    pub by_beta: f32,
    /// d(range)/drho.
    pub by_rho: f32,
}

impl Beam {
    /// The point at a range along the beam.
    pub fn at(&self, range_m: f32) -> [f32; 2] {
        [self.origin[0] + range_m * self.direction[0], self.origin[1] + range_m * self.direction[1]]
    }

    /// Cosine of the incidence angle on a wall; positive where the beam runs into the side that can be seen.
    pub fn cos_incidence(&self, line: &Line) -> f32 {
        line.normal[0] * self.direction[0] + line.normal[1] * self.direction[1]
    }

    /// The range at which the beam meets a line, with derivatives. The incidence cosine must not be zero.
    pub fn predict(&self, line: &Line) -> Prediction {
        let [nx, ny] = line.normal;
        let cos = self.cos_incidence(line);
        // sin(beta - phi)
        let sin = ny * self.direction[0] - nx * self.direction[1];
        let inverse = 1.0 / cos;
        let range_m = line.distance(self.origin) * inverse;
        // The arm turns with the robot: d(arm)/dtheta = (-arm_y, arm_x).
        let arm_turn = nx * -self.arm[1] + ny * self.arm[0];
        Prediction {
            range_m,
            by_position: [-nx * inverse, -ny * inverse],
            by_heading: (-arm_turn - range_m * sin) * inverse,
            by_beta: (-line.along(self.origin) + range_m * sin) * inverse,
            by_rho: inverse,
        }
    }
}
