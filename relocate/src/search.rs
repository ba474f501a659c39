//! Every hypothesis of where a fresh map lies in a kept one, scored in slices.

use core::f32::consts::FRAC_PI_2;

use heapless::Vec;
use slam_core::angle::wrap;
use slam_core::kept::Kept;
use slam_core::{Match, Pose};

use crate::crossings;
use crate::fresh::Fresh;
use crate::joint::{Joint, Pair};
use crate::odds::{self, Displaced, Verdict};
use crate::order::descending;
use crate::shift::Shifts;
use crate::side::{ALPHA, Side, find_sides, path_on_grid, turned_point};
use crate::{KEPT_SIDES, PATH_POINTS};

/// Hypotheses that are remembered.
const REMEMBERED: usize = 8;

/// Hypotheses that differ by less than this along both axes are one, metres.
const SAME_PLACE_M: f32 = 0.15;

/// And so are those that differ by less than so many sigmas.
const SAME_SIGMAS: f32 = 3.0;

/// A hypothesis whose bound is so far below the best one's score adds nothing to the odds, natural logarithm.
const NEGLIGIBLE: f32 = 16.0;

/// Points of a path beside a kept wall take as long as a comparison of two matches.
const POINTS_A_COMPARISON: u32 = 4;

/// A place of the fresh map in the kept one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// Quarter turns from the fresh grid to the kept one.
    pub quarters: u8,
    /// Shift of the turned fresh map where the robot is, metres along the kept grid's x and y.
    pub shift_m: [f32; 2],
    /// Variance of that, m^2.
    pub variance_m2: [f32; 2],
    /// Logarithm of its likelihood times its prior, against the fresh walls standing anywhere.
    pub score: f32,
    /// Fresh walls that stand where kept ones do, along x and along y.
    pub matched: [u8; 2],
    /// Of each axis, the matched walls that the robot's place is best known from: fresh, kept.
    pub pairs: [Option<(u16, u16)>; 2],
}

impl Hypothesis {
    /// Whether two are one place.
    pub fn is_same_place(&self, other: &Self) -> bool {
        let near = |axis: usize| {
            let off_m = self.shift_m[axis] - other.shift_m[axis];
            let variance = self.variance_m2[axis] + other.variance_m2[axis];
            off_m * off_m < (SAME_PLACE_M * SAME_PLACE_M).max(SAME_SIGMAS * SAME_SIGMAS * variance)
        };
        self.quarters == other.quarters && near(0) && near(1)
    }

    /// The walls that say where the robot is in the kept map; none where an axis has no matched one.
    pub fn to_match(&self) -> Option<Match> {
        Some(Match { quarters: self.quarters, pairs: [self.pairs[0]?, self.pairs[1]?] })
    }
}

/// What is known beforehand of where a fresh map lies in a kept one that is in the same frame, but that something displaced the robot.
#[derive(Clone, Copy, Debug)]
struct Near {
    /// Where that was, metres, on the fresh grid and on the kept one.
    at_m: [[f32; 2]; 2],
    /// The kept grid against the fresh one, radians.
    turned_rad: f32,
    by: Displaced,
}

impl Near {
    /// Of maps on these grids (radians), the place as both have it, and how far the fresh map's frame is turned in the kept one's.
    fn new(grids_rad: [f32; 2], at_m: [[f32; 2]; 2], frame_rad: f32, by: Displaced) -> Self {
        let [fresh_rad, kept_rad] = grids_rad;
        let at_m = [path_on_grid(at_m[0], fresh_rad), path_on_grid(at_m[1], kept_rad)];
        Self { at_m, turned_rad: kept_rad - fresh_rad - frame_rad, by }
    }

    /// Log-density of the displacement.
    fn of(&self, quarters: u8, shift_m: [f32; 2]) -> f32 {
        let [fresh, kept] = self.at_m;
        let [x, y] = turned_point(fresh, quarters);
        let moved_m = slam_core::pose::length(x + shift_m[0] - kept[0], y + shift_m[1] - kept[1]);
        self.by.of(moved_m, wrap(self.turned_rad + f32::from(quarters) * FRAC_PI_2))
    }
}

