//! The f32 filter beside its f64 oracle, over random sequences of everything that can happen to it.

use std::vec;
use std::vec::Vec;

use super::oracle::{Oracle, dense, is_positive};
use super::random::Random;
use crate::filter::ekf::{Ekf, Jacobian, LEADING, MotionJacobian, storage};

/// Both filters, and a truth for them to estimate.
struct Pair<const ROWS: usize> {
    ekf: Ekf<ROWS>,
    oracle: Oracle,
    truth: Vec<f64>,
    random: Random,
}

impl<const ROWS: usize> Pair<ROWS> {
    /// Pose known, a grid that is not founded, eleven calibration factors of 1 %.
    fn new(seed: u64) -> Self {
        let ekf = Ekf::EMPTY;
        let oracle = Oracle::of(&ekf);
        let mut pair = Self { ekf, oracle, truth: Vec::new(), random: Random::new(seed) };
        for _ in 0..4 {
            pair.augment(0.0, &Jacobian::new(), 0.0);
        }
        for _ in 0..11 {
            pair.augment(1.0, &Jacobian::new(), 1e-4);
        }
        pair
    }

    fn gauss(&mut self, variance: f32) -> f64 {
        f64::from(variance).sqrt() * self.random.gaussian()
    }

    fn augment(&mut self, value: f32, jacobian: &Jacobian, noise: f32) {
        let n = self.truth.len();
        let row = dense(jacobian, n);
        let error: f64 = (0..n).map(|j| row[j] * (self.truth[j] - self.oracle.mean[j])).sum();
        let own = self.gauss(noise);
        let index = self.ekf.augment(value, jacobian, noise);
        assert_eq!(index, Some(n));
        self.oracle.augment(value.into(), &row, noise.into());
        self.truth.push(f64::from(value) + error + own);
    }

    fn initialise(&mut self, i: usize, value: f32, jacobian: &Jacobian, noise: f32) {
        let row = dense(jacobian, self.truth.len());
        let error: f64 = row.iter().enumerate().map(|(j, d)| d * (self.truth[j] - self.oracle.mean[j])).sum();
        let own = self.gauss(noise);
        self.ekf.initialise(i, value, jacobian, noise);
        self.oracle.initialise(i, value.into(), &row, noise.into());
        self.truth[i] = f64::from(value) + error + own;
    }

    /// A step of 1 cm and up to 2 degrees, with the heading and three calibration factors in its Jacobian.
    fn predict(&mut self) {
        let mut jacobian = MotionJacobian::default();
        let mut noise = [[0.0f32; 3]; 3];
        for i in 0..3 {
            jacobian[i][i] = 1.0;
            noise[i][i] = 1e-7;
        }
        for row in &mut jacobian[..2] {
            row[2] = self.random.uniform(-0.01, 0.01) as f32;
        }
        for row in &mut jacobian {
            for entry in &mut row[4..7] {
                *entry = self.random.uniform(-0.04, 0.04) as f32;
            }
        }
        (noise[0][1], noise[1][0]) = (3e-8, 3e-8);
        // A linear motion of the truth and of both estimates about their own means.
        let rows: [Vec<f64>; 3] = jacobian.map(|row| row.iter().map(|d| f64::from(*d)).collect());
        let moved = [0, 1, 2].map(|_| self.random.uniform(-0.02, 0.02));
        let by = |state: &dyn Fn(usize) -> f64, i: usize| {
            moved[i] + (0..LEADING).map(|j| rows[i][j] * state(j)).sum::<f64>()
        };
        let pose32 = [0, 1, 2].map(|i| by(&|j| f64::from(self.ekf.mean(j)), i) as f32);
        let pose64 = [0, 1, 2].map(|i| by(&|j| self.oracle.mean[j], i));
        let true_pose = [0, 1, 2].map(|i| by(&|j| self.truth[j], i));
        let own = [0, 1, 2].map(|_| self.gauss(1e-7));
        for i in 0..3 {
            self.truth[i] = true_pose[i] + own[i];
        }
        self.ekf.predict(pose32, &jacobian, &noise);
        self.oracle.predict(pose64, &rows, &noise.map(|row| row.map(f64::from)));
    }

