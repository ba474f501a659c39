//! Taking a look back over: against a dense f64 derivation, with numerical derivatives; what is refused; what goes on.

use std::vec;
use std::vec::Vec;

use super::oracle::{Matrix, Oracle, is_positive, sandwich};
use super::random::Random;
use crate::filter::ekf::Jacobian;
use crate::filter::layout::{self, THETA, X, Y};
use crate::hand_over::{self, Calibration, HandOver, PlacedWall};
use crate::walls::wall::{Direction, Wall};
use crate::{
    Config, DriveModel, MapFrame, Motion, Mount, NotTaken, Pose, RangeInput, RangeModel, RangeSensor, Rig, RobotSlam,
    Sample, Ticks,
};

const TRACK_M: f64 = 0.3;

fn rig() -> Rig<8> {
    let sensor = |bearing_rad| RangeSensor {
        mount: Mount { x_m: 0.1, y_m: 0.0, bearing_rad },
        min_m: 0.1,
        max_m: 4.0,
        max_incidence_rad: 1.2,
        gain_sigma: 0.02,
        model: RangeModel::Sharp { scale_m: 0.6, exponent: -1.16, noise_v: 0.012 },
    };
    let drive = DriveModel::Wheels {
        track_m: TRACK_M as f32,
        track_sigma: 0.01,
        metres_per_tick: 1e-4,
        scale_sigma: 0.01,
        noise_m2_per_m: 1e-5,
    };
    let adc = Some(crate::Adc { bits: 12, vref_v: 3.3 });
    Rig { drive, adc, sensors: [0.0, 1.0].map(sensor).into_iter().collect() }
}

/// A filter with two walls that are one, a third one, and one that was just born, a metre from a robot that is at (1, 2).
fn filter() -> RobotSlam {
    let mut slam = RobotSlam::new(rig()).expect("a good rig");
    slam.map.has_grid = true;
    slam.drive.dead_reckoning.path_m = 20.0;
    for (state, mean) in [(X, 1.0), (Y, 2.0), (THETA, 0.3)] {
        slam.ekf.set_mean(state, mean);
        slam.ekf.set_covariance(state, state, 0.01);
    }
    slam.ekf.set_covariance(layout::ALPHA, layout::ALPHA, 1e-4);
    let far: Jacobian = [(X, 1.0)].into_iter().collect();
    for (rho_m, quarter, updates, seen_at_m) in [(4.0, 0, 50, 5.0), (4.1, 0, 30, 19.0), (3.5, 1, 40, 19.0)] {
        let rho = slam.ekf.augment(rho_m, &far, 1e-4).expect("there is room");
        slam.map.add(Wall::at(rho, Direction::Grid(quarter), (0.0, 3.0)), updates, seen_at_m);
    }
    // Born as it was seen: its direction is the heading's, its offset the robot's.
    let seen: Jacobian = [(X, 1.0), (THETA, 2.0)].into_iter().collect();
    let rho = slam.ekf.augment(2.0, &seen, 2e-4).expect("there is room");
    let theta = slam.ekf.augment(0.1, &[(THETA, 1.0)].into_iter().collect(), 3e-4).expect("there is room");
    slam.ekf.correlate(rho, theta, 1e-4);
    slam.map.add(Wall::at(rho, Direction::Free(theta as u16), (1.0, 2.5)), 6, 20.0);
    slam
}

const WALLS: [PlacedWall; 3] = [
    PlacedWall { id: 1, rho_m: 4.05, beta_rad: 0.02, anchor_m: 1.5, lo_m: 0.0, hi_m: 3.0, hits: 90, on_grid: true },
    PlacedWall { id: 2, rho_m: 3.52, beta_rad: 1.59, anchor_m: -1.0, lo_m: -3.0, hi_m: 1.0, hits: 60, on_grid: true },
    PlacedWall { id: 9, rho_m: 5.0, beta_rad: -2.0, anchor_m: 0.7, lo_m: 0.0, hi_m: 1.4, hits: 30, on_grid: false },
];
const NAMES: [(u16, u8); 4] = [(0, 0), (1, 0), (2, 1), (9, 2)];

