//! Hindsight: what the drive's calibration, as it is learned later, tells of the way that was driven before.
//!
//! The errors of a pose that wheels alone tell went together with those of their calibration: a robot whose left wheel is a hundredth larger
//! than it thinks turned to the right all the way. Once that is known, so is the way. Of what a filter knows of this that is all that is left
//! when it begins anew where it is: with the calibration given, the way there and whatever is seen from now on are independent, so that the
//! regression of the one on the other is the whole of it (a fixed point smoother's, Gelb 1974, section 5.3, by three states).

use crate::filter::ekf::EkfView;
use crate::filter::layout::{POSE, covariances, pose_covariance};
use crate::geometry::matrix::{Matrix, inverse, propagated, rotation, sum, times_transposed};
use crate::geometry::pose::Pose;
use crate::motion::drive::DriveStates;

/// A way that was taken for straight and was bent evenly, so that its end looks another way by phi, ends at (sin phi, 1 - cos phi) / phi times
/// its length, and that place goes on by phi at right angles to two thirds of phi, to third order.
const ENDS_AT: f32 = 2.0 / 3.0;

/// A calibration that changes the pose by less, metres or radians, waits: rounding would add up.
const LEAST: f32 = 1e-5;

/// Variance of a factor that is known, so that there is an inverse.
const KNOWN: f32 = 1e-12;

/// A filter whose calibration changes the pose by more at once, metres or radians, is unwell.
const MOST: f32 = 10.0;

/// How the errors of a pose go with those of the drive's calibration.
#[derive(Clone, Copy, Debug)]
pub struct Hindsight {
    /// Derivatives of x, y and theta by each factor of the drive.
    by: Matrix,
    /// The factors that the pose is for; nought for those that are known.
    at: [f32; 3],
}

impl Hindsight {
    /// Nothing that is learned of the calibration tells of the pose.
    pub const NONE: Self = Self { by: [[0.0; 3]; 3], at: [0.0; 3] };

    /// Of a filter's pose; and what is left of that one's covariance where the calibration is known.
    pub fn of_pose(ekf: &EkfView, states: &DriveStates) -> (Self, Matrix) {
        let states = states.in_order();
        let together = covariances(ekf, &POSE, &states);
        let mut own = covariances(ekf, &states, &states);
        for (i, row) in own.iter_mut().enumerate() {
            row[i] += KNOWN;
        }
        let inverse = inverse(&own);
        let left = sum(&pose_covariance(ekf), &propagated(&together, &inverse), -1.0);
        (Self { by: times_transposed(&inverse, &together), at: factors(ekf, &states) }, left)
    }

    /// Of a pose that is known by this in a frame whose own pose is known by `frame`'s.
    pub fn within(&self, frame: &Self, at: &Pose, pose: &Pose) -> Self {
        let turn = rotation(at.theta_rad);
        let arm = [0, 1].map(|i| turn[i][0] * pose.x_m + turn[i][1] * pose.y_m);
        let by_frame = [[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]], [0.0, 0.0, 1.0]];
        let by = sum(&times_transposed(&self.by, &turn), &times_transposed(&frame.by, &by_frame), 1.0);
        Self { by, at: self.at }
    }

    /// What the calibration's present covariance adds to that of the pose.
    pub fn covariance(&self, ekf: &EkfView, states: &DriveStates) -> Matrix {
        let states = states.in_order();
        let by_pose = [0, 1, 2].map(|i| self.by.map(|by_factor| by_factor[i]));
        propagated(&by_pose, &covariances(ekf, &states, &states))
    }

    /// By how much the calibration, as it is known now, moves the pose: x and y, metres, and theta, radians.
    pub fn follow(&mut self, ekf: &EkfView, states: &DriveStates) -> [f32; 3] {
        let now = factors(ekf, &states.in_order());
        let mut moved = [0.0f32; 3];
        for ((by, now), at) in self.by.iter().zip(now).zip(self.at) {
            for (moved, by) in moved.iter_mut().zip(by) {
                *moved += by * (now - at);
            }
        }
        let sum: f32 = moved.iter().map(|moved| moved.abs()).sum();
        // What is no number is not followed, either.
        if !(sum > LEAST && sum < MOST) {
            return [0.0; 3];
        }
        self.at = now;
        // It is learned little by little.
        let turn_rad = ENDS_AT * moved[2];
        for [x, y, _] in &mut self.by {
            (*x, *y) = (*x - turn_rad * *y, *y + turn_rad * *x);
        }
        moved
    }
}

/// The factors; nought for those that are known.
#[inline(never)]
fn factors(ekf: &EkfView, states: &[Option<usize>; 3]) -> [f32; 3] {
    states.map(|state| state.map_or(0.0, |state| ekf.mean(state)))
}
