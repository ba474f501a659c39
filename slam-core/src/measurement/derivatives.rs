//! How a reading depends on the pose and on the wall that it is of.

use crate::filter::ekf::Jacobian;
use crate::filter::layout::{ALPHA, THETA, X, Y};
use crate::measurement::beam::Prediction;
use crate::walls::wall::{Direction, Wall};

/// Derivatives of what a sensor of this gain reads on a wall by the states of pose and wall, at most six.
pub fn by_pose_and_wall(gain: f32, wall: &Wall, prediction: &Prediction, theta_moves: bool) -> Jacobian {
    let mut row = Jacobian::new();
    let mut push = |i: usize, derivative: f32| {
        // The capacity is three times what a measurement has.
        let _ = row.push((i, derivative));
    };
    push(X, gain * prediction.by_position[0]);
    push(Y, gain * prediction.by_position[1]);
    push(THETA, gain * prediction.by_heading);
    match wall.direction {
        Direction::Grid(_) => push(ALPHA, gain * prediction.by_beta),
        Direction::Free(theta) | Direction::NearGrid(theta, _) | Direction::Built(theta, _) => {
            push(usize::from(theta), gain * prediction.by_beta)
        }
        Direction::Snapped(theta) => {
            push(ALPHA, gain * prediction.by_beta);
            if theta_moves {
                push(usize::from(theta), gain * prediction.by_beta);
            }
        }
    }
    push(wall.rho(), gain * prediction.by_rho);
    row
}
