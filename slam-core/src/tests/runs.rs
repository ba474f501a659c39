//! A whole run of the f32 estimator with an f64 dense Joseph-form filter beside it.
//!
//! The oracle has its own mean, its own models, its own numerical derivatives; it takes from the estimator only which
//! wall a reading belongs to. Where the map itself changes (births, mergers, the grid) it starts again from the
//! estimator's state: those operations have tests of their own.

use std::vec;
use std::vec::Vec;

use super::numeric::{arc, beam, ray_to_line, slope};
use super::oracle::{Matrix, Oracle, dot, is_positive, sandwich};
use super::random::Random;
use crate::filter::layout::{ALPHA, THETA, X, Y};
use crate::walls::wall::WallPolicy;
use crate::walls::wall::{Direction, Wall};
use crate::{
    Config, DriveModel, Linearisation, Motion, Mount, Outcome, RangeInput, RangeModel, RangeSensor, Rig, RobotSlam,
    Sample, Slip, StepReport, Ticks,
};

const TRACK_M: f64 = 0.235;
const METRES_PER_TICK: f64 = 1e-4;
const WHEEL_NOISE: f64 = 1e-5;
const NOISE_M: f64 = 0.01;
const NOISE_REL: f64 = 0.01;
/// Walls at x = 2.5, y = 2.2, x = -1.5 and y = -1.6.
const ROOM: [f64; 4] = [2.5, 2.2, 1.5, 1.6];

pub(super) fn rig() -> Rig<8> {
    let sensors = (0..8).map(|i| {
        let bearing_rad = core::f32::consts::FRAC_PI_4 * i as f32;
        RangeSensor {
            mount: Mount { x_m: 0.1 * bearing_rad.cos() + 0.02, y_m: 0.1 * bearing_rad.sin(), bearing_rad },
            min_m: 0.1,
            max_m: 4.0,
            max_incidence_rad: 1.2,
            gain_sigma: 0.01,
            model: RangeModel::Metric { noise_m: NOISE_M as f32, noise_rel: NOISE_REL as f32 },
        }
    });
    let drive = DriveModel::Wheels {
        track_m: TRACK_M as f32,
        track_sigma: 0.005,
        metres_per_tick: METRES_PER_TICK as f32,
        scale_sigma: 0.005,
        noise_m2_per_m: WHEEL_NOISE as f32,
    };
    Rig { drive, adc: None, sensors: sensors.collect() }
}

fn mount(sensor: &RangeSensor) -> [f64; 3] {
    [sensor.mount.x_m, sensor.mount.y_m, sensor.mount.bearing_rad].map(f64::from)
}

/// The robot as it really is, driving figures of eight in its room.
pub(super) struct Truth {
    pub(super) pose: [f64; 3],
    rolled_m: [f64; 2],
    scales: [f64; 2],
    gains: [f64; 8],
    random: Random,
}

