//! Every hypothesis of where a fresh map lies in a kept one, scored in slices.

use heapless::Vec;
use slam_core::Match;
use slam_core::kept::Kept;

use crate::odds::{self, Verdict};
use crate::shift::{SHIFTS, Shift, shifts};
use crate::side::{ALPHA, Side, find_sides, path_on_grid, turned_point};
use crate::{FRESH_SIDES, KEPT_SIDES, PATH_POINTS};

/// Hypotheses that are remembered.
const REMEMBERED: usize = 8;

/// Hypotheses that differ by less than this along both axes are one, metres.
const SAME_PLACE_M: f32 = 0.15;

/// A hypothesis whose bound is so far below the best one's score adds nothing to the odds, natural logarithm.
const NEGLIGIBLE: f32 = 16.0;

/// An extent overlaps another one also where it ends so much before, metres.
const ENDS_M: f32 = 0.15;

/// A match that the robot is placed by is nearer than this, metres.
const MATCHED_M: f32 = 0.10;

/// A place of the fresh map in the kept one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// Quarter turns from the fresh grid to the kept one.
    pub quarters: u8,
    /// Shift of the turned fresh map, metres along the kept grid's x and y.
    pub shift_m: [f32; 2],
    /// Logarithm of its likelihood times its prior, against the fresh walls standing anywhere.
    pub score: f32,
    /// Fresh walls that stand where kept ones do, along x and along y.
    pub matched: [u8; 2],
    /// The best matched walls of each axis: fresh, kept.
    pub pairs: [Option<(u16, u16)>; 2],
}

impl Hypothesis {
    /// Whether two are one place.
    pub fn is_same_place(&self, other: &Self) -> bool {
        let near = |axis: usize| (self.shift_m[axis] - other.shift_m[axis]).abs() < SAME_PLACE_M;
        self.quarters == other.quarters && near(0) && near(1)
    }

