//! Where to go next: a wave through the picture, some cells a step, to the nearest floor that was not swept.

use heapless::{Deque, Vec};

use super::overview::BLOCK;
use super::sheet::Sheet;
use super::swept::CELLS;
use crate::pilot::memory::Cell;

/// The eight neighbours of a cell, those straight ahead first.
const NEIGHBOURS: [(i16, i16); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Cells of the wave's front. When it is full the wave leaves out cells: far places are found later.
const FRONT: usize = 240;
const _: () = assert!(FRONT <= u8::MAX as usize);

/// How much farther an edge may be than open floor to be preferred, in cells: what is beside walls is swept first, for lanes
/// overlap it on their way.
const EDGE_PREFERENCE: u8 = 8;

/// Rows of the picture that are made ready in one step, and cells that are gone through.
const ROWS: usize = 16;
const SLICE: usize = 25;
const _: () = assert!(CELLS.is_multiple_of(ROWS));

/// Cells of a route. Of a longer one the first ones are kept, and the rest is looked for when they are done.
pub(super) const ROUTE: usize = 96;

/// No way is longer, in cells.
const LONGEST: usize = 512;

/// What the wave is to find.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aim {
    /// Floor that was not swept.
    Floor,
    /// Such floor that borders on what was not seen: nobody knows how much there is.
    Beyond,
    /// A place, in cells.
    Place(Cell),
    /// Beyond the picture: to floor that is left there, or home. The block to go to next is yet to be found.
    Away,
    /// The block with this first cell, on the way there.
    Exit(Cell),
}

/// What the wave found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Open floor.
    Open(Cell),
    /// Floor beside something, and the cell beside it where the robot has room.
    Edge { at: Cell, from: Cell },
    /// The place that was aimed at.
    Place(Cell),
    /// In the block that was.
    Exit(Cell),
}

impl Target {
    /// The cell to drive to.
    pub(super) fn stand(self) -> Cell {
        match self {
            Self::Open(cell) | Self::Place(cell) | Self::Exit(cell) | Self::Edge { from: cell, .. } => cell,
        }
    }

    /// Floor to sweep in four bytes: the cell, and that to drive to.
    fn packed(self) -> [[u8; 2]; 2] {
        let stand = self.stand();
        let at = if let Self::Edge { at, .. } = self { at } else { stand };
        [at, stand].map(Cell::packed)
    }

    fn unpacked(packed: [[u8; 2]; 2]) -> Self {
        let [at, from] = packed.map(Cell::unpacked);
        if at == from { Self::Open(at) } else { Self::Edge { at, from } }
    }
}

/// How a slice of the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slice {
    /// There is more to search.
    More,
    /// This is the nearest.
    Found(Target),
    /// There is none.
    Nothing,
}

/// The way to a target, cell by cell, the next one last.
pub(super) type Route = Vec<[u8; 2], ROUTE, u8>;

/// A search under way.
#[derive(Clone, Debug)]
pub(super) struct Wave {
    /// Cells of the front, in the order of their steps from the start.
    front: Deque<[u8; 2], FRONT>,
    /// Steps of the next one, and how many of the front are as far.
    steps: u8,
    as_far: u8,
    start: Cell,
    /// The nearest open floor, and its steps from the start.
    open: Option<([u8; 2], u8)>,
    /// The nearest for which the picture would lose what it knows: the cell, and that to go to.
    far: Option<[[u8; 2]; 2]>,
    /// Cells from the start within which the way may be narrow.
    escape: i16,
    /// What was not seen is taken for floor.
    dares: bool,
    /// The row of the picture that is made ready next.
    row: i16,
    /// Cells that the search went through.
    pub reached: u16,
}

impl Wave {
    pub(super) const fn new() -> Self {
        Self {
            front: Deque::new(),
            steps: 0,
            as_far: 0,
            start: Cell { col: 0, row: 0 },
            open: None,
            far: None,
            escape: 0,
            dares: false,
            row: 0,
            reached: 0,
        }
    }

    /// Begins a search where the robot is; `escape` cells from there the way may be narrow. One that dares takes what was not seen
    /// for floor.
    pub(super) fn begin(&mut self, start: Cell, escape: i16, dares: bool) {
        self.front.clear();
        (self.open, self.far) = (None, None);
        (self.steps, self.as_far) = (0, 1);
        self.reached = 0;
        self.row = 0;
        self.start = start;
        (self.escape, self.dares) = (escape, dares);
    }

    /// Makes some rows of the picture ready; whether all are.
    fn prepare(&mut self, sheet: &mut Sheet) -> bool {
        if self.row == CELLS as i16 {
            return true;
        }
        for _ in 0..ROWS {
            sheet.picture.begin_row(self.row, self.dares);
            self.row += 1;
        }
        if self.row == CELLS as i16 && sheet.picture.is_inside(self.start) {
            sheet.picture.set_step_label(self.start, 0);
            let _ = self.front.push_back(self.start.packed());
        }
        false
    }

