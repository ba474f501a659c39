//! The covariance: one symmetric matrix, stored once.
//!
//! Layout: the upper triangle by rows, in blocks of eight columns. Row i starts at the block that holds column i, so
//! the eight rows 8q .. 8q + 7 have `NB - q` blocks each, and two neighbouring rows can be worked on together. The pose
//! has the lowest indices: its rows are whole and contiguous, and the map grows at the far end.
//!
//! Lanes left of the diagonal in a row's first block are never read.

/// Columns of a block.
pub const LANES: usize = 8;

/// Eight neighbouring columns of a row, or eight neighbouring entries of a vector.
pub type Block = [f32; LANES];

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

    /// self *= factor.
    fn scaled(&self, factor: f32, n: usize) -> Self {
        let mut out = Self::ZERO;
        out.add_scaled(factor, self, n);
        out
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

    /// Index of the first block of row `i`.
    #[inline]
    const fn row_start(i: usize) -> usize {
        let (q, r) = (i / LANES, i % LANES);
        // The sum of 8 (NB - p) over the block rows p < q, then r rows of NB - q.
        LANES * (q * NB - q * q.saturating_sub(1) / 2) + r * (NB - q)
    }

    #[inline]
    fn locate(i: usize, j: usize) -> (usize, usize) {
        let (i, j) = if i <= j { (i, j) } else { (j, i) };
        if j >= LANES * NB {
            return (BLOCKS, 0);
        }
        (Self::row_start(i) + j / LANES - i / LANES, j % LANES)
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

    /// The stored blocks of row `i` up to column `n`: the first holds column `i`.
    #[inline]
    fn row(&self, i: usize, n: usize) -> &[Block] {
        let len = n.div_ceil(LANES).saturating_sub(i / LANES);
        self.0.get(Self::row_start(i.min(LANES * NB - 1))..).and_then(|b| b.get(..len)).unwrap_or(&[])
    }

    /// Adds `factor` times column `c` of the leading n x n part to `out`. O(n).
    pub fn add_column(&self, c: usize, factor: f32, n: usize, out: &mut Vector<NB>) {
        for i in 0..c.min(n) {
            out.set(i, out.get(i) + factor * self.get(i, c));
        }
        let row = self.row(c, n);
        let mut blocks = out.0.iter_mut().skip(c / LANES).zip(row);
        if let Some((a, b)) = blocks.next() {
            for lane in c % LANES..LANES {
                a[lane] += factor * b[lane];
            }
        }
        for (a, b) in blocks {
            add_scaled(a, factor, b);
        }
    }

    /// P -= k g g^T over the leading n x n part: n (n + 1) / 2 multiply-subtracts.
    ///
    /// `g` must be zero past `n`.
    pub fn downdate(&mut self, g: &Vector<NB>, k: f32, n: usize) {
        let used = n.div_ceil(LANES).min(NB);
        let scaled = g.scaled(k, n);
        let mut rest = &mut self.0[..];
        for q in 0..used {
            let stride = NB - q;
            let (Some(factors), Some(columns)) = (scaled.0.get(q), g.0.get(q..used)) else { return };
            for factor in factors {
                let Some((row, tail)) = core::mem::take(&mut rest).split_at_mut_checked(stride) else { return };
                rest = tail;
                for (p, g) in row.iter_mut().zip(columns) {
                    add_scaled(p, -*factor, g);
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
