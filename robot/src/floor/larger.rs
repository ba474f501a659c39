//! Homes that are larger than the picture.
//!
//! The picture moves on with the robot, as far as nothing that is known falls off at its far side. Where something would, the floor in the
//! picture is swept first; then it moves on by half its width, and the [overview](super::overview) remembers what falls off. Where nothing is
//! left in the picture, the robot goes to where the overview has floor left. On its way home it takes the picture along.

use slam_core::Pose;

use super::FloorJob;
use super::overview::{BLOCK, Block, Known};
use super::sheet::{Axis, Sheet, Stretch};
use super::swept::CELLS;
use super::wave::Aim;
use crate::pilot::memory::Cell;
use crate::pilot::search::is_passable;

/// So near to its border the picture is to move on, and has to where it may not lose anything, in cells: the robot sees ten cells far.
const MARGIN: i16 = CELLS as i16 / 8;
const BRINK: i16 = 3;
/// Cosine of the angle off the way straight out of the picture up to which a robot leaves it.
const OUTWARD: f32 = 0.5;
/// Ways to what is left beyond the picture, one picture after the other: eight times through all that the overview holds.
const MAX_TRIPS: u8 = 32;
/// Of a block with fewer free cells than these nothing is remembered.
const FEW: usize = 5;

/// What the picture may lose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moves {
    /// Nothing, while there is floor to sweep in it.
    Keeping,
    /// What is in it is swept: half of it.
    Leaving,
    /// What falls off does not matter.
    Freely,
}

/// A side of the picture.
#[derive(Clone, Copy)]
struct Side {
    axis: usize,
    is_low: bool,
}

const SIDES: [Side; 4] = [
    Side { axis: 0, is_low: true },
    Side { axis: 0, is_low: false },
    Side { axis: 1, is_low: true },
    Side { axis: 1, is_low: false },
];

impl Side {
    fn bit(self) -> u8 {
        1 << (2 * self.axis + usize::from(self.is_low))
    }

    /// Cells between a cell and this side; negative beyond it.
    fn depth(self, cell: Cell) -> i16 {
        let index = if self.axis == 0 { cell.col } else { cell.row };
        if self.is_low { index } else { CELLS as i16 - 1 - index }
    }

    /// A cell by its depth from this side and its place along it.
    fn cell(self, depth: i16, along: i16) -> Cell {
        let across = if self.is_low { depth } else { CELLS as i16 - 1 - depth };
        if self.axis == 0 { Cell { col: across, row: along } } else { Cell { col: along, row: across } }
    }
}

/// How the picture is about to move.
#[derive(Clone, Debug)]
pub(super) struct Border {
    /// Sides towards which it cannot move without losing something, a bit each.
    loses: u8,
    /// The floor in it is swept: it may lose what it has.
    pub leaves: bool,
    /// Nothing that is left in it can be reached.
    is_spent: bool,
    /// Blocks by which it is yet to move along each axis, one a step.
    due: [i8; 2],
    /// Ways that led beyond it.
    trips: u8,
}

impl Border {
    pub(super) const NEW: Self = Self { loses: 0, leaves: false, is_spent: false, due: [0; 2], trips: 0 };
}

/// The cells of a block with this first one.
fn cells(first: Cell) -> impl Iterator<Item = Cell> {
    (0..BLOCK * BLOCK).map(move |index| first.offset(index % BLOCK, index / BLOCK))
}

impl Sheet {
    /// The block that a cell is in.
    fn block_of(&self, cell: Cell) -> Block {
        let [col, row] = self.picture.corner();
        [col + i32::from(cell.col), row + i32::from(cell.row)].map(|index| index.div_euclid(BLOCK.into()) as i16)
    }

    /// The first cell of a block.
    fn first_cell(&self, [col, row]: Block) -> Cell {
        let corner = self.picture.corner();
        let place = |block: i16, corner: i32| (i32::from(block) * i32::from(BLOCK) - corner).clamp(-1000, 1000) as i16;
        Cell { col: place(col, corner[0]), row: place(row, corner[1]) }
    }

    /// What is known of the block with this first cell.
    fn known_of(&self, first: Cell) -> Known {
        match cells(first).filter(|cell| self.picture.is_free(*cell)).count() {
            0..FEW => Known::Nothing,
            _ if cells(first).any(|cell| self.is_passable_left(cell)) => Known::Left,
            _ => Known::Swept,
        }
    }

