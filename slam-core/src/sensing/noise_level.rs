//! How large the errors are, as factors of the variances that the rig states.
//!
//! A rig file says what its writer thought: a laser's data sheet, a guess at the floor. What there is shows in the
//! innovations: their squares are, on average, the variance that the filter expects of them. Where they are not, the factors
//! of the noise of readings and of motion move towards what makes the innovations likeliest, by recursive scoring (Mehra
//! 1970 for the principle; the score of a normal distribution's log-variance). A reading counts by the probability that it
//! is its wall's, and as one of as many as say the same.
//!
//! The noise of readings that is learned here is that of the innovation: what the next reading will differ by, which decides
//! whose it is. What it is worth to the filter stays what the rig states and more, since readings of one stretch of wall
//! are off together ([`crate::sensing::correlation`]).

use crate::rig::DriveModel;

/// A factor's limits, and the information on its logarithm before any reading.
pub struct Prior {
    /// Least and greatest factor.
    pub limits: [f32; 2],
    /// As [`Level::learn`] counts it.
    pub information: f32,
}

/// Information on the logarithm of a factor before any reading: a factor of 1.7 either
/// way, 1-sigma. On the logs of docs/notes/real-logs.md 6 to 8 do as well.
const INFORMATION: f32 = 7.0;

/// Most information: what is older than some 500 readings of different places fades.
const MOST: f32 = 100.0;

/// One innovation changes a factor by no more than half of it.
const LARGEST_CHANGE: f32 = 0.5;

/// A rig file overstates variances by no more than 20, and does not understate them. What is larger is other surfaces' doing: a factor
/// above one widens the gate that lets their readings in, and these raise it further. Of the logs of docs/notes/real-logs.md only the
/// drone's two flights went above one; in smcl-S8, among short walls and openings, to as much as was allowed within 70 s.
const PRIOR: Prior = Prior { limits: [0.05, 1.0], information: INFORMATION };

/// A factor of a variance.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// The factor less one.
    above: f32,
    information: f32,
}

impl Level {
    /// As stated.
    pub const STATED: Self = Self { above: 0.0, information: 0.0 };

    /// The factor.
    pub fn factor(&self) -> f32 {
        1.0 + self.above
    }

    /// One innovation: its square was larger than its variance by the share `excess`, its variance grows by the share
    /// `sensitivity` when the factor does.
    pub fn learn(&mut self, excess: f32, sensitivity: f32, weight: f32, prior: &Prior) {
        self.information = (self.information + weight * sensitivity * sensitivity).min(MOST);
        let change = weight * sensitivity * excess / (prior.information + self.information);
        let factor = self.factor() * (1.0 + change.clamp(-LARGEST_CHANGE, LARGEST_CHANGE));
        let [least, most] = prior.limits;
        self.above = factor.max(least).min(most) - 1.0;
    }
}

/// An innovation, and what its variance is made of.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    /// Measured minus predicted, metres.
    pub innovation_m: f32,
    /// Its variance, m^2.
    pub variance_m2: f32,
    /// The part of the variance that is the reading's own noise, m^2.
    pub noise_m2: f32,
    /// The part that the heading alone would make, m^2.
    pub heading_m2: f32,
}

/// The factors of one robot in one home.
#[derive(Clone, Copy, Debug)]
pub struct NoiseLevels {
    /// Of readings.
    pub readings: Level,
    /// Of the position in motion.
    pub position: Level,
    /// Of the heading in motion.
    heading: Level,
}

impl NoiseLevels {
    /// As stated.
    pub const STATED: Self = Self { readings: Level::STATED, position: Level::STATED, heading: Level::STATED };

    /// Takes note of an innovation that counts as `weight` of one.
    pub fn note(&mut self, expected: &Expected, weight: f32) {
        let Expected { innovation_m, variance_m2, noise_m2, heading_m2 } = *expected;
        let excess = innovation_m * innovation_m / variance_m2 - 1.0;
        if !excess.is_finite() {
            return;
        }
        self.readings.learn(excess, noise_m2 / variance_m2, weight, &PRIOR);
        // In the balance of prediction and update the variance of the state grows as the root of the motion's noise.
        self.position.learn(excess, 0.5 * (1.0 - noise_m2 / variance_m2), weight, &PRIOR);
        self.heading.learn(excess, 0.5 * (heading_m2 / variance_m2).min(1.0), weight, &PRIOR);
    }

    /// The covariance of (forward, left, turn) at these levels. What slips is allowed for in the position only: the heading of
    /// wheels that are counted is as noisy as the rig states, while who logs poses guessed at it.
    pub fn of_motion(&self, stated: &[[f32; 3]; 3], drive: &DriveModel) -> [[f32; 3]; 3] {
        let is_stated = matches!(drive, DriveModel::Wheels { .. });
        let heading = if is_stated { 1.0 } else { float::sqrtf(self.heading.factor()) };
        let position = float::sqrtf(self.position.factor());
        let roots = [position, position, heading];
        core::array::from_fn(|i| core::array::from_fn(|j| roots[i] * roots[j] * stated[i][j]))
    }
}
