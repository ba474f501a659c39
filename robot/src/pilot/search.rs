//! Where to go next: a wave through the free cells finds the nearest place worth a visit. It goes on from step to step, some cells
//! in each.

use core::ops::ControlFlow;

use heapless::Deque;

use super::memory::{Cell, Memory};

/// The eight neighbours of a cell, counter-clockwise from the frame's x axis.
const NEIGHBOURS: [(i16, i16); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// Neighbours in order of their turn from the heading, so that of equally near places the one ahead wins.
const AHEAD_FIRST: [usize; 8] = [0, 1, 7, 2, 6, 3, 5, 4];

/// Cells of the wave's front. When it is full the wave leaves out cells: far places are found later.
const FRONT: usize = 320;

/// How much farther a stretch of wall may be than unseen space to be preferred, in cells.
const WALL_PREFERENCE: u16 = 16;

/// How near to obstacles the wave may pass while it is still near the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Squeeze {
    /// Only to leave a place that is itself too near an obstacle: two cells.
    Leave,
    /// For five cells: when there is no other way.
    Through,
}

/// Length of the path's first part that is handed out, in cells.
pub(crate) const LOOK_AHEAD: usize = 4;

/// A place worth a visit and the way there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Route {
    pub target: Cell,
    /// Steps to the target.
    pub steps: u16,
    /// The first cells of the path after the robot's own, and how many there are.
    pub first: [Cell; LOOK_AHEAD],
    pub count: usize,
    /// Whether the target is beside a wall; otherwise it borders on the unknown.
    pub wall: bool,
}

impl Route {
    /// Of a pilot that is yet to be prepared.
    pub(crate) const ZEROS: Self = Self {
        target: Cell { col: 0, row: 0 },
        steps: 0,
        first: [Cell { col: 0, row: 0 }; LOOK_AHEAD],
        count: 0,
        wall: false,
    };
}

/// Whether the robot's body fits at this cell.
pub(crate) fn is_passable<const N: usize>(memory: &Memory<N>, cell: Cell) -> bool {
    memory.is_free(cell) && !memory.obstacle_within(cell, 1)
}

/// A wall is at the distance at which one follows it: two or three cells off.
fn is_beside_wall<const N: usize>(memory: &Memory<N>, cell: Cell) -> bool {
    memory.obstacle_within(cell, 3)
}

/// Whether nothing is known of a cell beside this one.
pub(crate) fn borders_on_unknown<const N: usize>(memory: &Memory<N>, cell: Cell) -> bool {
    let unknown = |&index: &usize| {
        let (cols, rows) = NEIGHBOURS[index];
        let neighbour = cell.offset(cols, rows);
        memory.is_inside(neighbour) && !memory.is_known(neighbour)
    };
    [0, 2, 4, 6].iter().any(unknown)
}

/// A wave under way, to the nearest place that is worth a visit: unvisited and beside a wall, or else at the edge of the unknown.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    start: Cell,
    /// The robot's heading in eighths of a turn.
    octant: u8,
    /// How far from the start the wave may pass beside obstacles, in cells.
    escape: i16,
    /// Columns and rows of cells where the wave arrived and from which it did not go on, those that are as many steps from the start
    /// one after the other.
    front: Deque<[u8; 2], FRONT>,
    /// Steps from the start, and how many cells of the front are so many.
    steps: u16,
    left: u16,
    /// The nearest cell at the edge of the unknown, and its steps.
    edge: Option<(Cell, u16)>,
}

impl Search {
    /// Nothing to go on with.
    pub(crate) const ENDED: Self = Self {
        start: Cell { col: 0, row: 0 },
        octant: 0,
        escape: 0,
        front: Deque::new(),
        steps: 0,
        left: 0,
        edge: None,
    };

    /// Begins at a cell, the robot's heading as given in eighths of a turn.
    pub(crate) fn begin<const N: usize>(&mut self, memory: &mut Memory<N>, start: Cell, octant: u8, squeeze: Squeeze) {
        let escape = match squeeze {
            Squeeze::Through => 5,
            Squeeze::Leave if is_passable(memory, start) => 0,
            Squeeze::Leave => 2,
        };
        (self.start, self.octant, self.escape) = (start, octant, escape);
        (self.steps, self.left, self.edge) = (0, 1, None);
        self.front.clear();
        memory.clear_steps();
        if memory.is_inside(start) {
            memory.set_step_label(start, 0);
            let _ = self.front.push_back(start.packed());
        }
    }

    /// Goes on by at most so many cells: once it has ended, the route if there is one.
    pub(crate) fn go_on<const N: usize>(&mut self, memory: &mut Memory<N>, cells: u16) -> ControlFlow<Option<Route>> {
        for _ in 0..cells {
            let Some(cell) = self.front.pop_front().map(Cell::unpacked) else {
                return ControlFlow::Break(self.edge.map(|(target, steps)| trace(memory, target, steps, false)));
            };
            if self.left == 0 {
                (self.steps, self.left) = (self.steps + 1, self.front.len() as u16 + 1);
            }
            self.left -= 1;
            if let Some((target, edge_steps)) = self.edge
                && self.steps > edge_steps + WALL_PREFERENCE
            {
                return ControlFlow::Break(Some(trace(memory, target, edge_steps, false)));
            }
            if !memory.is_visited(cell) && is_passable(memory, cell) {
                if is_beside_wall(memory, cell) {
                    return ControlFlow::Break(Some(trace(memory, cell, self.steps, true)));
                }
                if self.edge.is_none() && borders_on_unknown(memory, cell) {
                    self.edge = Some((cell, self.steps));
                }
            }
            self.spread(memory, cell);
        }
        ControlFlow::Continue(())
    }

