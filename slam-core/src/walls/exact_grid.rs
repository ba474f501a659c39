//! Walls are tied to the grid as closely as the home's walls stand on it once readings tell that they do, not when they are found.
//!
//! A line that is found along the grid is known to two degrees or so, and a partition that stands three degrees askew looks like one
//! on the grid. Forced onto it, it bends the heading, and makes it surer than it is. So a wall is tied to the grid loosely first and
//! has a direction of its own. When readings have made that known, the odds that it is the grid's are what they say for no deviation
//! against any, or for one such as built walls have (`walls/tolerance.rs`), times those before them. A tie that comes late tells as much as
//! one at birth would have: the covariance passes it on. A wall that stands on an exact grid needs no direction of its own any more.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::ALPHA;
use crate::geometry::angle::{off_quarter, wrap};
use crate::walls::decision::{GRID_TOLERANCE, LOOSE_RAD, SURE, relative_variance, tie};
use crate::walls::exactness::{Exactness, says};
use crate::walls::map::MapView;
use crate::walls::tolerance::{BUILT_RAD, Deviation, Tolerance, built_rather_than_exact, further};
use crate::walls::wall::{Direction, Wall};
use core::f32::consts::FRAC_PI_2;

/// Log of the odds that two walls both stand exactly on an exact grid that is not founded yet: each does in nine cases of ten.
const BOTH: f32 = 1.45;

/// Least length of a wall that tells of the home, metres: shorter ones are of things that stand as they were put.
const TELLING_M: f32 = 0.5;

/// States of two walls: where no more is left, what is likelier is enough.
const RESERVE: usize = 4;

/// Judges the home once a round, and decides of wall `index`.
#[inline(never)]
pub fn upkeep(map: &mut MapView, ekf: &mut EkfView, index: usize) {
    let is_full = ekf.len() + RESERVE > ekf.capacity();
    let enough = if is_full { 0.0 } else { SURE };
    if index == 0 {
        map.tolerance = map.tolerance.or_else(|| tolerance(map, ekf, enough));
        map.exactness = judged(map, ekf);
    }
    let Some((theta, quarter)) = map.walls().get(index).and_then(of_near_wall) else { return };
    let is_exact = map.tolerance == Some(Tolerance::Exact);
    if is_exact && !map.walls().iter().any(is_decided) {
        found(map, ekf, (index, theta, quarter), enough);
        return;
    }
    let Some(&wall) = map.walls().get(index) else { return };
    let Some(deviation) = Deviation::of(ekf, &wall) else { return };
    let length_m = wall.length_m();
    let prior = map.exactness.prior(length_m);
    if is_exact {
        let told = deviation.told(GRID_TOLERANCE);
        if prior + told > enough && stand(map, ekf, index) {
            map.exactness = map.exactness.decided(says(length_m, deviation.off_rad, told));
        }
    } else if deviation.tied_rad > BUILT_RAD {
        if prior + deviation.told(BUILT_RAD) > SURE
            && tie(ekf, theta, ALPHA, deviation.off_rad, further(LOOSE_RAD, BUILT_RAD))
        {
            map.set_direction(index, Direction::Built(theta as u16, quarter));
        }
    } else if is_full && deviation.rather(GRID_TOLERANCE) > 0.0 {
        stand(map, ekf, index);
    }
}

/// How far the home's walls stand off its grid, where they tell.
fn tolerance(map: &MapView, ekf: &EkfView, enough: f32) -> Option<Tolerance> {
    // Before that was asked walls were put onto an exact one, as in a map that an older program kept.
    if map.walls().iter().any(is_decided) {
        return Some(Tolerance::Exact);
    }
    let told = built_rather_than_exact(map.walls(), ekf);
    (told.abs() > enough).then_some(if told > 0.0 { Tolerance::Built } else { Tolerance::Exact })
}

/// How likely the home's walls stand on its grid, by all of them.
fn judged(map: &MapView, ekf: &EkfView) -> Exactness {
    let is_exact = map.tolerance == Some(Tolerance::Exact);
    let is_founded = !is_exact || map.walls().iter().any(is_decided);
    let to_rad = if is_exact { GRID_TOLERANCE } else { BUILT_RAD };
    let telling = map.walls().iter().filter(|wall| is_founded && wall.length_m() >= TELLING_M);
    map.exactness.with(telling.filter_map(|wall| {
        let deviation = Deviation::of(ekf, wall)?;
        Some(says(wall.length_m(), deviation.off_rad, deviation.told(to_rad)))
    }))
}

/// The state and the quarter turns of a wall that has a direction of its own along the grid.
fn of_near_wall(wall: &Wall) -> Option<(usize, u8)> {
    wall.direction.state().zip(wall.direction.quarter())
}

fn is_decided(wall: &Wall) -> bool {
    matches!(wall.direction, Direction::Grid(_))
}

/// Puts a wall exactly onto the grid. False, and the wall as it was, where that is numerically impossible.
#[inline(never)]
fn stand(map: &mut MapView, ekf: &mut EkfView, index: usize) -> bool {
    let Some((theta, quarter)) = map.walls().get(index).and_then(of_near_wall) else { return false };
    let off_rad = off_quarter(ekf.mean(theta), ekf.mean(ALPHA));
    let stands = tie(ekf, theta, ALPHA, off_rad, 0.0);
    if stands {
        map.set_direction(index, Direction::Grid(quarter));
        map.remove_state(ekf, theta);
    }
    stands
}

/// The first two walls that stand exactly parallel or orthogonal are the grid's direction from then on. Until there are such, that is
/// known no better than walls are tied to it.
fn found(map: &mut MapView, ekf: &mut EkfView, (index, theta, quarter): (usize, usize, u8), enough: f32) {
    let mut best: Option<(f32, usize)> = None;
    for (other_index, other) in map.walls().iter().enumerate().filter(|(other, _)| *other != index) {
        let Some((other, _)) = of_near_wall(other) else { continue };
        let off_rad = off_quarter(ekf.mean(theta), ekf.mean(other));
        let known = relative_variance(ekf, theta, other) + GRID_TOLERANCE * GRID_TOLERANCE;
        let before = 2.0 * LOOSE_RAD * LOOSE_RAD;
        let log_odds = BOTH + 0.5 * libm::logf((before / known).max(1.0)) - 0.5 * off_rad * off_rad / known;
        if best.is_none_or(|(most, _)| log_odds > most) {
            best = Some((log_odds, other_index));
        }
    }
    let Some((_, other)) = best.filter(|(log_odds, _)| *log_odds > enough) else { return };
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((theta, 1.0));
    ekf.initialise(ALPHA, wrap(ekf.mean(theta) - f32::from(quarter) * FRAC_PI_2), &jacobian, 0.0);
    map.set_direction(index, Direction::Grid(quarter));
    map.remove_state(ekf, theta);
    let _ = stand(map, ekf, other);
}