/// A covariance of the unknowns, sigmas of about a centimetre and a hundredth, everything correlated.
fn covariance(seed: u64) -> Matrix {
    let mut random = Random::new(seed);
    let n = hand_over::WALLS + 2 * WALLS.len();
    let factor: Matrix = (0..n).map(|_| (0..n).map(|_| 0.003 * random.gaussian()).collect()).collect();
    let entry = |i: usize, j: usize| (0..n).map(|k| factor[i][k] * factor[j][k]).sum::<f64>();
    (0..n).map(|i| (0..n).map(|j| entry(i, j) + if i == j { 1e-5 } else { 0.0 }).collect()).collect()
}

fn packed(covariance: &Matrix) -> Vec<f32> {
    let rows = covariance.iter().enumerate();
    rows.flat_map(|(i, row)| row[..=i].iter().map(|value| *value as f32).collect::<Vec<_>>()).collect()
}

fn found<'a>(slam: &RobotSlam, covariance: &'a [f32]) -> HandOver<'a> {
    HandOver {
        epoch: slam.epoch(),
        pose: Pose::new(1.02, 1.97, 0.31),
        alpha_rad: Some(0.01),
        calibration: Calibration { distance: 1.01, turn: 0.99, veer_rad_per_m: 0.02 },
        gains: [1.02, 0.98, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
        walls: &WALLS,
        names: &NAMES,
        covariance,
        is_displaced: false,
    }
}

/// The filter's states from the unknowns, in the order of pose, grid, wheels and track, gains, and then walls as they come.
fn states(x: &[f64]) -> Vec<f64> {
    let [distance, turn, veer, alpha] = [0, 1, 2, 3].map(|i| x[i]);
    let half = 0.5 * veer * TRACK_M;
    let mut all = vec![x[4], x[5], x[6], alpha, distance * (1.0 - half), distance * (1.0 + half), distance / turn];
    all.extend([x[hand_over::GAINS], x[hand_over::GAINS + 1]]);
    for (i, wall) in WALLS.iter().enumerate() {
        let (offset, turned) = (x[hand_over::WALLS + 2 * i], x[hand_over::WALLS + 2 * i + 1]);
        let (rho, beta) = (f64::from(wall.rho_m), f64::from(wall.beta_rad));
        let anchor = f64::from(wall.anchor_m);
        let at = [(rho + offset) * beta.cos() - anchor * beta.sin(), (rho + offset) * beta.sin() + anchor * beta.cos()];
        let direction = if wall.on_grid { alpha + i as f64 * core::f64::consts::FRAC_PI_2 } else { beta + turned };
        all.push(at[0] * direction.cos() + at[1] * direction.sin());
        if !wall.on_grid {
            all.push(direction);
        }
    }
    all
}

/// Each hand-over tells anew how the map lies to the start: with the start holding the frame it would turn under the robot.
#[test]
fn walls_hold_the_frame_of_a_map_that_is_taken_over() {
    for hand_overs in [false, true] {
        let config = Config { hand_overs, ..Config::for_rig(&rig()) };
        let slam = RobotSlam::with_config(rig(), config).expect("a good rig");
        assert_eq!(slam.config().walls.frame == MapFrame::Walls, hand_overs);
    }
}

#[test]
fn means_and_covariance_are_those_of_a_dense_derivation() {
    for seed in 1..=5 {
        let (mut slam, dense) = (filter(), covariance(seed));
        let entries = packed(&dense);
        let found = found(&slam, &entries);
        let mut x = vec![1.01, 0.99, 0.02, 0.01, 1.02, 1.97, 0.31, 1.02, 0.98];
        x.resize(dense.len(), 1.0);
        x[hand_over::WALLS..].fill(0.0);
        slam.replace(&found);
        let means = states(&x);
        let derivatives: Matrix = (0..means.len())
            .map(|i| {
                let by = |k: usize| {
                    let at = |d: f64| {
                        let mut moved = x.clone();
                        moved[k] += d;
                        states(&moved)[i]
                    };
                    (at(1e-5) - at(-1e-5)) / 2e-5
                };
                (0..x.len()).map(by).collect()
            })
            .collect();
        let expected = sandwich(&derivatives, &dense);
        // Pose, grid, drive and gains; the age of readings is in between; two walls on the grid, the free one.
        let age = slam.latency.state.expect("the age of analogue readings is a state");
        let places: Vec<usize> = (0..age).chain(age + 1..age + 5).collect();
        assert_eq!(places.len(), means.len());
        for (i, &a) in places.iter().enumerate() {
            assert!((f64::from(slam.ekf.mean(a)) - means[i]).abs() < 1e-5, "seed {seed}, mean {i}");
            assert_eq!(slam.ekf.covariance(a, age), 0.0);
            for (j, &b) in places.iter().enumerate() {
                let size = (expected[i][i] * expected[j][j]).sqrt();
                let off = (f64::from(slam.ekf.covariance(a, b)) - expected[i][j]).abs();
                assert!(off < 5e-4 * size, "seed {seed}, {i} {j}: {off} of {size}");
            }
        }
        assert!(is_positive(&Oracle::of(&slam.ekf).covariance, 1e-6));
    }
}

