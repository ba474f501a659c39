//! The extended Kalman filter: a mean and a covariance, and the four things that ever happen to them.
//!
//! Prediction touches the rows of the pose only; a scalar update has a sparse Jacobian; a state can be added with its
//! full cross-covariance, and removed. The costs are O(n) but for the update's downdate, which is n (n + 1) / 2.

use crate::filter::covariance::{self, Block, Covariance, HEAD, LANES};
use core::ops::{Deref, DerefMut};
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

/// Blocks of storage for a state of at most `states` entries: mean, three rows of scratch, covariance.
pub const fn storage(states: usize) -> usize {
    let columns = states.div_ceil(LANES);
    VECTORS * columns + covariance::blocks(columns)
}

/// Vectors in the storage: the mean, and three for the products of the covariance with Jacobian rows. These are kept,
/// since clearing and moving local ones costs as much as the products.
const VECTORS: usize = 4;

/// State estimate: [`Ekf`] with its storage, [`EkfView`] without its size.
#[derive(Debug)]
pub struct EkfInner<C: ?Sized> {
    len: usize,
    /// Blocks of a vector.
    columns: usize,
    /// The vectors, then the covariance.
    blocks: C,
}

/// State estimate in `BLOCKS` = [`storage`]`(states)` blocks.
pub type Ekf<const BLOCKS: usize> = EkfInner<[Block; BLOCKS]>;

/// A state estimate of whatever capacity.
pub type EkfView = EkfInner<[Block]>;

impl<const BLOCKS: usize> Ekf<BLOCKS> {
    const COLUMNS: usize = {
        let mut columns = 0;
        while storage(LANES * columns) < BLOCKS {
            columns += 1;
        }
        assert!(storage(LANES * columns) == BLOCKS, "the blocks of a filter must be ekf::storage(states)");
        columns
    };

    /// No states yet.
    pub const EMPTY: Self = Self { len: 0, columns: Self::COLUMNS, blocks: [[0.0; LANES]; BLOCKS] };

    /// Room for nothing until [`Ekf::clear`]; all its bytes are zero.
    pub const IDLE: Self = Self { len: 0, columns: 0, blocks: [[0.0; LANES]; BLOCKS] };

    /// Most states it can hold.
    pub const CAPACITY: usize = LANES * Self::COLUMNS;

    /// Forgets every state.
    pub fn clear(&mut self) {
        self.len = 0;
        self.columns = Self::COLUMNS;
        self.blocks.fill([0.0; LANES]);
    }
}

impl<const BLOCKS: usize> Deref for Ekf<BLOCKS> {
    type Target = EkfView;
    fn deref(&self) -> &EkfView {
        self
    }
}

impl<const BLOCKS: usize> DerefMut for Ekf<BLOCKS> {
    fn deref_mut(&mut self) -> &mut EkfView {
        self
    }
}

/// The storage of a filter, taken apart.
struct Parts<'a> {
    mean: &'a mut [Block],
    rows: [&'a mut [Block]; 3],
    covariance: Covariance<&'a mut [Block]>,
}

