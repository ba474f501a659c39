//! How closely the walls of this home stand on its grid: learned, by halves.
//!
//! An exact grid that is forced on walls a degree or two off bends the heading, and makes it surer than it is; directions of
//! their own for walls that do stand on the grid cost accuracy and states. Which it is the walls tell: against the grid,
//! deviations of 1-sigma s should have a mean square of s^2, in the share in which each is known better than that (empirical
//! Bayes; Efron and Morris 1973). Where they are clearly smaller, s is halved, and every wall is tied to the grid by what was
//! lacking; at a milliradian the grid is exact, and walls on it have no direction of their own any more. Where they are
//! clearly larger, walls that are found from then on are tied more loosely.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::ALPHA;
use crate::geometry::angle::wrap;
use crate::walls::decision::{self, relative_variance};
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::MapView;
use crate::walls::squareness::Squareness;
use crate::walls::wall::{Direction, Wall, WallPolicy};

/// Number of walls that the prior counts for: five walls without deviation then halve the sigma.
const PRIOR_WALLS: f32 = 2.0;
/// Ratio of found to expected mean square below which the sigma is halved.
const HALVES: f32 = 0.3;
/// Ratio of found to expected mean square above which the sigma is doubled.
const DOUBLES: f32 = 3.0;

/// Number of standard deviations off the grid beyond which a wall does not belong to it.
const SIGMAS: f32 = 3.0;

/// State, quarter turns, deviation (radians) and its variance (rad^2) of a near-grid wall; none for other walls.
fn deviation_of(wall: &Wall, ekf: &EkfView) -> Option<(usize, u8, f32, f32)> {
    let Direction::NearGrid(theta, quarter) = wall.direction else { return None };
    let theta = usize::from(theta);
    let off_rad = wrap(ekf.mean(theta) - ManhattanFrame::of(ekf).beta(quarter));
    Some((theta, quarter, off_rad, relative_variance(ekf, theta, ALPHA)))
}

/// Learns the squareness from all walls once a round, and ties wall `index` as closely as the squareness says.
pub fn upkeep(map: &mut MapView, ekf: &mut EkfView, index: usize) {
    if index == 0 {
        map.squareness = learned(map, ekf);
    }
    narrow(map, ekf, index);
}

fn learned(map: &MapView, ekf: &EkfView) -> Squareness {
    let variance = map.squareness.variance();
    let (mut squares, mut walls) = (PRIOR_WALLS, PRIOR_WALLS);
    for (.., off_rad, known) in map.walls().iter().filter_map(|wall| deviation_of(wall, ekf)) {
        squares += off_rad * off_rad / variance;
        walls += (1.0 - known / variance).max(0.0);
    }
    let ratio = squares / walls;
    // An exact grid has no deviations left that could tell otherwise.
    if map.squareness.is_exact() {
        map.squareness
    } else if ratio < HALVES {
        map.squareness.halved()
    } else if ratio > DOUBLES {
        map.squareness.doubled()
    } else {
        map.squareness
    }
}

/// Ties a wall to the grid as closely as walls are known to stand on it by now.
fn narrow(map: &mut MapView, ekf: &mut EkfView, index: usize) {
    let Some(&wall) = map.walls().get(index) else { return };
    let Some((theta, quarter, off_rad, known)) = deviation_of(&wall, ekf) else { return };
    if wall.squareness >= map.squareness {
        return;
    }
    // What is lacking between the two: precisions add up.
    let lacking = 1.0 / (1.0 / map.squareness.variance() - 1.0 / wall.squareness.variance());
    if off_rad * off_rad > SIGMAS * SIGMAS * (known + lacking) {
        return;
    }
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((theta, 1.0));
    let _ = jacobian.push((ALPHA, -1.0));
    if ekf.update(-off_rad, &jacobian, lacking).is_ok() {
        map.tie(index, map.squareness);
        if map.squareness.is_exact() {
            map.set_direction(index, Direction::Grid(quarter));
            map.remove_state(ekf, theta);
        }
    }
}

impl MapView {
    /// Variance of a wall's direction about the grid's, rad^2; zero where the grid is exact.
    pub fn deviation(&self, policy: WallPolicy) -> f32 {
        match policy {
            WallPolicy::LearnedGrid => self.squareness.deviation(),
            _ => decision::deviation(policy),
        }
    }
}
