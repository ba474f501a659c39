//! Motion on average, and what it is for.

use super::random::Random;
use crate::motion::mean_motion::MeanMotion;
use crate::motion::step::{Factor, Factors, step};
use crate::motion::travel::Travel;
use crate::{DriveModel, Increment};

#[test]
fn a_pace_follows_the_motion() {
    let moved = Increment { forward_m: 0.03, left_m: -0.01, turn_rad: 0.02 };
    let mut pace = MeanMotion::STILL;
    for _ in 0..200 {
        pace.follow(moved, 0.1, 1.0);
    }
    let over = pace.over(0.1);
    assert!((over.forward_m - 0.03).abs() < 1e-6 && (over.left_m + 0.01).abs() < 1e-6, "{over:?}");
    assert!((over.turn_rad - 0.02).abs() < 1e-6);
    pace.follow(Increment::default(), 0.0, 1.0);
    assert_eq!(pace.over(0.1), over, "no time, no motion");
    pace.follow(moved, 5.0, 1.0);
    assert!((pace.over(5.0).forward_m - 0.03).abs() < 1e-6, "a step longer than the memory is all there is");
}

#[test]
fn a_gap_is_not_driven_at_the_pace_before_it() {
    let mut pace = MeanMotion::STILL;
    let moved = Increment { forward_m: 0.03, left_m: 0.0, turn_rad: 0.02 };
    (0..200).for_each(|_| pace.follow(moved, 0.1, 1.0));
    let gap = pace.expected(Increment::default(), 3600.0, 1.0);
    assert!((gap.forward_m - 0.3).abs() < 1e-5 && (gap.turn_rad - 0.2).abs() < 1e-5, "one second of it: {gap:?}");
    assert_eq!(pace.expected(Increment::default(), 0.1, 1.0), pace.over(0.1));
}

/// The scale of an odometry that is exact but for a noise of each step that does not grow with it, by a filter of position
/// and scale on a line that measures its position in each step.
fn found_scale(steps: usize, memory_s: Option<f32>) -> f64 {
    const TRUE_M: f64 = 0.03;
    const NOISE_M2: f64 = 6e-5;
    let drive = DriveModel::Odometry {
        scale_sigma: 0.05,
        noise_m2_per_m: 0.0,
        noise_rad2_per_m: 1e-4,
        noise_rad2_per_rad: 1e-4,
        veer_sigma: 0.0,
    };
    let mut random = Random::new(3);
    let mut pace = MeanMotion::STILL;
    let (mut x, mut scale, mut truth) = (0.0f64, 1.0f64, 0.0f64);
    let mut p = [[0.0, 0.0], [0.0, 0.05f64.powi(2)]];
    for _ in 0..steps {
        truth += TRUE_M;
        let forward_m = (TRUE_M + NOISE_M2.sqrt() * random.gaussian()) as f32;
        let raw = Increment { forward_m, ..Increment::default() };
        let known = Factor { value: 1.0, state: None };
        let factors = Factors { first: Factor { value: scale as f32, state: None }, second: known, third: known };
        let made = step(&drive, &Travel::Body(raw), &factors);
        let by_factor = memory_s.map_or(made.by_factor, |memory_s| {
            pace.follow(raw, 0.1, memory_s);
            step(&drive, &Travel::Body(pace.over(0.1)), &factors).by_factor
        });
        let by = f64::from(by_factor[0][0]);
        x += f64::from(made.increment.forward_m);
        p[0][0] += 2.0 * by * p[0][1] + by * by * p[1][1] + NOISE_M2;
        p[0][1] += by * p[1][1];
        let variance = p[0][0] + 1e-6;
        let gain = [p[0][0] / variance, p[0][1] / variance];
        let innovation = truth + 1e-3 * random.gaussian() - x;
        (x, scale) = (x + gain[0] * innovation, scale + gain[1] * innovation);
        p = [[p[0][0] - gain[0] * p[0][0], p[0][1] - gain[0] * p[0][1]], [0.0, p[1][1] - gain[1] * p[0][1]]];
    }
    scale
}

#[test]
fn the_noise_of_single_steps_does_not_draw_the_scale_down() {
    let (single, mean) = (found_scale(20_000, None), found_scale(20_000, Some(1.0)));
    assert!(single < 0.95, "{single}: the noise is a fifteenth of a step's square");
    assert!((mean - 1.0).abs() < 0.015, "{mean}");
}
