//! The picture of the home together with what of its floor was swept.

use slam_core::Pose;

use super::larger::Border;
use super::overview::Overview;
use super::swept::{CELLS, Quarter, Swept};
use crate::pilot::memory::{Cell, Memory};
use crate::pilot::search::{borders_on_unknown, is_passable};

/// Edge of a quarter of a cell, metres: three of them, side by side, are a lane, which the brush overlaps by 8 mm on either side.
pub(super) const QUARTER_M: f32 = 0.078;

/// Quarters whose centre came this near to the robot's are swept, metres: where the path wavers by a centimetre, those beside it
/// still are.
const SWEPT_M: f32 = 0.12;

/// Quarters that a robot comes for: 0.03 m^2, less than the largest piece that may be missed.
const WORTHWHILE: u32 = 5;

/// The same beside something that stands there, where the brush does not reach all of what looks free.
const WORTHWHILE_BESIDE: u32 = 12;

/// A lane that goes on by so many quarters without sweeping any ends.
const GAP: i16 = 4;

/// Quarters that two have to sweep by which a lane goes on, of six under the brush: beyond a gap there has to be enough for the gap.
const PAYS: i16 = 3;

/// The border of what is left is looked for so many rows to each side.
const BORDER: i16 = 4;

/// Along which axis of the job's frame a lane runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Axis {
    /// x.
    #[default]
    X,
    /// y.
    Y,
}

impl Axis {
    /// The quarter at this place along and across a lane.
    fn quarter(self, along: i16, across: i16) -> Quarter {
        match self {
            Self::X => Quarter { col: along, row: across },
            Self::Y => Quarter { col: across, row: along },
        }
    }

    /// A point's coordinates along and across, metres.
    pub(super) fn split(self, [x, y]: [f32; 2]) -> [f32; 2] {
        match self {
            Self::X => [x, y],
            Self::Y => [y, x],
        }
    }
}

/// A stretch of floor that a lane would sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    /// First and last quarter along the lane that has something to sweep.
    pub from: i16,
    pub to: i16,
    /// Quarters to sweep.
    pub count: i16,
}

/// The picture of the home, and which of its floor was swept.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub picture: Memory<CELLS>,
    pub swept: Swept,
    pub overview: Overview,
    pub border: Border,
}

impl Sheet {
    pub(super) const fn new() -> Self {
        Self {
            picture: Memory::new(2.0 * QUARTER_M),
            swept: Swept::new(),
            overview: Overview::new(),
            border: Border::NEW,
        }
    }

    /// The same, where it lies.
    pub(super) fn clear(&mut self) {
        self.picture.clear(2.0 * QUARTER_M);
        self.swept.clear();
        (self.overview, self.border) = (Overview::new(), Border::NEW);
    }

    /// The quarter at a point, metres.
    pub(super) fn quarter_at(&self, [x_m, y_m]: [f32; 2]) -> Quarter {
        let cell = self.picture.cell_at(x_m, y_m);
        let [x, y] = self.picture.centre_m(cell);
        Quarter { col: 2 * cell.col + i16::from(x_m >= x), row: 2 * cell.row + i16::from(y_m >= y) }
    }

    /// Centre of a quarter, metres.
    pub(super) fn centre_m(&self, quarter: Quarter) -> [f32; 2] {
        let [x, y] = self.picture.centre_m(quarter.cell());
        let off = |index: i16| if index.rem_euclid(2) == 0 { -0.5 * QUARTER_M } else { 0.5 * QUARTER_M };
        [x + off(quarter.col), y + off(quarter.row)]
    }

    /// Sweeps what is under the brush; how many quarters were not before.
    pub(super) fn sweep(&mut self, pose: &Pose) -> u16 {
        let under = self.under_brush([pose.x_m, pose.y_m]);
        under.into_iter().map(|quarter| u16::from(self.swept.sweep(quarter))).sum()
    }

    /// What is under the brush here (metres) was not swept after all; how many quarters were.
    pub(super) fn unsweep(&mut self, at_m: [f32; 2]) -> u16 {
        let under = self.under_brush(at_m);
        under.into_iter().map(|quarter| u16::from(self.swept.unsweep(quarter))).sum()
    }

