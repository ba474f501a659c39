//! Dead reckoning with the calibration as estimated: the frame of the outlier buffer, in which nothing jumps but a robot that
//! turns out to have driven the other way.

use crate::geometry::angle::sin_cos;
use crate::geometry::pose::Pose;
use crate::motion::step::Step;

/// Derivatives of a point by the three calibration factors of the drive, metres.
pub type ByFactor = [[f32; 2]; 3];

/// Where the robot is by its motion input, how far it came, and how that depends on noise and calibration.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeadReckoning {
    /// Pose in the odometry frame.
    pub pose: Pose,
    /// Length of the path, metres.
    pub path_m: f32,
    /// Variance of the position since the start, each axis, m^2.
    pub position_variance: f32,
    /// Variance of the heading since the start, rad^2.
    pub heading_variance: f32,
    /// Derivatives of the position by the factors.
    position_by_factor: ByFactor,
    /// Derivatives of the heading by the factors, radians.
    heading_by_factor: [f32; 3],
}

impl DeadReckoning {
    /// At the start.
    pub const START: Self = Self {
        pose: Pose::ORIGIN,
        path_m: 0.0,
        position_variance: 0.0,
        heading_variance: 0.0,
        position_by_factor: [[0.0; 2]; 3],
        heading_by_factor: [0.0; 3],
    };

    /// Moves on by one step.
    pub fn advance(&mut self, step: &Step) {
        let (s, c) = sin_cos(self.pose.theta_rad);
        let rotate = |v: [f32; 2]| [c * v[0] - s * v[1], s * v[0] + c * v[1]];
        let moved = rotate([step.increment.forward_m, step.increment.left_m]);
        for ((position, heading), by) in
            self.position_by_factor.iter_mut().zip(&mut self.heading_by_factor).zip(&step.by_factor)
        {
            let direct = rotate([by[0], by[1]]);
            position[0] += direct[0] - *heading * moved[1];
            position[1] += direct[1] + *heading * moved[0];
            *heading += by[2];
        }
        self.pose = step.applied_to(&self.pose);
        self.path_m += step.path_m;
        self.position_variance += 0.5 * (step.noise[0][0] + step.noise[1][1]);
        self.heading_variance += step.noise[2][2];
    }

    /// Counts path, variances and derivatives from here; returns what they were.
    pub fn count_anew(&mut self) -> Self {
        let here = Self { pose: self.pose, ..Self::START };
        core::mem::replace(self, here)
    }

    /// Moves the position, and makes it less certain by a 1-sigma vector, metres: the motion so far turns out to have been another.
    pub fn displace(&mut self, moved_m: [f32; 2], sigma_m: [f32; 2]) {
        let Pose { x_m, y_m, theta_rad } = self.pose;
        self.pose = Pose { x_m: x_m + moved_m[0], y_m: y_m + moved_m[1], theta_rad };
        self.position_variance += 0.5 * (sigma_m[0] * sigma_m[0] + sigma_m[1] * sigma_m[1]);
    }

    /// Derivatives of a point that is fixed to the robot now, by the factors.
    pub fn by_factor(&self, point_m: [f32; 2]) -> ByFactor {
        let arm = [point_m[0] - self.pose.x_m, point_m[1] - self.pose.y_m];
        let mut out = self.position_by_factor;
        for (position, heading) in out.iter_mut().zip(self.heading_by_factor) {
            position[0] -= heading * arm[1];
            position[1] += heading * arm[0];
        }
        out
    }
}
