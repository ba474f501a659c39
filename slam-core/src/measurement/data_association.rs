//! Whether a reading that fits a wall is the wall's.
//!
//! A filter that knows little of where it is would take anything for the wall: a gate of so many of its standard deviations
//! is then as wide as a room, and one wrong reading makes it sure of a wrong pose. But the wider the gate, the likelier is
//! it that something else stands in it. So what counts is which is likelier: that the wall was met, or anything else within
//! the sensor's span, either as probable as the other beforehand. And a reading counts by the probability that it is the
//! wall's (Bar-Shalom and Tse 1975, probabilistic data association with one reading).

use crate::filter::density::INVERSE_SQRT_TAU;

/// A beam comes to something else, a wall's end, a chair or a door, once in so many metres that its middle moves.
const CHANGE_M: f32 = 0.75;

/// Least and greatest chance of that between two looks: people walk; and a change that is as likely as not tells nothing.
pub const CHANGES: (f32, f32) = (0.02, 0.6);

/// Chance that a beam whose middle moved by so much, metres, came to something else.
pub fn change(moved_m: f32) -> f32 {
    let (least, most) = CHANGES;
    (moved_m / CHANGE_M).clamp(least, most)
}

/// Odds that a reading is the wall's: the normal density of its innovation against the uniform one of what else may stand in
/// the sensor's span.
pub fn odds(innovation_m: f32, variance_m2: f32, span_m: f32) -> f32 {
    let square = innovation_m * innovation_m / variance_m2;
    INVERSE_SQRT_TAU * span_m / float::sqrtf(variance_m2) * libm::expf(-0.5 * square)
}

/// Noise with which an update with these odds has as much gain as its probability is worth, p = odds / (1 + odds):
/// `known / (known + noise + variance / odds)` is `p known / variance` for `variance = known + noise`.
pub fn noise_m2(noise_m2: f32, variance_m2: f32, odds: f32) -> f32 {
    noise_m2 + variance_m2 / odds
}
