//! Matches of fresh with kept walls, judged together: by the joint covariance of both maps, given that one shift along each axis lays
//! the fresh map into the kept one (joint compatibility, Neira and Tardos 2001).
//!
//! Where a map is bent, all walls of a place are off alike: what is known of one wall against another says so, where the sigma of each
//! alone allows anything. The shift is nobody's state: the first match of each axis, its *seed*, settles it, and all others are
//! held against the seeds.

use heapless::Vec;
use slam_core::kept::Kept;

use crate::FRESH_SIDES;
use crate::extents::Extents;
use crate::fresh::Fresh;
use crate::odds::{self, BENT_M};
use crate::side::{Side, covariance_m2, dot, is_one};

/// Entries of the factor: its lower triangle with the diagonal.
const ENTRIES: usize = FRESH_SIDES * (FRESH_SIDES + 1) / 2;

/// Comparisons of a match with itself and the seeds.
const WITH_SEEDS: u32 = 3;

/// A match is out of the question beyond so many sigmas, squared.
const GATE: f32 = 16.0;

/// A fresh wall taken for a kept one: their places in the lists.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    pub fresh: u8,
    pub kept: u8,
}

impl Pair {
    /// How far apart the two are without a shift, across the kept one, metres.
    pub(crate) fn apart_m(self, fresh: &Fresh, kept: &[Side]) -> f32 {
        let walls = kept.get(usize::from(self.kept)).zip(fresh.sides.get(usize::from(self.fresh)));
        walls.map_or(0.0, |(kept, fresh)| kept.off_m(fresh.middle_m()))
    }
}

/// The match that settles the shift along an axis, and how far apart its walls are without one, metres.
type Seed = Option<(Pair, f32)>;

/// Walls that were matched.
pub(crate) struct Joint<'m> {
    fresh: &'m Fresh,
    kept: &'m [Side],
    map: &'m dyn Kept,
    seeds: [Seed; 2],
    /// Covariances of the seeds.
    of_seeds: [[f32; 2]; 2],
    extents: Extents,
    /// Askew walls that were matched, and that were not.
    askew: [u8; 2],
    /// All matches but the seeds.
    pub pairs: Vec<Pair, FRESH_SIDES>,
    /// How much each is moved by the shift along either axis.
    across: Vec<[f32; 2], FRESH_SIDES>,
    /// Covariance of each with the seeds.
    with_seeds: Vec<[f32; 2], FRESH_SIDES>,
    /// Lower triangle of the Cholesky factor of their covariance against the seeds, by rows.
    factor: Vec<f32, ENTRIES>,
    /// How far apart they are against the seeds, whitened by it.
    white: Vec<f32, FRESH_SIDES>,
    /// Comparisons of two matches made so far.
    pub comparisons: u32,
}

/// How far apart two walls are, given the matches so far.
struct Offset {
    pair: Pair,
    off_m: f32,
    variance_m2: f32,
    with_seeds: [f32; 2],
    across: [f32; 2],
    row: Vec<f32, FRESH_SIDES>,
}

impl<'m> Joint<'m> {
    /// Nothing matched but the seeds of both axes, or of one.
    pub(crate) fn new(fresh: &'m Fresh, kept: &'m [Side], map: &'m dyn Kept, seeds: [Option<Pair>; 2]) -> Self {
        let mut joint = Self {
            fresh,
            kept,
            map,
            seeds: [None; 2],
            of_seeds: [[0.0; 2]; 2],
            extents: Extents::ANYWHERE,
            askew: [0; 2],
            pairs: Vec::new(),
            across: Vec::new(),
            with_seeds: Vec::new(),
            factor: Vec::new(),
            white: Vec::new(),
            comparisons: 0,
        };
        joint.seeds = seeds.map(|seed| seed.map(|pair| (pair, pair.apart_m(fresh, kept))));
        joint.of_seeds = seeds.map(|seed| seed.map_or([0.0; 2], |pair| joint.with_seeds(pair)));
        if let [Some((_, x_m)), Some((_, y_m))] = joint.seeds {
            joint.extents = Extents::at([x_m, y_m]);
        }
        joint
    }

    /// Covariance of how far apart two pairs are.
    fn covariance_m2(&self, p: Pair, q: Pair) -> f32 {
        let [a, b] = [p, q].map(|pair| self.kept.get(usize::from(pair.kept)));
        let (Some(a), Some(b)) = (a, b) else { return 0.0 };
        let kept = covariance_m2(self.map, a, b);
        let own = if p == q { BENT_M * BENT_M } else { 0.0 };
        kept + own + self.fresh.covariance_m2(usize::from(p.fresh), usize::from(q.fresh))
    }

    fn with_seeds(&self, pair: Pair) -> [f32; 2] {
        self.seeds.map(|seed| seed.map_or(0.0, |(seed, _)| self.covariance_m2(pair, seed)))
    }

