//! The anchor's moments, the shortfall's, and what rounding is given, each against another derivation.

use super::random::Random;
use crate::filter::ekf::{Ekf, EkfView, Jacobian, storage};
use crate::geometry::pose::Pose;
use crate::motion::drive::DriveStates;
use crate::motion::shortfall::Shortfall;
use crate::walls::anchor::Anchor;

/// Second moments of a pose of the anchor's frame about its estimate, by drawing the anchor's error (a lower triangular factor
/// times normal numbers) and the pose's.
fn drawn(anchor: &Pose, factor: &[[f64; 3]; 3], pose: &Pose, sigmas: [f64; 3]) -> [[f64; 3]; 3] {
    const DRAWS: usize = 100_000;
    let place = |anchor: [f64; 3], pose: [f64; 3]| {
        let (s, c) = anchor[2].sin_cos();
        [anchor[0] + c * pose[0] - s * pose[1], anchor[1] + s * pose[0] + c * pose[1], anchor[2] + pose[2]]
    };
    let [anchor, pose] = [anchor, pose].map(|p| [p.x_m, p.y_m, p.theta_rad].map(f64::from));
    let centre = place(anchor, pose);
    let mut random = Random::new(1);
    let mut sum = [[0.0; 3]; 3];
    for _ in 0..DRAWS {
        let normal: [f64; 3] = core::array::from_fn(|_| random.gaussian());
        let off = |i: usize| (0..=i).map(|k| factor[i][k] * normal[k]).sum::<f64>();
        let at = core::array::from_fn(|i| anchor[i] + off(i));
        let seen = core::array::from_fn(|i| pose[i] + sigmas[i] * random.gaussian());
        let placed = place(at, seen);
        for i in 0..3 {
            for j in 0..3 {
                sum[i][j] += (placed[i] - centre[i]) * (placed[j] - centre[j]) / DRAWS as f64;
            }
        }
    }
    sum
}

#[test]
fn a_pose_beyond_an_anchor_is_as_uncertain_as_one_that_is_drawn() {
    for turn in [0.02, 0.09, 0.4, 1.0] {
        // Position errors that go with the turn, as those of a drive into the unknown do.
        let factor = [[0.5, 0.0, 0.0], [0.2, 0.8, 0.0], [-0.3 * turn, 0.5 * turn, turn]];
        let product = |i: usize, j: usize| (0..3).map(|k| factor[i][k] * factor[j][k]).sum::<f64>();
        let anchor = Anchor::new(
            Pose { x_m: 3.0, y_m: -1.0, theta_rad: 0.7 },
            core::array::from_fn(|i| core::array::from_fn(|j| product(i, j) as f32)),
        );
        let (pose, sigmas) = (Pose { x_m: 4.0, y_m: 2.0, theta_rad: -1.0 }, [0.05, 0.02, 0.01]);
        let own = core::array::from_fn(|i| {
            core::array::from_fn(|j| if i == j { (sigmas[i] * sigmas[i]) as f32 } else { 0.0 })
        });
        let placed = anchor.covariance_beyond(&anchor.covariance.matrix(), &pose, &own);
        let drawn = drawn(&anchor.pose, &factor, &pose, sigmas);
        for i in 0..3 {
            for j in 0..3 {
                let scale = (drawn[i][i] * drawn[j][j]).sqrt();
                let off = (f64::from(placed[i][j]) - drawn[i][j]).abs() / scale;
                assert!(off < 0.02, "turn {turn}, {i}, {j}: {} is not {}", placed[i][j], drawn[i][j]);
            }
        }
    }
}

#[test]
fn a_known_start_is_not_left_behind_and_an_unknown_one_is() {
    let filter = |heading_rad: f32| {
        let mut ekf = Ekf::<{ storage(16) }>::EMPTY;
        for (mean, sigma) in [(2.0, 0.5), (-1.0, 0.5), (0.3, heading_rad), (0.0, 0.0), (1.01, 0.005)] {
            ekf.augment(mean, &Jacobian::new(), sigma * sigma);
        }
        ekf
    };
    let known = filter(0.05);
    assert!(!Anchor::is_due(&known));
    let mut unknown = filter(0.1);
    assert!(Anchor::is_due(&unknown));
    let anchor = Anchor::START.drop_at(&mut unknown, [1e-8, 0.0, 1e-6], &DriveStates::NONE);
    assert_eq!((anchor.pose.x_m, anchor.pose.y_m, anchor.pose.theta_rad), (2.0, -1.0, 0.3));
    assert_eq!([0, 1, 2].map(|i| unknown.mean(i)), [0.0; 3]);
    assert_eq!([0, 1, 2].map(|i| unknown.covariance(i, i)), [1e-8, 0.0, 1e-6]);
    assert_eq!((unknown.mean(4), unknown.covariance(4, 4)), (1.01, 0.005 * 0.005), "the calibration is kept");
}

