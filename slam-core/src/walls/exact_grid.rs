//! Walls are put onto the grid exactly once readings tell that they stand on it, not when they are found.
//!
//! A line that is found along the grid is known to two degrees or so, and a partition that stands three degrees askew looks like one
//! on the grid. Forced onto it, it bends the heading, and makes it surer than it is. So a wall is tied to the grid loosely first and
//! has a direction of its own. When readings have made that known, the odds that it is the grid's are what they say for no deviation
//! against any (the Savage-Dickey density ratio; Dickey 1971), times those before them. A tie that comes late tells as much as one at
//! birth would have: the covariance passes it on.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::ALPHA;
use crate::geometry::angle::{off_quarter, wrap};
use crate::walls::decision::{SURE, relative_variance, tie};
use crate::walls::exactness::{Exactness, evidence, says};
use crate::walls::map::MapView;
use crate::walls::wall::{Direction, Wall};
use core::f32::consts::FRAC_PI_2;

/// Log of the odds that two walls both stand exactly on the grid that is not founded yet: each does in nine cases of ten.
const BOTH: f32 = 1.45;

/// Least length of a wall that tells of the home, metres: shorter ones are of things that stand as they were put.
const TELLING_M: f32 = 0.5;

/// States of two walls: where no more is left, what is likelier is enough.
const RESERVE: usize = 4;

/// Judges the home once a round, and decides of wall `index`.
#[inline(never)]
pub fn upkeep(map: &mut MapView, ekf: &mut EkfView, index: usize) {
    if index == 0 {
        map.exactness = judged(map, ekf);
    }
    let Some(Direction::NearGrid(theta, quarter)) = map.walls().get(index).map(|wall| wall.direction) else { return };
    let theta = usize::from(theta);
    let enough = if ekf.len() + RESERVE > ekf.capacity() { 0.0 } else { SURE };
    if !map.walls().iter().any(is_decided) {
        found(map, ekf, (index, theta, quarter), enough);
        return;
    }
    let off_rad = off_quarter(ekf.mean(theta), ekf.mean(ALPHA));
    let known = relative_variance(ekf, theta, ALPHA);
    let length_m = map.walls().get(index).map_or(0.0, Wall::length_m);
    if map.exactness.prior(length_m) + evidence(off_rad, known, 1.0) > enough && stand(map, ekf, index) {
        map.exactness = map.exactness.decided(says(length_m, off_rad, known));
    }
}

/// How likely the home's grid is exact by all its walls, once it is founded.
fn judged(map: &MapView, ekf: &EkfView) -> Exactness {
    let is_founded = map.walls().iter().any(is_decided);
    let telling = map.walls().iter().filter(|wall| is_founded && wall.length_m() >= TELLING_M);
    map.exactness.with(telling.filter_map(|wall| wall.direction.state().map(|theta| (wall.length_m(), theta))).map(
        |(length_m, theta)| {
            says(length_m, off_quarter(ekf.mean(theta), ekf.mean(ALPHA)), relative_variance(ekf, theta, ALPHA))
        },
    ))
}

fn is_decided(wall: &Wall) -> bool {
    matches!(wall.direction, Direction::Grid(_))
}

/// Puts a wall exactly onto the grid. False, and the wall as it was, where that is numerically impossible.
#[inline(never)]
fn stand(map: &mut MapView, ekf: &mut EkfView, index: usize) -> bool {
    let direction = map.walls().get(index).map(|wall| wall.direction);
    let Some(Direction::NearGrid(theta, quarter)) = direction else { return false };
    let theta = usize::from(theta);
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
        let Direction::NearGrid(other, _) = other.direction else { continue };
        let other = usize::from(other);
        let off_rad = off_quarter(ekf.mean(theta), ekf.mean(other));
        let known = relative_variance(ekf, theta, other);
        let log_odds = BOTH + evidence(off_rad, known, 2.0);
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