impl EkfView {
    fn parts(&mut self) -> Parts<'_> {
        fn split(blocks: &mut [Block], at: usize) -> (&mut [Block], &mut [Block]) {
            blocks.split_at_mut_checked(at).unwrap_or_default()
        }
        let (mean, rest) = split(&mut self.blocks, self.columns);
        let (first, rest) = split(rest, self.columns);
        let (second, rest) = split(rest, self.columns);
        let (third, covariance) = split(rest, self.columns);
        Parts { mean, rows: [first, second, third], covariance: Covariance(covariance) }
    }

    fn stored(&self) -> Covariance<&[Block]> {
        Covariance(self.blocks.get(VECTORS * self.columns..).unwrap_or_default())
    }

    /// Most states it can hold.
    pub fn capacity(&self) -> usize {
        LANES * self.columns
    }

    /// True before the first state.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Estimate of state `i`, which must be one.
    #[inline]
    pub fn mean(&self, i: usize) -> f32 {
        covariance::entry(&self.blocks, i)
    }

    /// Moves the estimate of state `i` without touching its uncertainty (an angle's whole turns).
    pub fn set_mean(&mut self, i: usize, value: f32) {
        if let Some(entry) = self.blocks.as_flattened_mut().get_mut(i).filter(|_| i < self.len) {
            *entry = value;
        }
    }

    /// Covariance of states `i` and `j`.
    #[inline]
    pub fn covariance(&self, i: usize, j: usize) -> f32 {
        self.stored().get(i, j)
    }

    /// J P J^T of a sparse row: the variance of what it measures. O(entries^2), no pass over the state.
    pub fn variance(&self, jacobian: &Jacobian) -> f32 {
        self.stored().quadratic(jacobian.head(), jacobian.others())
    }

    /// Prediction: the pose becomes `pose`, its rows and columns F P, its own block F P F^T + Q.
    ///
    /// `jacobian` is d(pose')/d(leading states); `noise` is Q, symmetric.
    pub fn predict(&mut self, pose: [f32; 3], jacobian: &MotionJacobian, noise: &[[f32; 3]; 3]) {
        let len = self.len;
        let Parts { mean, mut rows, mut covariance } = self.parts();
        for (row, derivatives) in rows.iter_mut().zip(jacobian) {
            let Some((head, rest)) = derivatives.split_first_chunk() else { return };
            let mut others: Vec<(usize, f32), { LEADING - HEAD }> = Vec::new();
            for (i, &derivative) in (HEAD..len).zip(rest) {
                if derivative != 0.0 {
                    let _ = others.push((i, derivative));
                }
            }
            covariance.product(head, &others, len, row);
        }
        let mut pose_block = *noise;
        for ((out, row), noise) in pose_block.iter_mut().zip(&rows).zip(noise) {
            for ((out, derivatives), noise) in out.iter_mut().zip(jacobian).zip(noise) {
                let mut sum = *noise;
                for (i, &derivative) in derivatives.iter().enumerate() {
                    sum += covariance::entry(row, i) * derivative;
                }
                *out = sum;
            }
        }
        for (i, (row, block)) in rows.iter().zip(&pose_block).enumerate() {
            covariance.set_row(i, row, len);
            for (j, entry) in block.iter().enumerate().skip(i) {
                covariance.set(i, j, *entry);
            }
        }
        for (mean, value) in mean.as_flattened_mut().iter_mut().zip(pose) {
            *mean = value;
        }
    }

    /// One scalar measurement: innovation (measured minus predicted), its Jacobian row, its noise variance.
    ///
    /// # Errors
    /// [`Degenerate`] and nothing changed where the innovation variance is not a positive number.
    pub fn update(&mut self, innovation: f32, jacobian: &Jacobian, noise: f32) -> Result<(), Degenerate> {
        let len = self.len;
        let Parts { mean, rows: [column, gain, _], mut covariance } = self.parts();
        covariance.product(jacobian.head(), jacobian.others(), len, column);
        let known = covariance::dot(column, jacobian.head(), jacobian.others());
        let variance = known + noise;
        let finest = known + FINEST * known;
        let inverse = 1.0 / if variance > 0.0 && variance < finest { finest } else { variance };
        // Also false for what is not a number.
        if !(inverse > 0.0 && inverse <= f32::MAX && innovation.abs() <= f32::MAX) {
            return Err(Degenerate);
        }
        covariance::correct(mean, gain, column, inverse, innovation, len);
        covariance.downdate(column, gain, len);
        Ok(())
    }

    /// Adds a state whose derivative by the others is `jacobian`, with `noise` of its own. Returns its index.
    pub fn augment(&mut self, value: f32, jacobian: &Jacobian, noise: f32) -> Option<usize> {
        let i = self.len;
        if i >= self.capacity() {
            return None;
        }
        self.len += 1;
        self.initialise(i, value, jacobian, noise);
        Some(i)
    }

    /// Gives state `i`, which nothing depends on yet, a value that depends on other states by `jacobian`.
    pub fn initialise(&mut self, i: usize, value: f32, jacobian: &Jacobian, noise: f32) {
        let len = self.len;
        let Parts { rows: [column, ..], mut covariance, .. } = self.parts();
        covariance.product(jacobian.head(), jacobian.others(), len, column);
        let variance = noise + covariance::dot(column, jacobian.head(), jacobian.others());
        covariance.set_column(i, column, variance, len);
        self.set_mean(i, value);
    }

    /// Adds covariance between two states (noise that the initialisations of both share).
    pub fn correlate(&mut self, i: usize, j: usize, covariance: f32) {
        let before = self.covariance(i, j);
        self.parts().covariance.set(i, j, before + covariance);
    }

    /// Removes state `i` by moving the last one into its place; returns the index that the moved one had.
    pub fn remove(&mut self, i: usize) -> usize {
        let last = self.len.saturating_sub(1);
        let len = self.len;
        self.parts().covariance.move_state(last, i, len);
        self.set_mean(i, self.mean(last));
        self.set_mean(last, 0.0);
        self.len = last;
        last
    }
}
