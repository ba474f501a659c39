//! The filter's oracle: the same operations in f64 on a dense covariance, the update in Joseph's form.

use std::vec;
use std::vec::Vec;

use crate::filter::ekf::{EkfView, Jacobian};

/// A dense matrix by rows.
pub type Matrix = Vec<Vec<f64>>;

/// State estimate with a dense covariance.
#[derive(Clone)]
pub struct Oracle {
    pub mean: Vec<f64>,
    pub covariance: Matrix,
}

/// A sparse row as a dense one of length `n`.
pub fn dense(jacobian: &Jacobian, n: usize) -> Vec<f64> {
    let mut row = vec![0.0; n];
    for (i, derivative) in jacobian.head().iter().copied().enumerate().chain(jacobian.others().iter().copied()) {
        if derivative != 0.0 {
            row[i] += f64::from(derivative);
        }
    }
    row
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transpose(b);
    a.iter().map(|row| columns.iter().map(|column| dot(row, column)).collect()).collect()
}

pub fn transpose(a: &Matrix) -> Matrix {
    (0..a.first().map_or(0, Vec::len)).map(|j| a.iter().map(|row| row[j]).collect()).collect()
}

pub fn identity(n: usize) -> Matrix {
    (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect()
}

/// J P J^T.
pub fn sandwich(j: &Matrix, p: &Matrix) -> Matrix {
    multiply(&multiply(j, p), &transpose(j))
}

impl Oracle {
    /// The filter's present state.
    pub fn of(ekf: &EkfView) -> Self {
        let n = ekf.len();
        Self {
            mean: (0..n).map(|i| ekf.mean(i).into()).collect(),
            covariance: (0..n).map(|i| (0..n).map(|j| ekf.covariance(i, j).into()).collect()).collect(),
        }
    }

    /// F P F^T + Q with the pose rows of F given over the leading states.
    pub fn predict(&mut self, pose: [f64; 3], rows: &[Vec<f64>; 3], noise: &[[f64; 3]; 3]) {
        let n = self.mean.len();
        let mut f = identity(n);
        for (row, given) in f.iter_mut().zip(rows) {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = given.get(j).copied().unwrap_or(0.0);
            }
        }
        self.covariance = sandwich(&f, &self.covariance);
        for i in 0..3 {
            for j in 0..3 {
                self.covariance[i][j] += noise[i][j];
            }
            self.mean[i] = pose[i];
        }
    }

    /// (I - K h) P (I - K h)^T + K r K^T.
    pub fn update(&mut self, innovation: f64, h: &[f64], noise: f64) {
        let n = self.mean.len();
        let ph: Vec<f64> = self.covariance.iter().map(|row| dot(row, h)).collect();
        let s = dot(&ph, h) + noise;
        let gain: Vec<f64> = ph.iter().map(|p| p / s).collect();
        let mut factor = identity(n);
        for (row, k) in factor.iter_mut().zip(&gain) {
            for (entry, h) in row.iter_mut().zip(h) {
                *entry -= k * h;
            }
        }
        self.covariance = sandwich(&factor, &self.covariance);
        for (i, ki) in gain.iter().enumerate() {
            self.mean[i] += ki * innovation;
            for (j, kj) in gain.iter().enumerate() {
                self.covariance[i][j] += ki * noise * kj;
            }
        }
    }

    /// Adds a state at the end.
    pub fn augment(&mut self, value: f64, h: &[f64], noise: f64) {
        self.mean.push(0.0);
        for row in &mut self.covariance {
            row.push(0.0);
        }
        self.covariance.push(vec![0.0; self.mean.len()]);
        let mut h = h.to_vec();
        h.push(0.0);
        self.initialise(self.mean.len() - 1, value, &h, noise);
    }

    /// State `i` becomes `value` with row `h` over the other states.
    pub fn initialise(&mut self, i: usize, value: f64, h: &[f64], noise: f64) {
        let mut f = identity(self.mean.len());
        f[i] = h.to_vec();
        self.covariance = sandwich(&f, &self.covariance);
        self.covariance[i][i] += noise;
        self.mean[i] = value;
    }

    /// Removes state `i`; the last one takes its place.
    pub fn remove(&mut self, i: usize) {
        self.mean.swap_remove(i);
        self.covariance.swap_remove(i);
        for row in &mut self.covariance {
            row.swap_remove(i);
        }
    }

    /// Largest difference of the filter's covariance from this one, in units of the two states' sigmas.
    pub fn covariance_error(&self, ekf: &EkfView) -> f64 {
        assert_eq!(ekf.len(), self.mean.len());
        let n = self.mean.len();
        let sigma: Vec<f64> = (0..n).map(|i| self.covariance[i][i].sqrt()).collect();
        let mut worst = 0.0f64;
        for i in 0..n {
            for j in 0..n {
                let difference = (f64::from(ekf.covariance(i, j)) - self.covariance[i][j]).abs();
                assert!(difference.is_finite(), "covariance {i}, {j} is not finite");
                if difference > 0.0 {
                    worst = worst.max(difference / (sigma[i] * sigma[j]));
                }
            }
        }
        worst
    }

    /// Largest difference of the filter's mean from this one, in sigmas.
    pub fn mean_error(&self, ekf: &EkfView) -> f64 {
        let in_sigmas = |(i, mean): (usize, &f64)| {
            let difference = (f64::from(ekf.mean(i)) - mean).abs();
            if difference == 0.0 { 0.0 } else { difference / self.covariance[i][i].sqrt() }
        };
        self.mean.iter().enumerate().map(in_sigmas).fold(0.0, f64::max)
    }
}

/// Whether a symmetric matrix, scaled to unit diagonal and with `slack` added there, has a Cholesky factorisation.
///
/// States without variance (a grid that is not founded) are left out.
pub fn is_positive(covariance: &Matrix, slack: f64) -> bool {
    let states: Vec<usize> = (0..covariance.len()).filter(|&i| covariance[i][i] != 0.0).collect();
    let scaled = |i: usize, j: usize| {
        let (i, j) = (states[i], states[j]);
        covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt()
    };
    let n = states.len();
    let mut lower = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let rest = scaled(i, j) - dot(&lower[i][..j], &lower[j][..j]);
            if i > j {
                lower[i][j] = rest / lower[j][j];
            } else if rest + slack > 0.0 {
                lower[i][i] = (rest + slack).sqrt();
            } else {
                return false;
            }
        }
    }
    true
}
