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

/// A match that settles the shift along an axis, and the most that the walls across that axis can say for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift {
    pub pair: Pair,
    pub bound: f32,
}

/// Every shift along an axis that lays a fresh wall on a kept one that faces the same way; the best supported ones where there
/// is no room for all, best first.
pub(crate) fn shifts(fresh: &Fresh, kept: &[Side], map: &impl Kept, axis: usize, found: &mut Vec<Shift, SHIFTS>) {
    found.clear();
    for (i, a) in fresh.sides.iter().enumerate().filter(|(_, side)| side.axis() == axis) {
        for (j, b) in kept.iter().enumerate().filter(|(_, side)| side.facing == a.facing) {
            let by_m = b.at_m - a.at_m;
            if found.iter().any(|shift| (shift.pair.apart_m(fresh, kept) - by_m).abs() < MERGE_M) {
                continue;
            }
            let pair = Pair { fresh: i as u8, kept: j as u8 };
            let shift = Shift { pair, bound: bound(fresh, kept, map, axis, pair) };
            if let Err(shift) = found.push(shift)
                && let Some(worst) = found.iter_mut().min_by(|a, b| a.bound.total_cmp(&b.bound))
                && worst.bound < shift.bound
            {
                *worst = shift;
            }
        }
    }
    descending(found, |shift| shift.bound);
}

/// The most that the walls across an axis can say for a shift.
fn bound(fresh: &Fresh, kept: &[Side], map: &impl Kept, axis: usize, seed: Pair) -> f32 {
    Joint::new(fresh, kept, map, [0, 1].map(|i| (i == axis).then_some(seed))).match_all()
}
