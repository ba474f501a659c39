//! A second copy of the home in one map: walls that lie to one another as older ones do, and askew to them or shifted.
//!
//! Something turned the robot, and it drew what it came to again a second time. Where the walls drawn since some moment stand askew to the
//! grid by one angle, that may be so, or the home has a wing that is built askew: what the older walls are says which. Or something pushed
//! it along: then readings spoke against the older walls for a while, and the walls drawn since fit.

use core::f32::consts::FRAC_PI_2;

use heapless::Vec;
use slam_core::angle::sin_cos;
use slam_core::kept::{Kept, KeptFrame, KeptWall};
use slam_core::{Match, SecondCopy};

use crate::KEPT_SIDES;
use crate::side::{ALPHA, OFF_GRID_RAD, may_be_noise};

/// By so much the walls of a copy outweigh those on the grid at least, metres: by less things do that stand askew.
const LEAST_M: f32 = 2.0;

/// Walls that were met on so much path, metres, are those that the robot is beside.
const BESIDE_M: f32 = 1.0;

/// A wall as far as it says something of a second copy.
#[derive(Clone, Copy)]
struct Line {
    id: u16,
    /// Its direction against the grid's nearest, radians.
    askew_rad: f32,
    length_m: f32,
    /// The robot is beside it.
    is_beside: bool,
}

impl Line {
    /// The wall at a place of a map; none where it may be noise.
    fn of(map: &dyn Kept, index: usize) -> Option<Self> {
        let wall = map.wall(index).filter(|wall| !may_be_noise(wall))?;
        Some(Self {
            id: wall.id,
            askew_rad: within_quarter(map.line(&wall)[1] - map.mean(ALPHA)),
            length_m: wall.hi_m - wall.lo_m,
            is_beside: map.unseen_m(index).is_some_and(|path_m| path_m < BESIDE_M),
        })
    }

    fn is_askew(&self) -> bool {
        self.askew_rad.abs() > OFF_GRID_RAD
    }

    /// How far apart the directions of two are, radians, but for quarter turns.
    fn apart_rad(&self, other: &Self) -> f32 {
        within_quarter(self.askew_rad - other.askew_rad).abs()
    }

    fn is_along(&self, other: &Self) -> bool {
        self.apart_rad(other) < OFF_GRID_RAD
    }
}

/// An angle less the nearest multiple of a right angle, radians.
fn within_quarter(angle_rad: f32) -> f32 {
    angle_rad - libm::roundf(angle_rad / FRAC_PI_2) * FRAC_PI_2
}

/// The walls since one of which those that stand askew like it outweigh those on the grid by most, by their lengths. Where they hardly do,
/// those on the grid since the wall of this identifier, from which on readings spoke for the robot being elsewhere. None where the robot is
/// not beside more of them than of older ones: it found itself back.
pub(crate) fn find(map: &dyn Kept, doubted: Option<u16>) -> Option<SecondCopy> {
    let frame = map.frame();
    if !frame.has_grid {
        return None;
    }
    let mut lines: Vec<Line, KEPT_SIDES> = Vec::new();
    for line in (0..usize::from(frame.walls)).filter_map(|i| Line::of(map, i)) {
        // What there is no room for no search would match.
        let _ = lines.push(line);
    }
    let mut best: Option<(f32, Line)> = None;
    for first in lines.iter().filter(|line| line.is_askew()) {
        let copy = SecondCopy { since: first.id, grid: Some(first.id) };
        let says = |line: &Line| {
            if line.is_along(first) {
                line.length_m
            } else if line.is_askew() {
                0.0
            } else {
                -line.length_m
            }
        };
        let sum_m = lines.iter().filter(|line| copy.has(line.id)).map(says).sum();
        if sum_m > best.map_or(LEAST_M, |(most_m, _)| most_m) {
            best = Some((sum_m, *first));
        }
    }
    let Some((_, first)) = best else {
        return shifted(&lines, doubted?);
    };
    let since = SecondCopy { since: first.id, grid: Some(first.id) };
    let copied = || lines.iter().filter(|line| since.has(line.id) && line.is_along(&first));
    if !is_beside(&lines, copied(), &since) {
        return None;
    }
    // The direction that the others are nearest to.
    let apart = |line: &Line| copied().map(|other| other.length_m * line.apart_rad(other)).sum::<f32>();
    let grid = copied().map(|line| (apart(line), line.id)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(SecondCopy { grid: Some(grid.1), ..since })
}

/// The walls on the grid since that of this identifier: what pushes a robot along need not turn it.
fn shifted(lines: &[Line], doubted: u16) -> Option<SecondCopy> {
    let since = SecondCopy { since: doubted, grid: None };
    let copied = lines.iter().filter(|line| since.has(line.id) && !line.is_askew());
    is_beside(lines, copied, &since).then_some(since)
}

/// Whether the robot is beside more of these walls than of those before the copy.
fn is_beside<'l>(lines: &[Line], copied: impl Iterator<Item = &'l Line>, since: &SecondCopy) -> bool {
    let older = lines.iter().filter(|line| !since.has(line.id) && line.is_beside);
    copied.filter(|line| line.is_beside).count() > older.count()
}

