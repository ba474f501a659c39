//! A turn that nothing told.
//!
//! A robot that is kicked along a wall that it does not know yet sees nothing that contradicts its map. But what it draws from then on stands
//! askew, wall after wall by the same angle, and what it saw before it sees no more. Of one such wall nobody can say whether it stands
//! askew; that all do is the less likely the more there are.

use core::f32::consts::{FRAC_2_PI, TAU};

use heapless::Vec;
use slam_core::angle::wrap;
use slam_core::{DECISION, GRID_SHARE, JOLT, Pose, Standing, are_apart};

use crate::diary::{Diary, FEWEST};
use crate::frame::{Frame, dot};
use crate::group::Group;
use crate::place::is_on_grid;
use crate::rows::{off_grid, quarters};
use crate::wall::{Line, Wall};

/// Odds at which a decision is made, 19 to 1: as the filter decides what stands on the grid.
const SURE: f32 = DECISION / (1.0 - DECISION);

/// Odds that a wall stands on the grid, before it is seen, 9 to 1: as the filter has it.
const ON_GRID: f32 = GRID_SHARE / (1.0 - GRID_SHARE);

/// Walls that stand alike do so within this angle, radians: two sigma of the two degrees to which the filter knows a wall off the grid.
const ALIKE_RAD: f32 = 0.07;

/// So many walls that stand alike are looked for: more say no more.
const MOST_ALIKE: usize = 8;

/// So many walls make a grid, at least.
const GRID_WALLS: usize = 2;

/// Of the hits on a wall, and of all, one in so many may be another wall's: after a jolt some fit what they are not of.
const STRAY: u32 = 20;

/// How often it is a jolt where all walls in view become others. They do so every 65 m, counted once, in forty simulated homes, and a jolt
/// comes once in an hour, 900 m, as the filter has it.
const JOLTED: f32 = 0.07;

/// Share of homes that are taken to have a wing that stands askew as a whole.
const WINGS: f32 = 0.02;

/// How often such a wing begins there. One robot in five saw nothing there of where it came from, in 24 simulated wings, and walls in view become others two or
/// three times in a home.
const WING: f32 = WINGS * (0.2 / 2.5);

/// What the look back before found longer is no piece of furniture but a wall of the building, metres. It stands askew as often as homes have a wing
/// that does.
const LONG_M: f32 = 3.0;

/// Multiply-adds of a look at one wall, for each group of the diary.
const COST: u32 = 5;

/// What was turned back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned {
    /// The filter has not taken that over yet.
    pub is_new: bool,
    /// The keyframe since which it was, and by how much, radians; nought where nothing was, or it turned out to be a wing.
    since: u32,
    by_rad: f32,
}

impl Turned {
    /// Nothing was; every byte is zero.
    pub const NOT: Self = Self { is_new: false, since: 0, by_rad: 0.0 };
}

/// What may have turned the robot between two keyframes: of all walls none was seen both until the first and from the second one on, and
/// those that were seen since stand askew.
#[derive(Clone, Copy, Debug)]
struct Turn {
    from: usize,
    to: usize,
    /// By so much what was seen since is to be turned, radians.
    by_rad: f32,
    odds: f32,
}

impl Turn {
    const NONE: Self = Self { from: 0, to: 0, by_rad: 0.0, odds: 0.0 };

    /// The likelier one.
    fn or(self, other: Self) -> Self {
        if other.odds > self.odds { other } else { self }
    }

    /// Whether it is sure enough.
    fn is_sure(&self) -> bool {
        self.odds > SURE
    }
}

/// Looks for a turn, wall by wall.
#[derive(Clone, Debug)]
pub(crate) struct Search {
    wall: usize,
    /// At odds of nought where none was found: with an `Option` a look back that has nothing to do would not be all zeros.
    likeliest: Turn,
}

impl Search {
    /// Before the first wall.
    pub const NEW: Self = Self { wall: 0, likeliest: Turn::NONE };

