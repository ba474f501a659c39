//! The extended Kalman filter: a mean and a covariance, and the four things that ever happen to them.
//!
//! Prediction touches the rows of the pose only; a scalar update has a sparse Jacobian; a state can be added with its
//! full cross-covariance, and removed. The costs are O(n) but for the update's downdate, which is n (n + 1) / 2.

use crate::filter::covariance::{self, Covariance, HEAD, LANES, Pair, TILE};
use core::ops::{Deref, DerefMut, Range};
use heapless::Vec;

pub use crate::filter::jacobian::Jacobian;

/// Number of leading states that a prediction may read: pose, grid direction, motion calibration, all in one block.
pub const LEADING: usize = LANES;

/// Rows of the pose in the Jacobian of the motion model, over the leading states.
pub type MotionJacobian = [[f32; LEADING]; 3];

/// Smallest noise variance of an update, as a share of the variance before it: 2^-16. A smaller one would leave a
/// variance that is lost in f32's rounding of the larger one, and a covariance that is none.
const FINEST: f32 = 1.0 / 65536.0;

/// What [`EkfView::restore_rounding`] adds: 2^-22, two units in the last place.
const ROUNDING: f32 = 1.0 / 4_194_304.0;

/// An update that cannot be done: the innovation variance is not a positive number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Degenerate;

/// Rows of storage for a state of at most `states` entries: mean, three rows of scratch, covariance.
pub const fn storage(states: usize) -> usize {
    let tiles = states.div_ceil(TILE);
    VECTORS * tiles + covariance::rows(tiles)
}

/// Vectors in the storage: the mean, and three for the products of the covariance with Jacobian rows. These are kept,
/// since clearing and moving local ones costs as much as the products.
const VECTORS: usize = 4;

/// State estimate: [`Ekf`] with its storage, [`EkfView`] without its size.
#[derive(Debug)]
pub struct EkfInner<C: ?Sized> {
    len: usize,
    /// Tiles that a vector is long.
    tiles: usize,
    /// The vectors, then the covariance.
    rows: C,
}

/// State estimate in `ROWS` = [`storage`]`(states)` rows.
pub type Ekf<const ROWS: usize> = EkfInner<[Pair; ROWS]>;

/// A state estimate of whatever capacity.
pub type EkfView = EkfInner<[Pair]>;

impl<const ROWS: usize> Ekf<ROWS> {
    const TILES: usize = {
        let mut tiles = 0;
        while storage(TILE * tiles) < ROWS {
            tiles += 1;
        }
        assert!(storage(TILE * tiles) == ROWS, "the rows of a filter must be ekf::storage(states)");
        tiles
    };

    /// No states yet.
    pub const EMPTY: Self = Self { len: 0, tiles: Self::TILES, rows: [[[0.0; LANES]; 2]; ROWS] };

    /// Room for nothing until [`Ekf::clear`]; all its bytes are zero.
    pub const IDLE: Self = Self { len: 0, tiles: 0, rows: [[[0.0; LANES]; 2]; ROWS] };

    /// Most states it can hold.
    pub const CAPACITY: usize = TILE * Self::TILES;

    /// Forgets every state.
    pub fn clear(&mut self) {
        self.len = 0;
        self.tiles = Self::TILES;
        self.rows.fill([[0.0; LANES]; 2]);
    }
}

impl<const ROWS: usize> Deref for Ekf<ROWS> {
    type Target = EkfView;
    fn deref(&self) -> &EkfView {
        self
    }
}

impl<const ROWS: usize> DerefMut for Ekf<ROWS> {
    fn deref_mut(&mut self) -> &mut EkfView {
        self
    }
}

/// The storage of a filter, taken apart.
struct Parts<'a> {
    mean: &'a mut [Pair],
    rows: [&'a mut [Pair]; 3],
    covariance: Covariance<&'a mut [Pair]>,
}