#[test]
fn walls_keep_their_names_and_those_born_since_lie_to_the_robot_as_before() {
    let mut slam = filter();
    let entries = packed(&covariance(1));
    let wall = *slam.map.walls().last().expect("there are four");
    let seen = |slam: &RobotSlam| {
        let (pose, wall) = (slam.filter_pose(), slam.map.walls().iter().find(|other| other.id == wall.id).copied());
        let wall = wall.expect("it is kept");
        let Direction::Free(theta) = wall.direction else { panic!("it is free") };
        let theta = usize::from(theta);
        let (rho_m, beta_rad) = (slam.ekf.mean(wall.rho()), slam.ekf.mean(theta));
        let (s, c) = beta_rad.sin_cos();
        let along_m = pose.y_m * c - pose.x_m * s;
        let distance: Jacobian = [(X, -c), (Y, -s), (wall.rho(), 1.0), (theta, -along_m)].into_iter().collect();
        let turn: Jacobian = [(THETA, -1.0), (theta, 1.0)].into_iter().collect();
        let means = [rho_m - pose.x_m * c - pose.y_m * s, beta_rad - pose.theta_rad, wall.lo_m - along_m];
        (means, [slam.ekf.variance(&distance), slam.ekf.variance(&turn)])
    };
    let before = seen(&slam);
    let found = found(&slam, &entries);
    slam.replace(&found);
    let after = seen(&slam);
    let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-5, "{before:?} {after:?}");
    before.0.iter().zip(after.0).for_each(|(a, b)| close(*a, b));
    before.1.iter().zip(after.1).for_each(|(a, b)| close(*a, b));
    let ids: Vec<u16> = slam.map.walls().iter().map(|wall| wall.id).collect();
    assert!(
        [0, 2, 3, 9].iter().all(|id| ids.contains(id)) && ids.len() == 4,
        "{ids:?}: of two that are one, the surer"
    );
}

#[test]
fn what_is_taken_over_is_of_another_epoch_and_what_is_refused_changes_nothing() {
    let entries: Vec<f32> = packed(&covariance(2)).iter().map(|value| 0.1 * value).collect();
    let mut slam = filter();
    let good = found(&slam, &entries);
    let nowhere = [PlacedWall { rho_m: 1.0, ..WALLS[0] }, PlacedWall { rho_m: 9.0, ..WALLS[1] }, WALLS[2]];
    let vague: Vec<f32> = entries.iter().map(|value| 1e4 * value).collect();
    let mut negative = entries.clone();
    negative[0] = -1.0;
    let bad = [
        (NotTaken::Outdated, HandOver { epoch: good.epoch.wrapping_sub(1), ..good }),
        (NotTaken::Unsound, HandOver { pose: Pose { x_m: f32::NAN, ..good.pose }, ..good }),
        (NotTaken::Unsound, HandOver { covariance: &entries[1..], ..good }),
        (NotTaken::Unsound, HandOver { covariance: &negative, ..good }),
        (NotTaken::Apart, HandOver { walls: &nowhere, ..good }),
        (NotTaken::LessSure, HandOver { covariance: &vague, ..good }),
    ];
    for (count, (reason, found)) in bad.iter().enumerate() {
        let before = (Oracle::of(&slam.ekf).covariance, slam.epoch(), slam.pose());
        assert_eq!(slam.take_over(found), Err(*reason));
        assert_eq!((Oracle::of(&slam.ekf).covariance, slam.epoch(), slam.pose()), before);
        assert_eq!(slam.counters().not_taken.iter().sum::<u32>(), count as u32 + 1);
    }
    assert_eq!(slam.take_over(&good), Ok(()));
    assert_eq!((slam.counters().taken_over, slam.epoch()), (1, good.epoch + 1));
    assert_eq!(slam.take_over(&good), Err(NotTaken::Outdated), "it was made for the filter as it was");
}

