//! A new wall from a fitted line: its direction by maximum likelihood, its states with full cross-covariance.

use crate::births::local_line::LocalLine;
use crate::births::verdict::Verdict;
use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::{ALPHA, THETA, X, Y};
use crate::geometry::angle::{off_quarter, wrap};
use crate::walls::decision::{LOOSE_RAD, tie};
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::wall::Direction;

/// Adds the states of a wall. None, and nothing changed, where the state is full.
pub fn add_states(ekf: &mut EkfView, verdict: Verdict, line: &LocalLine) -> Option<(usize, Direction)> {
    match verdict {
        Verdict::Wait => None,
        Verdict::OnGrid(quarter) => add_grid(ekf, line, quarter),
        Verdict::NearGrid(quarter, deviation) => {
            let (rho, theta) = add_line(ekf, line)?;
            let off = off_quarter(ekf.mean(theta), ekf.mean(ALPHA));
            // Where that is numerically impossible it is a free wall.
            let tied = tie(ekf, theta, ALPHA, off, deviation);
            Some((rho, if tied { Direction::NearGrid(theta as u16, quarter) } else { Direction::Free(theta as u16) }))
        }
        Verdict::Askew(other, off_rad) => {
            let (rho, theta) = add_line(ekf, line)?;
            // Where that is numerically impossible it has a direction of its own, as it has anyway.
            let _ = tie(ekf, theta, usize::from(other), off_rad, LOOSE_RAD * LOOSE_RAD);
            Some((rho, Direction::Free(theta as u16)))
        }
        Verdict::Free => add_line(ekf, line).map(|(rho, theta)| (rho, Direction::Free(theta as u16))),
        Verdict::Snapped => add_line(ekf, line).map(|(rho, theta)| (rho, Direction::Snapped(theta as u16))),
    }
}

fn direction_jacobian(line: &LocalLine) -> Jacobian {
    let mut jacobian = Jacobian::new();
    // The capacity is that of the pose, the grid, the drive, 16 gains and the latency.
    let _ = jacobian.push((THETA, 1.0));
    for &(state, _, direction) in &line.by_calibration {
        let _ = jacobian.push((state, direction));
    }
    jacobian
}

/// Centroid in the map relative to the robot, for its present heading.
fn arm(ekf: &EkfView, line: &LocalLine) -> [f32; 2] {
    let (s, c) = crate::geometry::angle::sin_cos(ekf.mean(THETA));
    let [x, y] = line.centroid_m;
    [c * x - s * y, s * x + c * y]
}

/// rho = (p + R(theta) q) . n(alpha + k pi/2) for the centroid q in the robot's frame.
fn add_grid(ekf: &mut EkfView, line: &LocalLine, quarter: u8) -> Option<(usize, Direction)> {
    let normal = ManhattanFrame::of(ekf).normal(quarter);
    let arm = arm(ekf, line);
    let centroid = [ekf.mean(X) + arm[0], ekf.mean(Y) + arm[1]];
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((X, normal[0]));
    let _ = jacobian.push((Y, normal[1]));
    let _ = jacobian.push((THETA, arm[0] * normal[1] - arm[1] * normal[0]));
    let _ = jacobian.push((ALPHA, centroid[1] * normal[0] - centroid[0] * normal[1]));
    for &(state, offset, _) in &line.by_calibration {
        let _ = jacobian.push((state, offset));
    }
    let rho_m = centroid[0] * normal[0] + centroid[1] * normal[1];
    let rho = ekf.augment(rho_m, &jacobian, line.variance_m2)?;
    Some((rho, Direction::Grid(quarter)))
}

/// theta = heading + normal in the robot's frame; rho = (p + R q) . n(theta), where R q . n does not depend on the heading.
fn add_line(ekf: &mut EkfView, line: &LocalLine) -> Option<(usize, usize)> {
    if ekf.len() + 2 > ekf.capacity() {
        return None;
    }
    let theta_value = wrap(ekf.mean(THETA) + line.normal_rad);
    let (s, c) = crate::geometry::angle::sin_cos(theta_value);
    let arm = arm(ekf, line);
    let centroid = [ekf.mean(X) + arm[0], ekf.mean(Y) + arm[1]];
    // The lever of the direction: the centroid's coordinate along the wall.
    let along = centroid[1] * c - centroid[0] * s;
    let arm_along = arm[1] * c - arm[0] * s;
    let mut jacobian = Jacobian::new();
    let _ = jacobian.push((X, c));
    let _ = jacobian.push((Y, s));
    let _ = jacobian.push((THETA, along - arm_along));
    for &(state, offset, direction) in &line.by_calibration {
        let _ = jacobian.push((state, offset + along * direction));
    }
    let noise = line.variance_m2 + along * along * line.direction_variance;
    let rho = ekf.augment(centroid[0] * c + centroid[1] * s, &jacobian, noise)?;
    let theta = ekf.augment(theta_value, &direction_jacobian(line), line.direction_variance)?;
    ekf.correlate(rho, theta, along * line.direction_variance);
    Some((rho, theta))
}
