//! Finding oneself again: where the map of a drive that just began lies in a map that was kept.
//!
//! Both maps have a grid. Turned onto each other's, they leave four rotations and a shift, along x by the walls that
//! face along x and along y by the others: two lists of candidates in place of an interpretation tree (Arras, Castellanos and
//! Siegwart 2002). Every pair of candidates is a hypothesis, whose matches are judged together (Neira and Tardos 2001), and *elsewhere* is one, too: a fresh map from another home has to
//! score worse than that.
//!
//! | part | what it makes |
//! |---|---|
//! | [`Side`] | a wall of either map, turned onto its grid |
//! | [`Search`] | every hypothesis scored, in slices of bounded work |
//! | [`Verdict`] | the best one, and its odds against all others together |
//! | [`Locator`] | the states of a robot in a kept map: searching, on probation, tracking, doubtful |
//!
//! One rule: work is asked for. No tasks, files or clocks, no heap, no panic.
//!
//! Frames: each map's own, turned by its grid's direction. Units are metres and radians; odds are natural logarithms.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;
#[cfg(test)]
mod tests;

mod agreement;
mod copy;
mod crossings;
mod dock;
mod extents;
mod fresh;
mod joint;
mod locator;
mod odds;
mod order;
mod search;
mod shift;
mod side;

pub use locator::{CLAIM, Event, Locator, State, Step};
pub use odds::Verdict;
pub use search::{Hypothesis, Progress, Search};
pub use side::{Side, path_on_grid, sides};

/// Comparisons of two matches that a robot may make in a step of its estimator.
pub const COMPARISONS: u32 = 3_300;
/// Most walls of a kept map that are matched.
pub const KEPT_SIDES: usize = 64;
/// Most walls of a fresh map that are matched: the longest of those met of late.
pub const FRESH_SIDES: usize = 16;
/// Length of the last path whose walls are held against the kept map, metres: both maps are bent, the more the farther apart two walls are.
pub(crate) const LATELY_M: f32 = 15.0;
/// Distance between two points of the path that are held against kept walls, metres.
pub(crate) const POINTS_M: f32 = 0.25;
/// Most points of the driven path that are held against kept walls.
pub const PATH_POINTS: usize = (LATELY_M / POINTS_M) as usize;
