//! A symmetric matrix, its lower triangle stored row by row, and its Cholesky factor in the same place.

/// Entries of the triangle of a matrix with so many rows.
pub const fn packed_len(rows: usize) -> usize {
    rows * (rows + 1) / 2
}

/// Smallest share of a diagonal entry that may be left once what is before it is known. What is smaller is f32's rounding,
/// and is held where it is.
const SMALLEST_PIVOT: f32 = 1e-6;

/// The matrix, or its factor L with the inverse of each pivot on the diagonal.
#[derive(Clone, Debug)]
pub struct Packed<const P: usize> {
    entries: [f32; P],
}

impl<const P: usize> Packed<P> {
    /// All zero.
    pub const ZERO: Self = Self { entries: [0.0; P] };

    /// Sets the first rows to zero.
    pub fn clear(&mut self, rows: usize) {
        self.entries.iter_mut().take(packed_len(rows)).for_each(|entry| *entry = 0.0);
    }

    /// Adds to the entry at `i` and `j`; nothing past the end.
    pub fn add(&mut self, i: usize, j: usize, value: f32) {
        let (row, column) = if i < j { (j, i) } else { (i, j) };
        if let Some(entry) = self.entries.get_mut(packed_len(row) + column) {
            *entry += value;
        }
    }

    /// The first `rows` rows, each as long as its number.
    fn rows_mut(&mut self, rows: usize) -> impl Iterator<Item = &mut [f32]> {
        let mut rest = self.entries.as_mut_slice();
        (0..rows).map_while(move |i| {
            let (row, tail) = core::mem::take(&mut rest).split_at_mut_checked(i + 1)?;
            rest = tail;
            Some(row)
        })
    }

    /// Takes y y^T off the first `rows` rows, y of three columns.
    pub fn subtract_square(&mut self, y: &[[f32; 3]], rows: usize) {
        for (row, head) in self.rows_mut(rows).zip(y) {
            if *head == [0.0; 3] {
                continue;
            }
            let (fours, rest) = row.as_chunks_mut::<4>();
            let (others, _) = y.as_chunks::<4>();
            let done = 4 * fours.len();
            for (entries, others) in fours.iter_mut().zip(others) {
                for (entry, other) in entries.iter_mut().zip(others) {
                    *entry -= head[0] * other[0] + head[1] * other[1] + head[2] * other[2];
                }
            }
            for (entry, other) in rest.iter_mut().zip(y.iter().skip(done)) {
                *entry -= head[0] * other[0] + head[1] * other[1] + head[2] * other[2];
            }
        }
    }

    /// Adds row `i` of the whole symmetric matrix, scaled, to the first `rows` entries of `y`.
    pub fn add_scaled_row(&self, i: usize, scale: f32, y: &mut [f32], rows: usize) {
        let row = self.entries.get(packed_len(i)..packed_len(i + 1)).unwrap_or(&[]);
        let (up_to_it, below) =
            y.get_mut(..rows).unwrap_or_default().split_at_mut_checked(row.len()).unwrap_or_default();
        up_to_it.iter_mut().zip(row).for_each(|(sum, entry)| *sum += scale * entry);
        // Below the diagonal it is a column.
        for (sum, j) in below.iter_mut().zip(i + 1..) {
            *sum += scale * self.get(j, i);
        }
    }

    /// Takes two products factor y y^T off the first `rows` rows, both at once: fetching and storing entries is half of the work.
    pub fn subtract_scaled(&mut self, [y, z]: [&[f32]; 2], [by_y, by_z]: [f32; 2], rows: usize) {
        for ((row, y_here), z_here) in self.rows_mut(rows).zip(y).zip(z) {
            subtract_scaled(row, [by_y * y_here, by_z * z_here], [y, z]);
        }
    }

    /// Replaces row `i` by that of the factor; the rows before it must be the factor's. False where the pivot is not told from
    /// zero.
    pub fn factor_row(&mut self, i: usize) -> bool {
        let Some((above, rest)) = self.entries.split_at_mut_checked(packed_len(i)) else { return false };
        let Some(row) = rest.get_mut(..i + 1) else { return false };
        let mut above: &[f32] = above;
        for j in 0..i {
            let Some((other, tail)) = above.split_at_checked(j + 1) else { return false };
            above = tail;
            let (Some((inverse, factors)), Some((done, rest))) = (other.split_last(), row.split_at_mut_checked(j))
            else {
                return false;
            };
            if let Some(entry) = rest.first_mut() {
                *entry = (*entry - sum_of_products(done, factors)) * inverse;
            }
        }
        let Some((pivot, done)) = row.split_last_mut() else { return false };
        let left = *pivot - sum_of_products(done, done);
        let is_told = left > SMALLEST_PIVOT * *pivot;
        *pivot = 1.0 / float::sqrtf(if is_told { left } else { pivot.max(1.0) });
        is_told
    }