    /// How far apart two walls are; none where that is out of the question.
    fn offset(&self, pair: Pair, across: [f32; 2]) -> Option<Offset> {
        let least_m2 = BENT_M * BENT_M;
        let shift_m = self.seeds.map(|seed| seed.map_or(0.0, |(_, apart_m)| apart_m));
        let mut off_m = pair.apart_m(self.fresh, self.kept) - dot(across, shift_m);
        let with_seeds = self.with_seeds(pair);
        // What the shift moves them by, which is the seeds'.
        let of_shift = self.of_seeds.map(|row| dot(across, row));
        let alone_m2 = self.covariance_m2(pair, pair) - 2.0 * dot(across, with_seeds) + dot(across, of_shift);
        let mut variance_m2 = alone_m2.max(least_m2);
        if off_m * off_m > GATE * variance_m2 {
            return None;
        }
        let mut row: Vec<f32, FRESH_SIDES> = Vec::new();
        let mut entries = self.factor.iter();
        let others = self.across.iter().zip(&self.with_seeds);
        for ((other, (others_across, others_with)), white) in self.pairs.iter().zip(others).zip(&self.white) {
            let mut sum = self.covariance_m2(pair, *other) + dot(*others_across, of_shift);
            sum -= dot(*others_across, with_seeds) + dot(across, *others_with);
            sum -= row.iter().zip(&mut entries).map(|(a, b)| a * b).sum::<f32>();
            let entry = sum / entries.next().unwrap_or(&1.0);
            off_m -= entry * white;
            variance_m2 -= entry * entry;
            // There is room for as many entries as walls.
            let _ = row.push(entry);
        }
        Some(Offset { pair, off_m, variance_m2: variance_m2.max(least_m2), with_seeds, across, row })
    }

    fn take(&mut self, offset: &Offset) {
        let sigma_m = float::sqrtf(offset.variance_m2);
        // There is room for as many matches as fresh walls.
        let _ = self.factor.extend_from_slice(&offset.row);
        let _ = self.factor.push(sigma_m);
        let _ = self.white.push(offset.off_m / sigma_m);
        let _ = self.across.push(offset.across);
        let _ = self.with_seeds.push(offset.with_seeds);
        let _ = self.pairs.push(offset.pair);
    }

    /// Matches every wall across the axes that have a seed with the kept one that fits best: the sum of what they say. With one
    /// axis alone that is the most that they can say, wherever they are along their lines.
    pub(crate) fn match_all(&mut self) -> f32 {
        let fresh = self.fresh;
        let walls = fresh.sides.iter().zip(fresh.weights.iter().zip(&fresh.end_weights)).enumerate();
        walls.map(|(i, (a, (weight, ends)))| self.match_wall(i, a, *weight, *ends)).sum()
    }

    fn match_wall(&mut self, i: usize, a: &Side, weight: f32, ends: [f32; 2]) -> f32 {
        let Some((seed, _)) = self.seeds[a.axis()] else { return 0.0 };
        if usize::from(seed.fresh) == i {
            return self.of_seed(a, seed, ends);
        }
        let same = if !a.is_on_grid() { odds::same_askew(self.askew) } else { odds::SAME };
        let likes = self.kept.iter().enumerate().filter(|(_, b)| b.is_like(a));
        if !a.is_on_grid() && self.seeds.iter().any(Option::is_none) {
            // Where it is across its line is open, too.
            return likes.count().min(1) as f32 * weight * odds::of_wall(1.0, 0.0, BENT_M * BENT_M, 1.0);
        }
        // Walls of one origin with the seed say no more of positions than it does.
        let of_seed = self.fresh.sides.get(usize::from(seed.fresh));
        let weight = if of_seed.is_some_and(|other| is_one(a, other)) { 0.0 } else { weight };
        let mut best: Option<(f32, [f32; 2], Offset)> = None;
        for (j, b) in likes {
            let share = self.extents.overlap(a, b);
            let pair = Pair { fresh: i as u8, kept: j as u8 };
            self.comparisons += WITH_SEEDS;
            let Some(offset) = (share > 0.0).then(|| self.offset(pair, b.across())).flatten() else { continue };
            self.comparisons += offset.row.len() as u32;
            let bare = odds::of_wall(same, offset.off_m, offset.variance_m2, share);
            let whole = odds::of_wall(same, offset.off_m, offset.variance_m2, share * self.extents.ends(a, b, ends));
            if best.as_ref().is_none_or(|(most, ..)| *most < whole) {
                best = Some((whole, [bare, whole - bare], offset));
            }
        }
        let taken = best.as_ref().filter(|(whole, ..)| *whole > odds::of_even(same));
        if !a.is_on_grid() {
            self.askew[usize::from(taken.is_none())] += 1;
        }
        if let Some((.., offset)) = taken {
            self.take(offset);
        }
        let Some((_, [bare, of_ends], _)) = best else { return weight * odds::of_nothing(same) };
        weight * bare + of_ends
    }

    /// What the seed of an axis says.
    fn of_seed(&self, a: &Side, seed: Pair, ends: [f32; 2]) -> f32 {
        let Some(b) = self.kept.get(usize::from(seed.kept)) else { return 0.0 };
        let share = self.extents.overlap(a, b);
        odds::of_seed(share * self.extents.ends(a, b, ends))
    }
}
