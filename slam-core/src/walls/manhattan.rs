//! The Manhattan frame: the one direction that a home's walls are parallel or orthogonal to (Rousse & Qiu 3.2, eq. 4).

use crate::filter::ekf::EkfView;
use crate::filter::layout::ALPHA;
use crate::geometry::angle::sin_cos;
use core::f32::consts::FRAC_PI_2;

/// Direction of the Manhattan frame with its sine and cosine, taken once a step.
#[derive(Clone, Copy, Debug)]
pub struct ManhattanFrame {
    /// alpha, radians.
    pub alpha_rad: f32,
    /// (sin alpha, cos alpha).
    pub sin_cos: (f32, f32),
}

impl ManhattanFrame {
    /// At the filter's present estimate.
    pub fn of(ekf: &EkfView) -> Self {
        let alpha_rad = ekf.mean(ALPHA);
        Self { alpha_rad, sin_cos: sin_cos(alpha_rad) }
    }

    /// Unit normal of the grid direction `quarter` quarter turns from alpha: exact, no second sine.
    pub fn normal(&self, quarter: u8) -> [f32; 2] {
        let (s, c) = self.sin_cos;
        match quarter & 3 {
            0 => [c, s],
            1 => [-s, c],
            2 => [-c, -s],
            _ => [s, -c],
        }
    }

    /// The number of quarter turns, 0 to 3, of the grid direction nearest to an angle (Rousse & Qiu eq. 4, counted
    /// counter-clockwise).
    pub fn quarter(&self, theta_rad: f32) -> u8 {
        let quarters = libm::floorf((theta_rad - self.alpha_rad) * (1.0 / FRAC_PI_2) + 0.5);
        (quarters as i32 & 3) as u8
    }

    /// Direction of grid direction `quarter`, radians.
    pub fn beta(&self, quarter: u8) -> f32 {
        crate::geometry::angle::wrap(self.alpha_rad + f32::from(quarter) * FRAC_PI_2)
    }
}
