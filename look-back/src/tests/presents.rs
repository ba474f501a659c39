//! From the last keyframe that was placed to the present, and into a filter.

use std::vec::Vec;

use nalgebra::{DMatrix, DVector};
use slam_core::{
    Config, Increment, Motion, Mount, NotTaken, RangeInput, RangeModel, RangeSensor, Rig, RobotSlam, Sample,
};

use super::drive::DRIVE;
use super::random::Random;
use crate::rows::{DISTANCE, LAST_POSE, Row, TURN, VEER, WALLS};
use crate::system::System;
use crate::{BackEnd, border_len, packed_len};

const W: usize = 4;
const B: usize = border_len(W);
type Small = System<B, { packed_len(B) }>;

/// A system with a known covariance, and the same dense.
fn known(seed: u64) -> (Small, DMatrix<f64>) {
    let mut random = Random(seed);
    let factor = DMatrix::from_fn(B, B, |_, _| random.normal());
    let information = &factor * factor.transpose() + DMatrix::identity(B, B) * 3.0;
    let mut system = Small::NEW;
    system.begin(W);
    for i in 0..B {
        for j in 0..=i {
            system.add_entry(i, j, information[(i, j)] as f32);
        }
    }
    (0..B).for_each(|row| assert!(system.factor_row(row)));
    (0..B).for_each(|row| assert!(system.invert_row(row)));
    (0..B).for_each(|row| assert!(system.square_row(row)));
    assert!(!system.factor_row(B) && !system.invert_row(B) && !system.square_row(B));
    system.settle();
    (system, information.try_inverse().expect("positive"))
}

fn compare(system: &Small, dense: &DMatrix<f64>, what: &str) {
    for i in 0..B {
        for j in 0..B {
            let size = (dense[(i, i)] * dense[(j, j)]).sqrt();
            let off = (f64::from(system.covariance(i, j)) - dense[(i, j)]).abs();
            assert!(off < 2e-4 * size, "{what}, {i} {j}: {off} of {size}");
        }
    }
}

#[test]
fn the_factor_s_inverse_motions_and_updates_are_those_of_a_dense_filter() {
    for seed in 1..=10 {
        let (mut system, mut dense) = known(seed);
        let mut mean: DVector<f64> = DVector::zeros(B);
        compare(&system, &dense, "inverse");
        let mut random = Random(100 + seed);
        for _ in 0..5 {
            let mut value = || random.normal() as f32;
            let by = [
                [(LAST_POSE + 2, value()), (DISTANCE, value()), (0, 0.0)],
                [(LAST_POSE + 2, value()), (DISTANCE, value()), (0, 0.0)],
                [(TURN, value()), (VEER, value()), (0, 0.0)],
            ];
            let noise = [0.1, 0.2, 0.3];
            let mut f: DMatrix<f64> = DMatrix::identity(B, B);
            let mut q: DMatrix<f64> = DMatrix::zeros(B, B);
            for (i, by) in by.iter().enumerate() {
                q[(LAST_POSE + i, LAST_POSE + i)] = f64::from(noise[i]);
                by.iter().for_each(|(j, value)| f[(LAST_POSE + i, *j)] += f64::from(*value));
            }
            let taken = system.take_pose();
            (0..3).for_each(|i| {
                assert!((f64::from(taken[i]) - mean[LAST_POSE + i]).abs() < 1e-3);
                mean[LAST_POSE + i] = 0.0;
            });
            system.move_on(&by, noise);
            dense = &f * dense * f.transpose() + q;
            compare(&system, &dense, "motion");
            let rows = [2.0, 0.5].map(|weight| Row {
                residual: value(),
                weight,
                here: [value(), value(), value()],
                next: [0.0; 3],
                border: [(WALLS + 2, value()), (WALLS + 3, value()), (DISTANCE, value())],
            });
            system.update(&rows, f32::INFINITY);
            for row in rows {
                let mut h: DVector<f64> = DVector::zeros(B);
                (0..3).for_each(|i| h[LAST_POSE + i] = f64::from(row.here[i]));
                row.border.iter().for_each(|(j, value)| h[*j] += f64::from(*value));
                let column = &dense * &h;
                let variance = h.dot(&column) + 1.0 / f64::from(row.weight);
                mean += &column * ((-f64::from(row.residual) - h.dot(&mean)) / variance);
                dense -= &column * column.transpose() / variance;
            }
            compare(&system, &dense, "update");
            (0..B).for_each(|i| assert!((f64::from(system.increment(i)) - mean[i]).abs() < 1e-3, "{i}"));
        }
        let far = Row { residual: 1e3, weight: 1.0, here: [1.0, 0.0, 0.0], next: [0.0; 3], border: [(0, 0.0); 3] };
        let unknown = Row { residual: f32::NAN, ..far };
        system.update(&[far, unknown], 25.0);
        compare(&system, &dense, "what is far off or no number is not taken");
        assert!((0..B).all(|i| (f64::from(system.increment(i)) - mean[i]).abs() < 1e-3));
    }
}

