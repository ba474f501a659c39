//! How closely walls stand on the grid: a sigma of their directions about it that is halved or doubled.

/// 1-sigma of a wall's direction about the grid's before any tells, radians: half a degree, as built walls are.
const START_RAD: f32 = 0.008;

/// Number of halvings at which the grid counts as exact.
const EXACT: i8 = 3;
/// Number of halvings at the loosest, two degrees: doublings are negative.
const LOOSEST: i8 = -2;

/// How closely walls stand on the grid: the more, the closer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Squareness {
    halvings: i8,
}

impl Squareness {
    /// Not known yet.
    pub const UNKNOWN: Self = Self { halvings: 0 };

    /// So many halvings of the first sigma; doublings where negative.
    pub fn of_halvings(halvings: i8) -> Self {
        Self { halvings: halvings.clamp(LOOSEST, EXACT) }
    }

    /// Halvings of the first sigma; doublings where negative.
    pub fn halvings(self) -> i8 {
        self.halvings
    }

    /// The grid is exact.
    pub fn is_exact(self) -> bool {
        self.halvings >= EXACT
    }

    /// Variance of a wall's direction about the grid's, rad^2; zero where the grid is exact.
    pub fn deviation(self) -> f32 {
        if self.is_exact() { 0.0 } else { self.variance() }
    }

    /// Variance of a wall's direction about the grid's as it is learned, rad^2; not zero where the grid is exact, either.
    pub fn variance(self) -> f32 {
        let mut sigma = 4.0 * START_RAD;
        for _ in LOOSEST..self.halvings {
            sigma *= 0.5;
        }
        sigma * sigma
    }

    /// The next closer one, up to an exact grid.
    pub fn halved(self) -> Self {
        Self { halvings: (self.halvings + 1).min(EXACT) }
    }

    /// The next looser one, up to two degrees.
    pub fn doubled(self) -> Self {
        Self { halvings: (self.halvings - 1).max(LOOSEST) }
    }
}
