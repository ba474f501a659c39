//! A coarse picture of the floor in the estimated frame: what was seen free, what was hit, where the robot has been.

use slam_core::Pose;

/// A cell of the picture, counted from its lower corner; it may lie outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cell {
    pub col: i16,
    pub row: i16,
}

impl Cell {
    pub(crate) fn offset(self, cols: i16, rows: i16) -> Cell {
        Cell { col: self.col + cols, row: self.row + rows }
    }

    /// Its column and row, where it lies inside.
    pub(crate) fn packed(self) -> [u8; 2] {
        [self.col as u8, self.row as u8]
    }

    /// The cell in this column and row.
    pub(crate) fn unpacked([col, row]: [u8; 2]) -> Self {
        Self { col: col.into(), row: row.into() }
    }

    /// Distance in king's moves.
    pub(crate) fn moves_to(self, other: Cell) -> i16 {
        (self.col - other.col).abs().max((self.row - other.row).abs())
    }
}

// One byte a cell. Low four bits: 0 unknown, else evidence from 1 (surely free) to 15 (surely occupied).
const EVIDENCE: u8 = 0x0F;
const NEUTRAL: u8 = 8;
/// Two hits where nothing was known: one may be a spike.
const OCCUPIED: u8 = 12;
const HIT: u8 = 3;
const VISITED: u8 = 0x10;
/// The floor job's search keeps here, for as long as it lasts, where the body has room; it remembers no visits.
const ROOM: u8 = VISITED;
const STEP: u8 = 0x60;
const STEP_SHIFT: u32 = 5;
/// Touched by the bumper or without a floor: no beam that passes above clears it.
const BLOCKED: u8 = 0x80;

/// Whether a cell of this value is an obstacle. Blocked is the highest bit.
fn holds_obstacle(value: u8) -> bool {
    value >= BLOCKED || value & EVIDENCE >= OCCUPIED
}

/// `N` by `N` cells, one byte each, of a plane that is rolled up both ways: when the picture moves, cells stay where they are
/// stored, and those that fall off at one side come in, empty, at the other.
#[derive(Clone, Debug)]
pub(crate) struct Memory<const N: usize> {
    cells: [[u8; N]; N],
    /// Place of the lower corner in the estimated frame, in cells.
    corner: [i32; 2],
    /// The column and row in which it is stored.
    origin: [u8; 2],
    pub cell_m: f32,
}

/// Where a row or column is stored that lies so many cells from the lower corner, itself stored at `origin`; none outside.
pub(crate) fn stored<const N: usize>(index: i16, origin: u8) -> Option<usize> {
    // A negative one becomes a large one.
    let index = usize::from(index as u16);
    let rolled = index + usize::from(origin);
    (index < N).then_some(if rolled < N { rolled } else { rolled - N })
}

/// Where the lower corner is stored after the picture moved by so many cells.
pub(crate) fn moved_origin<const N: usize>(origin: u8, moved: i16) -> u8 {
    (i16::from(origin) + moved).rem_euclid(N as i16) as u8
}

/// The rows or columns that come in when the picture moves by so many cells, counted from its new lower corner.
pub(crate) fn incoming<const N: usize>(moved: i16) -> core::ops::Range<i16> {
    let cells = N as i16;
    if moved >= 0 { (cells - moved).max(0)..cells } else { 0..(-moved).min(cells) }
}

impl<const N: usize> Memory<N> {
    /// Of a pilot that is yet to be prepared.
    pub(crate) const ZEROS: Self = Self { cells: [[0; N]; N], corner: [0; 2], origin: [0; 2], cell_m: 0.0 };

    /// Nothing known; the start in the middle.
    pub(crate) const fn new(cell_m: f32) -> Self {
        Self { cells: [[0; N]; N], corner: Self::CORNER, origin: [0; 2], cell_m }
    }

    /// Where its lower corner is at first: the start is in the middle.
    const CORNER: [i32; 2] = [-((N / 2) as i32); 2];

    /// The same, where it lies: a new one beside it would need as much memory again.
    pub(crate) fn clear(&mut self, cell_m: f32) {
        self.cells.as_flattened_mut().fill(0);
        (self.corner, self.origin, self.cell_m) = (Self::CORNER, [0; 2], cell_m);
    }

    pub(crate) fn cell_at(&self, x_m: f32, y_m: f32) -> Cell {
        let place = |value_m: f32, corner: i32| {
            // Far outside stays outside: the limits keep the sum in range.
            let cell = libm::floorf((value_m / self.cell_m).clamp(-1e6, 1e6)) as i32 - corner;
            cell.clamp(-1000, 1000) as i16
        };
        Cell { col: place(x_m, self.corner[0]), row: place(y_m, self.corner[1]) }
    }