    /// Looks at the next wall; after the last one turns back what was turned, if that is sure enough. The cost in multiply-adds; none where it
    /// is over. While the filter has not taken over what was turned back nothing else is looked for.
    pub fn take<const K: usize, const G: usize, const W: usize>(&mut self, diary: &mut Diary<K, G, W>) -> Option<u32> {
        if self.wall < W && !diary.turned.is_new {
            let found = diary.stands_askew(self.wall).then(|| diary.turn_before(self.wall));
            self.wall += 1;
            let Some(found) = found else { return Some(1) };
            self.likeliest = found.map_or(self.likeliest, |turn| turn.or(self.likeliest));
            return Some(COST * diary.groups.len() as u32);
        }
        if self.likeliest.is_sure() {
            diary.turn_back(&self.likeliest);
        }
        None
    }
}

/// Hits on each wall before a keyframe, and since.
struct Sides<const W: usize>([[u32; 2]; W]);

impl<const W: usize> Sides<W> {
    /// Whether a wall was seen since, rather than before; none where it has too few hits.
    fn is_since(&self, wall: usize) -> Option<bool> {
        let [before, since] = *self.0.get(wall)?;
        (before + since >= FEWEST).then(|| self.is_mostly_since(wall))
    }

    /// Whether most of its hits are since; not of a wall without hits, which is older than the diary.
    fn is_mostly_since(&self, wall: usize) -> bool {
        self.0.get(wall).is_some_and(|[before, since]| since > before)
    }

    /// Whether each wall was seen on one side only, but for stray hits.
    fn are_parted(&self) -> bool {
        let (mut hits, mut stray) = ([0; 2], 0);
        for [before, since] in self.0 {
            hits = if since > before { [hits[0], hits[1] + since] } else { [hits[0] + before, hits[1]] };
            stray += before.min(since);
        }
        STRAY * stray <= hits[0].min(hits[1])
    }
}

/// A wall as one of those that stand alike.
struct Alike {
    line: Line,
    middle_m: [f32; 2],
    is_long: bool,
}

impl Alike {
    fn of(wall: &Wall) -> Self {
        let line = wall.line();
        Self { line, middle_m: line.at(wall.anchor_m), is_long: wall.hi_m - wall.lo_m > LONG_M }
    }

    fn is_behind(&self, other: &Self) -> bool {
        dot(other.line.normal, self.middle_m) > other.line.rho_m
    }

    /// Whether the two may be sides of one thing that stands askew: each is behind the other.
    fn is_one_with(&self, other: &Self) -> bool {
        self.is_behind(other) && other.is_behind(self)
    }
}

impl<const K: usize, const G: usize, const W: usize> Diary<K, G, W> {
    /// Whether a wall does not stand on the grid.
    fn stands_askew(&self, wall: usize) -> bool {
        self.placed(wall).is_some_and(|wall| !wall.on_grid)
    }

