//! How much the wheels slip beyond what the rig states, learned from what the readings put right.
//!
//! Over a stretch of path the corrections of the heading add up to what the motion got wrong. The filter expects their sum to
//! have the variance that they take away (Mehra 1970, of single innovations; of those a slip is in each a little). Where the
//! square of the sum is larger, the noise of motion is larger than stated.
//!
//! Walls that were drawn before that was known are as badly known as the motion was noisy, and the covariance says so once it is.

use crate::filter::ekf::EkfView;
use crate::filter::layout::{ALPHA, THETA};
use crate::geometry::angle::wrap;
use crate::sensing::noise_level::{Level, Prior};
use crate::walls::decision::relative_variance;

/// Path after which a stretch ends, metres. Beside a wall that two sensors meet, the readings of a second tell the heading again: that is
/// a quarter of a metre, and a slip at the end of a stretch is in the next one.
const STRETCH_M: f32 = 1.0;

/// The factor of the variance of motion that is believed before the robot has driven. A rig states the noise of a clean floor, and slips
/// of half a centimetre a metre, which no encoder tells, are as much again.
const BELIEVED: f32 = 2.0;

/// Wheels slip no less than the rig states; where the variance is a hundred times as large, ten degrees a metre with the default robot,
/// they tell nothing of the heading any more. The factor believed may be e times as large or as small, 1-sigma: 2 / ln^2 e.
const PRIOR: Prior = Prior { limits: [1.0 / BELIEVED, 100.0 / BELIEVED], information: 2.0 };

/// A covariance whose noise of motion was so many times another is as many times another to this power: to the first where motion alone
/// made it, as that of the first walls, and to a half where readings and motion are in balance.
const POWER: f32 = 0.75;

/// The covariance is restated when the factor has changed by so much, as a share.
const CHANGED: f32 = 0.05;

/// The level of the noise of motion, and the corrections of the present stretch.
#[derive(Clone, Copy, Debug)]
pub struct Slippage {
    level: Level,
    /// The level that the covariance is of, and whether it stays so.
    stated: Level,
    is_kept: bool,
    stretch: Stretch,
}

/// What readings corrected along a stretch of path.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    path_m: f32,
    corrected_rad: f32,
    /// What the corrections were expected to be, rad^2, and the noise of motion in it.
    expected_rad2: f32,
    moved_rad2: f32,
}

impl Stretch {
    const NONE: Self = Self { path_m: 0.0, corrected_rad: 0.0, expected_rad2: 0.0, moved_rad2: 0.0 };
}

/// The robot's direction against the grid of walls, or in the map frame until there is one, radians, and its variance: that
/// readings tell, while of the map's own direction they do not.
#[derive(Clone, Copy, Debug)]
pub struct Direction {
    rad: f32,
    variance: f32,
}

impl Direction {
    /// As it is now.
    pub fn of(ekf: &EkfView) -> Self {
        Self { rad: ekf.mean(THETA) - ekf.mean(ALPHA), variance: relative_variance(ekf, THETA, ALPHA) }
    }
}

impl Slippage {
    /// What is believed before the robot has driven.
    pub const BELIEVED: Self =
        Self { level: Level::STATED, stated: Level::STATED, is_kept: false, stretch: Stretch::NONE };

    /// The factor of the variance of motion.
    pub fn factor(&self) -> f32 {
        BELIEVED * self.level.factor()
    }

    /// By how many times the standard deviations of pose and walls are larger than the covariance says, once the factor has turned out to
    /// be another one.
    pub fn restated(&mut self) -> Option<f32> {
        let ratio = self.level.factor() / self.stated.factor();
        if self.is_kept || (ratio - 1.0).abs() < CHANGED {
            return None;
        }
        self.stated = self.level;
        Some(float::powf(ratio, 0.5 * POWER))
    }

    /// A new map begins, whose covariance is of the factor as it is known now.
    pub fn begin_map(&mut self) {
        (self.stated, self.is_kept) = (self.level, false);
    }

    /// The covariance is that of another drive from now on, which knew its own factor.
    pub fn keep(&mut self) {
        self.is_kept = true;
    }

    /// A step of so much path, to whose direction the noise of motion added so much (rad^2).
    pub fn moved(&mut self, path_m: f32, noise_rad2: f32) {
        self.stretch.path_m += path_m;
        self.stretch.moved_rad2 += noise_rad2;
    }

    /// The readings of a step corrected the direction.
    pub fn corrected(&mut self, from: Direction, to: Direction) {
        let stretch = &mut self.stretch;
        stretch.corrected_rad += wrap(to.rad - from.rad);
        stretch.expected_rad2 += (from.variance - to.variance).max(0.0);
        if stretch.path_m < STRETCH_M {
            return;
        }
        let Stretch { corrected_rad, expected_rad2, moved_rad2, .. } = core::mem::replace(stretch, Stretch::NONE);
        let excess = corrected_rad * corrected_rad / expected_rad2 - 1.0;
        // Of what the corrections take away, the motion's noise is so much.
        let share = (moved_rad2 / expected_rad2).min(1.0);
        if excess.is_finite() && share.is_finite() {
            self.level.learn(excess, share, 1.0, &PRIOR);
        }
    }
}
