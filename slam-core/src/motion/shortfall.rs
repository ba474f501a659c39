//! A way whose direction is not known is shorter than it looks.
//!
//! A linear filter moves the robot along its heading and gives the heading's error an effect across it only. Where the heading
//! is known to a third of a radian or less, a robot that drives on is also not as far as it believes, by the mean of one
//! less the cosine: nothing in a home, metres in a hall where no wall is in reach.

/// How much shorter, on average, the way is since a reading last told, metres.
#[derive(Clone, Copy, Debug)]
pub struct Shortfall(f32);

impl Shortfall {
    /// A reading has just told.
    pub const NONE: Self = Self(0.0);

    /// Adds a stretch of path with a heading of this variance (rad^2), and returns by how much the variance along the heading
    /// grows, m^2: the mean square of a squared normal variable is three times the square of its mean.
    pub fn advance(&mut self, path_m: f32, heading_rad2: f32) -> f32 {
        let more_m = path_m * (1.0 - libm::expf(-0.5 * heading_rad2));
        let grown_m2 = 3.0 * more_m * (2.0 * self.0 + more_m);
        self.0 += more_m;
        grown_m2
    }
}