    /// A reading of 1 cm noise on wall `rho`, with its direction, pose and a gain.
    fn update(&mut self, rho: usize) {
        let mut jacobian = Jacobian::new();
        let angle = self.random.uniform(-3.0, 3.0);
        let gain = 7 + self.random.below(8);
        let entries = [
            (0, angle.cos()),
            (1, angle.sin()),
            (2, self.random.uniform(-1.5, 1.5)),
            (3, self.random.uniform(-3.0, 3.0)),
            (gain, self.random.uniform(0.2, 1.5)),
            (rho, self.random.uniform(1.0, 2.0)),
        ];
        for (i, derivative) in entries {
            jacobian.push((i, derivative as f32)).unwrap();
        }
        let noise = 1e-4f32;
        let row = dense(&jacobian, self.truth.len());
        let own = self.gauss(noise);
        let innovation = |mean: &dyn Fn(usize) -> f64| -> f64 {
            own + row.iter().enumerate().map(|(j, d)| d * (self.truth[j] - mean(j))).sum::<f64>()
        };
        let innovation32 = innovation(&|j| f64::from(self.ekf.mean(j))) as f32;
        let innovation64 = innovation(&|j| self.oracle.mean[j]);
        let variance = f64::from(self.ekf.variance(&jacobian));
        let expected: f64 = super::oracle::sandwich(&vec![row.clone()], &self.oracle.covariance)[0][0];
        assert!((variance - expected).abs() < 0.01 * (expected + 1e-4), "{variance} {expected}");
        self.ekf.update(innovation32, &jacobian, noise).unwrap();
        self.oracle.update(innovation64, &row, noise.into());
    }

    /// A new wall's rho, seen from the present pose.
    fn birth(&mut self) {
        let mut jacobian = Jacobian::new();
        let angle = self.random.uniform(-3.0, 3.0);
        for (i, derivative) in [(0, angle.cos()), (1, angle.sin()), (2, self.random.uniform(-1.0, 1.0)), (3, 0.5)] {
            jacobian.push((i, derivative as f32)).unwrap();
        }
        let value = self.random.uniform(-3.0, 3.0) as f32;
        self.augment(value, &jacobian, 2e-5);
    }

    fn remove(&mut self, i: usize) {
        assert_eq!(self.ekf.remove(i), self.truth.len() - 1);
        self.oracle.remove(i);
        self.truth.swap_remove(i);
    }

    /// Founds the grid: alpha becomes what the heading says.
    fn found(&mut self) {
        let mut jacobian = Jacobian::new();
        jacobian.push((2, 1.0)).unwrap();
        let heading = self.ekf.mean(2);
        self.initialise(3, heading, &jacobian, 1e-4);
    }

    /// What f32 may lose. Every operation rounds an entry by up to half a unit in the last place (6e-8 of it); such
    /// errors add like a random walk while new readings keep forgetting old ones: a few 1e-6 of the states' sigmas were
    /// seen, and 2e-5 are allowed. Wrong algebra would be off by its order. A mean of some metres is rounded to 2e-7 m,
    /// of which a wall known to 0.1 mm gathers some hundredths of its sigma in a long run.
    fn assert_equal(&self, covariance_tolerance: f64, mean_tolerance: f64) {
        let error = self.oracle.covariance_error(&self.ekf);
        assert!(error < covariance_tolerance, "covariance off by {error} of its sigmas");
        let error = self.oracle.mean_error(&self.ekf);
        assert!(error < mean_tolerance, "mean off by {error} sigma");
    }
}

fn random_sequence<const ROWS: usize>(seed: u64, operations: usize) {
    let mut pair = Pair::<ROWS>::new(seed);
    pair.predict();
    pair.found();
    let capacity = Ekf::<ROWS>::CAPACITY;
    let mut was_full = false;
    for operation in 0..operations {
        let walls = pair.truth.len() - 15;
        match pair.random.below(20) {
            0..3 if pair.truth.len() < capacity => pair.birth(),
            3 if walls > 0 => {
                let wall = 15 + pair.random.below(walls);
                pair.remove(wall);
            }
            4..8 => pair.predict(),
            _ if walls > 0 => {
                let wall = 15 + pair.random.below(walls);
                pair.update(wall);
            }
            _ => {}
        }
        was_full |= pair.truth.len() == capacity;
        if operation % 50 == 0 {
            pair.assert_equal(2e-5, 5e-3);
        }
    }
    pair.assert_equal(2e-5, 5e-3);
    assert!(was_full, "the state was never full");
    assert!(is_positive(&Oracle::of(&pair.ekf).covariance, 0.0));
}

