//! The covariance: one symmetric matrix, stored once.
//!
//! Layout: the upper triangle in tiles of sixteen columns, from the left, each with one run of sixteen neighbouring
//! entries for every row down to the last on the diagonal. A smaller state uses a prefix of the storage, whatever the
//! capacity; the map grows at the far end.
//!
//! Entries left of the diagonal, in the tiles on it, are anything; they are not read.

mod downdate;
mod product;

/// Columns of a block.
pub const LANES: usize = 8;

/// Eight neighbouring columns of a row, or eight neighbouring entries of a vector.
pub type Block = [f32; LANES];

/// Sixteen neighbouring entries: a row of a tile, or of a vector.
pub type Pair = [Block; 2];

/// States of a tile.
pub const TILE: usize = 2 * LANES;

/// States at the head, which every reading depends on: the pose and the grid's direction.
pub const HEAD: usize = LANES / 2;

/// Most entries beside the head of a sparse row: the drive's calibration, sixteen gains in a birth, and one more.
pub const MAX_OTHERS: usize = 20;

/// Number of rows in a covariance of so many tiles; also where the rows of the next tile start.
pub const fn rows(tiles: usize) -> usize {
    LANES * tiles * (tiles + 1)
}

/// Entry `i` of a vector as long as the state, or longer; zero past its end.
#[inline]
pub fn entry(vector: &[Pair], i: usize) -> f32 {
    vector.as_flattened().as_flattened().get(i).copied().unwrap_or(0.0)
}

/// Product of such a vector with a sparse row, given by its first entries and the others.
pub fn dot(vector: &[Pair], head: &[f32; HEAD], others: &[(usize, f32)]) -> f32 {
    let mut sum = 0.0;
    for (h, value) in head.iter().zip(vector.as_flattened().first().unwrap_or(&[0.0; LANES])) {
        sum += h * value;
    }
    let entries = vector.as_flattened().as_flattened();
    for &(i, h) in others {
        // With a second way out the compiler leaves the short loop as it is.
        let Some(value) = entries.get(i) else { break };
        sum += h * value;
    }
    sum
}

/// gain = factor * column, and mean += innovation * gain, over the first `n` entries' blocks.
pub(crate) fn correct(mean: &mut [Pair], gain: &mut [Pair], column: &[Pair], factor: f32, innovation: f32, n: usize) {
    let column = column.as_flattened().get(..n.div_ceil(LANES)).unwrap_or(&[]);
    downdate::correct(mean.as_flattened_mut(), gain.as_flattened_mut(), column, factor, innovation);
}

/// A symmetric matrix, in an array of [`rows`]`(tiles)` or in a borrowed slice of so many.
#[derive(Clone, Debug)]
pub struct Covariance<C>(pub C);

/// Largest index of a state; a larger one is outside every matrix.
const LARGEST: usize = u16::MAX as usize;

/// Place of an entry; past the end for one outside.
#[inline]
const fn locate(i: usize, j: usize) -> usize {
    let (i, j) = if i <= j { (i, j) } else { (j, i) };
    if j > LARGEST {
        return usize::MAX;
    }
    TILE * (rows(j / TILE) + i) + j % TILE
}

impl<C: AsRef<[Pair]>> Covariance<C> {
    /// The rows of all tiles.
    fn pairs(&self) -> &[Pair] {
        self.0.as_ref()
    }

    /// Entry (i, j); zero outside.
    #[inline]
    pub fn get(&self, i: usize, j: usize) -> f32 {
        self.0.as_ref().as_flattened().as_flattened().get(locate(i, j)).copied().unwrap_or(0.0)
    }

    /// J P J^T for a sparse row J, given by its entries of the first states and the others. O(entries^2).
    pub fn quadratic(&self, head: &[f32; HEAD], others: &[(usize, f32)]) -> f32 {
        let Some([[p, _], [q, _], [r, _], [s, _]]) = self.pairs().first_chunk() else { return 0.0 };
        let [e, f, g, h] = *head;
        let mut half = e * (0.5 * e * p[0] + f * p[1] + g * p[2] + h * p[3]);
        half += f * (0.5 * f * q[1] + g * q[2] + h * q[3]);
        half += g * (0.5 * g * r[2] + h * r[3]);
        half += h * (0.5 * h * s[3]);
        for (a, &(i, hi)) in others.iter().enumerate() {
            let mut row = 0.5 * hi * self.get(i, i);
            for (p, hj) in self.head_of(i).iter().zip(head) {
                row += hj * p;
            }
            for &(j, hj) in others.iter().skip(a + 1) {
                row += hj * self.get(i, j);
            }
            half += hi * row;
        }
        2.0 * half
    }