/// Two metres straight ahead by wheels of which it is not known by how much a metre turns the robot; later that is.
#[test]
fn an_anchor_goes_where_the_calibration_tells() {
    const LENGTH_M: f32 = 2.0;
    const SIGMA: f32 = 0.2;
    const VEER: usize = 4;
    let by_veer = [0.0, 0.5 * LENGTH_M * LENGTH_M, LENGTH_M];
    let mut ekf = Ekf::<{ storage(16) }>::EMPTY;
    for mean in [LENGTH_M, 0.0, 0.0, 0.0] {
        ekf.augment(mean, &Jacobian::new(), 1e-6);
    }
    ekf.augment(0.0, &Jacobian::new(), SIGMA * SIGMA);
    for (i, by) in by_veer.into_iter().enumerate() {
        ekf.correlate(i, VEER, by * SIGMA * SIGMA);
        for (j, other) in by_veer.into_iter().enumerate().skip(i) {
            ekf.correlate(i, j, by * other * SIGMA * SIGMA);
        }
    }
    let states = DriveStates { third: Some(VEER as u16), ..DriveStates::NONE };
    let sigma_rad = |anchor: &Anchor, ekf: &EkfView| anchor.whole_covariance(ekf, &states)[2][2].sqrt();
    let mut anchor = Anchor::START.drop_at(&mut ekf, [1e-8, 0.0, 1e-6], &states);
    assert!((sigma_rad(&anchor, &ekf) - LENGTH_M * SIGMA).abs() < 1e-3);
    let before = anchor.pose;
    anchor.follow(&ekf, &states);
    assert_eq!(anchor.pose, before);
    // A little at a time, as readings tell it.
    for step in 1..=100 {
        ekf.set_mean(VEER, 0.004 * step as f32);
        anchor.follow(&ekf, &states);
    }
    let veer = ekf.mean(VEER);
    let turn_rad = veer * LENGTH_M;
    let end_m = [turn_rad.sin(), 1.0 - turn_rad.cos()].map(|share| share / veer);
    let Pose { x_m, y_m, theta_rad } = anchor.pose;
    assert!((theta_rad - turn_rad).abs() < 1e-3, "{theta_rad} is not {turn_rad}");
    assert!((x_m - end_m[0]).abs() < 0.02 && (y_m - end_m[1]).abs() < 0.02, "({x_m}, {y_m}) is not {end_m:?}");
    ekf.initialise(VEER, veer, &Jacobian::new(), 1e-6);
    assert!(sigma_rad(&anchor, &ekf) < 0.02 * SIGMA * LENGTH_M);
}

/// A path with a constant heading error: what it lacks along the heading, in mean square over the errors.
#[test]
fn a_shortfall_is_that_of_a_heading_that_is_off() {
    const SIGMA: f64 = 0.2;
    let mut shortfall = Shortfall::NONE;
    let grown: f32 = (0..1000).map(|_| shortfall.advance(0.01, (SIGMA * SIGMA) as f32)).sum();
    let mut random = Random::new(2);
    let drawn = (0..100_000).map(|_| (10.0 * (1.0 - (SIGMA * random.gaussian()).cos())).powi(2)).sum::<f64>() / 1e5;
    assert!((f64::from(grown) / drawn - 1.0).abs() < 0.1, "{grown} is not {drawn}");
}

#[test]
fn rounding_is_given_back_to_what_is_as_large_as_asked() {
    let mut ekf = Ekf::<{ storage(16) }>::EMPTY;
    for variance in [4.0, 0.0, 1e-4] {
        ekf.augment(0.0, &Jacobian::new(), variance);
    }
    ekf.restore_rounding(0.01);
    assert!(ekf.covariance(0, 0) > 4.0 && ekf.covariance(0, 0) < 4.000_002);
    assert_eq!((ekf.covariance(1, 1), ekf.covariance(2, 2)), (0.0, 1e-4));
    ekf.restore_rounding(0.0);
    assert!(ekf.covariance(2, 2) > 1e-4 && ekf.covariance(1, 1) == 0.0);
}
