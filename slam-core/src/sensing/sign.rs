//! Odometry without a sign: whether the robot drove backwards where its odometry says forwards.
//!
//! An encoder with one channel counts the same whichever way its wheel turns, and the odometry that is made of it says
//! forwards always. The ranges tell: while a robot drives forwards, a beam that points ahead gets shorter by what was
//! driven, and longer while it drives backwards. That takes no wall and no map. A surface that a beam meets at an angle goes its
//! own way row by row, so that one such surface alone does not decide.
//!
//! A robot turns round where it stands. So a stretch between two stops was driven one way as a whole, and which way is a
//! hidden Markov model with two states, of which the log odds are kept. Once they tell that a stretch goes the other way, the
//! pose is moved by twice what was driven since the stop, or since it was last settled. An odometry that once said backwards has a sign, and is believed.

use crate::geometry::angle::sin_cos;
use crate::motion::travel::Travel;
use crate::rig::{RangeModel, RangeSensor};
use crate::sample::RangeInput;

/// Probability that an odometry has no sign before anything tells, and the least that is left after any number of stretches.
const UNSIGNED: f32 = 0.02;
const LEAST_UNSIGNED: f32 = 1e-3;

/// Share of its stretches that such a robot drives backwards: out of corners and away from what it met.
const BACKWARDS_SHARE: f32 = 0.3;

/// A row slower than this may be a stop, metres per second: at five rows a second a robot that stops and goes on within one
/// is seen at half its speed.
const STOP_M_S: f32 = 0.1;

/// Probability that a robot stopped and turned round between two rows unseen.
const UNSEEN_STOP: f32 = 1e-3;

/// Backwards motion that no noise of standing wheels makes, metres together; single steps below the second are rounding.
const SIGN_M: f32 = 0.02;
const ROUNDING_M: f32 = 1e-3;

/// Ranges are compared over so much motion at least, metres, or radians: shorter steps are lost in their noise.
const ADVANCE_M: f32 = 0.04;
const ADVANCE_RAD: f32 = 0.1;

/// Beams within 60 degrees of the way tell, by their cosine.
const AHEAD_COS: f32 = 0.5;

/// Variance of a row's motion by its stamps, as a share of its square: rows five times a second whose stamps are off by 60 ms.
const STAMP_SHARE: f32 = 0.09;

/// Variance of how a surface's range changes, as a share of the motion's square and of the squared sine of the beam's angle
/// to it: of a normal that may stand anywhere up to 70 degrees from the beam, 0.7 rad 1-sigma.
const INCIDENCE_SHARE: f32 = 0.5;

/// What one surface tells is at most this over the sine of the beam's angle to the way, as log odds: how it stands is in all of
/// its rows. Of one that is met straight ahead that does not matter.
const MOST_OF_SURFACE: f32 = 1.5;

/// What one row tells is at most this, as log odds: its readings share the stamp, and the motion.
const MOST_OF_ROW: f32 = 3.0;

/// A range that changes by more than this many times what was driven, and by more than its noise and the beam's sweep, is of
/// another surface: 70 degrees from the beam it would change by three times that.
const SAME_SURFACE: f32 = 3.0;
const SIGMAS: f32 = 4.0;

/// Log odds of 95 % against 5 %.
const DECISION: f32 = 2.944_439;

/// Which way the robot drives, where its odometry may not know.
#[derive(Clone, Debug)]
pub struct Sign<const S: usize> {
    /// The stretch goes backwards where the odometry says forwards.
    pub is_reversed: bool,
    /// Displacement since the last stop, or since it was last settled which way the robot drives, as it is believed, in the frame of dead reckoning, metres.
    stretch_m: [f32; 2],
    is_moving: bool,
    /// Of backwards against forwards.
    log_odds: f32,
    /// Probability that the odometry has no sign.
    unsigned: f32,
    backwards_m: f32,
    /// What each beam met.
    surfaces: [Surface; S],
    /// Motion since ranges were last compared, as the odometry says it.
    forward_m: f32,
    turn_rad: f32,
}

