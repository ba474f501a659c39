//! Dead reckoning's derivatives by the calibration factors, over a whole path.

use super::numeric::{arc, slope};
use super::random::Random;
use crate::DriveModel;
use crate::motion::dead_reckoning::DeadReckoning;
use crate::motion::step::{Factor, Factors, step};
use crate::motion::travel::Travel;

const TRACK_M: f64 = 0.2;

/// Where a point that is fixed to the robot now is, for these factors, after the whole path.
fn end(path: &[[f64; 2]], factors: &[f64], local_m: [f64; 2]) -> [f64; 2] {
    let pose = path.iter().fold([0.0; 3], |pose, [l, r]| {
        arc(pose, factors[0] * l, factors[1] * r, factors[2] * f64::from(TRACK_M as f32))
    });
    let (s, c) = pose[2].sin_cos();
    [pose[0] + c * local_m[0] - s * local_m[1], pose[1] + s * local_m[0] + c * local_m[1]]
}

#[test]
fn a_point_moves_with_the_factors_as_driving_again_would_move_it() {
    let drive = DriveModel::Wheels {
        track_m: TRACK_M as f32,
        track_sigma: 0.01,
        metres_per_tick: 1e-3,
        scale_sigma: 0.01,
        noise_m2_per_m: 1e-5,
    };
    let values = [1.01f32, 0.98, 1.02];
    let factor = |i: usize| Factor { value: values[i], state: None };
    let factors = Factors { first: factor(0), second: factor(1), third: factor(2) };
    let mut random = Random::new(1);
    let mut odometry = DeadReckoning::START;
    let mut path = std::vec::Vec::new();
    for number in 0..300 {
        let wheels = [0, 1].map(|_| random.uniform(-0.005, 0.02) as f32);
        path.push(wheels.map(f64::from));
        odometry.advance(&step(&drive, &Travel::Wheels { left_m: wheels[0], right_m: wheels[1] }, &factors));
        if number % 50 != 49 {
            continue;
        }
        let local_m = [random.uniform(-1.0, 1.0) as f32, random.uniform(-1.0, 1.0) as f32];
        let point_m = odometry.pose.transform(local_m);
        let at = values.map(f64::from);
        let local_m = local_m.map(f64::from);
        for (which, by) in odometry.by_factor(point_m).iter().enumerate() {
            for (axis, got) in by.iter().enumerate() {
                let expected = slope(|f| end(&path, f, local_m)[axis], &at, which);
                let tolerance = 1e-4 * (1.0 + expected.abs());
                assert!((f64::from(*got) - expected).abs() < tolerance, "factor {which}: {got}, not {expected}");
            }
        }
    }
    let rolled: f64 = path.iter().map(|[l, r]| 0.5 * (1.01 * l + 0.98 * r).abs()).sum();
    assert!((f64::from(odometry.path_m) - rolled).abs() < 1e-3);
}
