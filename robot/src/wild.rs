//! Inputs that nothing in a home would give, for tests: the same ones on every run.

use slam_core::Pose;

use crate::contact::Contacts;

/// A generator of such inputs.
pub struct Wild(u32);

impl Wild {
    /// From the beginning.
    pub fn new() -> Self {
        Self(1)
    }

    /// The next bits (xorshift, Marsaglia 2003).
    pub fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// True once in so many times.
    pub fn once_in(&mut self, times: u32) -> bool {
        self.bits().is_multiple_of(times)
    }

    /// A number between -1 and 1.
    pub fn share(&mut self) -> f32 {
        (self.bits() % 2001) as f32 * 0.001 - 1.0
    }

    /// A number or none, every other one as a range may be.
    pub fn value(&mut self) -> f32 {
        match self.bits() % 8 {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => f32::from_bits(self.bits()),
            3 => -1.0,
            _ => (self.bits() % 1000) as f32 * 0.005,
        }
    }

    /// A pose of three such numbers.
    pub fn pose(&mut self) -> Pose {
        Pose { x_m: self.value(), y_m: self.value(), theta_rad: self.value() }
    }

    /// Eight such ranges.
    pub fn ranges(&mut self) -> [Option<f32>; 8] {
        [(); 8].map(|()| Some(self.value()))
    }

    /// Bumps now and then.
    pub fn contacts(&mut self) -> Contacts {
        Contacts { bump_left: self.once_in(9), bump_right: self.once_in(9), ..Contacts::default() }
    }
}
