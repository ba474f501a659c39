//! What a sensor puts out beside what it did: its range, whether that is another one, and where the robot has turned to since.

use crate::geometry::pose::Pose;
use crate::holds::stillness::{CHANGED, LOOK_RAD, Look, NEAR, SWING_M, log_odds};
use crate::jolts::confirmation::SURE;
use crate::measurement::data_association::change;
use crate::measurement::sensor::Sensor;
use crate::motion::step::MIDDLE_M;
use crate::rig::{RangeModel, RangeSensor, Rig};
use crate::sample::RangeInput;
use core::f32::consts::{PI, TAU};

/// Log odds from which on outputs that repeat are none of a live sensor: once in 250 hours of cleaning beforehand, in which eight sensors put
/// out 1.4e8, and twenty to one after.
const REPEATED: f32 = 18.8 + SURE;

/// Units in which headings, radians, ranges and positions, metres, and log odds are kept, in eight bytes a sensor.
pub(super) const PER_RAD: f32 = 256.0 / TAU;
pub(super) const PER_M: f32 = 4000.0;
pub(super) const PER_M_DRIVEN: f32 = 100.0;
pub(super) const PER_M_OFF: f32 = 250.0;
pub(super) const PER_NAT: f32 = 12.0;

/// So far a look is from the one before, and from the first at most, units: beyond that a wall that was met at right angles is met at none.
pub(super) const LOOK: u8 = (PER_RAD * LOOK_RAD) as u8 + 1;
pub(super) const FARTHEST: u8 = 50;

/// A robot turns on the spot where it drives no farther than such a share of the way of what it turns past, and this, metres.
pub(super) const SPOT: f32 = 0.5;
pub(super) const SPOT_M: f32 = 0.02;

/// What a sensor read since its output last changed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    /// The range that is to stay, none where that is zero: the first one since anything spoke for it.
    pub(super) first: u16,
    /// The position and the heading from which looks are taken, by the wheels.
    pub(super) at: [u8; 2],
    pub(super) heading: u8,
    /// From there, the heading of the last look, none where that is zero, and by how much its range differed.
    pub(super) last_at: i8,
    pub(super) last_off: i8,
    /// What it says for being frozen, as log odds.
    pub(super) says: u8,
}

/// What a sensor's output is seen by.
pub struct View<'a, const S: usize> {
    /// The robot.
    pub rig: &'a Rig<S>,
    /// How much larger the variance of outputs is than stated, and the same where it is less.
    pub noise: f32,
    pub true_noise: f32,
    /// The pose by the wheels alone, which nothing holds, and the length of the path, metres.
    pub wheels: &'a Pose,
    pub path_m: f32,
    /// The reading met the wall that the map has there.
    pub fits: bool,
}

/// Whether the output of an analogue sensor hardly changes with the range, or folds back: it stays though what is seen does not.
pub(super) fn is_near(limits: &RangeSensor, range_m: f32) -> bool {
    matches!(limits.model, RangeModel::Sharp { .. }) && range_m < NEAR * limits.min_m
}

/// How far a range is from the one that is to stay, metres.
pub(super) fn off_m(range_m: f32, first: u16) -> f32 {
    range_m - f32::from(first) * (1.0 / PER_M)
}

/// Whether a range, metres, of this variance, m^2, is another one than that which is to stay.
pub(super) fn is_another((range_m, noise_m2): (f32, f32), first: u16) -> bool {
    let beyond_m = off_m(range_m, first).abs() - SWING_M;
    beyond_m > 0.0 && beyond_m * beyond_m > CHANGED * CHANGED * 2.0 * noise_m2
}