    /// The next cell of the front.
    fn next(&mut self) -> Option<Cell> {
        if self.as_far == 0 {
            // What is in the front by now is one step farther.
            self.steps = self.steps.saturating_add(1);
            self.as_far = self.front.len() as u8;
        }
        self.as_far = self.as_far.saturating_sub(1);
        self.front.pop_front().map(Cell::unpacked)
    }

    /// Searches on, as much as a step allows.
    pub(super) fn search(&mut self, sheet: &mut Sheet, aim: Aim) -> Slice {
        if !self.prepare(sheet) {
            return Slice::More;
        }
        for _ in 0..SLICE {
            let Some(cell) = self.next() else {
                return self.rest(sheet);
            };
            self.reached = self.reached.saturating_add(1);
            if let Some((open, near)) = self.open
                && self.steps > near.saturating_add(EDGE_PREFERENCE)
            {
                return Slice::Found(Target::Open(Cell::unpacked(open)));
            }
            match target_at(sheet, cell, aim) {
                Some(Target::Open(_)) if self.open.is_some() => {}
                Some(target) if is_far(sheet, target) => self.far = self.far.or(Some(target.packed())),
                Some(Target::Open(open)) => self.open = Some((open.packed(), self.steps)),
                Some(target) => return Slice::Found(target),
                None => {}
            }
            let label = sheet.picture.step_label(cell).unwrap_or(0);
            for (cols, rows) in NEIGHBOURS {
                let next = cell.offset(cols, rows);
                if sheet.picture.is_inside(next) && sheet.picture.step_label(next).is_none() && self.is_way(sheet, next)
                {
                    sheet.picture.set_step_label(next, (label + 1) % 3);
                    let _ = self.front.push_back(next.packed());
                }
            }
        }
        Slice::More
    }

    /// What there is after all cells were gone through.
    fn rest(&self, sheet: &mut Sheet) -> Slice {
        match (self.open, self.far) {
            (Some((open, _)), _) => Slice::Found(Target::Open(Cell::unpacked(open))),
            (None, Some(far)) => {
                sheet.border.leaves = true;
                Slice::Found(Target::unpacked(far))
            }
            (None, None) => Slice::Nothing,
        }
    }

    fn is_way(&self, sheet: &Sheet, cell: Cell) -> bool {
        let is_near = cell.moves_to(self.start) <= self.escape && sheet.picture.is_free(cell);
        is_near || sheet.picture.has_room(cell)
    }

    /// The way to a target that was just found, without the cell where the robot is.
    pub(super) fn route(&self, sheet: &Sheet, target: Target) -> Route {
        let mut route = Route::new();
        let mut cell = target.stand();
        for _ in 0..LONGEST {
            if cell == self.start {
                return route;
            }
            if route.is_full() {
                route.remove(0);
            }
            let _ = route.push(cell.packed());
            let Some(label) = sheet.picture.step_label(cell) else { break };
            let before = (label + 2) % 3;
            let mut neighbours = NEIGHBOURS.iter().map(|&(cols, rows)| cell.offset(cols, rows));
            let Some(next) = neighbours.find(|&next| sheet.picture.step_label(next) == Some(before)) else { break };
            cell = next;
        }
        // Where the front was full, steps that are known by threes may lead in a circle: that is no way.
        Route::new()
    }
}

/// Whether the floor in the picture is to be swept before it moves on to there.
fn is_far(sheet: &Sheet, target: Target) -> bool {
    matches!(target, Target::Open(_) | Target::Edge { .. }) && sheet.is_brink(target.stand())
}

fn target_at(sheet: &Sheet, cell: Cell, aim: Aim) -> Option<Target> {
    match aim {
        Aim::Beyond => sheet.leads_on(cell).then_some(Target::Open(cell)),
        Aim::Place(place) => (cell.moves_to(place) <= 1).then_some(Target::Place(cell)),
        Aim::Away => None,
        Aim::Exit(first) => {
            let [cols, rows] = [cell.col - first.col, cell.row - first.row];
            ((0..BLOCK).contains(&cols) && (0..BLOCK).contains(&rows)).then_some(Target::Exit(cell))
        }
        Aim::Floor => {
            let edge =
                NEIGHBOURS.iter().map(|&(cols, rows)| cell.offset(cols, rows)).find(|&at| sheet.is_edge_left(at));
            match edge {
                Some(at) => Some(Target::Edge { at, from: cell }),
                None => sheet.is_open_left(cell).then_some(Target::Open(cell)),
            }
        }
    }
}