/// How far a search is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// There is more to do.
    Working,
    /// Every hypothesis was scored.
    Done,
}

/// What a search does next.
#[derive(Clone, Copy, Debug)]
enum Next {
    /// Finds the shifts along this axis.
    Shift(usize),
    /// Scores the hypothesis of these shifts along x and along y.
    Hypothesis(usize, usize),
    /// Turns the fresh map on.
    Quarter,
}

/// A search of a fresh map in a kept one: some 5 KB, which therefore stays where it is from one search to the next.
#[derive(Clone, Debug)]
pub struct Search {
    fresh: Fresh,
    kept: Vec<Side, KEPT_SIDES>,
    /// On the fresh grid.
    path_m: Vec<[f32; 2], PATH_POINTS>,
    /// Logarithm of the density of places, where any is as likely.
    of_any: f32,
    /// The same of the likeliest.
    of_place: f32,
    /// What is known beforehand of where the fresh map lies.
    near: Option<Near>,
    /// Along x and along y.
    shifts: [Shifts; 2],
    next: Next,
    best: Vec<Hypothesis, REMEMBERED>,
    /// Logarithm of what all others sum up to.
    rest: f32,
}

impl Search {
    /// Not begun. Every byte is zero, so that one is written without a pattern of it in the flash.
    pub const IDLE: Self = Self {
        fresh: Fresh::NONE,
        kept: Vec::new(),
        path_m: Vec::new(),
        of_any: 0.0,
        of_place: 0.0,
        near: None,
        shifts: [Shifts::NONE; 2],
        next: Next::Shift(0),
        best: Vec::new(),
        rest: 0.0,
    };

    /// Begins to search a fresh map, in whose frame the robot drove along this trail (metres), in a kept one; false where the fresh
    /// one has no walls on a grid.
    pub fn begin(&mut self, fresh: &dyn Kept, kept: &dyn Kept, trail_m: &[[f32; 2]]) -> bool {
        if !self.fresh.take(fresh) {
            return false;
        }
        find_sides(kept, f32::INFINITY, &mut self.kept);
        self.of_any = odds::of_place(floor_m2(&self.kept));
        (self.of_place, self.near) = (self.of_any, None);
        let alpha_rad = fresh.mean(ALPHA);
        self.path_m.clear();
        for point_m in trail_m {
            // The locator keeps no more points than there is room for.
            let _ = self.path_m.push(path_on_grid(*point_m, alpha_rad));
        }
        self.best.clear();
        self.rest = f32::NEG_INFINITY;
        self.begin_quarter();
        true
    }

    /// The same of two parts of one map, of which one is displaced against the other as a jolt does at this point, metres.
    pub(crate) fn begin_displaced(&mut self, fresh: &dyn Kept, kept: &dyn Kept, at_m: [f32; 2]) -> bool {
        let is_begun = self.begin(fresh, kept, &[]);
        self.of_any = f32::NEG_INFINITY;
        self.expect(Near::new([fresh, kept].map(|map| map.mean(ALPHA)), [at_m; 2], 0.0, odds::COPY));
        is_begun
    }

    /// The fresh map's start lies here in the frame of the kept one's, and the robot is displaced against that so, but for those that were
    /// carried and are anywhere.
    pub(crate) fn expect_near(&mut self, [fresh, kept]: [&dyn Kept; 2], start: &Pose, by: Displaced) {
        let frame = |map: &dyn Kept| map.frame().anchor.map_or(Pose::ORIGIN, |(pose, _)| pose);
        let begun = frame(kept).inverse().compose(start).compose(&frame(fresh));
        self.of_any += odds::CARRIED;
        let grids_rad = [fresh, kept].map(|map| map.mean(ALPHA));
        self.expect(Near::new(grids_rad, [[0.0; 2], [begun.x_m, begun.y_m]], begun.theta_rad, by));
    }