/// A stretch that ended, in the frame of dead reckoning.
#[derive(Clone, Copy, Debug)]
pub struct Ended {
    /// By how much the position is to be moved, metres: the likelier way is taken in the end.
    pub moved_m: [f32; 2],
    /// 1-sigma vector of the position, metres: it may have been the other way after all, and the moments of both are kept.
    pub sigma_m: [f32; 2],
}

fn log_odds(probability: f32) -> f32 {
    libm::logf(probability / (1.0 - probability))
}

fn probability(log_odds: f32) -> f32 {
    1.0 / (1.0 + libm::expf(-log_odds))
}

impl<const S: usize> Sign<S> {
    /// The odometry has one. Every byte is zero.
    pub const TRUE: Self = Self {
        is_reversed: false,
        stretch_m: [0.0; 2],
        is_moving: false,
        log_odds: 0.0,
        unsigned: 0.0,
        backwards_m: 0.0,
        surfaces: [Surface::NONE; S],
        forward_m: 0.0,
        turn_rad: 0.0,
    };

    /// It is not known whether it has one.
    pub const UNKNOWN: Self = Self { unsigned: UNSIGNED, ..Self::TRUE };

    /// The probability that a stretch begins backwards.
    fn prior(&self) -> f32 {
        BACKWARDS_SHARE * self.unsigned
    }

    /// Takes in a row's motion as the odometry says it; what is left to say of a stretch that ends here.
    pub fn follow(&mut self, travel: &Travel, turn_rad: f32, dt_s: f32) -> Option<Ended> {
        if self.unsigned == 0.0 {
            return None;
        }
        let forward_m = travel.forward_m();
        self.backwards_m += if forward_m < -ROUNDING_M { -forward_m } else { 0.0 };
        if self.backwards_m > SIGN_M {
            *self = Self::TRUE;
            return None;
        }
        self.forward_m += forward_m;
        self.turn_rad += turn_rad;
        if forward_m.abs() < STOP_M_S * dt_s {
            return self.stop();
        }
        if !self.is_moving {
            self.is_moving = true;
            self.log_odds = log_odds(self.prior());
        }
        let backwards = probability(self.log_odds);
        let turned = UNSEEN_STOP * ((1.0 - backwards) * self.prior() - backwards);
        self.log_odds = log_odds(backwards + turned);
        None
    }

    /// Ends the stretch.
    fn stop(&mut self) -> Option<Ended> {
        if !self.is_moving {
            return None;
        }
        let backwards = probability(self.log_odds);
        // Bayes' rule for the odometry, by how much likelier backwards was than forwards.
        let ratio = libm::expf(self.log_odds - log_odds(self.prior()));
        let unsigned = self.unsigned * (1.0 - BACKWARDS_SHARE + BACKWARDS_SHARE * ratio);
        self.unsigned = (unsigned / (unsigned + 1.0 - self.unsigned)).clamp(LEAST_UNSIGNED, 1.0 - LEAST_UNSIGNED);
        let share = if (self.log_odds > 0.0) == self.is_reversed { 0.0 } else { -2.0 };
        // What is settled leaves no doubt: a chance in a hundred of half a metre is no normal error of five centimetres.
        let is_open = self.log_odds.abs() < DECISION;
        let spread = if is_open { 2.0 * libm::sqrtf(backwards * (1.0 - backwards)) } else { 0.0 };
        self.is_moving = false;
        self.is_reversed = false;
        let stretch_m = core::mem::take(&mut self.stretch_m);
        Some(Ended { moved_m: stretch_m.map(|m| share * m), sigma_m: stretch_m.map(|m| spread * m) })
    }

    /// The robot moved by so much in the frame of dead reckoning.
    pub fn moved(&mut self, by_m: [f32; 2]) {
        if self.is_moving {
            self.stretch_m = [self.stretch_m[0] + by_m[0], self.stretch_m[1] + by_m[1]];
        }
    }

