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

use crate::geometry::angle::sin_cos;
use crate::motion::travel::Travel;
use crate::rig::{DriveModel, Mount, RangeModel, RangeSensor};
use crate::sample::RangeInput;

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

/// What one surface tells is at most this, as log odds: one in fifty moves by itself. Of one that fitted a wall of the map, one in a
/// thousand does.
const MOST_OF_SURFACE: f32 = 3.9;
const MOST_OF_WALL: f32 = 6.9;

/// How far the surface of a wall is from its line, metres.
const RELIEF_M: f32 = 0.01;

/// Least cosine of the incidence on a wall whose reading tells something.
const LEAST_COS: f32 = 0.3;

/// What one row tells is at most this, as log odds: its readings share the stamp, and the motion.
const MOST_OF_ROW: f32 = 3.0;

/// A range that changes by more than this many times what was driven, and by more than its noise and the beam's sweep, is of
/// another surface: one 70 degrees from the beam would change by three times that. One of a wall that is off by more than its noise either way is, too.
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
    /// Of backwards against forwards, and what they were when the stretch began.
    log_odds: f32,
    begun_at: f32,
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
        begun_at: 0.0,
        unsigned: 0.0,
        backwards_m: 0.0,
        surfaces: [Surface::NONE; S],
        forward_m: 0.0,
        turn_rad: 0.0,
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
        self.forward_m += forward_m;
        self.turn_rad += turn_rad;
        let stops_m = STOP_M_S * dt_s;
        let is_stop = forward_m.abs() < stops_m;
        let ended = if is_stop { self.stop() } else { None };
        let slow = forward_m / stops_m;
        let stopped = UNSEEN_STOP + (1.0 - UNSEEN_STOP) * libm::expf(-0.5 * slow * slow);
        let backwards = probability(self.log_odds);
        self.log_odds = log_odds(backwards + stopped * (self.prior() - backwards));
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

    /// A sensor met a wall whose normal has this direction in the robot's frame, radians.
    pub fn met(&mut self, sensor: usize, normal_rad: impl FnOnce() -> Option<f32>) {
        if self.unsigned > 0.0
            && let Some(surface) = self.surfaces.get_mut(sensor)
        {
            surface.normal_rad = normal_rad();
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
        let (mut says, mut tells) = (0.0, [0.0; S]);
        let surfaces = self.surfaces.iter_mut().zip(&mut tells);
        for ((sensor, input), (surface, tells)) in sensors.iter().zip(inputs).zip(surfaces) {
            if !self.is_moving {
                *surface = Surface::NONE;
            }
            let ratio = surface.look(sensor, *input, forward_m, turn_rad);
            *tells = surface.more(ratio);
            says += ratio;
        }
        if !self.is_moving {
            return None;
        }
        let told: f32 = tells.iter().sum();
        // Surfaces that have told all that they may go on to speak: one that says the other way is not heard against them.
        let [least, most] = [says.clamp(-MOST_OF_ROW, 0.0), says.clamp(0.0, MOST_OF_ROW)];
        let heard = told.max(least).min(most);
        let share = if told == 0.0 { 0.0 } else { heard / told };
        self.surfaces.iter_mut().zip(tells).for_each(|(surface, tells)| surface.told += share * tells);
        // Bounded, so that probabilities stay numbers between zero and one.
        self.log_odds = (self.log_odds + share * told).clamp(-15.0, 15.0);
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

/// A surface that a beam has met for some rows.
#[derive(Clone, Copy, Debug)]
struct Surface {
    /// The last range, metres; zero where there is none.
    last_m: f32,
    /// What it has told since, as log odds of backwards against forwards.
    told: f32,
    /// Direction of the normal of the wall that it is, either way, in the robot's frame, radians.
    normal_rad: Option<f32>,
}

/// How a range should change.
struct Change {
    /// What it would be had the robot only turned, metres.
    turned_m: f32,
    /// By how much more it changes forwards, metres.
    forwards_m: f32,
    /// Variance of both, m^2, without the reading's own noise.
    variance_m2: f32,
    /// By more than this it is another surface, beside the noise, metres.
    most_m: f32,
}

impl Surface {
    const NONE: Self = Self { last_m: 0.0, told: 0.0, normal_rad: None };

    /// What a row's range and motion say, as log odds of backwards against forwards, whatever it told before.
    fn look(&mut self, sensor: &RangeSensor, input: RangeInput, forward_m: f32, turn_rad: f32) -> f32 {
        let (RangeModel::Metric { noise_m, noise_rel }, RangeInput::Metres(now_m)) = (sensor.model, input) else {
            *self = Self::NONE;
            return 0.0;
        };
        if !(now_m >= sensor.min_m && now_m <= sensor.max_m) {
            *self = Self::NONE;
            return 0.0;
        }
        let before = core::mem::replace(self, Self { last_m: now_m, ..Self::NONE });
        let change = match before.normal_rad {
            Some(normal_rad) => before.change_of_wall(&sensor.mount, normal_rad, forward_m, turn_rad),
            None => before.change(&sensor.mount, now_m, forward_m, turn_rad),
        };
        let Some(change) = change else { return 0.0 };
        let noise_m = noise_m + noise_rel * now_m;
        let variance_m2 = 2.0 * noise_m * noise_m + change.variance_m2;
        let off_m = now_m - change.turned_m;
        let sigma_m = if before.normal_rad.is_some() { libm::sqrtf(variance_m2) } else { noise_m };
        if off_m.abs() > change.most_m + SIGMAS * sigma_m {
            return 0.0;
        }
        *self = Self { last_m: now_m, normal_rad: before.normal_rad.map(|rad| rad - turn_rad), ..before };
        log_ratio(off_m, change.forwards_m, variance_m2, sensor.span_m())
    }

    /// By how much that changes what it tells.
    fn more(&self, says: f32) -> f32 {
        let most = if self.normal_rad.is_some() { MOST_OF_WALL } else { MOST_OF_SURFACE };
        (self.told + says).clamp(-most, most) - self.told
    }

    /// Of a surface that may stand anyhow, seen now at this range.
    fn change(&self, mount: &Mount, now_m: f32, forward_m: f32, turn_rad: f32) -> Option<Change> {
        let (sin, cos) = sin_cos(mount.bearing_rad);
        if self.last_m == 0.0 || cos.abs() < AHEAD_COS {
            return None;
        }
        let swept_m = now_m * turn_rad;
        let share = STAMP_SHARE + INCIDENCE_SHARE * sin * sin;
        Some(Change {
            turned_m: self.last_m,
            forwards_m: -forward_m * cos,
            variance_m2: swept_m * swept_m + forward_m * forward_m * share,
            most_m: SAME_SURFACE * forward_m.abs() + swept_m.abs(),
        })
    }

    /// Of a wall with this normal. The robot moves and then turns.
    fn change_of_wall(&self, mount: &Mount, normal_rad: f32, forward_m: f32, turn_rad: f32) -> Option<Change> {
        let (sin, cos) = sin_cos(normal_rad);
        let before_cos = sin_cos(normal_rad - mount.bearing_rad).1;
        let (now_sin, now_cos) = sin_cos(normal_rad - turn_rad - mount.bearing_rad);
        if before_cos.abs() < LEAST_COS || now_cos.abs() < LEAST_COS {
            return None;
        }
        // The turn takes a sensor along that is not on the axle's centre.
        let beside_m = self.last_m * before_cos - turn_rad * (sin * mount.x_m - cos * mount.y_m);
        let (turned_m, forwards_m) = (beside_m / now_cos, -forward_m * cos / now_cos);
        let swept_m = turned_m * turn_rad * now_sin / now_cos;
        let variance_m2 = RELIEF_M * RELIEF_M + STAMP_SHARE * (forwards_m * forwards_m + swept_m * swept_m);
        Some(Change { turned_m, forwards_m, variance_m2, most_m: forwards_m.abs() })
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
