//! How far rounding moves the robot among its walls, by how badly the frame as a whole is known.

use core::f32::consts::FRAC_PI_2;
use std::vec::Vec;

use super::oracle::{Oracle, dense, dot, identity};
use super::random::Random;
use crate::filter::ekf::{Ekf, Jacobian, LEADING, MotionJacobian, storage};
use crate::filter::layout::{ALPHA, THETA, X, Y};
use crate::geometry::angle::normal;

type Filter = Ekf<{ storage(16) }>;

/// Where the robot stands: metres, radians.
const POSE: [f32; 3] = [0.8, -0.6, 0.3];

/// Direction of the grid, radians.
const GRID_RAD: f32 = 0.01;

/// Normals of a room's four walls.
fn normals() -> [[f32; 2]; 4] {
    core::array::from_fn(|quarter| normal(GRID_RAD + FRAC_PI_2 * quarter as f32))
}

/// A robot in a room whose walls it knows to 3 mm, in a frame that is known to so much as a whole: variances of (x, y, turn).
fn room([xx, yy, tt]: [f32; 3]) -> Filter {
    let mut ekf = Filter::EMPTY;
    let [x_m, y_m, theta_rad] = POSE;
    // What a motion of everything about the origin does to the pose.
    let variances = [xx + y_m * y_m * tt, yy + x_m * x_m * tt, tt];
    for (mean, variance) in [x_m, y_m, theta_rad].into_iter().zip(variances) {
        ekf.augment(mean, &Jacobian::new(), variance);
    }
    ekf.augment(0.0, &Jacobian::new(), 0.0);
    for (i, j, covariance) in [(X, Y, -x_m * y_m * tt), (X, THETA, -y_m * tt), (Y, THETA, x_m * tt)] {
        ekf.correlate(i, j, covariance);
    }
    ekf.initialise(ALPHA, GRID_RAD, &[(THETA, 1.0)].into_iter().collect(), 1e-6);
    for n in normals() {
        let distance = [(X, n[0]), (Y, n[1]), (ALPHA, y_m * n[0] - x_m * n[1])].into_iter().collect();
        ekf.augment(2.0 + x_m * n[0] + y_m * n[1], &distance, 1e-5);
    }
    ekf
}

/// How far the robot's distances from the walls are from those of a filter in f64 after 20,000 steps with a reading of each, metres: the
/// largest.
fn rounded_m(known: [f32; 3], seed: u64) -> f64 {
    let mut ekf = room(known);
    let (mut oracle, mut random) = (Oracle::of(&ekf), Random::new(seed));
    let states = ekf.len();
    let means = |ekf: &Filter| (0..states).map(|i| ekf.mean(i).into()).collect::<Vec<f64>>();
    let rows = [X, Y, THETA].map(|i| identity(LEADING)[i].clone());
    let still: MotionJacobian = [X, Y, THETA].map(|i| core::array::from_fn(|j| rows[i][j] as f32));
    let noise = [X, Y, THETA].map(|i| [X, Y, THETA].map(|j| if i == j { 1e-6 } else { 0.0 }));
    for _ in 0..20_000 {
        let (stays, own) = ([X, Y, THETA].map(|i| ekf.mean(i)), [X, Y, THETA].map(|i| oracle.mean[i]));
        ekf.predict(stays, &still, &noise);
        oracle.predict(own, &rows, &noise.map(|row| row.map(f64::from)));
        for (rho, n) in (ALPHA + 1..).zip(normals()) {
            let along_m = POSE[1] * n[0] - POSE[0] * n[1];
            let reading: Jacobian = [(rho, 1.0), (X, -n[0]), (Y, -n[1]), (ALPHA, -along_m)].into_iter().collect();
            let row = dense(&reading, states);
            let read_m = 2.0 + 0.01 * random.gaussian() - f64::from(along_m * GRID_RAD);
            let innovation = (read_m - dot(&row, &means(&ekf))) as f32;
            oracle.update(read_m - dot(&row, &oracle.mean), &row, 1e-4);
            ekf.update(innovation, &reading, 1e-4).expect("a reading that counts");
        }
    }
    let means = means(&ekf);
    let off_m = (ALPHA + 1..).zip(normals()).map(|(rho, n)| {
        let distance = dense(&[(rho, 1.0), (X, -n[0]), (Y, -n[1])].into_iter().collect(), states);
        (dot(&distance, &means) - dot(&distance, &oracle.mean)).abs()
    });
    off_m.fold(0.0, f64::max)
}

/// How walls lie to the robot is a small difference of how both lie to the start: where that is not known, rounding takes more of it.
#[test]
fn f32_rounds_more_of_a_map_whose_frame_is_known_worse() {
    for seed in 1..=5 {
        let (vague, known) = (rounded_m([0.04, 0.09, 0.01], seed), rounded_m([1e-6; 3], seed));
        std::println!("seed {seed}: {:.3} mm in the vague frame, {:.3} mm in the known one", 1e3 * vague, 1e3 * known);
        assert!(known < 5e-5, "{known} m where the frame is known");
        assert!(vague < 1e-3, "{vague} m where it is not");
        assert!(vague > 5.0 * known, "{vague} m where the frame is not known, {known} m where it is");
    }
}