    /// The walls that say where the robot is in the kept map; none where an axis has no matched one.
    pub fn to_match(&self) -> Option<Match> {
        Some(Match { quarters: self.quarters, pairs: [self.pairs[0]?, self.pairs[1]?] })
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

/// A search of a fresh map in a kept one: some 5 KB, which therefore stays where it is from one search to the next.
#[derive(Clone, Debug)]
pub struct Search {
    /// The fresh map's walls, turned by so many quarters.
    fresh: Vec<Side, FRESH_SIDES>,
    quarters: u8,
    /// How much each of them counts.
    weights: Vec<f32, FRESH_SIDES>,
    kept: Vec<Side, KEPT_SIDES>,
    /// On the fresh grid.
    path_m: Vec<[f32; 2], PATH_POINTS>,
    floor_m2: f32,
    xs: Vec<Shift, SHIFTS>,
    ys: Vec<Shift, SHIFTS>,
    next: (usize, usize),
    best: Vec<Hypothesis, REMEMBERED>,
    /// Logarithm of what all others sum up to.
    rest: f32,
}

impl Search {
    /// Not begun.
    pub const IDLE: Self = Self {
        fresh: Vec::new(),
        quarters: 0,
        weights: Vec::new(),
        kept: Vec::new(),
        path_m: Vec::new(),
        floor_m2: 0.0,
        xs: Vec::new(),
        ys: Vec::new(),
        next: (0, 0),
        best: Vec::new(),
        rest: f32::NEG_INFINITY,
    };

    /// Begins to search a fresh map, in whose frame the robot drove along this trail (metres), in a kept one; false where the fresh
    /// one has no walls on a grid.
    pub fn begin(&mut self, fresh: &impl Kept, kept: &impl Kept, trail_m: &[[f32; 2]]) -> bool {
        find_sides(fresh, &mut self.fresh);
        if self.fresh.is_empty() {
            return false;
        }
        odds::weigh(&self.fresh, &mut self.weights);
        find_sides(kept, &mut self.kept);
        self.floor_m2 = floor_m2(&self.kept);
        let alpha_rad = fresh.mean(ALPHA);
        self.path_m.clear();
        for point_m in trail_m {
            // The locator keeps no more points than there is room for.
            let _ = self.path_m.push(path_on_grid(*point_m, alpha_rad));
        }
        self.best.clear();
        self.rest = f32::NEG_INFINITY;
        self.quarters = 0;
        self.find_shifts();
        true
    }

    /// Turns the fresh map by another quarter.
    fn turn(&mut self) {
        self.quarters += 1;
        self.fresh.iter_mut().for_each(|side| *side = side.turned());
        self.find_shifts();
    }

    fn find_shifts(&mut self) {
        shifts(&self.fresh, &self.weights, &self.kept, 0, &mut self.xs);
        shifts(&self.fresh, &self.weights, &self.kept, 1, &mut self.ys);
        self.next = (0, 0);
    }

    /// Scores about so many hypotheses, each of [`FRESH_SIDES`] x [`KEPT_SIDES`] comparisons at most.
    pub fn work(&mut self, hypotheses: usize) -> Progress {
        for _ in 0..hypotheses {
            let (x, y) = self.next;
            let (Some(along_x), Some(along_y)) = (self.xs.get(x).copied(), self.ys.get(y).copied()) else {
                if y == 0 || self.xs.get(x + 1).is_none() {
                    if self.quarters == 3 {
                        return Progress::Done;
                    }
                    self.turn();
                } else {
                    self.next = (x + 1, 0);
                }
                continue;
            };
            let least = self.best.first().map_or(f32::NEG_INFINITY, |best| best.score - NEGLIGIBLE);
            if along_x.bound + along_y.bound < least.max(-NEGLIGIBLE) {
                // Those that follow have lower bounds.
                self.next = if y == 0 { (self.xs.len(), 0) } else { (x + 1, 0) };
                continue;
            }
            self.next = (x, y + 1);
            let hypothesis = self.score([along_x.by_m, along_y.by_m]);
            self.remember(hypothesis);
        }
        Progress::Working
    }

    /// A hypothesis near a shift: the shift is first settled by the walls that it matches.
    fn score(&self, near_m: [f32; 2]) -> Hypothesis {
        let (mut shift_m, mut precisions) = (near_m, [1.0; 2]);
        for axis in 0..2 {
            let (mut weights, mut sum_m) = (0.0, 0.0);
            for a in self.fresh.iter().filter(|side| side.axis() == axis) {
                if let Some((b, off_m)) = self.nearest(a, near_m)
                    && off_m.abs() < MATCHED_M
                {
                    let weight = odds::precision(a.variance_m2 + b.variance_m2);
                    weights += weight;
                    sum_m += weight * off_m;
                }
            }
            if weights > 0.0 {
                shift_m[axis] += sum_m / weights;
                precisions[axis] = weights;
            }
        }
        let mut found = Hypothesis { quarters: self.quarters, shift_m, score: 0.0, matched: [0; 2], pairs: [None; 2] };
        let mut least_m2 = [f32::INFINITY; 2];
        for (a, weight) in self.fresh.iter().zip(&self.weights) {
            let Some((b, off_m)) = self.nearest(a, shift_m) else {
                found.score += weight * odds::of_nothing();
                continue;
            };
            let variance = a.variance_m2 + b.variance_m2;
            found.score += weight * odds::of_wall(off_m, variance, overlap(a, b, shift_m));
            let axis = a.axis();
            if off_m.abs() < MATCHED_M {
                found.matched[axis] += 1;
                if variance < least_m2[axis] {
                    least_m2[axis] = variance;
                    found.pairs[axis] = Some((a.id, b.id));
                }
            }
        }
        found.score += odds::of_crossings(self.crossings(shift_m)) + odds::of_place(precisions, self.floor_m2);
        found
    }

    /// The kept wall that explains a fresh one best, and how far it is from that.
    fn nearest(&self, a: &Side, shift_m: [f32; 2]) -> Option<(&Side, f32)> {
        let off_m = |b: &Side| b.at_m - a.at_m - shift_m[a.axis()];
        let same = self.kept.iter().filter(|b| b.facing == a.facing && overlap(a, b, shift_m) > 0.0);
        same.map(|b| (b, off_m(b))).min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    }

    /// Kept walls that the driven path goes through.
    fn crossings(&self, shift_m: [f32; 2]) -> usize {
        let place = |point: &[f32; 2]| {
            let [x, y] = turned_point(*point, self.quarters);
            [x + shift_m[0], y + shift_m[1]]
        };
        let crosses = |side: &Side, from: [f32; 2], to: [f32; 2]| {
            let (across, along) = (side.axis(), 1 - side.axis());
            let (a, b) = (from[across] - side.at_m, to[across] - side.at_m);
            if a * b >= 0.0 {
                return false;
            }
            let at_m = from[along] + (to[along] - from[along]) * a / (a - b);
            (side.extent_m[0]..=side.extent_m[1]).contains(&at_m)
        };
        let legs = || self.path_m.windows(2).filter_map(|leg| Some((place(leg.first()?), place(leg.last()?))));
        self.kept.iter().filter(|side| legs().any(|(from, to)| crosses(side, from, to))).count()
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
        self.best.sort_unstable_by(|a, b| b.score.total_cmp(&a.score));
    }

    /// What the search found so far.
    pub fn verdict(&self) -> Option<Verdict> {
        let best = *self.best.first()?;
        let others = self.best.iter().skip(1).fold(self.rest, |sum, other| odds::log_sum(sum, other.score));
        let against = odds::log_sum(others, odds::of_elsewhere());
        Some(Verdict {
            best,
            walls: self.fresh.len() as u8,
            log_odds: best.score - against,
            others: best.score - others,
        })
    }

    /// The hypotheses that are remembered, best first.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.best
    }
}

/// Share of a fresh wall's extent that a kept one reaches along.
fn overlap(a: &Side, b: &Side, shift_m: [f32; 2]) -> f32 {
    let along_m = shift_m[1 - a.axis()];
    let [lo_m, hi_m] = a.extent_m.map(|end_m| end_m + along_m);
    let common_m = hi_m.min(b.extent_m[1] + ENDS_M) - lo_m.max(b.extent_m[0] - ENDS_M);
    (common_m / a.length_m().max(1e-3)).clamp(0.0, 1.0)
}

/// Floor that a map's walls enclose, m^2.
fn floor_m2(kept: &[Side]) -> f32 {
    let (mut lo_m, mut hi_m) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    for side in kept {
        let (across, along) = (side.axis(), 1 - side.axis());
        lo_m[across] = lo_m[across].min(side.at_m);
        hi_m[across] = hi_m[across].max(side.at_m);
        lo_m[along] = lo_m[along].min(side.extent_m[0]);
        hi_m[along] = hi_m[along].max(side.extent_m[1]);
    }
    let [width_m, depth_m] = [0, 1].map(|axis| (hi_m[axis] - lo_m[axis]).clamp(1.0, 1000.0));
    width_m * depth_m
}
