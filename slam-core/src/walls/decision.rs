//! Whether a wall stands on the grid: the odds of a direction on it against one of its own.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::walls::wall::WallPolicy;
use core::f32::consts::{FRAC_2_PI, PI};

/// Share of a home's walls that stand on its grid, before any is seen: "mostly parallel or orthogonal".
pub const GRID_SHARE: f32 = 0.9;

/// Share of lines too short to be told from furniture that stand on the grid. It is the smaller one: each further point is
/// another trial, and one of many trials takes a chest that stands askew for a wall.
pub const SHORT_SHARE: f32 = 0.8;

/// Posterior probability at which a wall is called on or off the grid.
pub const DECISION: f32 = 0.95;

/// Log of the odds of that.
pub const SURE: f32 = 2.944_439;

/// Largest variance of the angle between two directions of which each tells where the other stands, rad^2: two degrees. A wall whose
/// direction against the grid is known no better is not judged by that alone.
pub const TELLING: f32 = 0.035 * 0.035;

/// Angle within which walls of an exact grid are parallel or orthogonal, 1-sigma, radians: a twentieth of a degree.
pub const GRID_TOLERANCE: f32 = 1e-3;

/// Angle within which built walls are parallel or orthogonal, 1-sigma, radians: half a degree. Those of the Freiburg offices scatter by 1.7 degrees along the path that
/// is given as true, which has its share of that; up to 0.03 the results there are the same.
pub const BUILT_TOLERANCE: f32 = 0.01;

/// How far a wall may stand off the grid that it looks to stand on, or off a wall that it looks to be parallel to, 1-sigma, radians:
/// partitions that are askew are so by some degrees.
pub const LOOSE_RAD: f32 = 0.03;

/// Density of a direction `off_rad` from where it is expected, with that variance, beside the tolerance of exact grids.
#[inline(never)]
pub fn density(off_rad: f32, variance: f32) -> f32 {
    let variance = variance + GRID_TOLERANCE * GRID_TOLERANCE;
    libm::expf(-0.5 * off_rad * off_rad / variance) / float::sqrtf(2.0 * PI * variance)
}

/// Logarithm of how many times likelier a direction `off_rad` from the nearest one of a grid, with that variance, is of a wall on the
/// grid than of one off it: normal density on it, uniform over a quarter turn off it.
pub fn evidence(off_rad: f32, variance: f32) -> f32 {
    let variance = variance + GRID_TOLERANCE * GRID_TOLERANCE;
    let log_grid = -0.5 * off_rad * off_rad / variance - 0.5 * libm::logf(2.0 * PI * variance);
    log_grid - libm::logf(FRAC_2_PI)
}

/// Variance of a wall's direction about the grid's, rad^2, beyond what walls of a perfect grid have.
pub fn deviation(policy: WallPolicy) -> f32 {
    match policy {
        WallPolicy::NearGrid => BUILT_TOLERANCE * BUILT_TOLERANCE,
        _ => 0.0,
    }
}

/// Variance with which a wall is tied to the grid at first, rad^2; zero where it is put on it at once.
pub fn looseness(policy: WallPolicy) -> f32 {
    match policy {
        WallPolicy::Grid => LOOSE_RAD * LOOSE_RAD,
        _ => deviation(policy),
    }
}

/// On the grid (true), where `share` of such walls stand, off it (false), or not clear yet.
pub fn decide(off_rad: f32, variance: f32, share: f32) -> Option<bool> {
    decide_by(evidence(off_rad, variance), share)
}

/// The same by that [`evidence`].
pub fn decide_by(evidence: f32, share: f32) -> Option<bool> {
    let odds = evidence + libm::logf(share / (1.0 - share));
    if odds > SURE {
        Some(true)
    } else if odds < -SURE {
        Some(false)
    } else {
        None
    }
}

/// Variance of the angle between the directions that two states are, rad^2.
#[inline(never)]
pub fn relative_variance(ekf: &EkfView, i: usize, j: usize) -> f32 {
    (ekf.covariance(i, i) + ekf.covariance(j, j) - 2.0 * ekf.covariance(i, j)).max(0.0)
}

/// The scalar measurement that one direction, `off_rad` from another or from a quarter turn of it, is that one but for this variance.
/// False where it is numerically impossible.
#[inline(never)]
pub fn tie(ekf: &mut EkfView, theta: usize, other: usize, off_rad: f32, deviation: f32) -> bool {
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((theta, 1.0));
    let _ = jacobian.push((other, -1.0));
    ekf.update(-off_rad, &jacobian, GRID_TOLERANCE * GRID_TOLERANCE + deviation).is_ok()
}
