//! What a fresh wall says for or against a hypothesis, and what a search makes of all of them.

use heapless::Vec;

use crate::FRESH_SIDES;
use crate::side::Side;

/// Share of a fresh map's walls that stand where the kept one says: the others are furniture that was moved, doors, and walls
/// that either map has wrong.
const SAME: f32 = 0.7;

/// Where anything else stands: uniform over what a sensor sees, metres. A wall of a fresh map is no farther from the path than that, and the
/// path of a place that could be right lies beside walls, too: chance puts a wall on a kept one far more often than in all the home.
const REACH_M: f32 = 1.5;

/// Walls across one axis that are nearer to each other than this have one origin, metres: a wall between rooms has two
/// faces, and doors and furniture cut one face into several walls.
const ORIGIN_M: f32 = 0.15;

/// Two maps have the same wall up to this, metres, beyond what either knows: the relief of built walls, and how the maps are
/// bent.
const BENT_M: f32 = 0.02;

/// Logarithm of the odds that a kept wall that the robot drove through is gone: a door that was shut, a thing that was moved.
const CROSSED: f32 = -2.3;

/// Odds of elsewhere beforehand: that the robot stands in a home, or in a part of this one, that the map does not have.
const ELSEWHERE: f32 = 0.1;

/// How much worse elsewhere explains a match than the rest of the model says, nats. It takes walls of one origin for one and chance to be as near as the
/// reach; where both are at work they say some of the same. Over fourteen homes the best place of a search had modelled odds of 1 to
/// e^2 in 22 % of searches in the home's own map and in 0.25 % of those in another's: with the prior, odds of 900 to 1 that it is right, e^5.8 times as
/// high as modelled. Nearly two nats of that are left for homes that are not like those.
const CHANCE: f32 = 4.0;

/// Log-likelihood ratio of a fresh wall, `off_m` from a kept one that faces the same way and reaches along `overlap` of it, against
/// anything that stands anywhere.
pub(crate) fn of_wall(off_m: f32, variance_m2: f32, overlap: f32) -> f32 {
    let variance = variance_m2 + BENT_M * BENT_M;
    let density = libm::expf(-0.5 * off_m * off_m / variance) / libm::sqrtf(core::f32::consts::TAU * variance);
    libm::logf(1.0 - SAME + SAME * overlap * density * REACH_M)
}

/// The same of a fresh wall that no kept one explains.
pub(crate) fn of_nothing() -> f32 {
    libm::logf(1.0 - SAME)
}

/// How much each of a fresh map's walls counts, so that those of one origin together count as one: one that chance put on a kept one
/// brings the others with it.
pub(crate) fn weigh(fresh: &[Side], weights: &mut Vec<f32, FRESH_SIDES>) {
    weights.clear();
    for a in fresh {
        let is_of_it = |b: &&Side| a.axis() == b.axis() && (a.at_m - b.at_m).abs() < ORIGIN_M;
        // There is room for as many weights as walls.
        let _ = weights.push(1.0 / fresh.iter().filter(is_of_it).count().max(1) as f32);
    }
}

/// Precision of a wall's position against another map's, 1/m^2.
pub(crate) fn precision(variance_m2: f32) -> f32 {
    1.0 / (variance_m2 + BENT_M * BENT_M)
}

/// Log-likelihood of kept walls that were driven through.
pub(crate) fn of_crossings(count: usize) -> f32 {
    CROSSED * count as f32
}

/// Logarithm of the share of all places, in four rotations over so much floor (m^2), that is this one within what is known of
/// the shift (precisions, 1/m^2).
pub(crate) fn of_place(precisions: [f32; 2], floor_m2: f32) -> f32 {
    libm::logf(core::f32::consts::TAU / (libm::sqrtf(precisions[0] * precisions[1]) * 4.0 * floor_m2))
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
