//! A wall of the map: where its states are, and what is kept about it outside the filter.

use crate::filter::ekf::EkfView;
use crate::filter::layout::ALPHA;
use crate::geometry::angle::sin_cos;
use crate::geometry::line::Line;
use crate::walls::manhattan::ManhattanFrame;

/// Which kinds of wall the map may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WallPolicy {
    /// Every wall is a free line (rho, theta): Rousse & Qiu 3.1.
    Free,
    /// Every wall is a line (rho, theta) whose direction is snapped to the grid (Rousse & Qiu 3.2, eqs. 2-4).
    Snapped {
        /// Also move theta_i with the innovation, dh/dtheta_i = dh/dalpha, as eq. 5 can be read; otherwise
        /// dh/dtheta_i = 0, which is what beta(alpha) in eq. 3 gives.
        theta_moves: bool,
    },
    /// Walls on the grid have rho alone; lines that the data put off the grid are free.
    #[default]
    Grid,
    /// The same, but a wall on the grid may stand off its direction by half a degree, as built walls do: (rho, theta).
    NearGrid,
}

/// Points this far apart along a line are of one wall: the gap is too narrow for a door, metres. Doors start at 0.6 m.
pub const GAP_M: f32 = 0.4;

/// How a wall is represented in the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WallKind {
    /// rho and theta are states.
    Free,
    /// rho and theta are states; the direction used is the grid's nearest to theta.
    Snapped,
    /// rho is a state; the direction is alpha plus a whole number of quarter turns, but for a deviation where walls may
    /// have one.
    Grid,
}

/// Where a wall's direction comes from.
/// Indices of states have two bytes, since there are many walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The grid direction nearest to the state with this index (Rousse & Qiu eq. 4).
    Snapped(u16),
    /// The state with this index.
    Free(u16),
    /// The state with this index, which was tied to alpha plus that many quarter turns.
    NearGrid(u16, u8),
    /// The same, tied as closely as built walls stand on their grid.
    Built(u16, u8),
    /// alpha plus this many quarter turns, counter-clockwise, 0 to 3.
    Grid(u8),
}

impl Direction {
    /// The index of its own state, if it has one.
    pub fn state(self) -> Option<usize> {
        match self {
            Self::Free(theta) | Self::Snapped(theta) | Self::NearGrid(theta, _) | Self::Built(theta, _) => {
                Some(usize::from(theta))
            }
            Self::Grid(_) => None,
        }
    }

    /// The index of the state that turns it: its own, or alpha for what the grid holds.
    pub fn turns_with(self) -> usize {
        match self {
            Self::Free(theta) | Self::NearGrid(theta, _) | Self::Built(theta, _) => usize::from(theta),
            Self::Grid(_) | Self::Snapped(_) => ALPHA,
        }
    }

    /// The grid direction that it was found to be, counted in quarter turns from alpha.
    pub fn quarter(self) -> Option<u8> {
        match self {
            Self::Grid(quarter) | Self::NearGrid(_, quarter) | Self::Built(_, quarter) => Some(quarter),
            Self::Free(_) | Self::Snapped(_) => None,
        }
    }
}

/// A wall. Its normal points from the side it was seen from into the wall, so rho - p . n is positive for a robot at p
/// that can see it: the two faces of a partition are two walls.
#[derive(Clone, Copy, Debug)]
pub struct Wall {
    /// Identifier, never used again.
    pub id: u16,
    /// State index of rho; two bytes, since there are many walls.
    pub(crate) rho: u16,
    /// Where the direction comes from.
    pub direction: Direction,
    /// Start of the observed extent along (-sin beta, cos beta), metres.
    pub lo_m: f32,
    /// End of the observed extent, metres.
    pub hi_m: f32,
    /// Readings that updated it.
    pub updates: u32,
    /// Confidence in its existence: up with readings that meet it, down with those that pass through.
    pub score: i8,
    /// Path length at which it was last seen, metres.
    pub seen_at_m: f32,
    /// Its normal when it was born or taken anew: at which its readings are differentiated.
    pub(crate) first_normal: [f32; 2],
    /// Its line in the map frame when it was first drawn, where walls hold that frame: rho in metres, beta in radians.
    pub drawn: Option<[f32; 2]>,
}

impl Wall {
    /// A wall without states or extent.
    pub const NEW: Self = Self {
        id: 0,
        rho: 0,
        direction: Direction::Grid(0),
        lo_m: 0.0,
        hi_m: 0.0,
        updates: 0,
        score: 0,
        seen_at_m: 0.0,
        first_normal: [1.0, 0.0],
        drawn: None,
    };

    /// A wall whose rho is this state, with this direction and extent along it, metres.
    pub const fn at(rho: usize, direction: Direction, (lo_m, hi_m): (f32, f32)) -> Self {
        Self { rho: rho as u16, direction, lo_m, hi_m, ..Self::NEW }
    }

    /// Index of the state that is its rho.
    pub fn rho(&self) -> usize {
        usize::from(self.rho)
    }

    /// Sets that.
    pub fn set_rho(&mut self, state: usize) {
        self.rho = state as u16;
    }

    /// Its line at the filter's present estimate.
    pub fn line(&self, ekf: &EkfView, grid: &ManhattanFrame) -> Line {
        let rho_m = ekf.mean(self.rho());
        let on_grid = |quarter| Line { rho_m, beta_rad: grid.beta(quarter), normal: grid.normal(quarter) };
        match self.direction {
            Direction::Grid(quarter) => on_grid(quarter),
            Direction::Snapped(theta) => on_grid(grid.quarter(ekf.mean(usize::from(theta)))),
            Direction::Free(theta) | Direction::NearGrid(theta, _) | Direction::Built(theta, _) => {
                let beta_rad = ekf.mean(usize::from(theta));
                let (s, c) = sin_cos(beta_rad);
                Line { rho_m, beta_rad, normal: [c, s] }
            }
        }
    }

    /// The direction of its normal at the filter's present estimate, radians: what [`Wall::line`] has, without a sine.
    pub fn beta_rad(&self, ekf: &EkfView) -> f32 {
        let grid = ManhattanFrame::of(ekf);
        match self.direction {
            Direction::Grid(quarter) => grid.beta(quarter),
            Direction::Snapped(theta) => grid.beta(grid.quarter(ekf.mean(usize::from(theta)))),
            Direction::Free(theta) | Direction::NearGrid(theta, _) | Direction::Built(theta, _) => {
                ekf.mean(usize::from(theta))
            }
        }
    }

    /// States that it has.
    pub fn states(&self) -> usize {
        1 + usize::from(self.direction.state().is_some())
    }

    /// Length of its observed extent, metres.
    pub fn length_m(&self) -> f32 {
        self.hi_m - self.lo_m
    }

    /// Its representation.
    pub fn kind(&self) -> WallKind {
        match self.direction {
            Direction::Free(_) => WallKind::Free,
            Direction::Snapped(_) => WallKind::Snapped,
            Direction::Grid(_) | Direction::NearGrid(..) | Direction::Built(..) => WallKind::Grid,
        }
    }

    /// Follows a state that moved from index `from` to `to`.
    pub fn follow(&mut self, from: usize, to: usize) {
        if self.rho() == from {
            self.set_rho(to);
        }
        if let Direction::Free(theta)
        | Direction::Snapped(theta)
        | Direction::NearGrid(theta, _)
        | Direction::Built(theta, _) = &mut self.direction
            && usize::from(*theta) == from
        {
            *theta = to as u16;
        }
    }
}
