//! Walls that were drawn while the heading was astray.
//!
//! A heading that went unseen for some metres of slips is wrong by more than the filter expects, and what is drawn under it stands off
//! the grid by as much: a second grid, wall after wall. Of one such wall nobody can say whether it stands askew. That all stand askew by
//! the same angle is the less likely the more there are.

use crate::filter::ekf::EkfView;
use crate::geometry::angle::off_quarter;
use crate::walls::decision::{GRID_SHARE, SURE, TELLING, decide, relative_variance};
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::wall::{Direction, Wall};

/// Largest angle of such walls off the grid, in standard deviations of the heading: beyond it any number of them stands askew.
const SIGMAS: f32 = 5.0;

/// Fewest other walls that stand as one does: two may be a wall and what was pushed against it.
const OTHERS: f32 = 2.0;

/// Least distance between two such walls, metres: nearer ones may be two sides of one thing that stands askew.
const APART_M: f32 = 1.5;

/// Logarithm of the density of Student's t with four degrees of freedom where nothing is off, times a standard deviation, over that of
/// directions off the grid, which are uniform over a quarter turn: ln(3/8 / (2/pi)).
const STUDENT: f32 = -0.529;

/// Whether a free wall, `off_rad` from the grid with that variance, stands on it and the heading was off, by all walls that stand as it
/// does: that it does so by such an angle, for Student's t in place of the normal distribution, since the noise of motion is itself known
/// from a few metres only, against any angle; and that each other one does, against one more of a direction that stands askew
/// (`births::askew`).
#[inline(never)]
pub fn is_astray(
    walls: &[Wall],
    ekf: &EkfView,
    grid: &ManhattanFrame,
    wall: &Wall,
    (off_rad, variance): (f32, f32),
) -> bool {
    let square = off_rad * off_rad / variance;
    let Some(theta) = wall.direction.state().filter(|_| variance > TELLING && square < SIGMAS * SIGMAS) else {
        return false;
    };
    let [x, y] = middle(wall, ekf, grid);
    let share = GRID_SHARE / (1.0 - GRID_SHARE);
    let mut log_odds = libm::logf(share) + STUDENT - 0.5 * libm::logf(variance) - 2.5 * libm::logf(1.0 + 0.25 * square);
    let mut others = 0.0;
    for other in walls {
        let Direction::Free(other_theta) = other.direction else { continue };
        let other_theta = usize::from(other_theta);
        let relative = relative_variance(ekf, theta, other_theta);
        let apart_rad = off_quarter(ekf.mean(theta), ekf.mean(other_theta));
        if relative >= TELLING || decide(apart_rad, relative, GRID_SHARE) != Some(true) {
            continue;
        }
        let [to_x, to_y] = middle(other, ekf, grid);
        if (to_x - x) * (to_x - x) + (to_y - y) * (to_y - y) > APART_M * APART_M {
            others += 1.0;
            log_odds += libm::logf(share / others).max(0.0);
        }
    }
    others >= OTHERS && log_odds > SURE
}

/// The middle of what is known of a wall, metres.
#[inline(never)]
fn middle(wall: &Wall, ekf: &EkfView, grid: &ManhattanFrame) -> [f32; 2] {
    wall.line(ekf, grid).at(0.5 * (wall.lo_m + wall.hi_m))
}
