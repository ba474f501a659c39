//! Odometry without a sign: whether the robot drove backwards where its odometry says forwards.
//!
//! An encoder with one channel counts the same whichever way its wheel turns, and the odometry that is made of it says
//! forwards always. The ranges tell: while a robot drives forwards, a beam that points ahead gets shorter by what was
//! driven, and longer while it drives backwards. By how much, the direction of the wall tells that the beam met; where it met none
//! of the map, a surface may stand anyhow and move by itself, so that one such surface alone does not decide. People who walk ahead
//! are no walls: while they say backwards, the walls beside them say forwards.
//!
//! A robot turns round where it stands. So a stretch between two stops was driven one way as a whole, and which way is a
//! hidden Markov model with two states, of which the log odds are kept: the slower a row, the likelier a stop in it. Once they tell
//! that a stretch goes the other way, the pose is moved by twice what was driven since the stop, or since it was last settled. An
//! odometry that once said backwards has a sign, and is believed.

use crate::motion::travel::Travel;
use crate::rig::{DriveModel, RangeSensor};
use crate::sample::RangeInput;
use crate::sensing::surface::{Motion, Surface};

/// Probability that a logged pose has no sign before anything tells. Of counted wheels, whose counts are to be signed, and after any
/// number of stretches the least is left.
const UNSIGNED: f32 = 0.02;
const LEAST_UNSIGNED: f32 = 1e-3;

/// Share of its stretches that such a robot drives backwards: out of corners and away from what it met.
const BACKWARDS_SHARE: f32 = 0.3;

/// A row slower than this is a stop, metres per second, and one that is not much faster may have one in it, 1-sigma: a robot that brakes
/// by a metre per second squared, turns round and speeds up again within a row of a fifth of a second is seen at 0.05 m/s, and at
/// twice that where the stamps are off by as much as rows are long.
const STOP_M_S: f32 = 0.1;

/// Probability that a robot stopped and turned round between two fast rows unseen.
const UNSEEN_STOP: f32 = 1e-3;

/// Backwards motion that no noise of standing wheels makes, metres together; single steps below the second are rounding.
const SIGN_M: f32 = 0.02;
const ROUNDING_M: f32 = 1e-3;

