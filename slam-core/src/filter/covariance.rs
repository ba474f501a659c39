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

/// A row of a tile.
type Pair = [Block; 2];

/// States of a tile.
const TILE: usize = 2 * LANES;

/// States at the head, which every reading depends on: the pose and the grid's direction.
pub const HEAD: usize = LANES / 2;

/// Most entries beside the head of a sparse row: the drive's calibration, sixteen gains in a birth, and one more.
pub const MAX_OTHERS: usize = 20;

/// Number of blocks that a covariance of `nb` block columns has.
pub const fn blocks(nb: usize) -> usize {
    2 * tile_start(nb.div_ceil(2))
}

/// Where the rows of tile `m` start.
const fn tile_start(m: usize) -> usize {
    LANES * m * (m + 1)
}

/// A vector as long as the state, in blocks.
#[derive(Clone, Debug)]
pub struct Vector<const NB: usize>([Block; NB]);

impl<const NB: usize> Vector<NB> {
    /// All zero.
    pub const ZERO: Self = Self([[0.0; LANES]; NB]);

    /// Entry `i`; zero past the end.
    #[inline]
    pub fn get(&self, i: usize) -> f32 {
        self.0.as_flattened().get(i).copied().unwrap_or(0.0)
    }

    /// Sets entry `i`; nothing past the end.
    #[inline]
    pub fn set(&mut self, i: usize, value: f32) {
        if let Some(entry) = self.0.as_flattened_mut().get_mut(i) {
            *entry = value;
        }
    }

    /// Product with a sparse row, given by its first entries and the others.
    pub fn dot(&self, head: &[f32; HEAD], others: &[(usize, f32)]) -> f32 {
        let mut sum = 0.0;
        for (h, value) in head.iter().zip(self.0.as_flattened()) {
            sum += h * value;
        }
        for &(i, h) in others {
            sum += h * self.get(i);
        }
        sum
    }

    /// self += factor * other, over the first `n` entries' blocks.
    #[inline]
    pub fn add_scaled(&mut self, factor: f32, other: &Self, n: usize) {
        for (a, b) in self.0.iter_mut().zip(&other.0).take(n.div_ceil(LANES)) {
            add_scaled(a, factor, b);
        }
    }

    /// self = factor * other, over the first `n` entries' blocks.
    fn set_scaled(&mut self, factor: f32, other: &Self, n: usize) {
        for (a, b) in self.0.iter_mut().zip(&other.0).take(n.div_ceil(LANES)) {
            *a = b.map(|b| factor * b);
        }
    }

    /// gain = factor * column, and self += innovation * gain, over the first `n` entries' blocks.
    pub(crate) fn correct(&mut self, column: &Self, factor: f32, innovation: f32, gain: &mut Self, n: usize) {
        let column = column.0.get(..n.div_ceil(LANES)).unwrap_or(&[]);
        downdate::correct(&mut self.0, &mut gain.0, column, factor, innovation);
    }
}

#[inline(always)]
fn add_scaled(a: &mut Block, factor: f32, b: &Block) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * b;
    }
}

/// A symmetric matrix of up to `8 NB` rows in `BLOCKS` = [`blocks`]`(NB)` blocks.
#[derive(Clone, Debug)]
pub struct Covariance<const NB: usize, const BLOCKS: usize>([Block; BLOCKS]);

impl<const NB: usize, const BLOCKS: usize> Covariance<NB, BLOCKS> {
    /// All zero.
    pub const ZERO: Self = {
        assert!(BLOCKS == blocks(NB), "BLOCKS must be covariance::blocks(NB): 16 t (t + 1) for t = NB / 2, rounded up");
        Self([[0.0; LANES]; BLOCKS])
    };

    /// Makes all entries zero.
    pub fn clear(&mut self) {
        self.0.fill([0.0; LANES]);
    }

    /// The rows of all tiles.
    fn pairs(&self) -> &[Pair] {
        self.0.as_chunks().0
    }

    fn pairs_mut(&mut self) -> &mut [Pair] {
        self.0.as_chunks_mut().0
    }

    /// Place of an entry; past the end for one outside.
    #[inline]
    const fn locate(i: usize, j: usize) -> usize {
        let (i, j) = if i <= j { (i, j) } else { (j, i) };
        if j >= LANES * NB {
            return usize::MAX;
        }
        TILE * (tile_start(j / TILE) + i) + j % TILE
    }

