//! How the grid of the home's walls is founded, and how walls are taken into it.
//!
//! Every wall is born free or on a grid that exists. The grid is founded by walls that agree with one another on a
//! direction modulo a quarter turn: a first wall alone may be a sofa set askew. A free wall costs one more state and
//! holds the heading just as well, so nothing is lost by waiting.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::ALPHA;
use crate::geometry::angle::{off_quarter, wrap};
use crate::walls::astray::is_astray;
use crate::walls::decision::{
    GRID_SHARE, SURE, TELLING, decide, decide_by, deviation, evidence, looseness, relative_variance, tie,
};
use crate::walls::exact_grid;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::MapView;
use crate::walls::wall::WallPolicy;
use crate::walls::wall::{Direction, Wall};
use core::f32::consts::FRAC_PI_2;

/// Length of the walls that found the grid, metres, together.
const FOUNDING_LENGTH_M: f32 = 1.0;

/// What walls have to show before a grid is founded by them.
struct Needed {
    /// Largest variance of the angle between two walls that tells anything, rad^2.
    variance: f32,
    /// Logarithm of how many times likelier their directions are of one grid than of none.
    evidence: f32,
}

impl Needed {
    /// A home that may have none is asked for walls whose directions are known: a grid that is none bends all that follows.
    const FIRST: Self = Self { variance: TELLING, evidence: 0.0 };
    /// That a home has one is known where a map before had found it. A robot that lost its place there is often one whose heading nobody
    /// knows to two degrees, and it can be looked for on a grid only; so it is enough that walls tell the more together the less each tells.
    const AGAIN: Self = Self { variance: f32::INFINITY, evidence: SURE };

    fn of(map: &MapView) -> Self {
        if map.is_grid_expected { Self::AGAIN } else { Self::FIRST }
    }
}

/// Founds the grid where there is none, or takes one free wall into it.
pub fn upkeep(map: &mut MapView, ekf: &mut EkfView, policy: WallPolicy, turn: usize) {
    if policy == WallPolicy::Free || map.walls().is_empty() {
        return;
    }
    if !map.has_grid {
        let Some(theta) = founder(map.walls(), ekf, deviation(policy), &Needed::of(map)) else { return };
        let mut jacobian = Jacobian::new();
        let _ = jacobian.push((theta, 1.0));
        let direction = ekf.mean(theta);
        let quarters = libm::roundf(direction * (1.0 / FRAC_PI_2));
        ekf.initialise(ALPHA, direction - quarters * FRAC_PI_2, &jacobian, looseness(policy));
        map.has_grid = true;
        for index in (0..map.walls().len()).rev() {
            take_in(map, ekf, policy, index);
        }
    } else {
        let index = turn % map.walls().len();
        take_in(map, ekf, policy, index);
        if policy == WallPolicy::Grid {
            exact_grid::upkeep(map, ekf, index);
        }
    }
}

/// The direction state of the free wall with which the most length of wall agrees, where that is enough and a majority.
fn founder(walls: &[Wall], ekf: &EkfView, deviation: f32, needed: &Needed) -> Option<usize> {
    let mut best: Option<(f32, usize)> = None;
    let mut total_m = 0.0;
    for (i, wall) in walls.iter().enumerate() {
        total_m += wall.length_m();
        let Direction::Free(theta) = wall.direction else { continue };
        let theta = usize::from(theta);
        let mut support_m = wall.length_m();
        let mut told = 0.0;
        for (j, other) in walls.iter().enumerate() {
            let Direction::Free(other_theta) = other.direction else { continue };
            let other_theta = usize::from(other_theta);
            if i == j {
                continue;
            }
            let variance = relative_variance(ekf, theta, other_theta);
            if variance >= needed.variance {
                continue;
            }
            let off = off_quarter(ekf.mean(theta), ekf.mean(other_theta));
            let nats = evidence(off, variance + deviation);
            if decide_by(nats, GRID_SHARE) == Some(true) {
                support_m += other.length_m();
                told += nats;
            }
        }
        let is_enough = told > needed.evidence && support_m >= FOUNDING_LENGTH_M;
        if is_enough && best.is_none_or(|(most, _)| support_m > most) {
            best = Some((support_m, theta));
        }
    }
    best.filter(|(support_m, _)| *support_m > 0.5 * total_m).map(|(_, theta)| theta)
}

/// Takes a free wall into the grid where the odds are for it: its own, or those of all that stand as it does.
fn take_in(map: &mut MapView, ekf: &mut EkfView, policy: WallPolicy, index: usize) {
    let Some(&wall) = map.walls().get(index) else { return };
    let Direction::Free(state) = wall.direction else { return };
    let theta = usize::from(state);
    let grid = ManhattanFrame::of(ekf);
    let quarter = grid.quarter(ekf.mean(theta));
    let off = wrap(ekf.mean(theta) - grid.beta(quarter));
    let variance = relative_variance(ekf, theta, ALPHA);
    let is_known = variance <= Needed::of(map).variance;
    let stands = is_known && decide(off, variance + deviation(policy), GRID_SHARE) == Some(true);
    // Where each wall keeps a deviation of its own it is tied by half a degree, and the heading turns at once by more than derivatives
    // taken before bear; the method of Rousse & Qiu is left as it is.
    if !stands && (policy != WallPolicy::Grid || !is_astray(map.walls(), ekf, &grid, &wall, (off, variance))) {
        return;
    }
    let looseness = looseness(policy);
    // A tie that is numerically impossible leaves the wall free.
    if tie(ekf, theta, ALPHA, off, looseness) {
        match policy {
            WallPolicy::Snapped { .. } => map.set_direction(index, Direction::Snapped(state)),
            _ if looseness > 0.0 => map.set_direction(index, Direction::NearGrid(state, quarter)),
            _ => {
                map.set_direction(index, Direction::Grid(quarter));
                map.remove_state(ekf, theta);
            }
        }
    }
}