type SmallBackEnd = BackEnd<64, 256, 16, { border_len(16) }, { packed_len(border_len(16)) }>;

/// A robot with four exact beams goes round in a room of 4 m by 3 m.
struct Robot {
    slam: RobotSlam,
    back: SmallBackEnd,
    random: Random,
    time_us: u64,
}

impl Robot {
    fn new() -> Self {
        let sensor = |i: u8| RangeSensor {
            mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: 0.3 + 1.57 * f32::from(i) },
            min_m: 0.05,
            max_m: 5.0,
            max_incidence_rad: 1.2,
            gain_sigma: 0.0,
            model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 },
        };
        let rig = Rig { drive: DRIVE, adc: None, sensors: (0..4).map(sensor).collect() };
        let slam = RobotSlam::with_config(rig, Config::real_rooms()).expect("a good rig");
        Self { slam, back: SmallBackEnd::IDLE, random: Random(7), time_us: 0 }
    }

    /// Steps of 40 ms on a circle of 0.8 m about the room's middle; what came of each hand-over.
    fn drive(&mut self, steps: usize) -> Vec<Result<(), NotTaken>> {
        let mut handed = Vec::new();
        for _ in 0..steps {
            let turned = 0.02 * (self.time_us / 40_000) as f64;
            let pose = [2.0 + 0.8 * turned.sin(), 1.5 - 0.8 * turned.cos(), turned];
            let noise = 1.0 + 0.02 * self.random.normal();
            let moved = Increment { forward_m: (0.016 * noise) as f32, left_m: 0.0, turn_rad: 0.02 };
            let mut ranges = [RangeInput::Missing; 8];
            for (i, range) in ranges.iter_mut().take(4).enumerate() {
                let bearing = pose[2] + 0.3 + 1.57 * i as f64;
                let (s, c) = bearing.sin_cos();
                let to = |far: f64, at: f64, way: f64| if way * (far - at) > 0.0 { (far - at) / way } else { f64::MAX };
                let all = [to(4.0, pose[0], c), to(0.0, pose[0], c), to(3.0, pose[1], s), to(0.0, pose[1], s)];
                let metres = all.into_iter().fold(f64::MAX, f64::min) + 0.01 * self.random.normal();
                *range = RangeInput::Metres(metres as f32);
            }
            handed.extend(self.back.hand_over(&mut self.slam));
            self.time_us += 40_000;
            let sample = Sample { time_us: self.time_us, motion: Motion::Increment(moved), ranges };
            let report = self.slam.step(&sample);
            self.back.record(&self.slam, &report);
            self.back.work(40_000);
        }
        handed
    }
}

#[test]
fn a_robot_takes_over_what_its_back_end_finds_and_goes_on() {
    let mut robot = Robot::new();
    let handed = robot.drive(3000);
    let taken = handed.iter().filter(|taken| taken.is_ok()).count();
    assert!(taken >= 3, "{handed:?}");
    let counters = robot.slam.counters();
    assert_eq!(counters.taken_over as usize, taken);
    // Later on the filter knows better where it is: of its readings fewer say the same.
    assert_eq!(counters.not_taken[NotTaken::LessSure as usize] as usize, handed.len() - taken);
    let used = f64::from(counters.updates) / (4.0 * 3000.0);
    assert!(used > 0.8, "readings are of the walls that were taken over: {used}");
    let walls: Vec<f32> = robot.slam.walls().map(|wall| wall.sigma_rho_m).collect();
    assert_eq!(walls.len(), 4, "{walls:?}");
}

#[test]
fn a_look_back_on_a_drive_that_ended_is_thrown_away() {
    let mut robot = Robot::new();
    // Lifted in the middle of a look back: where it is put down a new map begins.
    while !robot.back.is_looking_back() {
        robot.drive(1);
    }
    let before = robot.slam.epoch();
    robot.slam.restart_map();
    assert_ne!(robot.slam.epoch(), before);
    assert_eq!(robot.drive(10), []);
    assert!(!robot.back.is_looking_back());
    assert_eq!(robot.back.tally().outdated, 1);
    assert_eq!(robot.back.diary().keyframes().len(), 1);
    assert!(robot.drive(1500).contains(&Ok(())), "the next drive is looked back on");
}

#[test]
fn what_is_found_when_the_filter_has_begun_anew_is_refused() {
    let mut robot = Robot::new();
    let mut handed = Vec::new();
    while handed.is_empty() {
        // Between the last slice of a look back and the hand-over.
        if robot.back.is_ready() {
            robot.slam.restart_map();
        }
        handed = robot.drive(1);
    }
    assert_eq!(handed, [Err(NotTaken::Outdated)]);
    assert_eq!(robot.slam.counters().not_taken[NotTaken::Outdated as usize], 1);
}
