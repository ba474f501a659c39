//! What a fresh wall says for or against a hypothesis, and what a search makes of all of them.

use heapless::Vec;
use slam_core::{CONTRADICTED_M, JOLT};

use crate::FRESH_SIDES;
use crate::side::{ORIGIN_M, Side, is_one};

/// Share of a fresh map's walls that stand where the kept one says: the others are furniture that was moved, doors, and walls
/// that either map has wrong.
pub(crate) const SAME: f32 = 0.7;

/// Where anything else stands: uniform over what a sensor sees, metres. A wall of a fresh map is no farther from the path than that, and the
/// path of a place that could be right lies beside walls, too: chance puts a wall on a kept one far more often than in all the home.
const REACH_M: f32 = 1.5;

/// Two maps have the same wall up to this, metres, beyond what either knows: the relief of built walls, and how the maps are
/// bent.
pub(crate) const BENT_M: f32 = 0.02;

/// Share of ends of walls that are corners and doors, where another drive sees them end, too: the others end where the robot saw no more.
const SAME_END: f32 = 0.5;

/// How far the ends of one wall in two maps are apart, 1-sigma, metres: seen from elsewhere, a beam's width and a reading's distance later.
const END_M: f32 = 0.15;

/// Share of kept walls that are gone: doors that were shut, things that were moved.
const GONE: f32 = 0.1;

/// Odds of elsewhere beforehand: that the robot stands in a home, or in a part of this one, that the map does not have.
const ELSEWHERE: f32 = 0.1;

/// How much worse elsewhere explains a match than the rest of the model says, nats. It takes walls of one origin for one, ends that are in one line, too,
/// and chance to be as near as the reach; where these are at work they say some of the same. Over fourteen homes with four nats the best place of a
/// search had modelled odds of 1 to e^2 in 3.2 % of searches in the home's own map and in 6.0 % of those in another's, of e^2 to e^4 in 6.1 % and 0.85 %:
/// with the prior, e^1.7 and e^4.3. Another nat is for homes that are not like those.
const CHANCE: f32 = 5.0;

/// Share of askew fresh walls that stand where the kept map says, after so many that did and that did not. It is the home's: in one that is
/// built askew nearly all do; where the truth lays maps of offices on one another, one in thirty does (two in five of those on the grid), for
/// most are things, or lines that either map has wrong. By Jeffreys' prior.
pub(crate) fn same_askew([matched, missed]: [u8; 2]) -> f32 {
    (f32::from(matched) + 0.5) / (f32::from(matched) + f32::from(missed) + 1.0)
}

/// Log-likelihood ratio of a fresh wall, `off_m` from a kept one that faces the same way and reaches along `overlap` of it, against
/// anything that stands anywhere, where a share `same` of them stands as kept.
pub(crate) fn of_wall(same: f32, off_m: f32, variance_m2: f32, overlap: f32) -> f32 {
    let density = libm::expf(-0.5 * off_m * off_m / variance_m2) / float::sqrtf(core::f32::consts::TAU * variance_m2);
    libm::logf(1.0 - same + same * overlap * density * REACH_M)
}

/// The same of a fresh wall that no kept one explains.
pub(crate) fn of_nothing(same: f32) -> f32 {
    libm::logf(1.0 - same)
}

/// What a wall says that is a kept one as likely as not.
pub(crate) fn of_even(same: f32) -> f32 {
    libm::logf(2.0 * (1.0 - same))
}

/// How much each of a fresh map's walls counts, so that those of one origin together count as one: one that chance put on a kept one
/// brings the others with it.
pub(crate) fn weigh(fresh: &[Side], weights: &mut Vec<f32, FRESH_SIDES>) {
    weights.clear();
    for a in fresh {
        let of_one = fresh.iter().filter(|b| is_one(a, b)).count();
        // There is room for as many weights as walls.
        let _ = weights.push(1.0 / of_one.max(1) as f32);
    }
}

/// How much the ends of each count: an end at a corner is where the wall across stands, which counts itself, and ends that are in
/// one line have one origin. Ends of askew walls are not asked.
pub(crate) fn weigh_ends(fresh: &[Side], weights: &mut Vec<[f32; 2], FRESH_SIDES>) {
    weights.clear();
    for a in fresh {
        let of_end = |end_m: f32| {
            let is_near = |at_m: f32| (at_m - end_m).abs() < ORIGIN_M;
            let on_grid = || fresh.iter().filter(|b| b.is_on_grid());
            let is_corner = on_grid().any(|b| b.axis() != a.axis() && is_near(b.at_m));
            let ends = on_grid().filter(|b| b.axis() == a.axis()).flat_map(|b| b.extent_m);
            if is_corner { 0.0 } else { 1.0 / ends.filter(|at_m| is_near(*at_m)).count().max(1) as f32 }
        };
        // There is room for as many weights as walls.
        let _ = weights.push(if !a.is_on_grid() { [0.0; 2] } else { a.extent_m.map(of_end) });
    }
}

/// Log-likelihood ratio of the first wall of an axis, which settles the shift along it: anywhere is as likely.
pub(crate) fn of_seed(likeness: f32) -> f32 {
    libm::logf(1.0 - SAME + SAME * REACH_M * likeness)
}

