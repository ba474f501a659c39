//! Motions of many stretches made one: where they end, and how well that is known.

use std::vec::Vec;

use slam_core::{Calibration, DriveModel, Increment, Pose};

use super::random::Random;
use crate::Diary;
use crate::keyframe::Keyframe;
use crate::rows::{DISTANCE, Odometry};

/// Errors are those of headings alone: wheels whose positions are exact.
const DRIVE: DriveModel = DriveModel::Odometry {
    scale_sigma: 0.0,
    noise_m2_per_m: 0.0,
    noise_rad2_per_m: 1e-5,
    noise_rad2_per_rad: 1e-5,
    veer_sigma: 0.0,
};

/// So much heading is off after a metre or a radian, 1-sigma.
const SIGMA_RAD: f64 = 0.003_162;

const DRIVES: u64 = 400;

/// The keyframe of one stretch.
fn stretch([forward_m, turn_rad]: [f64; 2]) -> Keyframe {
    let mut diary: Diary<4, 4, 1> = Diary::new(&DRIVE, Pose::ORIGIN);
    diary.travel(&Increment { forward_m: forward_m as f32, left_m: 0.0, turn_rad: turn_rad as f32 });
    *diary.keyframes.last().expect("the first")
}

/// All of them, put together in pairs of neighbours, or each to all before it.
fn one(stretches: &[[f64; 2]], in_pairs: bool, calibration: &Calibration) -> Keyframe {
    let over = |first: &Keyframe, second: &Keyframe| {
        let [_, heading_rad2] = Odometry::of(&DRIVE).variances(first);
        first.over(second, calibration, heading_rad2)
    };
    let mut keys: Vec<Keyframe> = stretches.iter().map(|stretch_of| stretch(*stretch_of)).collect();
    while let [first, second, rest @ ..] = &keys[..] {
        let both = |pair: &[Keyframe]| match pair {
            [first, second] => over(first, second),
            rest => rest[0],
        };
        keys = if in_pairs {
            keys.chunks(2).map(both).collect()
        } else {
            [over(first, second)].into_iter().chain(rest.iter().copied()).collect()
        };
    }
    keys[0]
}

/// Where they end: x, y, and all turning.
fn end(stretches: impl Iterator<Item = [f64; 2]>) -> [f64; 3] {
    stretches.fold([0.0; 3], |[x, y, theta], [forward, turn]| {
        [x + forward * theta.cos(), y + forward * theta.sin(), theta + turn]
    })
}

fn drives() -> [(&'static str, Vec<[f64; 2]>); 4] {
    let straight = std::vec![[0.25, 0.0]; 64];
    let out_and_back = (0..64).map(|i| [0.25, if i == 31 { std::f64::consts::PI } else { 0.0 }]).collect();
    let rounds = std::vec![[0.25, 0.2]; 128];
    let mut random = Random(5);
    let wander = (0..256).map(|_| [0.25, 0.5 * random.normal()]);
    [("straight", straight), ("out and back", out_and_back), ("rounds", rounds), ("wander", wander.collect())]
}

#[test]
fn where_many_stretches_end_is_known_as_well_as_their_headings_allow() {
    for (name, stretches) in drives() {
        let [x, y, _] = end(stretches.iter().copied());
        let mut random = Random(7);
        let mut square_m2 = 0.0;
        for _ in 0..DRIVES {
            let noisy = stretches.iter().map(|[forward, turn]| {
                let sigma_rad = SIGMA_RAD * (forward.abs() + turn.abs()).sqrt();
                [*forward, turn + sigma_rad * random.normal()]
            });
            let off = end(noisy);
            square_m2 += ((off[0] - x).powi(2) + (off[1] - y).powi(2)) / DRIVES as f64;
        }
        for in_pairs in [false, true] {
            let key = one(&stretches, in_pairs, &Calibration::EXACT);
            // Either axis may be the one that it is along: both have it.
            let said = 2.0 * f64::from(key.swing_m2()) / square_m2;
            assert!((0.5..6.0).contains(&said), "{name}, in pairs: {in_pairs}: {said} of {}", square_m2.sqrt());
        }
    }
}

#[test]
fn many_stretches_end_where_the_calibration_has_them_whole_turns_and_all() {
    let calibration = Calibration { distance: 0.98, turn: 1.03, veer_rad_per_m: 0.02 };
    let as_calibrated = |[forward, turn]: [f64; 2]| {
        let Calibration { distance, turn: scale, veer_rad_per_m } = calibration;
        [f64::from(distance) * forward, f64::from(scale) * (turn + f64::from(veer_rad_per_m) * forward)]
    };
    for (name, stretches) in drives() {
        let [x, y, turned] = end(stretches.iter().copied().map(as_calibrated));
        for in_pairs in [false, true] {
            let key = one(&stretches, in_pairs, &calibration);
            let next = Pose::new(x as f32, y as f32, turned as f32);
            for row in Odometry::of(&DRIVE).rows(&key, &next, &calibration) {
                assert!(row.residual.abs() < 2e-3, "{name}, in pairs: {in_pairs}: {}", row.residual);
            }
        }
    }
}

#[test]
fn a_motion_with_a_part_that_is_not_known_is_not_known() {
    let parted = |known| {
        let mut parted = stretch([0.25, 0.1]);
        parted.part_from(&Pose::new(0.3, -0.2, 0.4), &Calibration::EXACT, known);
        parted
    };
    let (known, kicked, held) = (stretch([0.25, 0.1]), parted([0.2, 0.1]), parted([0.5, 0.5]));
    for (parts, least) in [
        ([known, kicked], [0.04, 0.01]),
        ([kicked, kicked], [0.08, 0.02]),
        ([known, held], [0.25, 0.25]),
        ([kicked, held], [0.29, 0.26]),
    ] {
        for [first, second] in [parts, [parts[1], parts[0]]] {
            let [_, heading_rad2] = Odometry::of(&DRIVE).variances(&first);
            let both = first.over(&second, &Calibration::EXACT, heading_rad2);
            let variances = Odometry::of(&DRIVE).variances(&both);
            assert!((0..2).all(|i| variances[i] > 0.95 * least[i] && variances[i] < 1.25 * least[i]), "{variances:?}");
        }
    }
}

/// A robot that turns on the spot slides beside it, and the walls see that: it has not driven farther than its odometry says.
#[test]
fn where_nothing_was_sensed_the_scale_is_left_alone() {
    let turned = stretch([0.0, 0.5]);
    for next in [Pose::new(0.1, 0.0, 0.5), Pose::new(-0.1, 0.2, 0.5)] {
        let [ahead, aside, _] = Odometry::of(&DRIVE).rows(&turned, &next, &Calibration::EXACT);
        for row in [ahead, aside] {
            let by_scale: f32 = row.border.iter().filter(|(place, _)| *place == DISTANCE).map(|(_, by)| by).sum();
            assert_eq!(by_scale, 0.0, "{row:?}");
        }
        assert!((ahead.residual - next.x_m).abs() < 1e-6 && (aside.residual - next.y_m).abs() < 1e-6);
    }
}
