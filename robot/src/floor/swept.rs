//! Which floor was swept: four bits a cell of the picture, one for each of its quarters.

use crate::pilot::memory::{Cell, incoming, moved_origin, stored};

/// Cells along an edge of the picture.
pub(super) const CELLS: usize = 80;

/// Width of the brush, metres: so much floor a metre of path sweeps.
pub(crate) const BRUSH_M: f32 = 0.25;

/// A quarter of a cell, counted from the picture's lower corner; it may lie outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Quarter {
    pub col: i16,
    pub row: i16,
}

impl Quarter {
    /// The cell that it is a quarter of.
    pub(super) fn cell(self) -> Cell {
        Cell { col: self.col.div_euclid(2), row: self.row.div_euclid(2) }
    }

    fn bit(self) -> u8 {
        1 << (self.col.rem_euclid(2) + 2 * self.row.rem_euclid(2))
    }
}

/// All quarters of a cell.
const WHOLE: u8 = 0xF;
/// What stands for a cell that need not be swept: two opposite quarters alone, for between them the brush was, too.
const LEFT_OUT: u8 = 0b1001;

/// Which floor was swept, or was given up.
#[derive(Clone, Debug)]
pub(super) struct Swept {
    /// Two cells a byte, stored as the picture's are.
    cells: [[u8; CELLS / 2]; CELLS],
    /// The column and row in which the lower corner is stored.
    origin: [u8; 2],
}

impl Swept {
    /// Nothing yet.
    pub(super) const fn new() -> Self {
        Self { cells: [[0; CELLS / 2]; CELLS], origin: [0; 2] }
    }

    /// The same, where it lies.
    pub(super) fn clear(&mut self) {
        self.cells.as_flattened_mut().fill(0);
        self.origin = [0; 2];
    }

    fn stored_at(&self, cell: Cell) -> Option<[usize; 2]> {
        Some([stored::<CELLS>(cell.row, self.origin[1])?, stored::<CELLS>(cell.col, self.origin[0])?])
    }

    /// What is kept of a cell: its swept quarters, a bit each, or what stands for one that need not be swept.
    pub(super) fn kept_of(&self, cell: Cell) -> u8 {
        let Some([row, col]) = self.stored_at(cell) else { return WHOLE };
        let both = self.cells.get(row).and_then(|row| row.get(col / 2)).copied().unwrap_or(0xFF);
        (both >> (4 * (col % 2))) & WHOLE
    }

    fn keep(&mut self, cell: Cell, quarters: u8) {
        let Some([row, col]) = self.stored_at(cell) else { return };
        if let Some(both) = self.cells.get_mut(row).and_then(|row| row.get_mut(col / 2)) {
            let shift = 4 * (col % 2);
            *both = (*both & !(WHOLE << shift)) | (quarters << shift);
        }
    }

    /// The swept quarters of a cell, a bit each; all of them outside the picture, and where it need not be swept.
    pub(super) fn of(&self, cell: Cell) -> u8 {
        if self.is_left_out(cell) { WHOLE } else { self.kept_of(cell) }
    }

    /// Says which quarters of a cell are swept, a bit each.
    pub(super) fn put(&mut self, cell: Cell, quarters: u8) {
        self.keep(cell, if quarters == LEFT_OUT { quarters | 2 } else { quarters });
    }

    /// A cell need not be swept.
    pub(super) fn leave_out(&mut self, cell: Cell) {
        self.keep(cell, LEFT_OUT);
    }

    /// Whether a cell need not be swept.
    pub(super) fn is_left_out(&self, cell: Cell) -> bool {
        self.kept_of(cell) == LEFT_OUT
    }

    /// Whether this quarter was swept; one outside the picture counts as swept.
    pub(super) fn is_swept(&self, quarter: Quarter) -> bool {
        self.of(quarter.cell()) & quarter.bit() != 0
    }

    /// Marks a quarter as swept; whether it was not before.
    pub(super) fn sweep(&mut self, quarter: Quarter) -> bool {
        let is_new = !self.is_swept(quarter);
        if is_new {
            self.put(quarter.cell(), self.of(quarter.cell()) | quarter.bit());
        }
        is_new
    }

    /// Marks a quarter as not swept; whether it was.
    pub(super) fn unsweep(&mut self, quarter: Quarter) -> bool {
        let before = self.of(quarter.cell());
        self.put(quarter.cell(), before & !quarter.bit());
        before & quarter.bit() != 0
    }

    /// Quarters of a cell that were not swept.
    pub(super) fn left_in(&self, cell: Cell) -> u32 {
        (WHOLE & !self.of(cell)).count_ones()
    }

    /// Marks a whole cell as swept, or as not.
    pub(super) fn set(&mut self, cell: Cell, is_swept: bool) {
        self.put(cell, if is_swept { WHOLE } else { 0 });
    }

    /// Follows the picture, whose cells are now called otherwise by so many columns and rows less. What comes in was not swept.
    pub(super) fn shift(&mut self, cols: i16, rows: i16) {
        self.origin = [moved_origin::<CELLS>(self.origin[0], cols), moved_origin::<CELLS>(self.origin[1], rows)];
        let all = 0..CELLS as i16;
        for row in all.clone() {
            incoming::<CELLS>(cols).for_each(|col| self.put(Cell { col, row }, 0));
        }
        for row in incoming::<CELLS>(rows) {
            all.clone().for_each(|col| self.put(Cell { col, row }, 0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_is_swept_once_and_follows_the_picture() {
        let mut swept = Swept::new();
        let quarter = Quarter { col: 21, row: 10 };
        assert!(swept.sweep(quarter) && !swept.sweep(quarter));
        assert_eq!(swept.left_in(quarter.cell()), 3);
        swept.shift(3, -2);
        let moved = Quarter { col: 15, row: 14 };
        assert!(swept.is_swept(moved) && !swept.is_swept(quarter));
        swept.shift(-3, 2);
        assert!(swept.is_swept(quarter) && !swept.is_swept(moved));
    }

    #[test]
    fn a_cell_that_is_left_out_counts_as_swept_and_stays_left_out_under_the_brush() {
        let mut swept = Swept::new();
        let [one, opposite] = [Quarter { col: 20, row: 10 }, Quarter { col: 21, row: 11 }];
        swept.leave_out(one.cell());
        assert_eq!((swept.left_in(one.cell()), swept.sweep(one)), (0, false));
        assert!(swept.is_left_out(one.cell()));
        swept.set(one.cell(), false);
        assert!(swept.sweep(one) && swept.sweep(opposite) && !swept.is_left_out(one.cell()));
        assert!(swept.is_swept(one) && swept.is_swept(opposite));
    }

    #[test]
    fn outside_there_is_nothing_to_sweep() {
        let mut swept = Swept::new();
        for quarter in [Quarter { col: -1, row: 5 }, Quarter { col: 5, row: 160 }, Quarter { col: i16::MIN, row: 0 }] {
            assert!(swept.is_swept(quarter) && !swept.sweep(quarter));
        }
    }
}