    /// A robot that was on a lane here (metres) was so far beside it after all: what it did not come near enough to was not swept; how
    /// many quarters that are.
    pub(super) fn miss(&mut self, axis: Axis, at_m: [f32; 2], aside_m: f32) -> u16 {
        let [_, across_m] = axis.split(at_m);
        let mut count = 0;
        for quarter in self.under_brush(at_m) {
            let [_, row_m] = axis.split(self.centre_m(quarter));
            if (row_m - across_m - aside_m).abs() > SWEPT_M {
                count += u16::from(self.swept.unsweep(quarter));
            }
        }
        count
    }

    /// The quarters under the brush of a robot here, metres.
    fn under_brush(&self, [x_m, y_m]: [f32; 2]) -> heapless::Vec<Quarter, 25> {
        let here = self.quarter_at([x_m, y_m]);
        let mut under = heapless::Vec::new();
        for row in here.row - 2..=here.row + 2 {
            for col in here.col - 2..=here.col + 2 {
                let [x, y] = self.centre_m(Quarter { col, row });
                let [dx, dy] = [x - x_m, y - y_m];
                if dx * dx + dy * dy <= SWEPT_M * SWEPT_M {
                    let _ = under.push(Quarter { col, row });
                }
            }
        }
        under
    }

    /// Whether there is floor here that was not swept.
    pub(super) fn is_left(&self, quarter: Quarter) -> bool {
        !self.swept.is_swept(quarter) && self.picture.is_free(quarter.cell())
    }

    /// During a search: whether all of a cell is floor beside something that stands there, and nothing of it was swept, with enough
    /// beside it to come for.
    pub(super) fn is_edge_left(&self, cell: Cell) -> bool {
        let is_whole = self.swept.left_in(cell) == 4 && self.picture.is_free(cell) && !self.picture.has_room(cell);
        is_whole && self.left_around(cell, |cell| self.picture.is_free(cell)) >= WORTHWHILE_BESIDE
    }

    /// During a search: whether there is floor to sweep in this cell, where the body has room, and with what is beside it enough to come for.
    pub(super) fn is_open_left(&self, cell: Cell) -> bool {
        self.is_worthwhile(cell, |cell| self.picture.has_room(cell))
    }

    /// The same at any time.
    pub(super) fn is_passable_left(&self, cell: Cell) -> bool {
        self.is_worthwhile(cell, |cell| is_passable(&self.picture, cell))
    }

    /// Whether there is floor to sweep in this cell, where the body has room, and with what is beside it enough to come for.
    fn is_worthwhile(&self, cell: Cell, has_room: impl Fn(Cell) -> bool) -> bool {
        self.swept.left_in(cell) > 0 && has_room(cell) && self.left_around(cell, has_room) >= WORTHWHILE
    }

    /// The same, during a search, of such floor that borders on what was not seen.
    pub(super) fn leads_on(&self, cell: Cell) -> bool {
        self.is_open_left(cell) && borders_on_unknown(&self.picture, cell)
    }

    /// Quarters not swept in this cell and those around it that are such floor.
    fn left_around(&self, cell: Cell, is_floor: impl Fn(Cell) -> bool) -> u32 {
        around(cell).filter(|cell| is_floor(*cell)).map(|cell| self.swept.left_in(cell)).sum()
    }

    fn left_in_band(&self, axis: Axis, along: i16, across: i16) -> i16 {
        (across - 1..=across + 1).map(|across| i16::from(self.is_left(axis.quarter(along, across)))).sum()
    }

    /// A place along a lane near this one that has floor left, and between which rows near it there is floor left without a
    /// gap there.
    pub(super) fn rows_left(&self, axis: Axis, along: i16, across: i16) -> Option<(i16, [i16; 2])> {
        // The robot is there: what is under its brush is swept.
        let offs = [0, -1, 1, -2, 2, -3, 3];
        let mut quarters = offs.iter().flat_map(|row| offs.iter().map(move |off| (along + off, across + row)));
        let (along, row) = quarters.find(|&(along, row)| self.is_left(axis.quarter(along, row)))?;
        let end = |step: i16| {
            let mut row = row;
            while (row - across).abs() < BORDER && self.is_left(axis.quarter(along, row + step)) {
                row += step;
            }
            row
        };
        Some((along, [end(-1), end(1)]))
    }