    fn expect(&mut self, near: Near) {
        self.of_place = odds::log_sum(self.of_any, near.by.of_none());
        self.near = Some(near);
    }

    fn begin_quarter(&mut self) {
        self.shifts.iter_mut().for_each(Shifts::begin);
        self.next = Next::Shift(0);
    }

    /// Goes on in the kept map of [`begin`](Self::begin) until about so many comparisons of two matches are made: those of one hypothesis
    /// more at most.
    pub fn work(&mut self, map: &dyn Kept, comparisons: u32) -> Progress {
        let mut made = 0u32;
        while made < comparisons {
            made += match self.next {
                Next::Shift(axis) => self.go_on_with_shifts(map, axis),
                Next::Hypothesis(x, y) => self.try_hypothesis(map, x, y),
                Next::Quarter if self.fresh.quarters == 3 => return Progress::Done,
                Next::Quarter => {
                    self.fresh.turn();
                    self.begin_quarter();
                    1
                }
            };
        }
        Progress::Working
    }

    fn go_on_with_shifts(&mut self, map: &dyn Kept, axis: usize) -> u32 {
        let comparisons = self.shifts.get_mut(axis).and_then(|shifts| shifts.go_on(&self.fresh, &self.kept, map, axis));
        if comparisons.is_none() {
            self.next = if axis == 0 { Next::Shift(1) } else { Next::Hypothesis(0, 0) };
        }
        comparisons.unwrap_or(1)
    }

    fn try_hypothesis(&mut self, map: &dyn Kept, x: usize, y: usize) -> u32 {
        let [xs, ys] = &self.shifts;
        let Some(along_x) = xs.found.get(x).copied() else {
            self.next = Next::Quarter;
            return 1;
        };
        let Some(along_y) = ys.found.get(y).copied() else {
            self.next = if y == 0 { Next::Quarter } else { Next::Hypothesis(x + 1, 0) };
            return 1;
        };
        let least = self.best.first().map_or(f32::NEG_INFINITY, |best| best.score - NEGLIGIBLE);
        if along_x.bound + along_y.bound + self.of_place < least.max(-NEGLIGIBLE) {
            // Those that follow have lower bounds.
            self.next = if y == 0 { Next::Quarter } else { Next::Hypothesis(x + 1, 0) };
            return 1;
        }
        self.next = Next::Hypothesis(x, y + 1);
        let (hypothesis, comparisons) = self.score(map, [along_x.pair, along_y.pair], least);
        self.remember(hypothesis);
        comparisons
    }

    /// The hypothesis of two matches that settle the shift. Where it is below `least` as it is, it is not asked what the path says
    /// against it, too. With it, the comparisons that it took.
    fn score(&self, map: &dyn Kept, seeds: [Pair; 2], least: f32) -> (Hypothesis, u32) {
        let mut joint = Joint::new(&self.fresh, &self.kept, map, seeds.map(Some));
        let shift_m = seeds.map(|seed| seed.apart_m(&self.fresh, &self.kept));
        let of_near = self.near.map_or(f32::NEG_INFINITY, |near| near.of(self.fresh.quarters, shift_m));
        let mut found = Hypothesis {
            quarters: self.fresh.quarters,
            shift_m,
            variance_m2: [f32::INFINITY; 2],
            score: odds::log_sum(self.of_any, of_near) + joint.match_all(),
            matched: [0; 2],
            pairs: [None; 2],
        };
        let mut comparisons = joint.comparisons;
        if found.score > least {
            found.score += self.crossings(map, seeds, found.shift_m);
            comparisons += (self.kept.len() * self.path_m.len()) as u32 / POINTS_A_COMPARISON;
        }
        seeds.iter().chain(&joint.pairs).for_each(|pair| self.place(&mut found, *pair));
        (found, comparisons)
    }