    /// Place of the lower corner in the estimated frame, in cells.
    pub(crate) fn corner(&self) -> [i32; 2] {
        self.corner
    }

    /// An empty picture is put there.
    pub(crate) fn put_corner(&mut self, corner: [i32; 2]) {
        self.corner = corner.map(|cells| cells.clamp(-1_000_000, 1_000_000));
    }

    /// Centre of a cell in the estimated frame, metres.
    pub(crate) fn centre_m(&self, cell: Cell) -> [f32; 2] {
        let middle = |index: i16, corner: i32| (i32::from(index) + corner) as f32 * self.cell_m + 0.5 * self.cell_m;
        [middle(cell.col, self.corner[0]), middle(cell.row, self.corner[1])]
    }

    fn stored_at(&self, cell: Cell) -> Option<[usize; 2]> {
        Some([stored::<N>(cell.row, self.origin[1])?, stored::<N>(cell.col, self.origin[0])?])
    }

    fn get(&self, cell: Cell) -> u8 {
        let value = self.stored_at(cell).and_then(|[row, col]| self.cells.get(row)?.get(col));
        value.copied().unwrap_or(0)
    }

    fn edit(&mut self, cell: Cell, change: impl FnOnce(u8) -> u8) {
        let place = self.stored_at(cell);
        if let Some(value) = place.and_then(|[row, col]| self.cells.get_mut(row)?.get_mut(col)) {
            *value = change(*value);
        }
    }

    pub(crate) fn is_inside(&self, cell: Cell) -> bool {
        (cell.row as usize) < N && (cell.col as usize) < N
    }

    pub(crate) fn is_known(&self, cell: Cell) -> bool {
        self.get(cell) & (EVIDENCE | BLOCKED) != 0
    }

    /// Whether nothing is known of these columns (axis 0) or rows (axis 1).
    pub(crate) fn is_blank(&self, axis: usize, mut lines: core::ops::Range<i16>) -> bool {
        let is_blank = |value: &u8| value & (EVIDENCE | BLOCKED) == 0;
        lines.all(|line| {
            if axis == 0 {
                let col = stored::<N>(line, self.origin[0]);
                self.cells.iter().filter_map(|row| row.get(col?)).all(is_blank)
            } else {
                let row = stored::<N>(line, self.origin[1]).and_then(|row| self.cells.get(row));
                row.is_none_or(|row| row.iter().all(is_blank))
            }
        })
    }

    pub(crate) fn is_free(&self, cell: Cell) -> bool {
        let value = self.get(cell);
        let evidence = value & EVIDENCE;
        value & BLOCKED == 0 && evidence != 0 && evidence < OCCUPIED
    }

    pub(crate) fn is_obstacle(&self, cell: Cell) -> bool {
        holds_obstacle(self.get(cell))
    }

    pub(crate) fn is_visited(&self, cell: Cell) -> bool {
        self.get(cell) & VISITED != 0
    }

    /// Whether an obstacle lies within this many king's moves.
    pub(crate) fn obstacle_within(&self, cell: Cell, moves: i16) -> bool {
        let last = N as i16 - 1;
        let (from, to) = ((cell.col - moves).max(0), (cell.col + moves).min(last));
        let columns = [from, to].map(|col| stored::<N>(col, self.origin[0]));
        let ([Some(from), Some(to)], true) = (columns, from <= to) else { return false };
        ((cell.row - moves).max(0)..=(cell.row + moves).min(last))
            .filter_map(|row| self.cells.get(stored::<N>(row, self.origin[1])?))
            .any(|row| {
                let parts = if from <= to { [row.get(from..=to), None] } else { [row.get(from..), row.get(..=to)] };
                parts.into_iter().flatten().flatten().any(|value| holds_obstacle(*value))
            })
    }

    /// A beam passed here.
    pub(crate) fn see_free(&mut self, cell: Cell) {
        self.edit(cell, |value| {
            let evidence = if value & EVIDENCE == 0 { NEUTRAL } else { value & EVIDENCE };
            (value & !EVIDENCE) | (evidence - 1).max(1)
        });
    }

    /// A beam ended here.
    pub(crate) fn see_hit(&mut self, cell: Cell) {
        self.edit(cell, |value| {
            let evidence = if value & EVIDENCE == 0 { NEUTRAL } else { value & EVIDENCE };
            (value & !EVIDENCE) | (evidence + HIT).min(EVIDENCE)
        });
    }

