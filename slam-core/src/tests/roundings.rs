//! What f32 rounds away, by how much is not known of the whole.

use core::f32::consts::FRAC_PI_2;

use super::oracle::{Oracle, dense};
use super::random::Random;
use crate::filter::ekf::{Ekf, Jacobian, MotionJacobian, storage};
use crate::filter::layout::{ALPHA, THETA, X, Y};

type Filter = Ekf<{ storage(16) }>;

/// Where the robot stands: metres, radians.
const POSE: [f32; 3] = [0.8, -0.6, 0.3];

/// Direction of the grid, radians.
const GRID_RAD: f32 = 0.01;

/// Normals of a room's four walls.
fn normals() -> [[f32; 2]; 4] {
    core::array::from_fn(|quarter| {
        let beta_rad = GRID_RAD + FRAC_PI_2 * quarter as f32;
        [beta_rad.cos(), beta_rad.sin()]
    })
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

/// How far the robot's distances from the walls are from those of a filter in f64 after 20,000 steps with a reading of each, metres.
fn rounded_m(known: [f32; 3]) -> f64 {
    const FIRST: usize = ALPHA + 1;
    let mut ekf = room(known);
    let (mut oracle, mut random) = (Oracle::of(&ekf), Random::new(1));
    let still: MotionJacobian = core::array::from_fn(|i| core::array::from_fn(|j| f32::from(u8::from(i == j))));
    let rows = still.map(|row| row.map(f64::from).to_vec());
    let noise = core::array::from_fn(|i| core::array::from_fn(|j| if i == j { 1e-6 } else { 0.0 }));
    for _ in 0..20_000 {
        let (stays, own) = ([X, Y, THETA].map(|i| ekf.mean(i)), [X, Y, THETA].map(|i| oracle.mean[i]));
        ekf.predict(stays, &still, &noise);
        oracle.predict(own, &rows, &noise.map(|row| row.map(f64::from)));
        for (rho, n) in (FIRST..).zip(normals()) {
            let along_m = POSE[1] * n[0] - POSE[0] * n[1];
            let reading: Jacobian = [(rho, 1.0), (X, -n[0]), (Y, -n[1]), (ALPHA, -along_m)].into_iter().collect();
            let row = dense(&reading, oracle.mean.len());
            let read_m = 2.0 + 0.01 * random.gaussian() - f64::from(along_m * GRID_RAD);
            let off =
                |mean: &dyn Fn(usize) -> f64| read_m - row.iter().enumerate().map(|(i, h)| h * mean(i)).sum::<f64>();
            let innovation = off(&|i| ekf.mean(i).into()) as f32;
            oracle.update(off(&|i| oracle.mean[i]), &row, 1e-4);
            ekf.update(innovation, &reading, 1e-4).expect("a reading that counts");
        }
    }
    let distance_m = |mean: &dyn Fn(usize) -> f64, rho: usize, n: [f32; 2]| {
        mean(rho) - f64::from(n[0]) * mean(X) - f64::from(n[1]) * mean(Y)
    };
    let off_m = |(rho, n)| distance_m(&|i| ekf.mean(i).into(), rho, n) - distance_m(&|i| oracle.mean[i], rho, n);
    (FIRST..).zip(normals()).map(off_m).map(f64::abs).fold(0.0, f64::max)
}

/// What walls are to the robot is a small difference of what all are to the start: where that is not known, f32 rounds more of it.
#[test]
fn f32_rounds_more_of_a_map_whose_frame_is_known_worse() {
    let (vague, known) = (rounded_m([0.04, 0.09, 0.01]), rounded_m([1e-6; 3]));
    std::println!(
        "{:.3} mm where the start is known to 0.1 rad, {:.3} mm where it is to a millirad",
        1e3 * vague,
        1e3 * known
    );
    assert!(known < 5e-5, "{known} m where the frame is known");
    assert!(vague < 1e-3, "{vague} m where it is not");
    assert!(vague > 5.0 * known, "{vague} m where the frame is not known, {known} m where it is");
}