#[test]
fn random_operations_follow_the_oracle_at_every_size_of_state() {
    for seed in 0..6 {
        random_sequence::<{ storage(16) }>(seed, 600);
        random_sequence::<{ storage(24) }>(seed, 600);
    }
    random_sequence::<{ storage(40) }>(11, 900);
}

#[test]
fn the_robot_s_80_states_follow_the_oracle_when_full() {
    let mut pair = Pair::<{ storage(80) }>::new(3);
    pair.predict();
    pair.found();
    while pair.truth.len() < 80 {
        pair.birth();
    }
    assert_eq!(pair.ekf.augment(0.0, &Jacobian::new(), 1.0), None);
    for i in 0..400 {
        pair.update(15 + i * 7 % 65);
        if i % 4 == 0 {
            pair.predict();
        }
    }
    pair.assert_equal(2e-5, 5e-3);
}

/// Fifteen minutes of eight sensors, about: what a run does to the filter, with as many walls as a small flat has.
#[test]
fn twenty_thousand_operations_of_a_run_follow_the_oracle() {
    let mut pair = Pair::<{ storage(32) }>::new(7);
    pair.predict();
    pair.birth();
    pair.birth();
    pair.found();
    for operation in 0..20_000 {
        let walls = pair.truth.len() - 15;
        match operation % 5 {
            0 => pair.predict(),
            _ if operation % 400 == 1 && walls < 12 => pair.birth(),
            _ if operation % 2400 == 2 => {
                let wall = 15 + pair.random.below(walls);
                pair.remove(wall);
            }
            _ => {
                let wall = 15 + pair.random.below(walls);
                pair.update(wall);
            }
        }
        if operation % 1000 == 999 {
            pair.assert_equal(2e-5, 0.05);
            assert!(is_positive(&Oracle::of(&pair.ekf).covariance, 0.0), "after {operation}");
        }
    }
}

#[test]
fn correlated_births_share_their_noise() {
    let mut ekf = Ekf::<{ storage(16) }>::EMPTY;
    let mut oracle = Oracle::of(&ekf);
    for noise in [1e-3f32, 2e-3] {
        ekf.augment(0.0, &Jacobian::new(), noise);
        oracle.augment(0.0, &vec![0.0; oracle.mean.len()], noise.into());
    }
    ekf.correlate(0, 1, -1e-3);
    oracle.covariance[0][1] -= f64::from(1e-3f32);
    oracle.covariance[1][0] -= f64::from(1e-3f32);
    assert!(oracle.covariance_error(&ekf) < 1e-6);
}

#[test]
fn an_impossible_update_changes_nothing() {
    let mut pair = Pair::<{ storage(16) }>::new(1);
    pair.predict();
    let mut jacobian = Jacobian::new();
    jacobian.push((0, 1.0)).unwrap();
    for (innovation, noise) in [
        (f32::NAN, 1.0),
        (f32::INFINITY, 1.0),
        (0.1, -1.0),
        (0.1, f32::NAN),
        (0.1, f32::INFINITY),
        (0.1, f32::NEG_INFINITY),
    ] {
        assert!(pair.ekf.update(innovation, &jacobian, noise).is_err(), "{innovation} {noise}");
    }
    // Nothing known to be wrong, nothing to learn: variance zero.
    let mut exact = Jacobian::new();
    exact.push((3, 1.0)).unwrap();
    assert!(pair.ekf.update(0.1, &exact, 0.0).is_err());
    let mut bad = Jacobian::new();
    bad.push((4, f32::NAN)).unwrap();
    assert!(pair.ekf.update(0.1, &bad, 1.0).is_err());
    pair.assert_equal(1e-6, 1e-3);
}

#[test]
fn a_jacobian_has_room_for_every_entry_of_a_birth() {
    // Pose, grid direction, drive and sixteen gains.
    let mut jacobian = Jacobian::new();
    assert!((0..4 + 3 + 16).all(|i| jacobian.push((i, 1.0)).is_ok()));
    const { assert!(LEADING >= 4 + 3) };
}