    /// What would have turned the robot before wall `index` was seen first, by the angle by which that stands askew. None where walls were
    /// seen both before and since.
    fn turn_before(&self, index: usize) -> Option<Turn> {
        let alpha_rad = self.alpha_rad?;
        let off_rad = off_grid(self.placed(index)?.beta_rad, alpha_rad);
        // What turns a robot by less is the filter's own error, as it has it of jolts.
        if !are_apart(&[0.0, 0.0, off_rad], &[0.0; 3]) {
            return None;
        }
        let to = self.first_seen(index)?;
        let sides = self.sides(to);
        if sides.is_since(index) != Some(true) || !sides.are_parted() {
            return None;
        }
        let is_alike = |wall: &Wall| !wall.on_grid && off_grid(wall.beta_rad - off_rad, alpha_rad).abs() < ALIKE_RAD;
        // The grid is of before, and nothing there stands askew as well.
        let holds_grid = self.seen(&sides, false).filter(|wall| wall.on_grid).count() >= GRID_WALLS;
        if !holds_grid || self.seen(&sides, false).any(|wall| is_alike(&wall)) {
            return None;
        }
        let mut alike: Vec<Alike, MOST_ALIKE> = Vec::new();
        let (mut jolted, mut askew) = (JOLTED * jolt_density(off_rad), 1.0);
        for wall in self.seen(&sides, true) {
            let one = Alike::of(&wall);
            if wall.on_grid {
                // It would not be.
                jolted /= ON_GRID;
            } else if is_alike(&wall) && !alike.iter().any(|other| one.is_one_with(other)) {
                // One more of a direction askew that has so many, against one more on the grid.
                let others = alike.len().max(1) as f32;
                askew *= if alike.push(one).is_ok() { others / ON_GRID } else { 1.0 };
            }
        }
        if alike.iter().any(|one| one.is_long) {
            // That one stands askew one time in fifty, in place of one in ten.
            askew *= ON_GRID * WINGS;
        }
        let from = self.last_seen_before(to, &sides)?;
        // A direction askew is any within a quarter turn.
        Some(Turn { from, to, by_rad: -off_rad, odds: jolted / (FRAC_2_PI * (WING + askew)) })
    }

    /// The walls that were seen since, or before.
    fn seen<'a>(&'a self, sides: &'a Sides<W>, since: bool) -> impl Iterator<Item = Wall> + 'a {
        let there = (0..W).filter(move |number| sides.is_since(*number) == Some(since));
        there.filter_map(|number| self.placed(number))
    }

    fn placed(&self, wall: usize) -> Option<Wall> {
        self.walls.get(wall).copied().flatten().filter(|wall| wall.is_placed)
    }

    /// The keyframe from which a wall was seen first, but for stray hits.
    fn first_seen(&self, wall: usize) -> Option<usize> {
        let on_it = |groups: &[Group]| -> u32 {
            groups.iter().filter(|group| group.wall() == Some(wall)).map(|group| u32::from(group.hits)).sum()
        };
        let all = on_it(&self.groups);
        // Since where it was seen from each keyframe.
        let (mut since, mut until) = (0, 0);
        for (number, (_, groups)) in self.sightings().enumerate() {
            let hits = on_it(groups);
            if hits == 0 {
                since = number + 1;
            }
            until += hits;
            if STRAY * until > all {
                return Some(since);
            }
        }
        None
    }

    /// The last keyframe ahead of `to` from which a wall of before was seen.
    fn last_seen_before(&self, to: usize, sides: &Sides<W>) -> Option<usize> {
        let is_of_before = |group: &Group| group.wall().is_some_and(|wall| sides.is_since(wall) == Some(false));
        let seen = self.sightings().take(to).enumerate();
        seen.filter(|(_, (_, groups))| groups.iter().any(is_of_before)).map(|(key, _)| key).last()
    }

    /// Hits before keyframe `to` and since; from itself both may have been seen.
    fn sides(&self, to: usize) -> Sides<W> {
        let mut sides = Sides([[0; 2]; W]);
        for (key, (_, groups)) in self.sightings().enumerate().filter(|(key, _)| *key != to) {
            for (wall, group) in groups.iter().filter_map(|group| Some((group.wall()?, group))) {
                if let Some(hits) = sides.0.get_mut(wall).and_then(|hits| hits.get_mut(usize::from(key > to))) {
                    *hits += u32::from(group.hits);
                }
            }
        }
        sides
    }

    /// Turns what was seen since back onto the grid. On the way there a jolt may have moved the robot. Where it was turned back by as much
    /// as it had been turned, nothing did: it was in a wing that stands askew, and is back.
    fn turn_back(&mut self, turn: &Turn) {
        let &Turn { from, to, by_rad, .. } = turn;
        if self.leave_wing(by_rad, self.keyframes.len()) {
            return;
        }
        let sides = self.sides(to);
        // Their variances add up to a jolt's.
        let share = 1.0 / float::sqrtf(to.saturating_sub(from).max(1) as f32);
        for key in self.keyframes.iter_mut().take(to).skip(from) {
            key.jolt([share * JOLT[0], share * JOLT[2]]);
        }
        self.turn_since(to, self.keyframes.len(), by_rad, &sides);
        self.forget_strays(to, &sides);
        let since = self.keyframes.get(to).map_or(0, |key| key.serial);
        self.turned = Turned { is_new: true, since, by_rad };
    }

