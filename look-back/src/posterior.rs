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

    /// Takes in one more residual of the last pose and of the border, whose covariance is known: one update of a Kalman
    /// filter. One that is off by more than `gate` variances is not taken.
    pub fn update(&mut self, row: &Row, gate: f32) {
        // Hits on one point do not say how the wall is turned.
        if row.weight <= 0.0 {
            return;
        }
        let pose = [0, 1, 2].map(|i| (LAST_POSE + i, row.here[i]));
        let all = || pose.into_iter().chain(row.border).filter(|(_, value)| *value != 0.0);
        let innovation = -row.residual - all().map(|(place, value)| value * self.increment(place)).sum::<f32>();
        let mut column = [0.0; B];
        for (j, entry) in column.iter_mut().enumerate().take(self.len()) {
            *entry = all().map(|(place, value)| value * self.covariance(place, j)).sum();
        }
        let known: f32 = all().map(|(place, value)| value * column.get(place).copied().unwrap_or(0.0)).sum();
        let inverse = 1.0 / (known + 1.0 / row.weight);
        // Also false for what is no number.
        if !(row.weight > 0.0 && inverse > 0.0 && innovation * innovation * inverse <= gate) {
            return;
        }
        self.matrix.subtract_scaled(&column, inverse, self.len());
        self.right.iter_mut().zip(column).for_each(|(own, entry)| *own += innovation * inverse * entry);
    }

    /// The last pose goes on: its three unknowns become sums of themselves and of other unknowns, by these derivatives, with
    /// so much noise on each. The covariance follows.
    pub fn move_on(&mut self, by: &[[(usize, f32); 3]; 3], noise: [f32; 3]) {
        let mut rows = [[0.0; B]; 3];
        for ((i, row), by) in rows.iter_mut().enumerate().zip(by) {
            for (j, entry) in row.iter_mut().enumerate().take(self.len()) {
                let others: f32 = by.iter().map(|(k, value)| value * self.covariance(*k, j)).sum();
                *entry = self.covariance(LAST_POSE + i, j) + others;
            }
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
