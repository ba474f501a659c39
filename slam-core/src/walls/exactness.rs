//! How likely it is that a wall along the grid stands on it exactly.
//!
//! Homes are of two kinds: in most nearly all walls stand on the grid exactly, in some the partitions or a wing stand askew. Of
//! which kind this one is its walls tell together, and that decides how much each has to say.

use crate::walls::decision::{GRID_SHARE, GRID_TOLERANCE, LOOSE_RAD, density};
use core::f32::consts::FRAC_2_PI;

/// Share of a home's walls along the grid that stand on it exactly, in homes of either kind.
const SHARES: [f32; 2] = [0.97, 0.5];

/// Log of the odds that a home's grid is exact, before any wall tells: 19 homes of 20.
const EXACT_HOMES: f32 = 3.0;

/// Most that the readings of one wall say, as a log: what is expected of them is not known better.
const MOST: f32 = 6.0;

/// How likely the home's grid is exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exactness {
    /// Log of the odds by what walls told that were put onto the grid.
    decided: f32,
    /// The same by all walls.
    told: f32,
}

impl Exactness {
    /// Nothing is told.
    pub const UNKNOWN: Self = Self { decided: 0.0, told: 0.0 };

    /// As it was kept: the log of the odds by what was decided, in quarters.
    pub fn of_quarters(decided: i8) -> Self {
        let decided = 0.25 * f32::from(decided);
        Self { decided, told: decided }
    }

    /// The same, to be kept.
    pub fn quarters(self) -> i8 {
        libm::roundf(4.0 * self.decided) as i8
    }

    /// With what its other walls tell, as logs, beside those that were put onto the grid.
    pub fn with(self, others: impl Iterator<Item = f32>) -> Self {
        Self { told: self.decided + others.sum::<f32>(), ..self }
    }

    /// After one more wall was put onto the grid that told so much, as a log.
    pub fn decided(self, told: f32) -> Self {
        Self { decided: self.decided + told, ..self }
    }

    /// Log of the odds that a wall along the grid stands on it exactly, before its own direction is known.
    fn prior(self) -> f32 {
        let [exact, other] = SHARES;
        let unlike = libm::expf(-(EXACT_HOMES + self.told));
        libm::logf((exact + unlike * other) / (1.0 - exact + unlike * (1.0 - other)))
    }

    /// Log of the odds that a wall stands on the grid exactly whose direction is `off_rad` from the grid's, with that variance, rad^2.
    #[inline(never)]
    pub fn log_odds(self, off_rad: f32, variance: f32) -> f32 {
        self.prior() + evidence(off_rad, variance, 1.0)
    }
}

/// Log of the density of no deviation by what is known of it, against that before, when it was that of so many walls together.
#[inline(never)]
pub fn evidence(off_rad: f32, variance: f32, walls: f32) -> f32 {
    let known = variance + GRID_TOLERANCE * GRID_TOLERANCE;
    let before = walls * LOOSE_RAD * LOOSE_RAD;
    0.5 * libm::logf((before / known).max(1.0)) - 0.5 * off_rad * off_rad / known
}

/// What a wall whose direction is `off_rad` from the grid's, with that variance, says of its home, as a log: the ratio of its
/// likelihoods in homes of either kind. One in ten stands anyhow, and one that stands far off says nothing.
#[inline(never)]
pub fn says(off_rad: f32, variance: f32) -> f32 {
    let odds = libm::expf(evidence(off_rad, variance, 1.0).clamp(-MOST, MOST));
    let along = density(off_rad, LOOSE_RAD * LOOSE_RAD);
    let anyhow = (1.0 / GRID_SHARE - 1.0) * FRAC_2_PI;
    let [exact, other] = SHARES.map(|share| (share * odds + 1.0 - share) * along + anyhow);
    libm::logf(exact / other)
}
