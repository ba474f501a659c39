//! Walls that stand askew together, as those of a wing, of a bay or the partitions of a home may: directions beside the grid's.
//!
//! What is known of one helps to find the next. Each long wall that stands off the grid is as good a direction for a line as a new one
//! (a Chinese restaurant process, Aldous 1985, on the directions of an Atlanta world, Schindler and Dellaert 2004).

use crate::births::local_line::LocalLine;
use crate::filter::ekf::EkfView;
use crate::filter::layout::THETA;
use crate::geometry::angle::off_quarter;
use crate::walls::decision::{BUILT_TOLERANCE, DECISION, SURE, density, relative_variance};
use crate::walls::exactness::Exactness;
use crate::walls::tolerance::{BUILT_RAD, Deviation};
use crate::walls::wall::{Direction, Wall};
use core::f32::consts::FRAC_2_PI;

/// Largest angle between the grid and walls that stand askew at which a line may be of either and is drawn loosely, radians: four
/// degrees. At a larger one more points will tell.
const EITHER_RAD: f32 = 0.07;

/// What a line is where some walls stand askew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Among {
    /// The grid's rather than theirs, as far as it is of either.
    Grid,
    /// Off the grid, as the wall whose direction this state is, which is so far from the line's, radians.
    Askew(u16, f32),
    /// Of the grid or askew, which are so far apart, radians.
    Either(f32),
    /// Off the grid.
    Off,
    /// Not clear.
    Unclear,
}

/// A direction off the grid, as a line sees it.
#[derive(Clone, Copy)]
struct Nearest {
    state: usize,
    off_rad: f32,
    variance: f32,
}

/// What a line is whose direction is `off_rad` from the grid's with that variance, where `share` of such lines are on it: with walls of
/// at least this length that stand askew. None where there are none.
#[inline(never)]
pub fn among(
    ekf: &EkfView,
    walls: &[Wall],
    line: &LocalLine,
    (off_rad, variance, share): (f32, f32, f32),
    length_m: f32,
) -> Option<Among> {
    let theta_rad = ekf.mean(THETA) + line.normal_rad;
    let mut nearest: Option<Nearest> = None;
    let mut theirs = 0.0;
    for state in walls.iter().filter(|wall| wall.length_m() >= length_m).filter_map(|wall| askew(ekf, wall)) {
        let off_rad = off_quarter(theta_rad, ekf.mean(state));
        let known = relative_variance(ekf, THETA, state);
        let variance = line.direction_variance + known + BUILT_TOLERANCE * BUILT_TOLERANCE;
        // Walls that stand askew by other angles tell nothing of a line like this one.
        theirs += density(off_rad, variance);
        if nearest.is_none_or(|best| off_rad * off_rad * best.variance < best.off_rad * best.off_rad * variance) {
            nearest = Some(Nearest { state, off_rad, variance });
        }
    }
    let nearest = nearest?;
    let on_grid = share * density(off_rad, variance);
    let askew = (1.0 - share) * theirs;
    let new = (1.0 - share) * FRAC_2_PI;
    let enough = DECISION * (on_grid + askew + new);
    let apart_rad = (off_rad - nearest.off_rad).abs();
    Some(if askew > enough {
        Among::Askew(nearest.state as u16, nearest.off_rad)
    } else if on_grid > enough {
        Among::Grid
    } else if askew + new > enough {
        Among::Off
    } else if on_grid + askew > enough && apart_rad < EITHER_RAD {
        Among::Either(apart_rad)
    } else {
        Among::Unclear
    })
}

/// The state that is the direction of a wall that stands off the grid.
fn askew(ekf: &EkfView, wall: &Wall) -> Option<usize> {
    match wall.direction {
        Direction::Free(theta) => Some(usize::from(theta)),
        Direction::NearGrid(theta, _) => {
            let told = Deviation::of(ekf, wall)?.told(BUILT_RAD);
            (Exactness::UNKNOWN.prior(wall.length_m()) + told < -SURE).then_some(usize::from(theta))
        }
        Direction::Grid(_) | Direction::Built(..) | Direction::Snapped(_) => None,
    }
}
