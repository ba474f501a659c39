//! A new wall from a fitted line: its direction by maximum likelihood, its states with full cross-covariance.

use crate::angle::wrap;
use crate::config::WallPolicy;
use crate::ekf::{Ekf, Jacobian};
use crate::layout::{ALPHA, THETA, X, Y};
use crate::wall::{Direction, GridDirection};
use core::f32::consts::{FRAC_2_PI, FRAC_PI_2};

/// Share of a home's walls that stand on its grid, before any is seen: "mostly parallel or orthogonal".
const GRID_SHARE: f32 = 0.9;

/// Posterior probability at which a wall is called on or off the grid.
const DECISION: f32 = 0.95;

/// Largest direction sigma of the line that gives the grid its direction, and of a free line, radians: two degrees.
/// Ten of them are well within an eighth of a turn, so that no later wall is given to the wrong quarter.
const DIRECTION_SIGMA: f32 = 0.035;

/// The line in the robot's present frame, with the derivatives by the gains.
#[derive(Clone, Debug)]
pub struct LocalLine {
    /// Centroid, metres, robot frame.
    pub centroid_m: [f32; 2],
    /// Direction of the normal, radians, robot frame.
    pub normal_rad: f32,
    /// Variance of the centroid along the normal, m^2; of the readings and of the odometry since.
    pub variance_m2: f32,
    /// Variance of the direction, rad^2; likewise.
    pub direction_variance: f32,
    /// (gain state, d centroid, d direction).
    pub by_gains: heapless::Vec<(usize, f32, f32), 16>,
}

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Not yet clear; more points will tell.
    Wait,
    /// The first wall of the grid.
    FirstOfGrid,
    /// On the grid, this many quarter turns from alpha.
    OnGrid(u8),
    /// Off the grid, or there is none in this policy.
    Free,
    /// The report's snapped wall.
    Snapped,
}

/// Maximum likelihood between the grid's directions and a free line (report 3.3).
pub fn judge<const NB: usize, const BLOCKS: usize>(
    ekf: &Ekf<NB, BLOCKS>,
    policy: WallPolicy,
    grid: Option<&GridDirection>,
    line: &LocalLine,
) -> Verdict {
    let determined = line.direction_variance < DIRECTION_SIGMA * DIRECTION_SIGMA;
    let Some(grid) = grid else {
        return match policy {
            _ if !determined => Verdict::Wait,
            WallPolicy::Free => Verdict::Free,
            WallPolicy::Snapped { .. } | WallPolicy::Grid => Verdict::FirstOfGrid,
        };
    };
    let theta = ekf.mean(THETA) + line.normal_rad;
    let quarter = grid.quarter(theta);
    let off = wrap(theta - grid.beta(quarter));
    let relative = ekf.covariance(THETA, THETA) + ekf.covariance(ALPHA, ALPHA) - 2.0 * ekf.covariance(THETA, ALPHA);
    let variance = line.direction_variance + relative.max(0.0);
    // Densities of the deviation: normal on the grid, uniform over a quarter turn off it. Compared as logarithms.
    let log_grid = -0.5 * off * off / variance - 0.5 * libm::logf(2.0 * core::f32::consts::PI * variance);
    let log_odds = log_grid - libm::logf(FRAC_2_PI) + libm::logf(GRID_SHARE / (1.0 - GRID_SHARE));
    let sure = libm::logf(DECISION / (1.0 - DECISION));
    match policy {
        WallPolicy::Free => Verdict::Free,
        WallPolicy::Snapped { .. } if log_odds > sure => Verdict::Snapped,
        WallPolicy::Grid if log_odds > sure => Verdict::OnGrid(quarter),
        _ if log_odds < -sure && determined => Verdict::Free,
        _ => Verdict::Wait,
    }
}