impl EkfView {
    /// None where there is no storage, before a filter is started.
    #[inline(always)]
    fn parts(&mut self) -> Option<Parts<'_>> {
        let (mean, rest) = self.rows.split_at_mut_checked(self.tiles)?;
        let (first, rest) = rest.split_at_mut_checked(self.tiles)?;
        let (second, rest) = rest.split_at_mut_checked(self.tiles)?;
        let (third, covariance) = rest.split_at_mut_checked(self.tiles)?;
        Some(Parts { mean, rows: [first, second, third], covariance: Covariance(covariance) })
    }

    fn stored(&self) -> Covariance<&[Pair]> {
        Covariance(self.rows.get(VECTORS * self.tiles..).unwrap_or_default())
    }

    /// Most states it can hold.
    pub fn capacity(&self) -> usize {
        TILE * self.tiles
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
        covariance::entry(&self.rows, i)
    }

    /// Moves the estimate of state `i` without touching its uncertainty (an angle's whole turns).
    pub fn set_mean(&mut self, i: usize, value: f32) {
        if let Some(entry) = self.rows.as_flattened_mut().as_flattened_mut().get_mut(i).filter(|_| i < self.len) {
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
        let Some(Parts { mean, mut rows, mut covariance }) = self.parts() else { return };
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
            let Some([first, _]) = row.first() else { return };
            for ((out, derivatives), noise) in out.iter_mut().zip(jacobian).zip(noise) {
                let mut sum = *noise;
                for (p, derivative) in first.iter().zip(derivatives) {
                    sum += p * derivative;
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
        for (mean, value) in mean.as_flattened_mut().as_flattened_mut().iter_mut().zip(pose) {
            *mean = value;
        }
    }

    /// One scalar measurement: innovation (measured minus predicted), its Jacobian row, its noise variance.
    ///
    /// # Errors
    /// [`Degenerate`] and nothing changed where the innovation variance is not a positive number.
    pub fn update(&mut self, innovation: f32, jacobian: &Jacobian, noise: f32) -> Result<(), Degenerate> {
        let len = self.len;
        let Some(Parts { mean, rows: [column, gain, _], mut covariance }) = self.parts() else {
            return Err(Degenerate);
        };
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

    /// Whether each of the first `count` estimates is a number, and its variance one that is not negative.
    pub fn is_sound(&self, count: usize) -> bool {
        (0..self.len.min(count))
            .all(|i| self.mean(i).abs() <= f32::MAX && (0.0..=f32::MAX).contains(&self.covariance(i, i)))
    }

    /// Adds to each variance of at least `least` the share of it that rounding may have taken from the covariance.
    pub fn restore_rounding(&mut self, least: f32) {
        let len = self.len;
        let Some(Parts { mut covariance, .. }) = self.parts() else { return };
        for i in 0..len {
            let variance = covariance.get(i, i);
            if variance >= least {
                covariance.set(i, i, variance + ROUNDING * variance);
            }
        }
    }

    /// Multiplies the standard deviations of all states but these by so much. Correlations stay.
    #[cold]
    pub fn widen(&mut self, times: f32, but: Range<usize>) {
        let len = self.len;
        let Some(Parts { mut covariance, .. }) = self.parts() else { return };
        let of = |i: usize| if but.contains(&i) { 1.0 } else { times };
        for i in 0..len {
            for j in i..len {
                covariance.set(i, j, of(i) * of(j) * covariance.get(i, j));
            }
        }
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
        let Some(Parts { rows: [column, ..], mut covariance, .. }) = self.parts() else { return };
        covariance.product(jacobian.head(), jacobian.others(), len, column);
        let variance = noise + covariance::dot(column, jacobian.head(), jacobian.others());
        covariance.set_column(i, column, variance, len);
        self.set_mean(i, value);
    }

    /// Replaces the covariance of two states, or the variance of one; the caller answers for that all of them are a covariance.
    pub fn set_covariance(&mut self, i: usize, j: usize, value: f32) {
        if let Some(mut parts) = self.parts() {
            parts.covariance.set(i, j, value);
        }
    }

    /// Adds covariance between two states (noise that the initialisations of both share).
    pub fn correlate(&mut self, i: usize, j: usize, covariance: f32) {
        let before = self.covariance(i, j);
        if let Some(mut parts) = self.parts() {
            parts.covariance.set(i, j, before + covariance);
        }
    }

    /// State `i` is another quantity from now on, of the same value: its error is that of before and so many times those of others,
    /// which it must not be one of.
    #[inline(never)]
    pub fn restate(&mut self, i: usize, others: [(usize, f32); 3]) {
        let of_others =
            |ekf: &Self, j: usize| others.iter().map(|&(k, factor)| factor * ekf.covariance(k, j)).sum::<f32>();
        let own = others.iter().map(|&(k, factor)| factor * of_others(self, k)).sum::<f32>() + 2.0 * of_others(self, i);
        for j in (0..self.len).filter(|&j| j != i) {
            self.correlate(i, j, of_others(self, j));
        }
        self.correlate(i, i, own);
    }

    /// Removes state `i` by moving the last one into its place; returns the index that the moved one had.
    pub fn remove(&mut self, i: usize) -> usize {
        let last = self.len.saturating_sub(1);
        let len = self.len;
        if let Some(mut parts) = self.parts() {
            parts.covariance.move_state(last, i, len);
        }
        self.set_mean(i, self.mean(last));
        self.set_mean(last, 0.0);
        self.len = last;
        last
    }
}
