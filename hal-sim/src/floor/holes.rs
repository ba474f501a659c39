//! What was missed.

use super::{CELL_M, FloorRaster};

impl FloorRaster {
    /// Cells of the largest piece of floor that was missed.
    pub(super) fn largest_hole(&self) -> Vec<usize> {
        let is_missed = |cell: usize| self.is_floor[cell] && self.swept_s[cell][0].is_infinite();
        let mut is_counted = vec![false; self.is_floor.len()];
        let mut largest = Vec::new();
        for first in 0..self.is_floor.len() {
            let mut front = vec![first];
            let mut cells = Vec::new();
            while let Some(cell) = front.pop() {
                if !is_missed(cell) || core::mem::replace(&mut is_counted[cell], true) {
                    continue;
                }
                cells.push(cell);
                front.extend(self.neighbours(cell));
            }
            if cells.len() > largest.len() {
                largest = cells;
            }
        }
        largest
    }

    /// Lower and upper corner of the box around cells, metres.
    pub(super) fn box_around(&self, cells: &[usize]) -> Option<[[f64; 2]; 2]> {
        let corners = |cell: &usize| {
            let [x_m, y_m] = self.centre_m(*cell);
            let half_m = 0.5 * CELL_M;
            [[x_m - half_m, y_m - half_m], [x_m + half_m, y_m + half_m]]
        };
        cells.iter().map(corners).reduce(|[low, high], [from, to]| {
            [[low[0].min(from[0]), low[1].min(from[1])], [high[0].max(to[0]), high[1].max(to[1])]]
        })
    }
}
