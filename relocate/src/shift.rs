//! Candidates for the shift along one axis.

use heapless::Vec;
use slam_core::kept::Kept;

use crate::fresh::Fresh;
use crate::joint::{Joint, Pair};
use crate::order::descending;
use crate::side::Side;

/// Shifts that differ by less than this are one, metres.
const MERGE_M: f32 = 0.04;

/// Most shifts along one axis.
pub(crate) const SHIFTS: usize = 128;

/// Shifts held against another one take as long as a comparison of two matches.
const SHIFTS_A_COMPARISON: u32 = 8;

/// A match that settles the shift along an axis, and the most that the walls across that axis can say for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift {
    pub pair: Pair,
    pub bound: f32,
}

impl Shift {
    /// How far, metres: both walls are on the grid.
    fn by_m(&self, fresh: &Fresh, kept: &[Side]) -> f32 {
        let at_m = |sides: &[Side], i: u8| sides.get(usize::from(i)).map_or(0.0, |side| side.at_m);
        at_m(kept, self.pair.kept) - at_m(&fresh.sides, self.pair.fresh)
    }
}

/// The shifts along an axis that lay a fresh wall on a kept one that faces the same way; the best supported ones where there is no room
/// for all. They are found one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Shifts {
    pub found: Vec<Shift, SHIFTS>,
    /// The walls that are matched next: their places in the lists.
    next: (usize, usize),
}

impl Shifts {
    pub(crate) const NONE: Self = Self { found: Vec::new(), next: (0, 0) };

    pub(crate) fn begin(&mut self) {
        self.found.clear();
        self.next = (0, 0);
    }

    /// Goes on with the next two walls along this axis, and gives the comparisons that it took; none, and all in order, best first, after
    /// the last.
    pub(crate) fn go_on(&mut self, fresh: &Fresh, kept: &[Side], map: &dyn Kept, axis: usize) -> Option<u32> {
        let (i, j) = self.next;
        let Some(a) = fresh.sides.get(i) else {
            descending(&mut self.found, |shift| shift.bound);
            return None;
        };
        let Some(b) = kept.get(j).filter(|_| a.axis() == axis && a.is_on_grid()) else {
            self.next = (i + 1, 0);
            return Some(1);
        };
        self.next = (i, j + 1);
        if !b.is_like(a) {
            return Some(1);
        }
        let by_m = b.at_m - a.at_m;
        let is_same = |shift: &Shift| (shift.by_m(fresh, kept) - by_m).abs() < MERGE_M;
        let comparisons = 1 + self.found.len() as u32 / SHIFTS_A_COMPARISON;
        if self.found.iter().any(is_same) {
            return Some(comparisons);
        }
        let pair = Pair { fresh: i as u8, kept: j as u8 };
        let mut joint = Joint::new(fresh, kept, map, [0, 1].map(|other| (other == axis).then_some(pair)));
        // The most that the walls across the axis can say for it.
        let bound = joint.match_all();
        self.keep(Shift { pair, bound });
        Some(comparisons + joint.comparisons)
    }

    fn keep(&mut self, shift: Shift) {
        if let Err(shift) = self.found.push(shift)
            && let Some(worst) = self.found.iter_mut().min_by(|a, b| a.bound.total_cmp(&b.bound))
            && worst.bound < shift.bound
        {
            *worst = shift;
        }
    }
}