    /// The wave goes on from a cell to its neighbours.
    fn spread<const N: usize>(&mut self, memory: &mut Memory<N>, cell: Cell) {
        for turn in AHEAD_FIRST {
            let (cols, rows) = NEIGHBOURS[(usize::from(self.octant) + turn) % 8];
            let next = cell.offset(cols, rows);
            let near = next.moves_to(self.start) <= self.escape && memory.is_free(next);
            if memory.step_label(next).is_none() && (near || is_passable(memory, next)) {
                memory.set_step_label(next, ((self.steps + 1) % 3) as u8);
                let _ = self.front.push_back(next.packed());
            }
        }
    }
}

/// Follows the labels back from the target and keeps the part next to the robot.
fn trace<const N: usize>(memory: &Memory<N>, target: Cell, steps: u16, wall: bool) -> Route {
    let mut route =
        Route { target, steps, first: [target; LOOK_AHEAD], count: LOOK_AHEAD.min(usize::from(steps)), wall };
    let mut cell = target;
    for step in (1..=steps).rev() {
        if let Some(kept) = route.first.get_mut(usize::from(step - 1)) {
            *kept = cell;
        }
        let label = ((step - 1) % 3) as u8;
        let before = NEIGHBOURS.iter().map(|&(cols, rows)| cell.offset(cols, rows));
        match before.into_iter().find(|&c| memory.step_label(c) == Some(label)) {
            Some(before) => cell = before,
            None => break,
        }
    }
    route
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of free cells with walls, drawn as text; the robot is at `R`, visited cells are `v`.
    fn drawn(rows: &[&str]) -> (Memory<24>, Cell) {
        let mut memory = Memory::<24>::new(0.15);
        let mut start = Cell::default();
        for (row, line) in rows.iter().rev().enumerate() {
            for (col, mark) in line.bytes().enumerate() {
                let cell = Cell { col: col as i16 + 2, row: row as i16 + 2 };
                match mark {
                    b'#' => (0..2).for_each(|_| memory.see_hit(cell)),
                    b' ' => {}
                    _ => memory.see_free(cell),
                }
                if mark == b'v' || mark == b'R' {
                    memory.visit(cell, 0);
                }
                if mark == b'R' {
                    start = cell;
                }
            }
        }
        (memory, start)
    }

    /// What is found with so many cells in each step.
    fn find_by<const N: usize>(memory: &mut Memory<N>, start: Cell, octant: u8, cells: u16) -> Option<Route> {
        let mut search = Search::ENDED;
        search.begin(memory, start, octant, Squeeze::Leave);
        loop {
            if let ControlFlow::Break(route) = search.go_on(memory, cells) {
                return route;
            }
        }
    }

    fn find<const N: usize>(memory: &mut Memory<N>, start: Cell, octant: u8) -> Option<Route> {
        let route = find_by(memory, start, octant, u16::MAX);
        assert_eq!(find_by(memory, start, octant, 1), route);
        route
    }

    #[test]
    fn the_way_leads_through_the_door() {
        let (mut memory, start) = drawn(&[
            "####################",
            "#vvvvvvvv#.........#",
            "#vvvvvvvv#.........#",
            "#vvvvvvvv#.........#",
            "#vvvvvvvvv.........#",
            "#vvvvvvvvv.........#",
            "#vvvvvvvvv.........#",
            "#vvvvvvvvv.........#",
            "#vvvvvvvvv.........#",
            "#vRvvvvvv#.........#",
            "#vvvvvvvv#.........#",
            "####################",
        ]);
        let route = find(&mut memory, start, 0).unwrap();
        assert!(route.wall && route.target.col > 11, "{route:?}");
        assert_eq!(route.count, LOOK_AHEAD);
        assert_eq!(route.first[0].moves_to(start), 1);
        assert!(route.first.windows(2).all(|pair| pair[0].moves_to(pair[1]) == 1));
    }

    #[test]
    fn everything_visited_leaves_nothing_to_do() {
        let (mut memory, start) = drawn(&["######", "#vvvv#", "#vvRv#", "#vvvv#", "######"]);
        assert_eq!(find(&mut memory, start, 3), None);
    }

    #[test]
    fn the_edge_of_the_unknown_is_a_target_where_no_wall_is_in_sight() {
        let (mut memory, start) = drawn(&["vvvvvvv...", "vvvRvvv...", "vvvvvvv..."]);
        let route = find(&mut memory, start, 0).unwrap();
        assert!(!route.wall && route.target.col >= 9, "{route:?}");
    }
}