/// The walls of a second copy, or the older ones, as a map of their own.
pub(crate) struct Part<'m> {
    map: &'m dyn Kept,
    copy: SecondCopy,
    is_copy: bool,
    /// The state that is its grid's direction.
    grid: usize,
}

/// A map as its second copy and as what was there before, the one with fewer walls first: those of the other one are most of them where
/// that one does not reach. None where the wall that the copy's grid is of is gone.
pub(crate) fn parts<'m>(map: &'m dyn Kept, copy: &SecondCopy) -> Option<[Part<'m>; 2]> {
    let walls = || (0..usize::from(map.frame().walls)).filter_map(|i| map.wall(i));
    let grid = copy.grid_state(walls().map(|wall| (wall.id, wall.direction)))?;
    let part = |is_copy, grid| Part { map, copy: *copy, is_copy, grid };
    let (copied, older) = (part(true, grid), part(false, ALPHA));
    let is_larger = 2 * walls().filter(|wall| copy.has(wall.id)).count() > walls().count();
    Some(if is_larger { [older, copied] } else { [copied, older] })
}

impl Part<'_> {
    fn state(&self, i: usize) -> usize {
        if i == ALPHA { self.grid } else { i }
    }
}

impl Kept for Part<'_> {
    fn frame(&self) -> KeptFrame {
        self.map.frame()
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        self.map.wall(index).filter(|wall| self.copy.has(wall.id) == self.is_copy)
    }

    fn mean(&self, i: usize) -> f32 {
        self.map.mean(self.state(i))
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        self.map.covariance(self.state(i), self.state(j))
    }

    fn line(&self, wall: &KeptWall) -> [f32; 2] {
        self.map.line(wall)
    }
}

/// How the copy lies in the older walls, by how the first part lies in the second.
pub(crate) fn in_older(parts: &[Part<'_>; 2], found: Match) -> Match {
    let back = Match { quarters: (4 - found.quarters) & 3, pairs: found.pairs.map(|(a, b)| (b, a)) };
    if parts[0].is_copy { found } else { back }
}

/// About where the robot was displaced: at the middle of the wall that it drew first since.
pub(crate) fn begins_m(map: &dyn Kept, copy: &SecondCopy) -> [f32; 2] {
    let mut walls = (0..usize::from(map.frame().walls)).filter_map(|i| map.wall(i));
    walls.find(|wall| wall.id == copy.since).map_or([0.0; 2], |wall| {
        let [rho_m, beta_rad] = map.line(&wall);
        let ((s, c), along_m) = (sin_cos(beta_rad), 0.5 * (wall.lo_m + wall.hi_m));
        [c * rho_m - s * along_m, s * rho_m + c * along_m]
    })
}

/// A shifted copy with the walls before it that were drawn after those which tell where it lies in the older ones: the robot was pushed
/// before it drew the copy's first wall, and after it drew these.
pub(crate) fn with_those_between(copy: &SecondCopy, found: &Match) -> SecondCopy {
    if copy.grid.is_some() {
        return *copy;
    }
    let [one, other] = found.pairs.map(|(_, older)| copy.since.wrapping_sub(older));
    SecondCopy { since: copy.since.wrapping_sub(one.min(other)).wrapping_add(1), ..*copy }
}
