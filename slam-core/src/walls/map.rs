//! The list of walls: adding, removing, and what happens when it is full.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::{ALPHA, THETA};
use crate::geometry::line::Line;
use crate::geometry::pose::Pose;
use crate::motion::drive::DriveStates;
use crate::walls::anchor::Anchor;
use crate::walls::decision::relative_variance;
use crate::walls::exactness::Exactness;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::tolerance::Tolerance;
use crate::walls::wall::{Direction, Wall};
use core::ops::{Deref, DerefMut};
use heapless::{Vec, VecView};

/// Score of a new wall: the excess of beams that pass through it over beams that meet it at which it is removed.
const BIRTH_SCORE: i8 = 5;
/// Largest score of a wall, so that a short run of wrong associations does not remove one that was seen all day.
const MAX_SCORE: i8 = 100;

/// Largest overshoot of a wall's end that passing beams take back, metres: readings of what stands beside an end prolong
/// the wall, each by a little.
const OVERSHOOT_M: f32 = 0.3;

/// Share of an overshoot that one passing beam takes away.
const CUT_SHARE: f32 = 0.1;

/// Number of readings below which a wall that was not met for [`FORGET_AFTER_M`] counts as noise.
const FORGET_BELOW: u32 = 10;
/// Length of path after which a wall that few readings met is removed, metres.
const FORGET_AFTER_M: f32 = 3.0;

/// Number of readings of a known wall that one point of a newborn outweighs: the newborn's points were picked.
const WORTH: u32 = 4;

/// What holds the map frame once the robot has left its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MapFrame {
    /// The start pose. What is learned of the first turns moves the map.
    #[default]
    Start,
    /// The walls. What is learned of the first turns moves the start pose.
    Walls,
}

/// How a robot came to be elsewhere in its map than its wheels tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Displaced {
    /// Something moved it besides its wheels.
    Jolted,
    /// It was held while they turned, or no longer is.
    Held,
}

/// The map: [`Map`] with its storage, [`MapView`] without its size.
#[derive(Debug)]
pub struct MapInner<V: ?Sized> {
    next_id: u16,
    /// Changes with whatever makes poses and walls of the filter's frame others than they were.
    epoch: u32,
    /// Why this epoch began, where the map is that of the one before and the robot is elsewhere in it.
    displaced: Option<Displaced>,
    /// The grid was founded.
    pub has_grid: bool,
    /// The home has one: a map before this one had found it.
    pub is_grid_expected: bool,
    /// How far walls of that grid stand off it, where they are tied to it once readings tell that they stand there; none before.
    pub tolerance: Option<Tolerance>,
    /// How likely they do.
    pub exactness: Exactness,
    /// What holds the map frame.
    pub frame: MapFrame,
    /// Where the robot started, in the map frame.
    pub start: Pose,
    /// Whether that is its dock.
    pub has_dock: bool,
    /// Where the filter's frame is in that of the start pose; none where they are one.
    pub anchor: Option<Anchor>,
    /// Which one that is since the estimator was made.
    pub frames: u16,
    walls: V,
}

/// A map of at most `W` walls.
pub type Map<const W: usize> = MapInner<Vec<Wall, W>>;

/// A map of whatever capacity.
pub type MapView = MapInner<VecView<Wall>>;

impl<const W: usize> Map<W> {
    /// No walls.
    pub const EMPTY: Self = Self {
        next_id: 0,
        epoch: 0,
        displaced: None,
        has_grid: false,
        is_grid_expected: false,
        tolerance: None,
        exactness: Exactness::UNKNOWN,
        frame: MapFrame::Start,
        start: Pose::ORIGIN,
        has_dock: false,
        anchor: None,
        frames: 0,
        walls: Vec::new(),
    };
}

impl<const W: usize> Deref for Map<W> {
    type Target = MapView;
    fn deref(&self) -> &MapView {
        self
    }
}

impl<const W: usize> DerefMut for Map<W> {
    fn deref_mut(&mut self) -> &mut MapView {
        self
    }
}

impl MapView {
    /// Forgets every wall and the grid, and begins a new frame.
    pub fn clear(&mut self, frame: MapFrame) {
        self.next_id = 0;
        self.begin_epoch();
        (self.has_grid, self.is_grid_expected) = (false, false);
        (self.tolerance, self.exactness) = (None, Exactness::UNKNOWN);
        self.frame = frame;
        self.start = Pose::ORIGIN;
        self.anchor = None;
        self.walls.clear();
    }

    /// Forgets every wall and the grid, and their states, but neither frame nor names, nor how the home's walls stand.
    pub fn forget_walls(&mut self, ekf: &mut EkfView) {
        self.begin_epoch();
        self.forget_some(ekf, |_| true);
        self.is_grid_expected |= core::mem::take(&mut self.has_grid);
        self.exactness = Exactness::UNKNOWN;
        ekf.initialise(ALPHA, 0.0, &Jacobian::new(), 0.0);
    }