    /// Whether something known falls off where the picture moves on by a block at this side.
    fn loses(&self, side: Side) -> bool {
        let cells = CELLS as i16;
        let far = if side.is_low { cells - BLOCK..cells } else { 0..BLOCK };
        !self.picture.is_blank(side.axis, far)
    }

    /// A search begins: for a way out of the picture, or for what is in it.
    pub(super) fn begin_search(&mut self, leaves: bool, is_to_sweep: bool) {
        self.border.loses = SIDES.iter().filter(|side| self.loses(**side)).fold(0, |bits, side| bits | side.bit());
        if self.border.due == [0; 2] {
            (self.border.leaves, self.border.is_spent) = (leaves, leaves && is_to_sweep);
        }
    }

    /// Moves on by a block at this side.
    fn move_on(&mut self, side: Side) {
        let far = Side { is_low: !side.is_low, ..side };
        let blocks = (0..CELLS as i16).step_by(BLOCK as usize);
        let first = |side: Side, along: i16| side.cell(if side.is_low { 0 } else { BLOCK - 1 }, along);
        for cell in blocks.clone().map(|along| first(far, along)) {
            match self.known_of(cell) {
                // What was not seen again is what it was.
                Known::Nothing => {}
                // What could be reached is swept by now.
                Known::Left if self.border.is_spent => self.overview.put(self.block_of(cell), Known::Swept),
                known => self.overview.put(self.block_of(cell), known),
            }
        }
        let by = if side.is_low { -BLOCK } else { BLOCK };
        let (cols, rows) = if side.axis == 0 { (by, 0) } else { (0, by) };
        self.picture.shift(cols, rows);
        self.swept.shift(cols, rows);
        for cell in blocks.map(|along| first(side, along)) {
            let block = self.block_of(cell);
            self.overview.include(block);
            if self.overview.of(block) == Known::Swept {
                // As one beam would see it: where walls are is seen anew.
                cells(cell).for_each(|cell| self.picture.see_free(cell));
                cells(cell).for_each(|cell| self.swept.set(cell, true));
            }
        }
        self.border.loses = 0;
    }

    /// By how many blocks it is to move along an axis for a robot in this cell.
    fn due(&mut self, axis: usize, cell: Cell, moves: Moves) -> i8 {
        let Some(side) = SIDES.into_iter().find(|side| side.axis == axis && side.depth(cell) < MARGIN) else {
            return 0;
        };
        if self.border.loses & side.bit() == 0 && self.loses(side) {
            self.border.loses |= side.bit();
        }
        let loses = self.border.loses & side.bit() != 0;
        let blocks = match moves {
            Moves::Keeping if loses && side.depth(cell) >= 0 => 0,
            Moves::Keeping if loses => 1,
            Moves::Freely => 1,
            _ => (CELLS as i16 / 2 - side.depth(cell)) / BLOCK,
        };
        let blocks = blocks.clamp(0, i8::MAX.into()) as i8;
        if side.is_low { -blocks } else { blocks }
    }

    /// Moves on with a robot there; whether it did.
    fn follow(&mut self, pose: &Pose, moves: Moves) -> bool {
        let cell = self.picture.cell_at(pose.x_m, pose.y_m);
        let mut is_moved = false;
        for axis in [0, 1] {
            let due = match self.border.due.get(axis).copied().unwrap_or(0) {
                0 => self.due(axis, cell, moves),
                // As far as nothing falls off.
                due if moves == Moves::Keeping && self.loses(Side { axis, is_low: due < 0 }) => 0,
                due => due,
            };
            if due != 0 {
                self.move_on(Side { axis, is_low: due < 0 });
                is_moved = true;
            }
            if let Some(left) = self.border.due.get_mut(axis) {
                *left = due - due.signum();
            }
        }
        if is_moved && self.border.due == [0; 2] {
            (self.border.leaves, self.border.is_spent) = (false, false);
        }
        is_moved
    }

    /// Whether the picture would lose what it knows for a robot in this cell.
    pub(super) fn is_brink(&self, cell: Cell) -> bool {
        SIDES.into_iter().any(|side| self.is_brink_at(side, cell))
    }

    fn is_brink_at(&self, side: Side, cell: Cell) -> bool {
        self.border.loses & side.bit() != 0 && side.depth(cell) < BRINK
    }