impl Truth {
    pub(super) fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let mut about_one = |sigma: f64| 1.0 + sigma * random.gaussian();
        let (scales, gains) = ([0; 2].map(|_| about_one(0.005)), [0; 8].map(|_| about_one(0.01)));
        Self { pose: [0.0; 3], rolled_m: [0.0; 2], scales, gains, random }
    }

    /// 1 cm on, and what is sensed there.
    pub(super) fn step(&mut self, rig: &Rig<8>, number: u64) -> Sample<8> {
        let turn = if (number / 377).is_multiple_of(2) { 0.01 / 0.6 } else { -0.01 / 0.6 };
        let wheels = [0.01 - 0.5 * TRACK_M * turn, 0.01 + 0.5 * TRACK_M * turn];
        self.pose = arc(self.pose, wheels[0], wheels[1], TRACK_M);
        let ticks = [0, 1].map(|i| {
            let noise = (WHEEL_NOISE * wheels[i].abs()).sqrt() * self.random.gaussian();
            self.rolled_m[i] += (wheels[i] + noise) / self.scales[i];
            (self.rolled_m[i] / METRES_PER_TICK).floor() as i32
        });
        let mut ranges = [RangeInput::Missing; 8];
        for (i, (range, sensor)) in ranges.iter_mut().zip(&rig.sensors).enumerate() {
            let (origin, phi) = beam(self.pose, mount(sensor));
            let hits = ROOM.iter().enumerate().filter_map(|(k, rho)| {
                // The start is the map's origin; the room's walls are a quarter turn apart.
                let beta = core::f64::consts::FRAC_PI_2 * k as f64;
                ((beta - phi).cos() > 0.01).then(|| ray_to_line(origin, phi, *rho, beta))
            });
            let true_m = hits.fold(f64::INFINITY, f64::min);
            let sigma = NOISE_M.hypot(NOISE_REL * true_m);
            *range = RangeInput::Metres((self.gains[i] * true_m + sigma * self.random.gaussian()) as f32);
        }
        let motion = Motion::Ticks(Ticks { left: ticks[0], right: ticks[1] });
        Sample { time_us: 40_000 * (number + 1), motion, ranges }
    }
}

/// What of the map the oracle must know; as long as it stays the same the oracle runs on its own.
fn structure(slam: &RobotSlam) -> (usize, bool, Vec<(u16, usize, Direction)>) {
    (slam.ekf.len(), slam.map.has_grid, slam.map.walls().iter().map(|w| (w.id, w.rho(), w.direction)).collect())
}

fn ticks(sample: &Sample<8>) -> [f64; 2] {
    match sample.motion {
        Motion::Ticks(t) => [t.left.into(), t.right.into()],
        Motion::Increment(_) => [0.0; 2],
    }
}

fn factor(slam: &RobotSlam, which: usize, state: &[f64]) -> f64 {
    let layout = slam.drive.states.in_order();
    layout[which].map_or(1.0, |i| state[i])
}

/// F P F^T + G W G^T over the exact arc. `steady` is what the wheels travelled in each of the steps before on average,
/// which is what their factors multiply in F; `first` is the pose that was predicted last.
fn predict(oracle: &mut Oracle, slam: &RobotSlam, raw: [f64; 2], steady: [f64; 2], first: &mut [f64; 3]) {
    let after = |s: &[f64], raw: [f64; 2]| {
        let track = factor(slam, 2, s) * f64::from(TRACK_M as f32);
        arc([s[X], s[Y], s[THETA]], factor(slam, 0, s) * raw[0], factor(slam, 1, s) * raw[1], track)
    };
    let mean = oracle.mean.clone();
    let factors = slam.drive.states.in_order();
    let travelled = |state: usize| if factors.contains(&Some(state)) { steady } else { raw };
    let mut rows: [Vec<f64>; 3] =
        [0, 1, 2].map(|i| (0..mean.len()).map(|j| slope(|s| after(s, travelled(j))[i], &mean, j)).collect());
    let predicted = after(&mean, raw);
    if slam.config.measurement.linearisation == Linearisation::FirstEstimates {
        rows[X][THETA] = first[Y] - predicted[Y];
        rows[Y][THETA] = predicted[X] - first[X];
    }
    *first = predicted;
    let rolled = [factor(slam, 0, &mean) * raw[0], factor(slam, 1, &mean) * raw[1]];
    let track = factor(slam, 2, &mean) * f64::from(TRACK_M as f32);
    let by_wheel: Matrix = (0..3)
        .map(|i| {
            (0..2).map(|w| slope(|r| arc([mean[X], mean[Y], mean[THETA]], r[0], r[1], track)[i], &rolled, w)).collect()
        })
        .collect();
    let wheel = |i: usize| f64::from(WHEEL_NOISE as f32) * rolled[i].abs();
    let noise = sandwich(&by_wheel, &vec![vec![wheel(0), 0.0], vec![0.0, wheel(1)]]);
    let noise = [0, 1, 2].map(|i| [0, 1, 2].map(|j| noise[i][j]));
    oracle.predict(predicted, &rows, &noise);
}