    /// Replaces row `i` of the factor by that of the factor's inverse; the rows before it must be the inverse's.
    pub fn invert_row(&mut self, i: usize) {
        let Some((above, rest)) = self.entries.split_at_mut_checked(packed_len(i)) else { return };
        let Some((inverse, row)) = rest.get_mut(..i + 1).and_then(|row| row.split_last_mut()) else { return };
        let mut above: &[f32] = above;
        for k in 0..i {
            let Some((other, tail)) = above.split_at_checked(k + 1) else { return };
            above = tail;
            let Some(entry) = row.get_mut(k) else { return };
            let factor = core::mem::replace(entry, 0.0);
            row.iter_mut().zip(other).for_each(|(entry, other)| *entry -= factor * other);
        }
        row.iter_mut().for_each(|entry| *entry *= *inverse);
    }

    /// Replaces row `i` of the factor's inverse by that of the matrix's, of so many rows; those after it must be the factor's
    /// inverse.
    pub fn square_row(&mut self, i: usize, rows: usize) {
        let Some((head, mut tail)) = self.entries.split_at_mut_checked(packed_len(i + 1)) else { return };
        let Some(row) = head.get_mut(packed_len(i)..) else { return };
        let own = row.last().copied().unwrap_or(0.0);
        row.iter_mut().for_each(|entry| *entry *= own);
        for k in i + 1..rows {
            let Some((other, rest)) = core::mem::take(&mut tail).split_at_mut_checked(k + 1) else { return };
            tail = rest;
            let factor = other.get(i).copied().unwrap_or(0.0);
            row.iter_mut().zip(other.iter()).for_each(|(entry, other)| *entry += factor * other);
        }
    }

    /// The entry at `i` and `j`; zero past the end.
    pub fn get(&self, i: usize, j: usize) -> f32 {
        let (row, column) = if i < j { (j, i) } else { (i, j) };
        self.entries.get(packed_len(row) + column).copied().unwrap_or(0.0)
    }

    /// Replaces the entry at `i` and `j`.
    pub fn set(&mut self, i: usize, j: usize, value: f32) {
        let (row, column) = if i < j { (j, i) } else { (i, j) };
        if let Some(entry) = self.entries.get_mut(packed_len(row) + column) {
            *entry = value;
        }
    }

    /// The first rows' entries, one row after the other.
    pub fn entries(&self, rows: usize) -> &[f32] {
        self.entries.get(..packed_len(rows)).unwrap_or(&[])
    }

    /// The factor's rows.
    fn rows(&self, rows: usize) -> impl DoubleEndedIterator<Item = &[f32]> + ExactSizeIterator {
        (0..rows).map(|i| self.entries.get(packed_len(i)..packed_len(i + 1)).unwrap_or(&[]))
    }

    /// Solves L y = x in place.
    pub fn forward(&self, x: &mut [f32], rows: usize) {
        for (i, row) in self.rows(rows).enumerate() {
            let (Some((inverse, factors)), Some((done, rest))) = (row.split_last(), x.split_at_mut_checked(i)) else {
                return;
            };
            if let Some(value) = rest.first_mut() {
                *value = (*value - sum_of_products(factors, done)) * inverse;
            }
        }
    }

    /// Solves L^T x = y in place.
    pub fn backward(&self, y: &mut [f32], rows: usize) {
        for (i, row) in self.rows(rows).enumerate().rev() {
            let (Some((inverse, factors)), Some((before, rest))) = (row.split_last(), y.split_at_mut_checked(i)) else {
                return;
            };
            let Some(value) = rest.first_mut() else { return };
            *value *= inverse;
            before.iter_mut().zip(factors).for_each(|(other, factor)| *other -= factor * *value);
        }
    }
}

/// Takes both, scaled, off a row that is no longer than they are.
fn subtract_scaled(row: &mut [f32], [by_y, by_z]: [f32; 2], [y, z]: [&[f32]; 2]) {
    let (fours, rest) = row.as_chunks_mut::<4>();
    let done = 4 * fours.len();
    for ((entries, y), z) in fours.iter_mut().zip(y.as_chunks::<4>().0).zip(z.as_chunks::<4>().0) {
        for ((entry, y), z) in entries.iter_mut().zip(y).zip(z) {
            *entry -= by_y * y + by_z * z;
        }
    }
    let others = y.iter().zip(z).skip(done);
    rest.iter_mut().zip(others).for_each(|(entry, (y, z))| *entry -= by_y * y + by_z * z);
}

/// In four sums, which the processor can have under way at once, and which lose less.
fn sum_of_products(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0f32; 4];
    let (fours_a, fours_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f32 = fours_a.remainder().iter().zip(fours_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in fours_a.zip(fours_b) {
        for ((sum, x), y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