    /// Forgets some walls, and their states.
    pub fn forget_some(&mut self, ekf: &mut EkfView, is_some: impl Fn(&Wall) -> bool) {
        while let Some(last) = self.walls.iter().rposition(&is_some) {
            self.remove(ekf, last);
        }
    }

    /// Puts the filter's frame where the robot is, in the frame that it was in, with `noise` as variance of (x, y, theta) there.
    pub fn drop_anchor(&mut self, ekf: &mut EkfView, noise: [f32; 3], states: &DriveStates) {
        // Where the start holds the map, it would turn with what is learned of the way to its first wall, and the robot's path with it.
        let states = if self.frame == MapFrame::Walls { states } else { &DriveStates::NONE };
        self.anchor = Some(self.anchor.unwrap_or(Anchor::START).drop_at(ekf, noise, states));
        self.frames = self.frames.wrapping_add(1);
        self.begin_epoch();
    }

    /// Moves the start to where the calibration, as it is known now, tells that it is.
    #[inline(never)]
    pub fn follow_calibration(&mut self, ekf: &EkfView, states: &DriveStates) {
        let Some(anchor) = &mut self.anchor else { return };
        let before = anchor.pose;
        anchor.follow(ekf, states);
        if anchor.pose != before {
            self.start = self.start.compose(&before).compose(&anchor.pose.inverse());
        }
    }

    /// The robot was found elsewhere in the same map, which begins an epoch.
    pub fn begin_epoch_elsewhere(&mut self, displaced: Displaced) {
        self.begin_epoch();
        self.displaced = Some(displaced);
    }

    /// How the robot came to be elsewhere, where the map is that of the epoch before this one.
    pub fn displaced(&self) -> Option<Displaced> {
        self.displaced
    }

    /// Poses and walls are others than they were.
    pub fn begin_epoch(&mut self) {
        self.epoch = self.epoch.wrapping_add(1);
        self.displaced = None;
    }

    /// Which one it is since the estimator was made.
    pub fn epoch(&self) -> u32 {
        self.epoch
    }

    /// The grid's direction at the filter's present estimate, once it was founded.
    pub fn grid(&self, ekf: &EkfView) -> Option<ManhattanFrame> {
        self.has_grid.then(|| ManhattanFrame::of(ekf))
    }

    /// Variance of the heading against what the robot drives by: the grid, or the filter's frame before there is one, rad^2.
    pub fn heading_variance(&self, ekf: &EkfView) -> f32 {
        if self.has_grid { relative_variance(ekf, THETA, ALPHA) } else { ekf.covariance(THETA, THETA) }
    }

    /// The walls.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The first of the filter's states that is a wall's: theirs are the last ones.
    pub fn first_state(&self, ekf: &EkfView) -> usize {
        ekf.len().saturating_sub(self.walls.iter().map(Wall::states).sum())
    }

    /// Fixes where wall `index` is drawn in the map frame from now on.
    pub fn draw(&mut self, index: usize, line: Line) {
        if let Some(wall) = self.walls.get_mut(index) {
            wall.drawn = Some([line.rho_m, line.beta_rad]);
        }
    }

    /// True where no wall can be added.
    pub fn is_full(&self) -> bool {
        self.walls.is_full()
    }

    /// Adds a wall whose states exist.
    pub fn add(&mut self, born: Wall, updates: u32, path_m: f32) {
        let id = self.next_id;
        self.next_id = self.next_id.wrapping_add(1);
        let wall = Wall { id, updates, score: BIRTH_SCORE, seen_at_m: path_m, ..born };
        let _ = self.walls.push(wall);
    }

    /// The path is counted anew from what it is by now, metres.
    pub fn count_anew(&mut self, path_m: f32) {
        self.walls.iter_mut().for_each(|wall| wall.seen_at_m -= path_m);
    }

    /// The identifier of the next wall.
    pub fn next_id(&self) -> u16 {
        self.next_id
    }

    /// Takes walls that were kept, whose states exist, in place of its own.
    pub fn restore(&mut self, walls: impl Iterator<Item = Wall>, next_id: u16) {
        self.walls.clear();
        self.walls.extend(walls.take(self.walls.capacity()));
        self.next_id = next_id;
    }

    /// Records that a reading met wall `index` at `along_m`, metres along the wall.
    pub fn met(&mut self, index: usize, along_m: f32, path_m: f32) {
        if let Some(wall) = self.walls.get_mut(index) {
            wall.lo_m = wall.lo_m.min(along_m);
            wall.hi_m = wall.hi_m.max(along_m);
            wall.updates = wall.updates.saturating_add(1);
            wall.score = wall.score.saturating_add(1).min(MAX_SCORE);
            wall.seen_at_m = path_m;
        }
    }