    /// Where the last turn that was turned back is turned again the other way by as much, the robot was in a wing in between, until the
    /// keyframe with the number `end`: it is where it was drawn. False where it was not.
    pub(crate) fn leave_wing(&mut self, by_rad: f32, end: usize) -> bool {
        let Turned { since, by_rad: last_rad, .. } = self.turned;
        let to = self.keyframes.iter().position(|key| key.serial >= since);
        let Some(to) = to.filter(|to| *to < end && last_rad != 0.0 && wrap(by_rad + last_rad).abs() < ALIKE_RAD) else {
            return false;
        };
        for key in self.keyframes.iter_mut().take(to).rev().take_while(|key| key.is_jolted()) {
            key.forget_jolt();
        }
        self.turn_since(to, end, -last_rad, &self.sides(to));
        self.turned = Turned { is_new: true, ..Turned::NOT };
        true
    }

    /// Turns the keyframes from `to` up to `end` about the first of them, and the walls that were seen since.
    fn turn_since(&mut self, to: usize, end: usize, by_rad: f32, sides: &Sides<W>) {
        let (Some(pivot), Some(alpha_rad)) = (self.keyframes.get(to).map(|key| key.pose), self.alpha_rad) else {
            return;
        };
        let turned = |heading_rad: f32| wrap(heading_rad + by_rad);
        let [as_seen, as_turned] = [pivot.theta_rad, turned(pivot.theta_rad)];
        let [as_seen, as_turned] = [as_seen, as_turned].map(|theta_rad| Frame::of(&Pose { theta_rad, ..pivot }));
        let moved = |at_m: [f32; 2]| as_turned.point(as_seen.seen(at_m));
        for key in self.keyframes.iter_mut().take(end).skip(to) {
            let [x_m, y_m] = moved([key.pose.x_m, key.pose.y_m]);
            key.pose = Pose { x_m, y_m, theta_rad: turned(key.pose.theta_rad) };
        }
        for (number, wall) in self.walls.iter_mut().enumerate() {
            let is_since = sides.is_mostly_since(number);
            let Some(wall) = wall.as_mut().filter(|wall| is_since && wall.is_placed) else { continue };
            wall.put(moved(wall.line().at(wall.anchor_m)), by_rad);
            if wall.told != Standing::Unknown {
                let is_near = off_grid(wall.beta_rad, alpha_rad).abs() < ALIKE_RAD;
                let quarter = (quarters(wall.beta_rad, alpha_rad) as i32).rem_euclid(4) as u8;
                wall.told = if is_near { Standing::Near(quarter) } else { Standing::Off };
            }
            wall.on_grid = is_on_grid(wall, self.alpha_rad);
        }
    }

    /// What was seen on one side of the turn is not on a wall of the other: nothing but the jolt holds the two sides together, and a few hits
    /// would draw them to where they are not.
    fn forget_strays(&mut self, to: usize, sides: &Sides<W>) {
        let before = self.keyframes.iter().take(to).map(|key| usize::from(key.groups)).sum();
        for (number, group) in self.groups.iter_mut().enumerate() {
            let is_stray = |wall| sides.is_since(wall).is_some_and(|is_since| is_since != (number >= before));
            if group.wall().is_some_and(is_stray) {
                group.set_wall(None);
            }
        }
    }
}

/// Density of the turn of a jolt, 1/rad.
fn jolt_density(turn_rad: f32) -> f32 {
    let sigmas = turn_rad / JOLT[2];
    libm::expf(-0.5 * sigmas * sigmas) / (JOLT[2] * float::sqrtf(TAU))
}