/// One reading on one wall. How noisy it is, the estimator decides (the surface, a wall's end): `variance` is its own
/// innovation variance, of which the oracle subtracts what it knows the states to contribute.
fn observe(
    oracle: &mut Oracle,
    slam: &RobotSlam,
    sensor: usize,
    wall: &Wall,
    (read_m, variance): (f32, f64),
    first: &[f64; 3],
) -> f64 {
    let mount = mount(&slam.rig.sensors[sensor]);
    let range = |s: &[f64]| {
        let (origin, phi) = beam([s[X], s[Y], s[THETA]], mount);
        let beta = match wall.direction {
            Direction::Grid(quarter) => s[ALPHA] + core::f64::consts::FRAC_PI_2 * f64::from(quarter),
            Direction::Free(theta) | Direction::NearGrid(theta, _) | Direction::Built(theta, _) => {
                s[usize::from(theta)]
            }
            Direction::Snapped(theta) => {
                let quarters = ((s[usize::from(theta)] - s[ALPHA]) / core::f64::consts::FRAC_PI_2).round();
                s[ALPHA] + quarters * core::f64::consts::FRAC_PI_2
            }
        };
        slam.sensors[sensor].gain_state().map_or(1.0, |i| s[i]) * ray_to_line(origin, phi, s[wall.rho()], beta)
    };
    let mean = oracle.mean.clone();
    let predicted_m = range(&mean);
    let mut h: Vec<f64> = (0..mean.len()).map(|j| slope(range, &mean, j)).collect();
    if slam.config.measurement.linearisation == Linearisation::FirstEstimates {
        let [nx, ny] = wall.first_normal.map(f64::from);
        (h[X], h[Y]) = (-nx * h[wall.rho()], -ny * h[wall.rho()]);
        let beta = wall.direction.turns_with();
        // No reading tells when everything is turned about the origin.
        h[beta] = first[Y] * h[X] - first[X] * h[Y] - h[THETA];
    }
    let ph: Vec<f64> = oracle.covariance.iter().map(|row| dot(row, &h)).collect();
    let noise = variance - dot(&ph, &h);
    let least = NOISE_M.hypot(NOISE_REL * predicted_m).powi(2);
    assert!(noise > 0.99 * least && noise < 10.0 * least, "noise {noise} of a sensor with {least}");
    let innovation = f64::from(read_m) - predicted_m;
    oracle.update(innovation, &h, noise);
    innovation
}

fn follow(
    oracle: &mut Oracle,
    slam: &RobotSlam,
    walls: &[Wall],
    sample: &Sample<8>,
    report: &StepReport<8>,
    first: &[f64; 3],
) -> usize {
    let mut updates = 0;
    for (i, reading) in report.readings.iter().enumerate() {
        let (Outcome::Updated { wall, innovation_m, variance_m2, .. }, RangeInput::Metres(read_m)) =
            (reading.outcome, sample.ranges[i])
        else {
            continue;
        };
        let wall = walls.iter().find(|w| w.id == wall).unwrap();
        let innovation = observe(oracle, slam, i, wall, (read_m, variance_m2.into()), first);
        assert!((f64::from(innovation_m) - innovation).abs() < 1e-4, "innovation {innovation_m}, not {innovation}");
        updates += 1;
    }
    let theta = &mut oracle.mean[THETA];
    *theta = theta.sin().atan2(theta.cos());
    updates
}

/// A wall whose normal is another one since: its distance, by which everything moves as it did.
fn restate(oracle: &mut Oracle, slam: &RobotSlam, walls: &[Wall], first: &[f64; 3]) -> usize {
    let mut renewed = 0;
    for (before, now) in walls.iter().zip(slam.map.walls()) {
        let by = [0, 1].map(|i| f64::from(now.first_normal[i]) - f64::from(before.first_normal[i]));
        if by == [0.0; 2] {
            continue;
        }
        let n = oracle.mean.len();
        let mut with: Matrix = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
        let row = &mut with[now.rho()];
        (row[X], row[Y], row[THETA]) = (by[0], by[1], by[0] * first[Y] - by[1] * first[X]);
        oracle.covariance = sandwich(&with, &oracle.covariance);
        renewed += 1;
    }
    renewed
}