    /// A reading went through wall `index` at `along_m`. Near an end it shows that the wall ends before.
    pub fn passed_through(&mut self, index: usize, along_m: f32) {
        if let Some(wall) = self.walls.get_mut(index) {
            wall.score = wall.score.saturating_sub(1);
            let (from_lo_m, to_hi_m) = ((along_m - wall.lo_m).max(0.0), (wall.hi_m - along_m).max(0.0));
            if from_lo_m < to_hi_m.min(OVERSHOOT_M) {
                wall.lo_m += CUT_SHARE * from_lo_m;
            } else if to_hi_m < OVERSHOOT_M {
                wall.hi_m -= CUT_SHARE * to_hi_m;
            }
        }
    }

    /// Removes the first wall that beams pass through or that was noise; true where there was one.
    pub fn prune(&mut self, ekf: &mut EkfView, path_m: f32) -> bool {
        let gone = self
            .walls
            .iter()
            .position(|w| w.score < 0 || (w.updates < FORGET_BELOW && path_m - w.seen_at_m > FORGET_AFTER_M));
        gone.is_some_and(|index| {
            self.remove(ekf, index);
            true
        })
    }

    /// Makes room where the map is full: removes the wall that the fewest readings met of those not seen for
    /// [`FORGET_AFTER_M`] with as many states as are `lacking`, if they are fewer than `points` of the newborn times [`WORTH`]. True where one
    /// went.
    pub fn evict(&mut self, ekf: &mut EkfView, points: u32, lacking: usize, path_m: f32) -> bool {
        let is_unseen = |w: &Wall| path_m - w.seen_at_m > FORGET_AFTER_M && w.states() >= lacking;
        let unseen = self.walls.iter().enumerate().filter(|(_, w)| is_unseen(w));
        let least = unseen.min_by_key(|(_, w)| w.updates).filter(|(_, w)| w.updates < WORTH.saturating_mul(points));
        let Some(index) = least.map(|(index, _)| index) else { return false };
        self.remove(ekf, index);
        true
    }

    /// Gives what was seen of wall `gone` to wall `kept`, and removes it.
    pub fn unite(&mut self, ekf: &mut EkfView, kept: usize, gone: usize) {
        let Some(&lost) = self.walls.get(gone) else { return };
        if let Some(kept) = self.walls.get_mut(kept) {
            kept.lo_m = kept.lo_m.min(lost.lo_m);
            kept.hi_m = kept.hi_m.max(lost.hi_m);
            kept.updates = kept.updates.saturating_add(lost.updates);
            kept.score = kept.score.max(lost.score);
            kept.seen_at_m = kept.seen_at_m.max(lost.seen_at_m);
        }
        self.remove(ekf, gone);
    }

    /// Removes wall `index` and its states.
    fn remove(&mut self, ekf: &mut EkfView, index: usize) {
        let Some(&wall) = self.walls.get(index) else { return };
        let last = self.walls.len() - 1;
        let moved = self.walls.get(last).copied();
        if let (Some(moved), Some(slot)) = (moved, self.walls.get_mut(index)) {
            *slot = moved;
        }
        self.walls.truncate(last);
        let rho = wall.rho();
        // The higher index first: the state moved into its place is then never the other one.
        match wall.direction.state() {
            None => self.remove_state(ekf, rho),
            Some(theta) => {
                self.remove_state(ekf, rho.max(theta));
                self.remove_state(ekf, rho.min(theta));
            }
        }
    }

    /// Removes a state that no wall needs any more; another state moves into its place.
    pub fn remove_state(&mut self, ekf: &mut EkfView, state: usize) {
        let moved = ekf.remove(state);
        for wall in &mut self.walls {
            wall.follow(moved, state);
        }
    }

    /// Wall `index`, to be changed with its states.
    pub fn wall_mut(&mut self, index: usize) -> Option<&mut Wall> {
        self.walls.get_mut(index)
    }

    /// Keeps those walls only. The states of the others are the caller's.
    pub fn retain(&mut self, is_kept: impl FnMut(&Wall) -> bool) {
        self.walls.retain(is_kept);
    }

    /// Forgets wall `index`, whose states are gone; the last one moves into its place.
    pub fn drop(&mut self, index: usize) {
        if index < self.walls.len() {
            self.walls.swap_remove(index);
        }
    }

    /// The wall added last had an identifier before, by which others know it.
    pub fn rename_last(&mut self, id: u16) {
        if let Some(wall) = self.walls.last_mut() {
            wall.id = id;
            self.next_id = self.next_id.wrapping_sub(1);
        }
    }

    /// Changes where a wall's direction comes from.
    pub fn set_direction(&mut self, index: usize, direction: Direction) {
        if let Some(wall) = self.walls.get_mut(index) {
            wall.direction = direction;
        }
    }
}
