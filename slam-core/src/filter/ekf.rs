//! The extended Kalman filter: a mean and a covariance, and the four things that ever happen to them.
//!
//! Prediction touches the rows of the pose only; a scalar update has a sparse Jacobian; a state can be added with its
//! full cross-covariance, and removed. The costs are O(n) but for the update's downdate, which is n (n + 1) / 2.

use crate::filter::covariance::{Covariance, HEAD, LANES, Vector};
use heapless::Vec;

pub use crate::filter::jacobian::Jacobian;

/// Number of leading states that a prediction may read: pose, grid direction, motion calibration, all in one block.
pub const LEADING: usize = LANES;

/// Rows of the pose in the Jacobian of the motion model, over the leading states.
pub type MotionJacobian = [[f32; LEADING]; 3];

/// Smallest noise variance of an update, as a share of the variance before it: 2^-16. A smaller one would leave a
/// variance that is lost in f32's rounding of the larger one, and a covariance that is none.
const FINEST: f32 = 1.0 / 65536.0;

/// An update that cannot be done: the innovation variance is not a positive number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Degenerate;

/// State estimate of at most `8 NB` entries.
#[derive(Clone, Debug)]
pub struct Ekf<const NB: usize, const BLOCKS: usize> {
    len: usize,
    mean: Vector<NB>,
    covariance: Covariance<NB, BLOCKS>,
    /// For the products of the covariance with Jacobian rows. Kept, since clearing and moving local ones costs as much
    /// as the products.
    rows: [Vector<NB>; 3],
}

impl<const NB: usize, const BLOCKS: usize> Ekf<NB, BLOCKS> {
    /// No states yet.
    pub const EMPTY: Self = Self {
        len: 0,
        mean: Vector::ZERO,
        covariance: Covariance::ZERO,
        rows: [Vector::ZERO, Vector::ZERO, Vector::ZERO],
    };

    /// Most states it can hold.
    pub const CAPACITY: usize = LANES * NB;

    /// True before the first state.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets every state.
    pub fn clear(&mut self) {
        self.len = 0;
        self.mean = Vector::ZERO;
        self.covariance.clear();
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Estimate of state `i`.
    #[inline]
    pub fn mean(&self, i: usize) -> f32 {
        self.mean.get(i)
    }

    /// Moves the estimate of state `i` without touching its uncertainty (an angle's whole turns).
    pub fn set_mean(&mut self, i: usize, value: f32) {
        self.mean.set(i, value);
    }

    /// Covariance of states `i` and `j`.
    #[inline]
    pub fn covariance(&self, i: usize, j: usize) -> f32 {
        self.covariance.get(i, j)
    }

    /// J P J^T of a sparse row: the variance of what it measures. O(entries^2), no pass over the state.
    pub fn variance(&self, jacobian: &Jacobian) -> f32 {
        self.covariance.quadratic(jacobian.head(), jacobian.others())
    }

    /// Prediction: the pose becomes `pose`, its rows and columns F P, its own block F P F^T + Q.
    ///
    /// `jacobian` is d(pose')/d(leading states); `noise` is Q, symmetric.
    pub fn predict(&mut self, pose: [f32; 3], jacobian: &MotionJacobian, noise: &[[f32; 3]; 3]) {
        for (row, derivatives) in self.rows.iter_mut().zip(jacobian) {
            let Some((head, rest)) = derivatives.split_first_chunk() else { return };
            let mut others: Vec<(usize, f32), { LEADING - HEAD }> = Vec::new();
            for (i, &derivative) in (HEAD..self.len).zip(rest) {
                if derivative != 0.0 {
                    let _ = others.push((i, derivative));
                }
            }
            self.covariance.product(head, &others, self.len, row);
        }
        let mut pose_block = *noise;
        for ((out, row), noise) in pose_block.iter_mut().zip(&self.rows).zip(noise) {
            for ((out, derivatives), noise) in out.iter_mut().zip(jacobian).zip(noise) {
                let mut sum = *noise;
                for (i, &derivative) in derivatives.iter().enumerate() {
                    sum += row.get(i) * derivative;
                }
                *out = sum;
            }
        }
        for (i, ((row, block), value)) in self.rows.iter().zip(&pose_block).zip(pose).enumerate() {
            self.covariance.set_row(i, row, self.len);
            for (j, entry) in block.iter().enumerate().skip(i) {
                self.covariance.set(i, j, *entry);
            }
            self.mean.set(i, value);
        }
    }

    /// One scalar measurement: innovation (measured minus predicted), its Jacobian row, its noise variance.
    ///
    /// # Errors
    /// [`Degenerate`] and nothing changed where the innovation variance is not a positive number.
    pub fn update(&mut self, innovation: f32, jacobian: &Jacobian, noise: f32) -> Result<(), Degenerate> {
        let [column, gain, _] = &mut self.rows;
        self.covariance.product(jacobian.head(), jacobian.others(), self.len, column);
        let known = column.dot(jacobian.head(), jacobian.others());
        let variance = known + noise;
        let finest = known + FINEST * known;
        let inverse = 1.0 / if variance > 0.0 && variance < finest { finest } else { variance };
        // Also false for what is not a number.
        if !(inverse > 0.0 && inverse <= f32::MAX && innovation.abs() <= f32::MAX) {
            return Err(Degenerate);
        }
        self.mean.correct(column, inverse, innovation, gain, self.len);
        self.covariance.downdate_scaled(column, gain, self.len);
        Ok(())
    }

    /// Adds a state whose derivative by the others is `jacobian`, with `noise` of its own. Returns its index.
    pub fn augment(&mut self, value: f32, jacobian: &Jacobian, noise: f32) -> Option<usize> {
        let i = self.len;
        if i >= Self::CAPACITY {
            return None;
        }
        self.len += 1;
        self.initialise(i, value, jacobian, noise);
        Some(i)
    }

    /// Gives state `i`, which nothing depends on yet, a value that depends on other states by `jacobian`.
    pub fn initialise(&mut self, i: usize, value: f32, jacobian: &Jacobian, noise: f32) {
        let [column, ..] = &mut self.rows;
        self.covariance.product(jacobian.head(), jacobian.others(), self.len, column);
        let variance = noise + column.dot(jacobian.head(), jacobian.others());
        self.mean.set(i, value);
        self.covariance.set_column(i, column, variance, self.len);
    }

    /// Adds covariance between two states (noise that the initialisations of both share).
    pub fn correlate(&mut self, i: usize, j: usize, covariance: f32) {
        self.covariance.set(i, j, self.covariance.get(i, j) + covariance);
    }

    /// Removes state `i` by moving the last one into its place; returns the index that the moved one had.
    pub fn remove(&mut self, i: usize) -> usize {
        let last = self.len.saturating_sub(1);
        self.covariance.move_state(last, i, self.len);
        self.mean.set(i, self.mean.get(last));
        self.mean.set(last, 0.0);
        self.len = last;
        last
    }
}