    /// First and last quarter along an axis up to which a robot does not make it lose what it knows.
    fn kept(&self, axis: usize) -> [i16; 2] {
        let off = |is_low| {
            let side = Side { axis, is_low };
            if self.border.loses & side.bit() == 0 { 0 } else { 2 * BRINK }
        };
        [off(true), 2 * CELLS as i16 - 1 - off(false)]
    }

    /// Whether a robot goes on out of the picture there.
    fn leads_off(&self, pose: &Pose) -> bool {
        let (s, c) = slam_core::angle::sin_cos(pose.theta_rad);
        let cell = self.picture.cell_at(pose.x_m, pose.y_m);
        SIDES.into_iter().any(|side| {
            let outward = if side.axis == 0 { c } else { s } * if side.is_low { -1.0 } else { 1.0 };
            outward > OUTWARD && self.is_brink_at(side, cell)
        })
    }

    /// The block of the picture that is next on the way to this one beyond it, or to one with floor left.
    fn exit(&self, goal: Option<Block>) -> Option<Block> {
        let has_room = |block| cells(self.first_cell(block)).any(|cell| is_passable(&self.picture, cell));
        self.overview.exit(self.block_of(Cell::default()), goal, has_room)
    }
}

impl<const S: usize> FloorJob<S> {
    /// Moves the picture on with the robot; whether it did.
    pub(super) fn take_picture_along(&mut self, pose: &Pose) -> bool {
        let moves = match self.errand.is_to_sweep() {
            true if self.sheet.border.leaves => Moves::Leaving,
            true if !self.areas.dares => Moves::Keeping,
            _ => Moves::Freely,
        };
        self.sheet.follow(pose, moves)
    }

    /// The part of a stretch on a lane there that is swept before the picture moves on.
    pub(super) fn before_brink(&self, axis: Axis, across: i16, stretch: Stretch) -> Option<Stretch> {
        if self.sheet.border.leaves || !self.errand.is_to_sweep() {
            return Some(stretch);
        }
        let [[first, last], rows] = match axis {
            Axis::X => [0, 1],
            Axis::Y => [1, 0],
        }
        .map(|axis| self.sheet.kept(axis));
        let (from, to) = (stretch.from.max(first), stretch.to.min(last));
        let is_kept = from <= to && (rows[0]..=rows[1]).contains(&across);
        is_kept.then(|| Stretch { from, to, count: stretch.count.min(3 * (to - from + 1)) })
    }

    /// Whether what it goes along leads out of a picture that it has not swept yet.
    pub(super) fn is_at_brink(&self, pose: &Pose) -> bool {
        self.errand.is_to_sweep() && !self.sheet.border.leaves && self.sheet.leads_off(pose)
    }

    /// Whether floor that is left beyond the picture is worth looking for.
    pub(super) fn may_leave(&self) -> bool {
        self.sheet.border.trips < MAX_TRIPS && self.is_path_left()
    }

    /// On to floor that is left beyond the picture, while there is none in it, or home; a step of its own.
    pub(super) fn find_exit(&mut self, now_us: u64) {
        let is_to_sweep = self.errand.is_to_sweep();
        self.sheet.border.trips += u8::from(is_to_sweep);
        let [x_m, y_m] = self.home_m();
        let home = self.sheet.picture.cell_at(x_m, y_m);
        let exit = self.sheet.exit((!is_to_sweep).then(|| self.sheet.block_of(home)));
        let is_there = exit.is_some_and(|exit| self.is_in(exit));
        match exit {
            Some(exit) if !is_there => self.plan(Aim::Exit(self.sheet.first_cell(exit)), now_us),
            _ if !is_to_sweep => self.plan(Aim::Place(home), now_us),
            Some(exit) if self.may_leave() => {
                // It is there, and sees nothing of it.
                self.sheet.overview.give_up_near(exit);
                self.plan(Aim::Away, now_us);
            }
            _ => self.find_nothing(Aim::Away, now_us),
        }
    }

    /// No way leads there.
    pub(super) fn give_up_exit(&mut self, exit: Cell) {
        let block = self.sheet.block_of(exit);
        self.sheet.overview.give_up_near(block);
    }

    fn is_in(&self, block: Block) -> bool {
        self.last.is_some_and(|pose| self.sheet.block_of(self.sheet.picture.cell_at(pose.x_m, pose.y_m)) == block)
    }
}