    /// Takes a match into a hypothesis: the robot's place is that beside the walls that it knows itself beside best.
    fn place(&self, found: &mut Hypothesis, Pair { fresh, kept }: Pair) {
        let (fresh, kept) = (usize::from(fresh), usize::from(kept));
        let (Some(a), Some(b)) = (self.fresh.sides.get(fresh), self.kept.get(kept)) else { return };
        let variance_m2 = self.fresh.beside_m2(fresh) + odds::BENT_M * odds::BENT_M;
        let axis = a.axis();
        found.matched[axis] += 1;
        if a.is_on_grid() && variance_m2 < found.variance_m2[axis] {
            found.variance_m2[axis] = variance_m2;
            found.shift_m[axis] = b.at_m - a.at_m;
            found.pairs[axis] = Some((a.id, b.id));
        }
    }

    /// What the kept walls say that the driven path goes through.
    fn crossings(&self, map: &dyn Kept, seeds: [Pair; 2], shift_m: [f32; 2]) -> f32 {
        let place = |point: &[f32; 2]| {
            let [x, y] = turned_point(*point, self.fresh.quarters);
            [x + shift_m[0], y + shift_m[1]]
        };
        let of_wall = |side: &Side| {
            let Some(depth_m) = crossings::depth_m(side, self.path_m.iter().map(place)) else { return 0.0 };
            let seed = seeds[side.axis()];
            let Some(other) = self.kept.get(usize::from(seed.kept)) else { return 0.0 };
            // Where the wall is beside the seed's kept one, and the path beside its fresh one.
            let of = |a: &Side, b: &Side| a.sign() * b.sign() * map.covariance(usize::from(a.rho), usize::from(b.rho));
            let walls_m2 = of(side, side) + of(other, other) - 2.0 * of(side, other);
            let path_m2 = self.fresh.beside_m2(usize::from(seed.fresh));
            odds::of_crossing(depth_m / float::sqrtf(walls_m2.max(0.0) + path_m2 + odds::BENT_M * odds::BENT_M))
        };
        self.kept.iter().filter(|side| side.is_on_grid()).map(of_wall).sum()
    }

    fn remember(&mut self, hypothesis: Hypothesis) {
        if let Some(twin) = self.best.iter_mut().find(|twin| twin.is_same_place(&hypothesis)) {
            if twin.score < hypothesis.score {
                *twin = hypothesis;
            }
        } else if let Err(hypothesis) = self.best.push(hypothesis) {
            let lost = match self.best.last_mut() {
                Some(last) if last.score < hypothesis.score => core::mem::replace(last, hypothesis),
                _ => hypothesis,
            };
            self.rest = odds::log_sum(self.rest, lost.score);
        }
        descending(&mut self.best, |place| place.score);
    }

    /// What the search found so far.
    pub fn verdict(&self) -> Option<Verdict> {
        let best = *self.best.first()?;
        let others = self.best.iter().skip(1).fold(self.rest, |sum, other| odds::log_sum(sum, other.score));
        let against = odds::log_sum(others, odds::of_elsewhere());
        Some(Verdict {
            best,
            walls: self.fresh.sides.len() as u8,
            log_odds: best.score - against,
            others: best.score - others,
        })
    }

    /// The hypotheses that are remembered, best first.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.best
    }
}

/// Floor that a map's walls enclose, m^2.
fn floor_m2(kept: &[Side]) -> f32 {
    let (mut lo_m, mut hi_m) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    for side in kept.iter().filter(|side| side.is_on_grid()) {
        let (across, along) = (side.axis(), 1 - side.axis());
        lo_m[across] = lo_m[across].min(side.at_m);
        hi_m[across] = hi_m[across].max(side.at_m);
        lo_m[along] = lo_m[along].min(side.extent_m[0]);
        hi_m[along] = hi_m[along].max(side.extent_m[1]);
    }
    let [width_m, depth_m] = [0, 1].map(|axis| (hi_m[axis] - lo_m[axis]).clamp(1.0, 1000.0));
    width_m * depth_m
}