impl<const S: usize> View<'_, S> {
    /// The range that an output says, within the sensor's limits or not, metres, and its variance, m^2; none where it says none.
    pub(super) fn range(&self, limits: &RangeSensor, input: RangeInput) -> Option<(f32, f32)> {
        match (input, &limits.model, &self.rig.adc) {
            (RangeInput::Counts(counts), &RangeModel::Sharp { scale_m, exponent, noise_v }, Some(adc))
                if counts > 0 =>
            {
                let volts = adc.volts(counts);
                let range_m = scale_m * float::powf(volts, exponent);
                let sigma_m = exponent * range_m / volts * noise_v;
                Some((range_m, self.noise * sigma_m * sigma_m))
            }
            (RangeInput::Metres(range_m), &RangeModel::Metric { noise_m, noise_rel }, _) => {
                Some((range_m, noise_m * noise_m + noise_rel * noise_rel * range_m * range_m))
            }
            _ => None,
        }
    }

    /// Whether an analogue sensor's output repeats as that of a live one does not: the difference of two outputs that do, but for a
    /// count, is one of three among those that their noise spreads over, 2 sqrt(pi) of its standard deviations.
    pub(super) fn repeats(&self, sensor: &Sensor) -> bool {
        let repeats = sensor.state.front_end.repeats();
        let (&RangeModel::Sharp { noise_v, .. }, Some(adc), true) = (&sensor.limits.model, &self.rig.adc, repeats > 3)
        else {
            return false;
        };
        let spread = 2.0 * float::sqrtf(PI * self.true_noise.min(1.0)) * noise_v / adc.volts(1);
        f32::from(repeats) * libm::logf(spread * (1.0 / 3.0)) > REPEATED
    }

    pub(super) fn heading(&self) -> u8 {
        (PER_RAD * self.wheels.theta_rad) as i32 as u8
    }

    pub(super) fn at(&self) -> [u8; 2] {
        [self.wheels.x_m, self.wheels.y_m].map(|m| (PER_M_DRIVEN * m) as i32 as u8)
    }
}

impl Kept {
    /// Whether the range that is to stay is so near that the output hardly changes with it.
    pub(super) fn was_near(&self, limits: &RangeSensor) -> bool {
        is_near(limits, f32::from(self.first) * (1.0 / PER_M))
    }

    /// Turned since looks are taken from here.
    pub(super) fn turned<const S: usize>(&self, view: &View<S>) -> i8 {
        view.heading().wrapping_sub(self.heading) as i8
    }

    /// Whether the robot turned on the spot since, what is seen being so far from its axle, metres. Of one that drives meanwhile nothing is
    /// told: it may follow what it sees.
    pub(super) fn is_on_spot<const S: usize>(&self, from_m: f32, view: &View<S>) -> bool {
        let turned = f32::from(self.turned(view).unsigned_abs());
        self.driven_m(view.at()) <= SPOT_M + SPOT * from_m * turned * (1.0 / PER_RAD)
    }

    /// Whether this is a look farther than the last one.
    pub(super) fn is_look(&self, now: i8) -> bool {
        now.abs_diff(self.last_at) >= LOOK && now.unsigned_abs() > self.last_at.unsigned_abs()
    }

    /// How far the robot is from where looks are taken from, metres: no less than along one axis, which at worst is two thirds of it.
    pub(super) fn driven_m(&self, [x, y]: [u8; 2]) -> f32 {
        let along = |now: u8, then: u8| (now.wrapping_sub(then) as i8).unsigned_abs();
        f32::from(along(x, self.at[0]).max(along(y, self.at[1]))) * (1.0 / PER_M_DRIVEN)
    }

    /// Log odds of a sensor that is frozen against one that sees a surface, by a look after the robot turned on the spot: as if it were held,
    /// but what it would see out of the sensor's reach tells, too.
    pub(super) fn log_odds(&self, now: i8, seen: Seen, limits: &RangeSensor) -> f32 {
        let Seen { range_m, off_m, variance_m2, from_m } = seen;
        let [now_rad, last_rad] = [now, self.last_at].map(|at| f32::from(at) * (1.0 / PER_RAD));
        let turn_rad = (now_rad - last_rad).abs();
        if self.last_at == 0 {
            // The slope of the surface may be any. A range that stays may be its foot, one that does not is none of a sensor that is frozen.
            let slope_m = from_m * now_rad;
            let moves = (off_m, variance_m2 + slope_m * slope_m, change(MIDDLE_M * turn_rad));
            return log_odds(moves, (off_m, variance_m2), limits.span_m()).min(0.0);
        }
        let last_m = f32::from(self.last_off) * (1.0 / PER_M_OFF);
        Look { now_rad, last_rad, turn_rad, range_m, off_m, last_m, variance_m2, from_m, limits }.log_odds(false)
    }
}

/// A range that stayed: itself, how far it is from the first, metres, with its variance, m^2, and how far what is seen is from the middle of a
/// turn on the spot, metres.
pub(super) struct Seen {
    pub(super) range_m: f32,
    pub(super) off_m: f32,
    pub(super) variance_m2: f32,
    pub(super) from_m: f32,
}