/// Of a jolt that a look back found the filter does not know, and is surer than it may be.
#[test]
fn a_filter_that_was_displaced_is_not_asked_how_sure_it_is() {
    let vague: Vec<f32> = packed(&covariance(2)).iter().map(|value| 1e3 * value).collect();
    let mut slam = filter();
    let found = found(&slam, &vague);
    assert_eq!(slam.take_over(&found), Err(NotTaken::LessSure));
    assert_eq!(slam.take_over(&HandOver { is_displaced: true, ..found }), Ok(()));
    assert_eq!(slam.counters().jolts, 1);
}

#[test]
fn the_map_frame_stays_with_the_walls() {
    let mut slam = filter();
    slam.map.frame = MapFrame::Walls;
    slam.map.hold_frame(&slam.ekf, 20.0);
    let drawn = |slam: &RobotSlam| slam.walls().find(|wall| wall.id == 2).expect("it is kept").rho_m;
    let before = drawn(&slam);
    // Everything is a decimetre farther on, the robot, too.
    let moved = WALLS.map(|wall| PlacedWall { rho_m: wall.rho_m + 0.1 * wall.beta_rad.sin(), ..wall });
    let entries = packed(&covariance(3));
    let found = HandOver { walls: &moved, pose: Pose::new(1.02, 2.07, 0.31), ..found(&slam, &entries) };
    slam.replace(&found);
    assert!((drawn(&slam) - before).abs() < 0.05, "{} {before}", drawn(&slam));
}

#[test]
fn a_wall_that_turned_does_not_take_the_map_frame_along() {
    let mut slam = filter();
    slam.map.frame = MapFrame::Walls;
    slam.map.hold_frame(&slam.ekf, 20.0);
    // The one in view turns by seventeen degrees about its middle.
    let turned = PlacedWall { rho_m: 3.66, beta_rad: 1.29, anchor_m: 0.1, on_grid: false, ..WALLS[1] };
    let entries = packed(&covariance(3));
    let found = HandOver { walls: &[WALLS[0], turned, WALLS[2]], ..found(&slam, &entries) };
    slam.replace(&found);
    assert!(slam.start_pose().theta_rad.abs() < 0.05, "{:?}", slam.start_pose());
}

/// Another map is taken over in this step, where most of what tells a hold is told.
const TAKEN_AT: u64 = 30;

/// A robot whose wheels turn while eight sensors read the same: where it is in the step in which another map is taken over or none, where it is
/// held, and the steps that it took to find out.
fn held(other: Option<&HandOver>) -> (Pose, Pose, u32) {
    let mut slam = RobotSlam::new(super::runs::rig()).expect("a good rig");
    let mut random = Random::new(7);
    let mut before = Pose::ORIGIN;
    for step in 0..100 {
        let ticks = 25 * step as i32;
        let motion = Motion::Ticks(Ticks { left: -ticks, right: ticks });
        let range = |index| RangeInput::Metres(0.7 + 0.2 * index as f32 + 0.002 * random.gaussian() as f32);
        let _ = slam.step(&Sample { time_us: 40_000 * (step + 1), motion, ranges: core::array::from_fn(range) });
        if slam.counters().holds > 0 {
            break;
        }
        if step == TAKEN_AT {
            before = slam.pose();
            other.into_iter().for_each(|found| slam.replace(found));
        }
    }
    assert_eq!(slam.counters().holds, 1);
    (before, slam.pose(), slam.counters().steps)
}

#[test]
fn what_speaks_for_a_hold_goes_on_in_the_map_that_is_taken_over() {
    let entries = packed(&covariance(4));
    let entries = &entries[..hand_over::WALLS * (hand_over::WALLS + 1) / 2];
    let other = HandOver { walls: &[], names: &[], ..found(&filter(), entries) };
    let (before, place, steps) = held(None);
    let (_, there, as_many) = held(Some(&other));
    assert!(u64::from(steps) > TAKEN_AT + 2 && as_many == steps, "{steps} {as_many}");
    let lies = other.pose.compose(&before.inverse().compose(&place)).inverse().compose(&there);
    // To what the readings since make of it; its wheels had turned it by 0.6 radians until then.
    assert!(lies.x_m.hypot(lies.y_m) < 0.1 && lies.theta_rad.abs() < 0.1, "{lies:?}");
}