    /// The bumper or the cliff sensor found something here.
    pub(crate) fn block(&mut self, cell: Cell) {
        self.edit(cell, |value| value | BLOCKED);
    }

    /// What kept it out of here is elsewhere.
    pub(crate) fn unblock(&mut self, cell: Cell) {
        self.edit(cell, |value| value & !BLOCKED);
    }

    /// The robot's centre is here: whatever was thought to be here is not.
    pub(crate) fn stand_on(&mut self, cell: Cell) {
        self.edit(cell, |value| (value & !(EVIDENCE | BLOCKED)) | 2);
    }

    /// Marks the cells within this many king's moves as visited; returns whether any was not.
    pub(crate) fn visit(&mut self, centre: Cell, moves: i16) -> bool {
        let mut any_new = false;
        for row in -moves..=moves {
            for col in -moves..=moves {
                let cell = centre.offset(col, row);
                any_new |= self.is_inside(cell) && !self.is_visited(cell);
                self.edit(cell, |value| value | VISITED);
            }
        }
        any_new
    }

    /// Forgets where the robot has been and what it bumped into; what was seen stays.
    pub(crate) fn forget_visits(&mut self) {
        self.cells.as_flattened_mut().iter_mut().for_each(|value| *value &= !(VISITED | BLOCKED));
    }

    /// Doubts every obstacle: one more beam that ends there makes it one again.
    pub(crate) fn doubt_obstacles(&mut self) {
        for value in self.cells.as_flattened_mut() {
            let evidence = (*value & EVIDENCE).min(OCCUPIED - 1);
            *value = *value & !(EVIDENCE | BLOCKED) | evidence;
        }
    }

    pub(crate) fn clear_steps(&mut self) {
        self.cells.as_flattened_mut().iter_mut().for_each(|value| *value &= !STEP);
    }

    /// Makes a row ready for a search: no steps yet, and known where the body has room. One that dares has room where nothing was seen.
    pub(crate) fn begin_row(&mut self, row: i16, dares: bool) {
        // In the order of storage, in which the last column is beside the first: somewhere in a picture that moved, and else at its edges, where
        // the body never is.
        let mut is_tight = [false; N];
        for row in [row - 1, row, row + 1] {
            let Some(row) = stored::<N>(row, self.origin[1]).and_then(|row| self.cells.get(row)) else { continue };
            for (is_tight, value) in is_tight.iter_mut().zip(row) {
                *is_tight |= holds_obstacle(*value);
            }
        }
        let Some(row) = stored::<N>(row, self.origin[1]).and_then(|row| self.cells.get_mut(row)) else { return };
        let mut before = is_tight.last().copied().unwrap_or(false);
        for (col, value) in row.iter_mut().enumerate() {
            let here = is_tight.get(col).copied().unwrap_or(false);
            let after = is_tight.get((col + 1) % N).copied().unwrap_or(false);
            let is_free = dares || *value & EVIDENCE != 0;
            *value &= !(STEP | ROOM);
            if is_free && !(before || here || after) {
                *value |= ROOM;
            }
            before = here;
        }
    }

    /// Whether the body has room here, as of when the search began.
    pub(crate) fn has_room(&self, cell: Cell) -> bool {
        self.get(cell) & ROOM != 0
    }

    /// Number of steps from the search's start modulo 3, where the search has been.
    pub(crate) fn step_label(&self, cell: Cell) -> Option<u8> {
        ((self.get(cell) & STEP) >> STEP_SHIFT).checked_sub(1)
    }

    pub(crate) fn set_step_label(&mut self, cell: Cell, steps_mod_3: u8) {
        self.edit(cell, |value| (value & !STEP) | ((steps_mod_3 + 1) << STEP_SHIFT));
    }

    /// Moves the picture when the robot comes near its edge: what falls off at the far side is forgotten.
    /// Returns by how many columns and rows: cells are now called otherwise by so much less.
    pub(crate) fn keep_around(&mut self, pose: &Pose) -> (i16, i16) {
        let margin = (N / 8) as i16;
        let cell = self.cell_at(pose.x_m, pose.y_m);
        let shift = |index: i16| {
            if index < margin {
                index - margin - margin / 2
            } else if index >= N as i16 - margin {
                index - (N as i16 - 1 - margin - margin / 2)
            } else {
                0
            }
        };
        let (cols, rows) = (shift(cell.col), shift(cell.row));
        if cols != 0 || rows != 0 {
            self.shift(cols, rows);
        }
        (cols, rows)
    }