    /// Entry (i, j); zero outside.
    #[inline]
    pub fn get(&self, i: usize, j: usize) -> f32 {
        self.0.as_flattened().get(Self::locate(i, j)).copied().unwrap_or(0.0)
    }

    /// Sets entries (i, j) and (j, i); nothing outside.
    #[inline]
    pub fn set(&mut self, i: usize, j: usize, value: f32) {
        if let Some(entry) = self.0.as_flattened_mut().get_mut(Self::locate(i, j)) {
            *entry = value;
        }
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
        let rows = self.pairs().get(tile_start(i / TILE)..).and_then(|rows| rows.first_chunk());
        rows.map_or([0.0; HEAD], |rows: &[Pair; HEAD]| rows.each_ref().map(|row| row[i / LANES % 2][i % LANES]))
    }

    /// out = P J^T over the leading n x n part, outside of which P is zero, for a sparse row J, given by its entries of
    /// the first states and the others. O(entries n). Past the block of `n`, `out` is left as it was.
    pub fn product(&self, head: &[f32; HEAD], others: &[(usize, f32)], n: usize, out: &mut Vector<NB>) {
        for (m, out) in out.0.chunks_mut(2).enumerate().take(n.div_ceil(TILE)) {
            let width = n - TILE * m;
            if width > LANES
                && let Some(out) = out.first_chunk_mut::<2>()
            {
                product::tile(self.pairs(), m, head, others, out);
            } else if width > LANES / 2
                && let Some(out) = out.first_chunk_mut::<1>()
            {
                product::tile(self.pairs(), m, head, others, out);
            } else if let Some([near, far]) = out.first_mut().map(|out| out.as_chunks_mut().0) {
                product::tile::<{ LANES / 2 }, 1>(self.pairs(), m, head, others, core::array::from_mut(near));
                *far = [0.0; LANES / 2];
            }
        }
    }

    /// P -= k g g^T over the leading n x n part: n (n + 1) / 2 multiply-subtracts, and those of unused lanes.
    ///
    /// `g` must be zero past `n`.
    pub fn downdate(&mut self, g: &Vector<NB>, k: f32, n: usize) {
        let mut scaled = Vector::ZERO;
        scaled.set_scaled(k, g, n);
        self.downdate_scaled(g, &scaled, n);
    }

    /// The same where k g is at hand.
    pub(crate) fn downdate_scaled(&mut self, g: &Vector<NB>, scaled: &Vector<NB>, n: usize) {
        let mut rest = self.pairs_mut();
        for (m, (g, factors)) in g.0.chunks(2).zip(scaled.0.chunks(2)).enumerate().take(n.div_ceil(TILE)) {
            let first = TILE * m;
            let Some((rows, tail)) = rest.split_at_mut_checked(first + TILE) else { return };
            rest = tail;
            match (g, factors) {
                ([g, h], [_, beside]) if n > first + LANES => {
                    let Some((above, diagonal)) = rows.split_at_mut_checked(first + LANES) else { return };
                    downdate::pairs(above, &scaled.0, g, h);
                    downdate::triangle::<1, LANES>(diagonal, beside, h);
                }
                ([g, ..], [beside, ..]) => {
                    let Some((above, diagonal)) = rows.split_at_mut_checked(first) else { return };
                    if n > first + LANES / 2 {
                        downdate::lanes::<LANES>(above, &scaled.0, g);
                        downdate::triangle::<0, LANES>(diagonal, beside, g);
                    } else {
                        downdate::lanes::<{ LANES / 2 }>(above, &scaled.0, g);
                        downdate::triangle::<0, { LANES / 2 }>(diagonal, beside, g);
                    }
                }
                _ => return,
            }
        }
    }

    /// Replaces the entries of row `i` from the diagonal on, for a row of the first block.
    pub fn set_row(&mut self, i: usize, row: &Vector<NB>, n: usize) {
        for j in i..n.min(TILE) {
            self.set(i, j, row.get(j));
        }
        for (m, values) in row.0.chunks(2).enumerate().take(n.div_ceil(TILE)).skip(1) {
            if let Some(row) = self.pairs_mut().get_mut(tile_start(m) + i) {
                for (p, values) in row.iter_mut().zip(values) {
                    *p = *values;
                }
            }
        }
    }

    /// Replaces row and column `i` of the leading n x n part by `column`, and the diagonal entry by `variance`.
    pub fn set_column(&mut self, i: usize, column: &Vector<NB>, variance: f32, n: usize) {
        for j in 0..n {
            self.set(i, j, column.get(j));
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
