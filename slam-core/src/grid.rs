//! The home's wall grid: its direction, how it is founded, and which walls stand on it.
//!
//! Every wall is born free or on a grid that exists. The grid is founded by walls that agree with one another on a
//! direction modulo a quarter turn: a first wall alone may be a sofa set askew. A free wall costs one more state and
//! holds the heading just as well, so nothing is lost by waiting.

use crate::angle::{sin_cos, wrap};
use crate::config::WallPolicy;
use crate::ekf::{Ekf, Jacobian};
use crate::layout::ALPHA;
use crate::map::Map;
use crate::wall::{Direction, Wall};
use core::f32::consts::{FRAC_2_PI, FRAC_PI_2, PI};

/// Share of a home's walls that stand on its grid, before any is seen: "mostly parallel or orthogonal".
pub const GRID_SHARE: f32 = 0.9;

/// The same for what is too short to be told from furniture: its direction must be known to a few degrees, or one of the
/// many trials, one with every point, takes a chest that stands askew for a wall.
pub const SHORT_SHARE: f32 = 0.8;

/// Posterior probability at which a wall is called on or off the grid.
const DECISION: f32 = 0.95;

/// Walls of one grid are parallel or orthogonal to within this, radians: a twentieth of a degree.
const GRID_TOLERANCE: f32 = 1e-3;

/// Built walls are to within this: half a degree. Those of the Freiburg offices scatter by 1.7 degrees along the path that
/// is given as true, which has its share of that; up to 0.03 the results there are the same.
pub const BUILT_TOLERANCE: f32 = 0.01;

/// Largest sigma of the angle between two walls that may found the grid, radians: two degrees.
const FOUNDING_SIGMA: f32 = 0.035;

/// Length of the walls that found the grid, metres, together.
const FOUNDING_LENGTH_M: f32 = 1.0;

/// Sine and cosine of the grid direction, taken once a step.
#[derive(Clone, Copy, Debug)]
pub struct GridDirection {
    /// alpha, radians.
    pub alpha_rad: f32,
    /// (sin alpha, cos alpha).
    pub sin_cos: (f32, f32),
}