    /// Moves the picture by so many columns and rows: cells are called otherwise by so much less. What falls off is forgotten.
    pub(crate) fn shift(&mut self, cols: i16, rows: i16) {
        self.corner[0] += i32::from(cols);
        self.corner[1] += i32::from(rows);
        self.origin = [moved_origin::<N>(self.origin[0], cols), moved_origin::<N>(self.origin[1], rows)];
        for row in incoming::<N>(rows) {
            let row = stored::<N>(row, self.origin[1]).and_then(|row| self.cells.get_mut(row));
            row.into_iter().for_each(|row| row.fill(0));
        }
        for col in incoming::<N>(cols).filter_map(|col| stored::<N>(col, self.origin[0])) {
            self.cells.iter_mut().filter_map(|row| row.get_mut(col)).for_each(|value| *value = 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hits_outweigh_a_few_passing_beams_and_yield_to_many() {
        let mut memory = Memory::<16>::new(0.2);
        let cell = memory.cell_at(0.5, -0.3);
        assert!(!memory.is_known(cell));
        memory.see_hit(cell);
        assert!(memory.is_free(cell), "one hit may be a spike");
        memory.see_hit(cell);
        assert!(memory.is_obstacle(cell));
        memory.see_free(cell);
        memory.see_free(cell);
        assert!(memory.is_obstacle(cell));
        memory.see_free(cell);
        assert!(memory.is_free(cell));
        memory.block(cell);
        memory.see_free(cell);
        assert!(memory.is_obstacle(cell) && !memory.is_free(cell));
    }

    #[test]
    fn the_picture_follows_the_robot_and_keeps_its_places() {
        for target in [[3.9, 0.1], [-3.9, 0.1], [0.1, 3.9], [-7.5, -7.5], [3.0, -3.0]] {
            let mut memory = Memory::<40>::new(0.2);
            let wall_m = [target[0] * 0.5, target[1] * 0.5];
            (0..2).for_each(|_| memory.see_hit(memory.cell_at(wall_m[0], wall_m[1])));
            memory.keep_around(&Pose::new(target[0], target[1], 0.0));
            let here = memory.cell_at(target[0], target[1]);
            assert!(here.col >= 5 && here.col < 35 && here.row >= 5 && here.row < 35, "{here:?}");
            let wall = memory.cell_at(wall_m[0], wall_m[1]);
            assert_eq!(memory.is_obstacle(wall), memory.is_inside(wall), "{target:?}");
        }
    }

    #[test]
    fn an_obstacle_is_near_wherever_the_picture_is_rolled_up() {
        const N: i16 = 16;
        let mut memory = Memory::<{ N as usize }>::new(0.2);
        memory.shift(5, -3);
        for cell in [(0, 0), (3, 13), (10, 12), (15, 2), (15, 15)].map(|(col, row)| Cell { col, row }) {
            memory.block(cell);
        }
        for (col, row) in (-4..N + 4).flat_map(|col| (-4..N + 4).map(move |row| (col, row))) {
            for moves in 0..=3 {
                let mut around = (-moves..=moves).flat_map(|cols| (-moves..=moves).map(move |rows| (cols, rows)));
                let cell = Cell { col, row };
                let is_near = around.any(|(cols, rows)| memory.is_obstacle(cell.offset(cols, rows)));
                assert_eq!(memory.obstacle_within(cell, moves), is_near, "{cell:?}, {moves} moves");
            }
        }
    }

    #[test]
    fn the_body_has_room_away_from_obstacles_wherever_the_picture_is_rolled_up() {
        const N: i16 = 16;
        for (cols, rows) in [(0, 0), (5, -3), (1, 0), (-1, 7), (15, 15), (9, -20)] {
            let mut memory = Memory::<{ N as usize }>::new(0.2);
            memory.shift(cols, rows);
            for cell in (0..N).flat_map(|col| (0..N).map(move |row| Cell { col, row })) {
                memory.see_free(cell);
                if (7 * cell.col + 5 * cell.row) % 13 == 0 {
                    memory.block(cell);
                }
            }
            (0..N).for_each(|row| memory.begin_row(row, false));
            for cell in (1..N - 1).flat_map(|col| (1..N - 1).map(move |row| Cell { col, row })) {
                let has_room = memory.is_free(cell) && !memory.obstacle_within(cell, 1);
                assert_eq!(memory.has_room(cell), has_room, "{cell:?}, moved by {cols} and {rows}");
            }
        }
    }

    #[test]
    fn far_outside_is_unknown_and_harmless() {
        let mut memory = Memory::<16>::new(0.2);
        for far in [1e30, -1e30, f32::INFINITY] {
            let cell = memory.cell_at(far, 0.0);
            memory.see_hit(cell);
            assert!(!memory.is_inside(cell) && !memory.is_known(cell));
        }
    }
}