    /// Takes in a row's ranges. Where they tell that the stretch goes the other way: by how much the position is to be moved,
    /// metres, in the frame of dead reckoning.
    pub fn tell(&mut self, sensors: &[RangeSensor], inputs: &[RangeInput]) -> Option<[f32; 2]> {
        let is_short = self.forward_m.abs() < ADVANCE_M && self.turn_rad.abs() < ADVANCE_RAD;
        if self.unsigned == 0.0 || (self.is_moving && is_short) {
            return None;
        }
        let (forward_m, turn_rad) = (core::mem::take(&mut self.forward_m), core::mem::take(&mut self.turn_rad));
        let mut told = 0.0;
        for ((sensor, input), surface) in sensors.iter().zip(inputs).zip(&mut self.surfaces) {
            if !self.is_moving {
                *surface = Surface::NONE;
            }
            told += surface.told_by(sensor, *input, forward_m, turn_rad);
        }
        if !self.is_moving {
            return None;
        }
        // Bounded, so that probabilities stay numbers between zero and one.
        self.log_odds = (self.log_odds + told.clamp(-MOST_OF_ROW, MOST_OF_ROW)).clamp(-15.0, 15.0);
        let is_other = if self.is_reversed { self.log_odds < -DECISION } else { self.log_odds > DECISION };
        self.is_reversed ^= is_other;
        let stretch_m = self.stretch_m;
        if self.log_odds.abs() > DECISION && self.is_reversed == (told > 0.0) {
            // What was driven up to here is settled.
            self.stretch_m = [0.0; 2];
        }
        is_other.then(|| stretch_m.map(|m| -2.0 * m))
    }
}

/// A surface that a beam has met for some rows.
#[derive(Clone, Copy, Debug)]
struct Surface {
    /// The last range, metres; zero where there is none.
    last_m: f32,
    /// What it has told since, as log odds of backwards against forwards.
    told: f32,
}

impl Surface {
    const NONE: Self = Self { last_m: 0.0, told: 0.0 };

    /// How much more it tells by a row's range and motion.
    fn told_by(&mut self, sensor: &RangeSensor, input: RangeInput, forward_m: f32, turn_rad: f32) -> f32 {
        let (sin, cos) = sin_cos(sensor.mount.bearing_rad);
        let (RangeModel::Metric { noise_m, noise_rel }, RangeInput::Metres(now_m)) = (sensor.model, input) else {
            *self = Self::NONE;
            return 0.0;
        };
        if !(now_m >= sensor.min_m && now_m <= sensor.max_m) || cos.abs() < AHEAD_COS {
            *self = Self::NONE;
            return 0.0;
        }
        let noise_m = noise_m + noise_rel * now_m;
        let swept_m = now_m * turn_rad;
        let change_m = now_m - self.last_m;
        let is_new =
            self.last_m == 0.0 || change_m.abs() > SAME_SURFACE * forward_m.abs() + swept_m.abs() + SIGMAS * noise_m;
        self.last_m = now_m;
        if is_new {
            self.told = 0.0;
            return 0.0;
        }
        let motion_m2 = forward_m * forward_m * (STAMP_SHARE + INCIDENCE_SHARE * sin * sin);
        let variance_m2 = 2.0 * noise_m * noise_m + swept_m * swept_m + motion_m2;
        let ratio = log_ratio(change_m, -forward_m * cos, variance_m2, sensor.span_m());
        let most = MOST_OF_SURFACE / sin.abs().max(1e-3);
        let told = (self.told + ratio).clamp(-most, most);
        told - core::mem::replace(&mut self.told, told)
    }
}

/// How much likelier this change of a range is of a robot that drove backwards than of one that drove forwards, as a
/// logarithm. Either is a normal density about what is expected or, as likely, anything that the sensor can read.
fn log_ratio(change_m: f32, forwards_m: f32, variance_m2: f32, span_m: f32) -> f32 {
    const INVERSE_SQRT_TAU: f32 = 0.398_942_3; // 1 / sqrt(2 pi)
    let density = |off_m: f32| {
        INVERSE_SQRT_TAU / libm::sqrtf(variance_m2) * libm::expf(-0.5 * off_m * off_m / variance_m2) + 1.0 / span_m
    };
    libm::logf(density(change_m + forwards_m) / density(change_m - forwards_m))
}