fn run(policy: WallPolicy, linearisation: Linearisation, seed: u64, steps: u64) {
    let rig = rig();
    // What repeats is learned from the readings, and so is how much wheels slip, which the oracle does not do.
    let mut config = Config::default();
    config.motion.slip = Slip::Stated;
    config.walls.policy = policy;
    config.measurement.linearisation = linearisation;
    config.sensing.repeats = false;
    config.sensing.bends = false;
    config.measurement.clutter = false;
    let mut truth = Truth::new(seed);
    let mut first = [0.0; 3];
    let mut slam = RobotSlam::with_config(rig.clone(), config).unwrap();
    let mut oracle = Oracle::of(&slam.ekf);
    let (mut last, mut steady) = (None::<[f64; 2]>, [0.0; 2]);
    let (mut updates, mut restarts, mut longest, mut alone, mut renewed) = (0, 0, 0, 0, 0);
    let mut worst = (0.0f64, 0.0f64);
    for number in 0..steps {
        let sample = truth.step(&rig, number);
        let now = ticks(&sample);
        if let Some(last) = last {
            let raw = [0, 1].map(|i| (now[i] - last[i]) * f64::from(METRES_PER_TICK as f32));
            predict(&mut oracle, &slam, raw, steady, &mut first);
            // A step is two fifths of the time over which motion is averaged.
            steady = [0, 1].map(|i| steady[i] + 0.4 * (raw[i] - steady[i]));
        }
        last = Some(now);
        let (before, walls) = (structure(&slam), slam.map.walls().to_vec());
        let report = slam.step(&sample);
        if structure(&slam) != before || report.births + report.merges + report.prunes > 0 {
            oracle = Oracle::of(&slam.ekf);
            (restarts, alone) = (restarts + 1, 0);
        } else {
            updates += follow(&mut oracle, &slam, &walls, &sample, &report, &first);
            renewed += restate(&mut oracle, &slam, &walls, &first);
            alone += 1;
            longest = longest.max(alone);
        }
        if number % 20 == 0 {
            worst.0 = worst.0.max(oracle.covariance_error(&slam.ekf));
            worst.1 = worst.1.max(oracle.mean_error(&slam.ekf));
        }
        if number % 100 == 0 {
            // The direction that founded the grid of snapped walls stays beside alpha, which equals it: singular.
            let slack = if matches!(policy, WallPolicy::Snapped { .. }) { 1e-5 } else { 0.0 };
            assert!(is_positive(&Oracle::of(&slam.ekf).covariance, slack), "covariance at step {number}");
        }
    }
    // The room was mapped, and the oracle was on its own for most of the run.
    assert!(slam.map.walls().len() >= 4 && updates as u64 > 3 * steps, "{updates} updates");
    assert!(longest > steps / 2, "the map changed {restarts} times");
    assert_eq!(renewed > 0, linearisation == Linearisation::FirstEstimates, "{renewed} normals were taken anew");
    // Both filters linearise where they stand: a few thousandths of a sigma apart, which is what f32 may move them.
    assert!(worst.0 < 1e-3, "covariance off by {} of its sigmas", worst.0);
    assert!(worst.1 < 0.05, "mean off by {} sigma", worst.1);
}

#[test]
fn a_run_on_grid_walls_follows_the_oracle() {
    run(WallPolicy::Grid, Linearisation::Latest, 1, 8000);
}

#[test]
fn a_run_with_first_estimates_follows_the_oracle() {
    run(WallPolicy::Grid, Linearisation::FirstEstimates, 1, 8000);
}