    fn is_way(&self, axis: Axis, along: i16, across: i16) -> bool {
        self.picture.is_free(axis.quarter(along, across).cell())
    }

    /// What a lane on the quarters `across` would sweep nearest to `near`, at most `reach` quarters from there.
    pub(super) fn stretch(&self, axis: Axis, across: i16, near: i16, reach: i16) -> Option<Stretch> {
        let is_start = |along: &i16| self.is_way(axis, *along, across) && self.left_in_band(axis, *along, across) > 0;
        let first = (0..=reach).flat_map(|off| [near + off, near - off]).find(is_start)?;
        let mut stretch = Stretch { from: first, to: first, count: self.left_in_band(axis, first, across) };
        for direction in [-1, 1] {
            let (mut along, mut gap, mut worth, mut count) = (first + direction, 0, 0, 0);
            while gap < GAP && self.is_way(axis, along, across) {
                let left = self.left_in_band(axis, along, across);
                (gap, worth, count) = (gap + 1, worth + 2 * left - PAYS, count + left);
                if left > 0 && worth >= 0 {
                    stretch.count += count;
                    stretch.from = stretch.from.min(along);
                    stretch.to = stretch.to.max(along);
                    (gap, worth, count) = (0, 0, 0);
                }
                along += direction;
            }
        }
        Some(stretch)
    }

    /// Whether a lane that has come to this quarter has enough to sweep just ahead.
    pub(super) fn is_more_ahead(&self, axis: Axis, along: i16, across: i16, sign: i16) -> bool {
        let mut worth = 0;
        (0..=GAP + 1).take_while(|step| self.is_way(axis, along + sign * step, across)).any(|step| {
            let left = self.left_in_band(axis, along + sign * step, across);
            // The first two are under the brush as it is.
            worth += 2 * left - if step > 1 { PAYS } else { 0 };
            left > 0 && worth >= 0
        })
    }

    /// Along and across a lane: the quarter at a point (metres).
    pub(super) fn place(&self, axis: Axis, point_m: [f32; 2]) -> [i16; 2] {
        let Quarter { col, row } = self.quarter_at(point_m);
        match axis {
            Axis::X => [col, row],
            Axis::Y => [row, col],
        }
    }

    /// Where a lane on a stretch begins that runs in this direction, metres: half a quarter within it, from where the brush covers the
    /// corners of its first quarters with two centimetres to spare.
    pub(super) fn begin_m(&self, axis: Axis, across: i16, stretch: &Stretch, sign: i16) -> [f32; 2] {
        let first = if sign > 0 { stretch.from } else { stretch.to };
        let second = if stretch.to - stretch.from > 1 { first + sign } else { first };
        let [first_m, second_m] = [first, second].map(|along| self.point_m(axis, along, across));
        [0, 1].map(|axis| 0.5 * (first_m[axis] + second_m[axis]))
    }

    /// Centre of the quarter at this place along and across a lane, metres.
    pub(super) fn point_m(&self, axis: Axis, along: i16, across: i16) -> [f32; 2] {
        self.centre_m(axis.quarter(along, across))
    }

    /// Whether nothing known stands on the straight line from here to there (metres), as wide as a cell.
    pub(super) fn is_open(&self, from_m: [f32; 2], to_m: [f32; 2]) -> bool {
        (1..=8).all(|step| {
            let share = step as f32 / 8.0;
            let [x_m, y_m] = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
            self.picture.is_free(self.picture.cell_at(x_m, y_m))
        })
    }

    /// The same with room for the body beside it.
    pub(super) fn is_passable(&self, from_m: [f32; 2], to_m: [f32; 2]) -> bool {
        (1..=8).all(|step| {
            let share = step as f32 / 8.0;
            let [x_m, y_m] = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
            is_passable(&self.picture, self.picture.cell_at(x_m, y_m))
        })
    }
}

/// A cell and those beside it.
fn around(cell: Cell) -> impl Iterator<Item = Cell> {
    (0..9).map(move |index| cell.offset(index % 3 - 1, index / 3 - 1))
}