/// Adds the states of a wall. None, and nothing changed, where the state is full.
pub fn add_states<const NB: usize, const BLOCKS: usize>(
    ekf: &mut Ekf<NB, BLOCKS>,
    verdict: Verdict,
    policy: WallPolicy,
    line: &LocalLine,
) -> Option<(usize, Direction)> {
    let needed = match (verdict, policy) {
        (Verdict::Wait, _) => return None,
        (Verdict::Free | Verdict::Snapped, _) | (Verdict::FirstOfGrid, WallPolicy::Snapped { .. }) => 2,
        _ => 1,
    };
    if ekf.len() + needed > Ekf::<NB, BLOCKS>::CAPACITY {
        return None;
    }
    match verdict {
        Verdict::Wait => None,
        Verdict::OnGrid(quarter) => add_grid(ekf, line, quarter),
        Verdict::Free => add_line(ekf, line).map(|(rho, theta)| (rho, Direction::Free(theta))),
        Verdict::Snapped => add_line(ekf, line).map(|(rho, theta)| (rho, Direction::Snapped(theta))),
        Verdict::FirstOfGrid => {
            let theta = wrap(ekf.mean(THETA) + line.normal_rad);
            let quarter = (libm::roundf(theta * (1.0 / FRAC_PI_2)) as i32 & 3) as u8;
            let alpha = wrap(theta - f32::from(quarter) * FRAC_PI_2);
            ekf.initialise(ALPHA, alpha, &direction_jacobian(line), line.direction_variance);
            match policy {
                WallPolicy::Snapped { .. } => {
                    let (rho, theta) = add_line(ekf, line)?;
                    Some((rho, Direction::Snapped(theta)))
                }
                _ => add_grid(ekf, line, quarter),
            }
        }
    }
}

fn direction_jacobian(line: &LocalLine) -> Jacobian {
    let mut jacobian = Jacobian::new();
    // The capacity is more than the pose, the grid and 16 gains.
    let _ = jacobian.push((THETA, 1.0));
    for &(gain, _, direction) in &line.by_gains {
        let _ = jacobian.push((gain, direction));
    }
    jacobian
}

/// Centroid in the map relative to the robot, for its present heading.
fn arm<const NB: usize, const BLOCKS: usize>(ekf: &Ekf<NB, BLOCKS>, line: &LocalLine) -> [f32; 2] {
    let (s, c) = crate::angle::sin_cos(ekf.mean(THETA));
    let [x, y] = line.centroid_m;
    [c * x - s * y, s * x + c * y]
}

/// rho = (p + R(theta) q) . n(alpha + k pi/2) for the centroid q in the robot's frame.
fn add_grid<const NB: usize, const BLOCKS: usize>(
    ekf: &mut Ekf<NB, BLOCKS>,
    line: &LocalLine,
    quarter: u8,
) -> Option<(usize, Direction)> {
    let normal = GridDirection::of(ekf).normal(quarter);
    let arm = arm(ekf, line);
    let centroid = [ekf.mean(X) + arm[0], ekf.mean(Y) + arm[1]];
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((X, normal[0]));
    let _ = jacobian.push((Y, normal[1]));
    let _ = jacobian.push((THETA, arm[0] * normal[1] - arm[1] * normal[0]));
    let _ = jacobian.push((ALPHA, centroid[1] * normal[0] - centroid[0] * normal[1]));
    for &(gain, offset, _) in &line.by_gains {
        let _ = jacobian.push((gain, offset));
    }
    let rho_m = centroid[0] * normal[0] + centroid[1] * normal[1];
    let rho = ekf.augment(rho_m, &jacobian, line.variance_m2)?;
    Some((rho, Direction::Grid(quarter)))
}

/// theta = heading + normal in the robot's frame; rho = (p + R q) . n(theta), where R q . n does not depend on the heading.
fn add_line<const NB: usize, const BLOCKS: usize>(
    ekf: &mut Ekf<NB, BLOCKS>,
    line: &LocalLine,
) -> Option<(usize, usize)> {
    let theta_value = wrap(ekf.mean(THETA) + line.normal_rad);
    let (s, c) = crate::angle::sin_cos(theta_value);
    let arm = arm(ekf, line);
    let centroid = [ekf.mean(X) + arm[0], ekf.mean(Y) + arm[1]];
    // The lever of the direction: the centroid's coordinate along the wall.
    let along = centroid[1] * c - centroid[0] * s;
    let arm_along = arm[1] * c - arm[0] * s;
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((X, c));
    let _ = jacobian.push((Y, s));
    let _ = jacobian.push((THETA, along - arm_along));
    for &(gain, offset, direction) in &line.by_gains {
        let _ = jacobian.push((gain, offset + along * direction));
    }
    let noise = line.variance_m2 + along * along * line.direction_variance;
    let rho = ekf.augment(centroid[0] * c + centroid[1] * s, &jacobian, noise)?;
    let theta = ekf.augment(theta_value, &direction_jacobian(line), line.direction_variance)?;
    ekf.correlate(rho, theta, along * line.direction_variance);
    Some((rho, theta))
}