/// Likelihood ratio of an end of a fresh wall that is so far from that of a kept one, against its being anywhere within reach.
pub(crate) fn of_end(off_m: f32) -> f32 {
    let sigmas = off_m * (1.0 / END_M);
    let density = libm::expf(-0.5 * sigmas * sigmas) / (2.506_628 * END_M);
    1.0 - SAME_END + SAME_END * density * 2.0 * REACH_M
}

/// Log-likelihood of a kept wall that the path goes through by so many sigmas.
pub(crate) fn of_crossing(sigmas: f32) -> f32 {
    libm::logf(GONE + (1.0 - GONE) * libm::expf(-0.5 * sigmas * sigmas))
}

/// Logarithm of the density of shifts, in four rotations over so much floor, m^2.
pub(crate) fn of_place(floor_m2: f32) -> f32 {
    -libm::logf(4.0 * floor_m2)
}

/// What displaces a robot unseen does so as a jolt does, radians, 1-sigma.
const TURNED_RAD: f32 = JOLT[2];

/// How far a robot in a dock may be turned, radians, 1-sigma: a dock forgives ten degrees to either side, all alike.
const DOCKED_RAD: f32 = 0.1;
/// How far two maps that begin in it may be shifted, metres, 1-sigma: a dock forgives three centimetres, and each map has the walls about it a few
/// centimetres off.
const DOCKED_M: f32 = 0.1;

/// How a robot was displaced unseen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Displaced {
    /// Variance along each axis, m^2: that of a jolt, and what its turn makes of how well is known where it was.
    moved_m2: f32,
    /// Its turn, radians, 1-sigma.
    turned_rad: f32,
    /// Logarithm of its share of all that may have happened, and of the density of its turn at none against any of four rotations'.
    share: f32,
}

/// Where one map has walls twice: at a sensor's reach from the second copy's begin.
pub(crate) const COPY: Displaced = Displaced { moved_m2: moved_m2(REACH_M), turned_rad: TURNED_RAD, share: 0.0 };

/// Where readings contradict a map: somewhere on the path that it takes at least to say so. Every other robot was carried anywhere.
pub(crate) const CONTRADICTED: Displaced =
    Displaced { moved_m2: moved_m2(CONTRADICTED_M), turned_rad: TURNED_RAD, share: 0.225_79 };

/// Logarithm of the share of those that were carried.
pub(crate) const CARRIED: f32 = -core::f32::consts::LN_2;

/// Where the robot stands in a dock, and the map has one: one half that it is in that dock where it was, one half that the dock was moved. Docks are
/// moved in one start of a hundred. But each stands before a wall, at the same distance, so that in a moved one the rotation and the shift across that wall
/// fit in any case: by chance they would once in some eighty times.
pub(crate) const DOCKED: Displaced =
    Displaced { moved_m2: DOCKED_M * DOCKED_M, turned_rad: DOCKED_RAD, share: 1.142_08 };

/// Logarithm of one half, times the density of a turn at none against any of four rotations', but for the turn's sigma: pi / 2 over the root of 2 pi.
const HALF_OF_TURNS: f32 = -1.160_503;

const fn moved_m2(known_to_m: f32) -> f32 {
    JOLT[0] * JOLT[0] + TURNED_RAD * known_to_m * TURNED_RAD * known_to_m
}

impl Displaced {
    /// Of a robot that stood where this is known so (m^2, rad^2) and that nobody carried: who takes out its battery or its power's plug nudges it as
    /// a kick does. That is one half; the other half was carried, for whoever carries a robot may switch it off first.
    pub(crate) fn nudged(known_m2: f32, known_rad2: f32) -> Self {
        let turned_rad = float::sqrtf(TURNED_RAD * TURNED_RAD + known_rad2);
        let moved_m2 = moved_m2(0.0) + known_m2;
        Self { moved_m2, turned_rad, share: HALF_OF_TURNS - libm::logf(turned_rad) }
    }

    /// Log-density of none.
    pub(crate) fn of_none(&self) -> f32 {
        self.share - libm::logf(core::f32::consts::TAU * self.moved_m2)
    }

    /// Log-density of so large a one.
    pub(crate) fn of(&self, moved_m: f32, turned_rad: f32) -> f32 {
        let turns = turned_rad / self.turned_rad;
        self.of_none() + -0.5 * (moved_m * moved_m / self.moved_m2 + turns * turns)
    }
}

/// Logarithm of the odds of elsewhere, against a place as the walls say.
pub(crate) fn of_elsewhere() -> f32 {
    libm::logf(ELSEWHERE) - CHANCE
}

/// log(exp(a) + exp(b)).
pub(crate) fn log_sum(a: f32, b: f32) -> f32 {
    let (high, low) = if a > b { (a, b) } else { (b, a) };
    if low == f32::NEG_INFINITY { high } else { high + libm::log1pf(libm::expf(low - high)) }
}

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The best hypothesis.
    pub best: crate::search::Hypothesis,
    /// Fresh walls that were matched.
    pub walls: u8,
    /// Logarithm of its odds against all others and elsewhere together.
    pub log_odds: f32,
    /// The same against the other places only.
    pub others: f32,
}