#[test]
fn a_run_on_free_walls_follows_the_oracle() {
    run(WallPolicy::Free, Linearisation::Latest, 2, 2000);
}

#[test]
fn a_run_on_free_walls_with_first_estimates_follows_the_oracle() {
    run(WallPolicy::Free, Linearisation::FirstEstimates, 2, 4000);
}

#[test]
fn a_run_on_snapped_walls_follows_the_oracle() {
    run(WallPolicy::Snapped { theta_moves: false }, Linearisation::Latest, 3, 2000);
}

#[test]
fn a_run_on_walls_near_the_grid_follows_the_oracle() {
    run(WallPolicy::NearGrid, Linearisation::Latest, 4, 2000);
}

#[test]
fn noise_that_is_new_each_time_is_found_to_be() {
    let rig = rig();
    let mut truth = Truth::new(5);
    let mut slam = RobotSlam::with_config(rig.clone(), Config::default()).unwrap();
    for number in 0..4000 {
        slam.step(&truth.step(&rig, number));
    }
    let share = slam.correlation.share();
    assert!(share < 0.08, "{share} of it is the surface's");
}

/// The latency that is found for readings of [`Truth`] that come in `steps` steps late, and its 1-sigma, seconds.
fn found_latency(seed: u64, steps: usize) -> (f32, f32) {
    let rig = rig();
    let mut config = Config::default();
    config.sensing.calibrate_latency = true;
    let mut truth = Truth::new(seed);
    let mut slam = RobotSlam::with_config(rig.clone(), config).unwrap();
    let mut late = vec![[RangeInput::Missing; 8]; steps + 1];
    for number in 0..4000 {
        let mut sample = truth.step(&rig, number);
        late.rotate_right(1);
        late[0] = sample.ranges;
        sample.ranges = late[steps];
        slam.step(&sample);
    }
    slam.latency().unwrap()
}

/// The sigma of the stamps that is found where each row's readings are of one of the last `rows` samples, seconds.
fn found_stamp_sigma(seed: u64, rows: usize) -> f32 {
    let rig = rig();
    let mut config = Config::default();
    config.sensing.calibrate_latency = true;
    config.sensing.stamps = true;
    let (mut truth, mut random) = (Truth::new(seed), Random::new(seed));
    let mut slam = RobotSlam::with_config(rig.clone(), config).unwrap();
    let mut late = vec![[RangeInput::Missing; 8]; rows];
    for number in 0..4000 {
        let mut sample = truth.step(&rig, number);
        late.rotate_right(1);
        late[0] = sample.ranges;
        sample.ranges = late[random.below(rows)];
        slam.step(&sample);
    }
    slam.stamp_sigma().unwrap()
}

/// Five samples 40 ms apart, each as likely as the others, have a standard deviation of 57 ms.
#[test]
fn how_far_stamps_are_off_is_found() {
    let (exact_s, far_s) = (found_stamp_sigma(9, 1), found_stamp_sigma(9, 5));
    assert!(exact_s < 0.02, "{exact_s} s where stamps are exact");
    assert!((far_s - 0.057).abs() < 0.015, "{far_s} s, not 57 ms");
}

/// To 20 ms: half a step, in which this robot moves by 5 mm.
#[test]
fn the_age_of_readings_is_found() {
    for (seed, steps) in [(6, 2), (8, 1)] {
        let (latency_s, sigma_s) = found_latency(seed, steps);
        assert!(sigma_s < 0.005, "{sigma_s} s");
        assert!((latency_s - 0.04 * steps as f32).abs() < 0.02, "{latency_s} s, not {steps} steps of 40 ms");
    }
}

#[test]
fn readings_that_are_surely_younger_than_half_a_step_are_of_the_moment() {
    let (latency_s, sigma_s) = found_latency(7, 0);
    assert!(latency_s.abs() < 1e-4 && sigma_s < 1e-3, "{latency_s} +- {sigma_s} s");
}
