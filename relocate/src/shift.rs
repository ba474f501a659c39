//! Candidates for the shift along one axis.

use heapless::Vec;

use crate::odds;
use crate::side::Side;
use crate::{FRESH_SIDES, KEPT_SIDES};

/// Shifts that differ by less than this are one, metres.
const MERGE_M: f32 = 0.04;

/// Most shifts along one axis.
pub(crate) const SHIFTS: usize = 128;

/// A shift along one axis, and the most that the walls across that axis can say for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift {
    pub by_m: f32,
    pub bound: f32,
}

/// Every shift along an axis that lays a fresh wall on a kept one that faces the same way; the best supported ones where there
/// is no room for all, best first.
pub(crate) fn shifts(
    fresh: &Vec<Side, FRESH_SIDES>,
    weights: &Vec<f32, FRESH_SIDES>,
    kept: &Vec<Side, KEPT_SIDES>,
    axis: usize,
    found: &mut Vec<Shift, SHIFTS>,
) {
    found.clear();
    for a in fresh.iter().filter(|side| side.axis() == axis) {
        for b in kept.iter().filter(|side| side.facing == a.facing) {
            let by_m = b.at_m - a.at_m;
            if found.iter().any(|shift| (shift.by_m - by_m).abs() < MERGE_M) {
                continue;
            }
            let shift = Shift { by_m, bound: bound(fresh, weights, kept, axis, by_m) };
            if let Err(shift) = found.push(shift)
                && let Some(worst) = found.iter_mut().min_by(|a, b| a.bound.total_cmp(&b.bound))
                && worst.bound < shift.bound
            {
                *worst = shift;
            }
        }
    }
    found.sort_unstable_by(|a, b| b.bound.total_cmp(&a.bound));
}

/// The most that the walls across an axis can say for a shift: each at the nearest kept wall, wherever that reaches, within what
/// merging leaves.
fn bound(fresh: &[Side], weights: &[f32], kept: &[Side], axis: usize, by_m: f32) -> f32 {
    let of_side = |a: &Side| {
        kept.iter()
            .filter(|b| b.facing == a.facing)
            .map(|b| {
                let off_m = ((b.at_m - a.at_m - by_m).abs() - MERGE_M).max(0.0);
                odds::of_wall(off_m, a.variance_m2 + b.variance_m2, 1.0)
            })
            .fold(odds::of_nothing(), f32::max)
    };
    let across = fresh.iter().zip(weights).filter(|(side, _)| side.axis() == axis);
    across.map(|(side, weight)| weight * of_side(side)).sum()
}
