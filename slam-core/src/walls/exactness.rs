//! How likely it is that a wall along the grid stands on it, and how exactly.
//!
//! Homes are of two kinds: in most nearly all walls stand on the grid, in some the partitions or a wing stand askew. Of
//! which kind this one is its walls tell together, and that decides how much each has to say. Furniture stands along the walls, or as it
//! was put: the short walls tell which.

use crate::walls::decision::{GRID_SHARE, LOOSE_RAD, density};
use crate::walls::tolerance::Tolerance;
use core::f32::consts::FRAC_2_PI;

/// Share of a home's walls along the grid that stand on it, in homes of either kind; the same of its furniture.
const SHARES: [f32; 2] = [0.97, 0.5];

/// Log of the odds that a home is of the first kind, before any wall tells: 19 homes of 20.
const STRAIGHT_HOMES: f32 = 3.0;

/// Log of the odds that furniture stands along the walls, before any tells: so that `decision::SHORT_SHARE` of all does.
const STRAIGHT_FURNITURE: f32 = 0.57;

/// From this length on a wall is built rather than put there, metres: few pieces of furniture show a longer side without a break.
const BUILT_M: f32 = 1.5;

/// Most that the readings of one wall say, as a log: what is expected of them is not known better.
const MOST: f32 = 6.0;

/// What is kept of a home whose walls stand as they are built: odds are not so small.
const AS_BUILT: i8 = i8::MIN;

/// How likely a home's walls stand on its grid, and how likely its furniture does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exactness {
    /// By all walls.
    home: Told,
    /// By those that may be furniture.
    furniture: Told,
}

/// What walls told of the kind of home, as the log of the odds that it is an exact one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Told {
    /// Those that were put onto the grid.
    decided: f32,
    /// All of them.
    all: f32,
}

/// What a wall so long says of its home, as a log.
pub struct Says {
    /// Its length, metres.
    pub length_m: f32,
    /// The log of the ratio of its likelihoods in homes of either kind.
    pub log_ratio: f32,
}

impl Told {
    /// After one more wall was put onto the grid.
    fn decided(&mut self, log_ratio: f32) {
        self.decided += log_ratio;
        self.all += log_ratio;
    }

    /// Log of the odds that a wall along the grid stands on it exactly, before its own direction is known.
    fn prior(self, kinds: f32) -> f32 {
        let [exact, other] = SHARES;
        let unlike = libm::expf(-(kinds + self.all));
        libm::logf((exact + unlike * other) / (1.0 - exact + unlike * (1.0 - other)))
    }
}

impl Exactness {
    /// Nothing is told.
    pub const UNKNOWN: Self =
        Self { home: Told { decided: 0.0, all: 0.0 }, furniture: Told { decided: 0.0, all: 0.0 } };

    /// As it was kept: the log of the odds by what was decided, in quarters, or that walls stand as they are built. Furniture is asked anew:
    /// it may have been moved.
    pub fn of_quarters(kept: i8) -> (Self, Option<Tolerance>) {
        if kept == AS_BUILT {
            return (Self::UNKNOWN, Some(Tolerance::Built));
        }
        let decided = 0.25 * f32::from(kept);
        (Self { home: Told { decided, all: decided }, ..Self::UNKNOWN }, None)
    }

    /// The same, to be kept.
    pub fn quarters(self, tolerance: Option<Tolerance>) -> i8 {
        match tolerance {
            Some(Tolerance::Built) => AS_BUILT,
            _ => libm::roundf(4.0 * self.home.decided).max(f32::from(AS_BUILT + 1)) as i8,
        }
    }

    /// With what its other walls tell beside those that were put onto the grid.
    pub fn with(mut self, others: impl Iterator<Item = Says>) -> Self {
        self.home.all = self.home.decided;
        self.furniture.all = self.furniture.decided;
        for says in others {
            self.home.all += says.log_ratio;
            if may_be_furniture(says.length_m) {
                self.furniture.all += says.log_ratio;
            }
        }
        self
    }

    /// After one more wall was put onto the grid that told so much.
    pub fn decided(mut self, says: Says) -> Self {
        self.home.decided(says.log_ratio);
        if may_be_furniture(says.length_m) {
            self.furniture.decided(says.log_ratio);
        }
        self
    }

    /// Log of the odds that a wall so long along the grid stands on it exactly, before its own direction is known: furniture does
    /// where walls and furniture do.
    pub fn prior(self, length_m: f32) -> f32 {
        let home = self.home.prior(STRAIGHT_HOMES);
        if may_be_furniture(length_m) { home.min(self.furniture.prior(STRAIGHT_FURNITURE)) } else { home }
    }
}

/// Whether what is so long may be furniture, which stands as it was put.
fn may_be_furniture(length_m: f32) -> bool {
    length_m < BUILT_M
}

/// What a wall so long says of its home whose direction is `off_rad` from the grid's, where `told` is the log of how many times likelier
/// it is on the grid than about it: the ratio of its likelihoods in homes of either kind. One in ten stands anyhow, and one that stands far
/// off says nothing.
#[inline(never)]
pub fn says(length_m: f32, off_rad: f32, told: f32) -> Says {
    let odds = libm::expf(told.clamp(-MOST, MOST));
    let along = density(off_rad, LOOSE_RAD * LOOSE_RAD);
    let anyhow = (1.0 / GRID_SHARE - 1.0) * FRAC_2_PI;
    let [exact, other] = SHARES.map(|share| (share * odds + 1.0 - share) * along + anyhow);
    Says { length_m, log_ratio: libm::logf(exact / other) }
}