/// What one row tells is at most this, as log odds: its readings share the stamp, and the motion.
const MOST_OF_ROW: f32 = 3.0;

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
    /// Of backwards against forwards, and what they were when the stretch began.
    log_odds: f32,
    begun_at: f32,
    /// Probability that the odometry has no sign.
    unsigned: f32,
    backwards_m: f32,
    /// What each beam met.
    surfaces: [Surface; S],
    /// The row's motion, as the odometry says it, and how far the row before went, metres.
    forward_m: f32,
    turn_rad: f32,
    before_m: f32,
    /// Probability that the robot turned round where it stopped in this row; zero where it did not stop.
    stopping: f32,
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
        begun_at: 0.0,
        unsigned: 0.0,
        backwards_m: 0.0,
        surfaces: [Surface::NONE; S],
        forward_m: 0.0,
        turn_rad: 0.0,
        before_m: 0.0,
        stopping: 0.0,
    };

    /// It is not known whether the odometry of such a drive has one.
    pub fn unknown(drive: &DriveModel) -> Self {
        let unsigned = match drive {
            DriveModel::Wheels { .. } => LEAST_UNSIGNED,
            DriveModel::Odometry { .. } => UNSIGNED,
        };
        Self { unsigned, log_odds: log_odds(BACKWARDS_SHARE * unsigned), ..Self::TRUE }
    }

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
        (self.forward_m, self.turn_rad) = (forward_m, turn_rad);
        let stops_m = STOP_M_S * dt_s;
        let is_stop = forward_m.abs() < stops_m;
        let slow = forward_m / stops_m;
        let stopped = UNSEEN_STOP + (1.0 - UNSEEN_STOP) * libm::expf(-0.5 * slow * slow);
        // The ranges of the row in which a robot stops tell of how it came there: the stretch ends with the next one.
        let ended = if self.stopping > 0.0 { self.stop() } else { None };
        let is_stopping = is_stop && self.is_moving;
        let before = core::mem::replace(&mut self.stopping, if is_stopping { stopped } else { 0.0 });
        let turned = if is_stopping { 0.0 } else { stopped.max(before) };
        let backwards = probability(self.log_odds);
        self.log_odds = log_odds(backwards + turned * (self.prior() - backwards));
        if !is_stop && !self.is_moving {
            self.is_moving = true;
            self.begun_at = self.log_odds;
        }
        ended
    }

    /// Ends the stretch.
    fn stop(&mut self) -> Option<Ended> {
        if !self.is_moving {
            return None;
        }
        let backwards = probability(self.log_odds);
        // Bayes' rule for the odometry, by how much likelier backwards was than forwards.
        let ratio = libm::expf(self.log_odds - self.begun_at);
        let unsigned = self.unsigned * (1.0 - BACKWARDS_SHARE + BACKWARDS_SHARE * ratio);
        self.unsigned = (unsigned / (unsigned + 1.0 - self.unsigned)).clamp(LEAST_UNSIGNED, 1.0 - LEAST_UNSIGNED);
        let share = if (self.log_odds > 0.0) == self.is_reversed { 0.0 } else { -2.0 };
        // What is settled leaves no doubt: a chance in a hundred of half a metre is no normal error of five centimetres.
        let is_open = self.log_odds.abs() < DECISION;
        let spread = if is_open { 2.0 * float::sqrtf(backwards * (1.0 - backwards)) } else { 0.0 };
        self.is_moving = false;
        self.is_reversed = false;
        self.surfaces.iter_mut().for_each(Surface::begin);
        let stretch_m = core::mem::take(&mut self.stretch_m);
        Some(Ended { moved_m: stretch_m.map(|m| share * m), sigma_m: stretch_m.map(|m| spread * m) })
    }

    /// The robot moved by so much in the frame of dead reckoning.
    pub fn moved(&mut self, by_m: [f32; 2]) {
        if self.is_moving {
            self.stretch_m = [self.stretch_m[0] + by_m[0], self.stretch_m[1] + by_m[1]];
        }
    }

    /// A sensor met a wall whose normal has this direction in the robot's frame, radians.
    pub fn met(&mut self, sensor: usize, normal_rad: impl FnOnce() -> Option<f32>) {
        if self.unsigned > 0.0
            && let Some(surface) = self.surfaces.get_mut(sensor)
        {
            surface.meet(normal_rad());
        }
    }

    /// Takes in a row's ranges; all begin anew while the robot stands. Where they tell that the stretch goes the other way: by how much the position is to be moved,
    /// metres, in the frame of dead reckoning.
    pub fn tell(&mut self, sensors: &[RangeSensor], inputs: &[RangeInput]) -> Option<[f32; 2]> {
        if self.unsigned == 0.0 {
            return None;
        }
        let forward_m = core::mem::take(&mut self.forward_m);
        let before_m = core::mem::replace(&mut self.before_m, forward_m.abs());
        let longest_m = forward_m.abs().max(before_m);
        let motion = Motion { forward_m, turn_rad: core::mem::take(&mut self.turn_rad), longest_m };
        let (mut says, mut tells) = (0.0, [0.0; S]);
        let surfaces = self.surfaces.iter_mut().zip(&mut tells);
        for ((sensor, input), (surface, tells)) in sensors.iter().zip(inputs).zip(surfaces) {
            if !self.is_moving {
                *surface = Surface::NONE;
            }
            let said = surface.look(sensor, *input, &motion);
            *tells = said.more;
            says += said.at_rest;
        }
        if !self.is_moving {
            return None;
        }
        let told: f32 = tells.iter().sum();
        // Surfaces that have told all that they may go on to speak: one that says the other way is not heard against them.
        let [least, most] = [says.clamp(-MOST_OF_ROW, 0.0), says.clamp(0.0, MOST_OF_ROW)];
        let heard = told.max(least).min(most);
        let share = if told == 0.0 { 0.0 } else { heard / told };
        self.surfaces.iter_mut().zip(tells).for_each(|(surface, tells)| surface.hear(share * tells));
        // Bounded, so that probabilities stay numbers between zero and one.
        self.log_odds = (self.log_odds + heard).clamp(-15.0, 15.0);
        let is_other = if self.is_reversed { self.log_odds < -DECISION } else { self.log_odds > DECISION };
        self.is_reversed ^= is_other;
        let stretch_m = self.stretch_m;
        if self.log_odds.abs() > DECISION && self.is_reversed == (says > 0.0) {
            // What was driven up to here is settled.
            self.stretch_m = [0.0; 2];
        } else if is_other {
            self.stretch_m = stretch_m.map(|m| -m);
        }
        is_other.then(|| stretch_m.map(|m| -2.0 * m))
    }
}