    /// Covariances of state `i`, which is not one of the first, with the first states.
    fn head_of(&self, i: usize) -> [f32; HEAD] {
        let rows = self.pairs().get(rows(i / TILE)..).and_then(|rows| rows.first_chunk());
        rows.map_or([0.0; HEAD], |rows: &[Pair; HEAD]| rows.each_ref().map(|row| row[i / LANES % 2][i % LANES]))
    }

    /// out = P J^T over the leading n x n part, outside of which P is zero, for a sparse row J, given by its entries of
    /// the first states and the others. O(entries n). Past the block of `n`, `out` is left as it was.
    #[inline(always)]
    pub fn product(&self, head: &[f32; HEAD], others: &[(usize, f32)], n: usize, out: &mut [Pair]) {
        for (m, out) in out.iter_mut().enumerate().take(n.div_ceil(TILE)) {
            let width = n - TILE * m;
            let [near, _] = out;
            if width > LANES {
                product::tile(self.pairs(), m, head, others, out);
            } else if width > LANES / 2 {
                product::tile(self.pairs(), m, head, others, core::array::from_mut(near));
            } else if let [near, far] = near.as_chunks_mut().0 {
                product::tile::<{ LANES / 2 }, 1>(self.pairs(), m, head, others, core::array::from_mut(near));
                *far = [0.0; LANES / 2];
            }
        }
    }
}

impl<C: AsRef<[Pair]> + AsMut<[Pair]>> Covariance<C> {
    fn pairs_mut(&mut self) -> &mut [Pair] {
        self.0.as_mut()
    }

    /// Sets entries (i, j) and (j, i); nothing outside.
    #[inline]
    pub fn set(&mut self, i: usize, j: usize, value: f32) {
        if let Some(entry) = self.0.as_mut().as_flattened_mut().as_flattened_mut().get_mut(locate(i, j)) {
            *entry = value;
        }
    }

    /// P -= k g g^T over the leading n x n part, for k g in `scaled`: n (n + 1) / 2 multiply-subtracts, and those of unused
    /// lanes. `g` must be zero past `n`.
    pub fn downdate(&mut self, g: &[Pair], scaled: &[Pair], n: usize) {
        let mut rest = self.pairs_mut();
        let factors = scaled.as_flattened();
        for (m, ([g, h], [near, far])) in g.iter().zip(scaled).enumerate().take(n.div_ceil(TILE)) {
            let first = TILE * m;
            let Some((rows, tail)) = rest.split_at_mut_checked(first + TILE) else { return };
            rest = tail;
            if n > first + LANES {
                let Some((above, diagonal)) = rows.split_at_mut_checked(first + LANES) else { return };
                downdate::pairs(above, factors, g, h);
                downdate::triangle::<1, LANES>(diagonal, far, h);
                continue;
            }
            let Some((above, diagonal)) = rows.split_at_mut_checked(first) else { return };
            if n > first + LANES / 2 {
                downdate::lanes::<LANES>(above, factors, g);
                downdate::triangle::<0, LANES>(diagonal, near, g);
            } else {
                downdate::lanes::<{ LANES / 2 }>(above, factors, g);
                downdate::triangle::<0, { LANES / 2 }>(diagonal, near, g);
            }
        }
    }

    /// Replaces the entries of row `i` from the diagonal on, for a row of the first block.
    pub fn set_row(&mut self, i: usize, row: &[Pair], n: usize) {
        let pairs = self.pairs_mut();
        if let (Some(to), Some(from)) = (pairs.get_mut(i), row.first()) {
            let to = to.as_flattened_mut().get_mut(i..n.min(TILE)).unwrap_or_default();
            let from = from.as_flattened().get(i..n.min(TILE)).unwrap_or_default();
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from;
            }
        }
        for (m, from) in row.iter().enumerate().take(n.div_ceil(TILE)).skip(1) {
            if let Some(to) = pairs.get_mut(rows(m) + i) {
                for (to, &[a, b, c, d, e, f, g, h]) in to.iter_mut().zip(from) {
                    // Entry by entry, in registers: as a whole it would be a call.
                    *to = [a, b, c, d, e, f, g, h];
                }
            }
        }
    }

    /// Replaces row and column `i` of the leading n x n part by `column`, and the diagonal entry by `variance`.
    pub fn set_column(&mut self, i: usize, column: &[Pair], variance: f32, n: usize) {
        for j in 0..n {
            self.set(i, j, entry(column, j));
        }
        self.set(i, i, variance);
    }

    /// Copies row and column `from` over row and column `to`, and clears `from`. O(n).
    pub fn move_state(&mut self, from: usize, to: usize, n: usize) {
        if from != to {
            let variance = self.get(from, from);
            for j in 0..n {
                self.set(to, j, self.get(from, j));
            }
            self.set(to, to, variance);
        }
        for j in 0..n {
            self.set(from, j, 0.0);
        }
    }
}
