//! The covariance: one symmetric matrix, stored once.
//!
//! Layout: the upper triangle in block columns of eight, from the left, each with one block of eight neighbouring
//! entries for every row down to the diagonal. Two neighbouring block columns share a tile: their blocks of one row lie
//! side by side, sixteen entries in one run, but for the last eight rows, which only the second column has. A smaller
//! state uses a prefix of the storage, whatever the capacity; the map grows at the far end.
//!
//! Entries left of the diagonal, in the blocks on it, are anything: they are made zero before a row is added whole.

mod kernel;

/// Columns of a block.
pub const LANES: usize = 8;

/// Eight neighbouring columns of a row, or eight neighbouring entries of a vector.
pub type Block = [f32; LANES];

/// States of a tile.
const TILE: usize = 2 * LANES;

/// Number of blocks that a covariance of `nb` block columns has.
pub const fn blocks(nb: usize) -> usize {
    LANES / 2 * nb * (nb + 1)
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
        self.0.get(i / LANES).map_or(0.0, |block| block[i % LANES])
    }

    /// Sets entry `i`; nothing past the end.
    #[inline]
    pub fn set(&mut self, i: usize, value: f32) {
        if let Some(block) = self.0.get_mut(i / LANES) {
            block[i % LANES] = value;
        }
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
        for ((x, gain), g) in self.0.iter_mut().zip(&mut gain.0).zip(&column.0).take(n.div_ceil(LANES)) {
            let k = g.map(|g| factor * g);
            *gain = k;
            add_scaled(x, innovation, &k);
        }
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
        assert!(BLOCKS == blocks(NB), "BLOCKS must be 4 NB (NB + 1)");
        Self([[0.0; LANES]; BLOCKS])
    };

    /// Makes all entries zero.
    pub fn clear(&mut self) {
        self.0.fill([0.0; LANES]);
    }

    /// Index of the first block of tile `m`.
    #[inline]
    const fn tile_start(m: usize) -> usize {
        blocks(2 * m)
    }

    /// Block and lane of an entry.
    #[inline]
    fn locate(i: usize, j: usize) -> (usize, usize) {
        let (i, j) = if i <= j { (i, j) } else { (j, i) };
        if j >= LANES * NB {
            return (BLOCKS, 0);
        }
        let (m, odd) = (j / TILE, j / LANES % 2);
        // Rows of the tile that have both columns; the last column of an odd number has no neighbour.
        let paired = if 2 * m + 1 == NB { 0 } else { TILE * m + LANES };
        let block = if i < paired { 2 * i + odd } else { paired + i };
        (Self::tile_start(m) + block, j % LANES)
    }

    /// Entry (i, j); zero outside.
    #[inline]
    pub fn get(&self, i: usize, j: usize) -> f32 {
        let (block, lane) = Self::locate(i, j);
        self.0.get(block).map_or(0.0, |b| b[lane])
    }

    /// Sets entries (i, j) and (j, i); nothing outside.
    #[inline]
    pub fn set(&mut self, i: usize, j: usize, value: f32) {
        let (block, lane) = Self::locate(i, j);
        if let Some(b) = self.0.get_mut(block) {
            b[lane] = value;
        }
    }

    /// out = P J^T over the leading n x n part, for a sparse row J. O(entries n). Past `n`, and its block, `out` is left
    /// as it was.
    pub fn product(&mut self, jacobian: &[(usize, f32)], n: usize, out: &mut Vector<NB>) {
        for block in out.0.iter_mut().take(n.div_ceil(LANES)) {
            *block = [0.0; LANES];
        }
        for &(c, factor) in jacobian {
            self.clear_left(c);
            self.add_above(c, factor, out);
        }
        let mut rest = &self.0[..];
        for (m, out) in out.0.chunks_mut(2).enumerate().take(n.div_ceil(TILE)) {
            let paired = TILE * m + LANES;
            if let [a, b] = out {
                let Some((pairs, tail)) = rest.split_at_checked(2 * paired) else { break };
                rest = tail.get(LANES..).unwrap_or(&[]);
                if n > paired {
                    add_pairs(a, b, pairs.as_chunks().0, jacobian);
                } else {
                    add_blocks::<2>(a, pairs.as_chunks().0, jacobian);
                }
            } else if let [a] = out {
                add_blocks::<1>(a, rest.as_chunks().0, jacobian);
            }
        }
        for entry in out.0.as_flattened_mut().iter_mut().take(n.next_multiple_of(LANES)).skip(n) {
            *entry = 0.0;
        }
    }

    /// Makes the entries of row `c` zero that lie left of the diagonal in its block.
    fn clear_left(&mut self, c: usize) {
        let (block, lane) = Self::locate(c, c);
        if let Some(block) = self.0.get_mut(block) {
            for entry in block.iter_mut().take(lane) {
                *entry = 0.0;
            }
        }
    }

    /// Adds `factor` times the part of column `c` above the diagonal, a walk down the stored blocks, and the row's part
    /// in a block without neighbour.
    fn add_above(&self, c: usize, factor: f32, out: &mut Vector<NB>) {
        if c < LANES && NB > 1 {
            // The pose and what is beside it: short walks, many of them.
            for (i, pair) in self.0.as_chunks::<2>().0.iter().take(c).enumerate() {
                out.0[0][i % LANES] += factor * pair[0][c % LANES];
            }
            return;
        }
        let (m, odd, lane) = (c / TILE, c / LANES % 2, c % LANES);
        let Some(tile) = self.0.get(Self::tile_start(m)..) else { return };
        let column = out.0.as_flattened_mut();
        if 2 * m + 1 == NB {
            walk::<1>(column, tile, c, lane, factor);
        } else if odd == 0 {
            walk::<2>(column, tile, c, lane, factor);
        } else {
            let paired = TILE * m + LANES;
            walk::<2>(column, tile.get(1..).unwrap_or(&[]), paired, lane, factor);
            let Some(single) = tile.get(2 * paired..) else { return };
            walk::<1>(column.get_mut(paired..).unwrap_or(&mut []), single, c - paired, lane, factor);
            if let Some((a, p)) = out.0.get_mut(c / LANES).zip(single.get(c - paired)) {
                add_scaled(a, factor, p);
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
        let factors = scaled.0.as_flattened();
        let mut rest = &mut self.0[..];
        for (m, g) in g.0.chunks(2).enumerate().take(n.div_ceil(TILE)) {
            let first = TILE * m;
            if let [g, h] = g {
                let Some((tile, tail)) = rest.split_at_mut_checked(2 * (first + LANES) + LANES) else { return };
                rest = tail;
                if n > first + LANES {
                    whole_tile(tile, first, factors, g, h);
                } else {
                    half_tile::<2>(tile.as_chunks_mut().0, first, factors, g, n - first);
                }
            } else if let [g] = g {
                half_tile::<1>(rest.as_chunks_mut().0, first, factors, g, n - first);
                return;
            }
        }
    }

    /// Replaces the entries of row `i` from the diagonal on, for a row of the first block.
    pub fn set_row(&mut self, i: usize, row: &Vector<NB>, n: usize) {
        for j in i..n.min(TILE) {
            self.set(i, j, row.get(j));
        }
        for q in 2..n.div_ceil(LANES) {
            let (block, _) = Self::locate(i, LANES * q);
            if let Some((p, values)) = self.0.get_mut(block).zip(row.0.get(q)) {
                *p = *values;
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

/// Downdates a tile of two block columns, the first of which is column `first` of the matrix.
fn whole_tile(tile: &mut [Block], first: usize, factors: &[f32], g: &Block, h: &Block) {
    let Some((paired, single)) = tile.split_at_mut_checked(2 * (first + LANES)) else { return };
    let rows: &mut [[Block; 2]] = paired.as_chunks_mut().0;
    kernel::pairs(rows.as_chunks_mut().0, factors.as_chunks().0, g, h);
    if let Some(factors) = factors.get(first + LANES..) {
        half_tile::<1>(single.as_chunks_mut().0, 0, factors, h, LANES);
    }
}

/// Downdates the first of a tile's block columns, `width` lanes of it at least.
fn half_tile<const STRIDE: usize>(
    tile: &mut [[Block; STRIDE]],
    first: usize,
    factors: &[f32],
    g: &Block,
    width: usize,
) {
    const HALF: usize = LANES / 2;
    let rows = tile.as_chunks_mut().0;
    let factors = factors.as_chunks().0;
    let Some((above, below)) = rows.split_at_mut_checked((first + HALF) / kernel::TURN) else { return };
    if width <= HALF {
        kernel::blocks::<STRIDE, 0, HALF>(above, factors, g);
    } else {
        kernel::blocks::<STRIDE, 0, LANES>(above, factors, g);
        if let (Some(row), Some(factors)) = (below.get_mut(..1), factors.get(above.len()..)) {
            kernel::blocks::<STRIDE, HALF, LANES>(row, factors, g);
        }
    }
}

/// Adds a lane of `len` blocks that are `STRIDE` blocks apart, times a factor.
#[inline(always)]
fn walk<const STRIDE: usize>(out: &mut [f32], blocks: &[Block], len: usize, lane: usize, factor: f32) {
    let (Some(out), Some(rows)) = (out.get_mut(..len), blocks.as_chunks::<STRIDE>().0.get(..len)) else { return };
    for (a, row) in out.iter_mut().zip(rows) {
        *a += factor * row[0][lane % LANES];
    }
}

/// Adds the rows that the entries name, times their factors.
fn add_pairs(a: &mut Block, b: &mut Block, rows: &[[Block; 2]], entries: &[(usize, f32)]) {
    let (mut x, mut y) = (*a, *b);
    for &(c, factor) in entries {
        let Some([p, q]) = rows.get(c) else { continue };
        add_scaled(&mut x, factor, p);
        add_scaled(&mut y, factor, q);
    }
    (*a, *b) = (x, y);
}

/// The same for the first of a tile's columns.
fn add_blocks<const STRIDE: usize>(a: &mut Block, rows: &[[Block; STRIDE]], entries: &[(usize, f32)]) {
    let mut x = *a;
    for &(c, factor) in entries {
        let Some(p) = rows.get(c).and_then(|row| row.first()) else { continue };
        add_scaled(&mut x, factor, p);
    }
    *a = x;
}
