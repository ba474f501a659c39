//! The border's covariance, and what happens to it afterwards: the last pose goes on, and more is seen from it.

use crate::rows::{LAST_POSE, Row};
use crate::system::System;

impl<const B: usize, const P: usize> System<B, P> {
    /// Inverts one row of the factor; false past the last.
    pub fn invert_row(&mut self, row: usize) -> bool {
        self.matrix.invert_row(row);
        row < self.len()
    }

    /// Makes one row of the factor's inverse one of the covariance; false past the last.
    pub fn square_row(&mut self, row: usize) -> bool {
        if row < self.len() {
            self.matrix.square_row(row, self.len());
        }
        row < self.len()
    }

    /// Entry of the covariance, once its rows are.
    pub fn covariance(&self, i: usize, j: usize) -> f32 {
        self.matrix.get(i, j)
    }

    /// The covariance's lower triangle, row by row, once its rows are.
    pub fn covariance_entries(&self) -> &[f32] {
        self.matrix.entries(self.len())
    }

    /// The increments are told from here on, none yet.
    pub fn settle(&mut self) {
        self.right = [0.0; B];
    }

    /// Takes the increments of the last pose: they are part of its mean from then on.
    pub fn take_pose(&mut self) -> [f32; 3] {
        [0, 1, 2].map(|i| self.right.get_mut(LAST_POSE + i).map_or(0.0, core::mem::take))
    }

    /// Takes in two more residuals of the last pose and of the border, whose covariance is known: two updates of a Kalman filter, one
    /// after the other. One that is off by more than `gate` variances is not taken.
    pub fn update(&mut self, rows: &[Row; 2], gate: f32) {
        let [first, second] = rows;
        let [mut column, mut other] = [[0.0; B]; 2];
        self.add_columns(first, &mut column);
        self.add_columns(second, &mut other);
        let mut innovation = self.innovation(second);
        let taken = Taken::of(first, &mut column, self.innovation(first), gate);
        // The second is seen once the first is known.
        let shared = sum(second, &column) * taken.factor;
        innovation -= shared * taken.innovation;
        other.iter_mut().zip(&column).for_each(|(entry, known)| *entry -= shared * known);
        let then = Taken::of(second, &mut other, innovation, gate);
        if taken.factor + then.factor > 0.0 {
            self.matrix.subtract_scaled([&column, &other], [taken.factor, then.factor], self.len());
        }
        let [by_column, by_other] = [taken, then].map(|taken| taken.factor * taken.innovation);
        for ((own, entry), other) in self.right.iter_mut().zip(column).zip(other) {
            *own += by_column * entry + by_other * other;
        }
    }

    /// What a residual is by the increments told so far, with its sign.
    fn innovation(&self, row: &Row) -> f32 {
        -row.residual - entries(row).map(|(place, value)| value * self.increment(place)).sum::<f32>()
    }

    /// Adds the covariance of a residual with all unknowns.
    fn add_columns(&self, row: &Row, column: &mut [f32; B]) {
        entries(row).for_each(|(place, value)| self.matrix.add_scaled_row(place, value, column, self.len()));
    }

    /// The last pose goes on: its three unknowns become sums of themselves and of other unknowns, by these derivatives, with
    /// so much noise on each. The covariance follows.
    pub fn move_on(&mut self, by: &[[(usize, f32); 3]; 3], noise: [f32; 3]) {
        let mut rows = [[0.0; B]; 3];
        for ((i, row), by) in rows.iter_mut().enumerate().zip(by) {
            by.iter().for_each(|(k, value)| self.matrix.add_scaled_row(*k, *value, row, self.len()));
            self.matrix.add_scaled_row(LAST_POSE + i, 1.0, row, self.len());
        }
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in row.iter().enumerate().take(self.len()) {
                if !(LAST_POSE..LAST_POSE + 3).contains(&j) {
                    self.matrix.set(LAST_POSE + i, j, *value);
                }
            }
            let entry = |at: usize| row.get(at).copied().unwrap_or(0.0);
            for (j, by) in by.iter().enumerate().take(i + 1) {
                let others: f32 = by.iter().map(|(k, value)| value * entry(*k)).sum();
                let own = if i == j { noise[i] } else { 0.0 };
                self.matrix.set(LAST_POSE + i, LAST_POSE + j, entry(LAST_POSE + j) + others + own);
            }
        }
    }
}

/// The derivatives of a residual by the last pose and the border.
fn entries(row: &Row) -> impl Iterator<Item = (usize, f32)> {
    let pose = [0, 1, 2].map(|i| (LAST_POSE + i, row.here[i]));
    pose.into_iter().chain(row.border).filter(|(_, value)| *value != 0.0)
}

/// Their sum over a column.
fn sum(row: &Row, column: &[f32]) -> f32 {
    entries(row).map(|(place, value)| value * column.get(place).copied().unwrap_or(0.0)).sum()
}

/// A residual that is taken, and one over the variance of its innovation; of one that is not, all is nought.
struct Taken {
    factor: f32,
    innovation: f32,
}

impl Taken {
    /// Whose covariance with all unknowns is this column.
    fn of(row: &Row, column: &mut [f32], innovation: f32, gate: f32) -> Self {
        // Hits on one point do not say how the wall is turned.
        let factor = if row.weight > 0.0 { 1.0 / (sum(row, column) + 1.0 / row.weight) } else { 0.0 };
        // Also false for what is no number.
        if factor > 0.0 && innovation * innovation * factor <= gate {
            return Self { factor, innovation };
        }
        column.fill(0.0);
        Self { factor: 0.0, innovation: 0.0 }
    }
}