impl GridDirection {
    /// At the filter's present estimate.
    pub fn of<const NB: usize, const BLOCKS: usize>(ekf: &Ekf<NB, BLOCKS>) -> Self {
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

    /// The number of quarter turns, 0 to 3, of the grid direction nearest to an angle (report eq. 4, counted
    /// counter-clockwise).
    pub fn quarter(&self, theta_rad: f32) -> u8 {
        let quarters = libm::floorf((theta_rad - self.alpha_rad) * (1.0 / FRAC_PI_2) + 0.5);
        (quarters as i32 & 3) as u8
    }

    /// Direction of grid direction `quarter`, radians.
    pub fn beta(&self, quarter: u8) -> f32 {
        crate::angle::wrap(self.alpha_rad + f32::from(quarter) * FRAC_PI_2)
    }
}

/// Logarithm of the odds that a wall `off_rad` from the nearest grid direction, with that variance, stands on the grid:
/// normal density on it, uniform over a quarter turn off it; `share` of such walls do.
fn log_odds(off_rad: f32, variance: f32, share: f32) -> f32 {
    let log_grid = -0.5 * off_rad * off_rad / variance - 0.5 * libm::logf(2.0 * PI * variance);
    log_grid - libm::logf(FRAC_2_PI) + libm::logf(share / (1.0 - share))
}

/// Variance of a wall's direction about the grid's, rad^2, beyond what walls of a perfect grid have.
pub fn deviation(policy: WallPolicy) -> f32 {
    match policy {
        WallPolicy::NearGrid => BUILT_TOLERANCE * BUILT_TOLERANCE,
        _ => 0.0,
    }
}

/// On the grid (true), off it (false), or not clear yet.
pub fn decide(off_rad: f32, variance: f32, share: f32) -> Option<bool> {
    let odds = log_odds(off_rad, variance + GRID_TOLERANCE * GRID_TOLERANCE, share);
    let sure = libm::logf(DECISION / (1.0 - DECISION));
    if odds > sure {
        Some(true)
    } else if odds < -sure {
        Some(false)
    } else {
        None
    }
}

/// Founds the grid where there is none, or takes one free wall into it.
pub fn upkeep<const W: usize, const NB: usize, const BLOCKS: usize>(
    map: &mut Map<W>,
    ekf: &mut Ekf<NB, BLOCKS>,
    has_grid: &mut bool,
    policy: WallPolicy,
    turn: usize,
) {
    if policy == WallPolicy::Free || map.walls().is_empty() {
        return;
    }
    if !*has_grid {
        let Some(theta) = founder(map.walls(), ekf, policy) else { return };
        let mut jacobian = Jacobian::new();
        let _ = jacobian.push((theta, 1.0));
        let direction = ekf.mean(theta);
        let quarters = libm::roundf(direction * (1.0 / FRAC_PI_2));
        ekf.initialise(ALPHA, direction - quarters * FRAC_PI_2, &jacobian, deviation(policy));
        *has_grid = true;
        for index in (0..map.walls().len()).rev() {
            take_in(map, ekf, policy, index);
        }
    } else {
        take_in(map, ekf, policy, turn % map.walls().len());
    }
}

/// Angle between two directions modulo a quarter turn, in (-pi/4, pi/4].
fn off_quarter(a: f32, b: f32) -> f32 {
    let difference = a - b;
    difference - libm::roundf(difference * (1.0 / FRAC_PI_2)) * FRAC_PI_2
}

/// The direction state of the free wall with which the most length of wall agrees, where that is enough and a majority.
fn founder<const NB: usize, const BLOCKS: usize>(
    walls: &[Wall],
    ekf: &Ekf<NB, BLOCKS>,
    policy: WallPolicy,
) -> Option<usize> {
    let mut best: Option<(f32, usize)> = None;
    let mut total_m = 0.0;
    for (i, wall) in walls.iter().enumerate() {
        total_m += wall.length_m();
        let Direction::Free(theta) = wall.direction else { continue };
        let mut support_m = wall.length_m();
        let mut others = 0;
        for (j, other) in walls.iter().enumerate() {
            let Direction::Free(other_theta) = other.direction else { continue };
            if i == j {
                continue;
            }
            let variance = relative_variance(ekf, theta, other_theta);
            let off = off_quarter(ekf.mean(theta), ekf.mean(other_theta));
            let agrees = decide(off, variance + deviation(policy), GRID_SHARE) == Some(true);
            if variance < FOUNDING_SIGMA * FOUNDING_SIGMA && agrees {
                support_m += other.length_m();
                others += 1;
            }
        }
        if others > 0 && support_m >= FOUNDING_LENGTH_M && best.is_none_or(|(most, _)| support_m > most) {
            best = Some((support_m, theta));
        }
    }
    best.filter(|(support_m, _)| *support_m > 0.5 * total_m).map(|(_, theta)| theta)
}

/// Variance of the angle between the directions that two states are, rad^2.
pub fn relative_variance<const NB: usize, const BLOCKS: usize>(ekf: &Ekf<NB, BLOCKS>, i: usize, j: usize) -> f32 {
    (ekf.covariance(i, i) + ekf.covariance(j, j) - 2.0 * ekf.covariance(i, j)).max(0.0)
}

/// Takes a free wall into the grid where the odds are for it.
fn take_in<const W: usize, const NB: usize, const BLOCKS: usize>(
    map: &mut Map<W>,
    ekf: &mut Ekf<NB, BLOCKS>,
    policy: WallPolicy,
    index: usize,
) {
    let Some(Direction::Free(theta)) = map.walls().get(index).map(|w| w.direction) else { return };
    let grid = GridDirection::of(ekf);
    let quarter = grid.quarter(ekf.mean(theta));
    let off = wrap(ekf.mean(theta) - grid.beta(quarter));
    let variance = relative_variance(ekf, theta, ALPHA);
    let on_grid = decide(off, variance + deviation(policy), GRID_SHARE);
    if variance > FOUNDING_SIGMA * FOUNDING_SIGMA || on_grid != Some(true) {
        return;
    }
    // A tie that is numerically impossible leaves the wall free.
    if tie(ekf, theta, off, policy) {
        match policy {
            WallPolicy::NearGrid => map.set_direction(index, Direction::NearGrid(theta, quarter)),
            WallPolicy::Snapped { .. } => map.set_direction(index, Direction::Snapped(theta)),
            _ => {
                map.set_direction(index, Direction::Grid(quarter));
                map.remove_state(ekf, theta);
            }
        }
    }
}

/// The scalar measurement that a wall's direction, `off_rad` from one of the grid's, is that one. False where it is
/// numerically impossible.
pub fn tie<const NB: usize, const BLOCKS: usize>(
    ekf: &mut Ekf<NB, BLOCKS>,
    theta: usize,
    off_rad: f32,
    policy: WallPolicy,
) -> bool {
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((theta, 1.0));
    let _ = jacobian.push((ALPHA, -1.0));
    ekf.update(-off_rad, &jacobian, GRID_TOLERANCE * GRID_TOLERANCE + deviation(policy)).is_ok()
}
