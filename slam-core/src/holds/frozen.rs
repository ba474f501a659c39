//! Sensors that are frozen: what they say stays as it is, whatever is before them. A driver hangs, a line breaks, a lens is covered.
//!
//! Two things tell. The noise of an analogue sensor is many counts of its converter, so that an output which repeats to the
//! count is none of a live one, moved or not ([`Repeats`]). And the range to a surface stays the same while the robot moves only where the
//! surface lies so that it can: of all planes through what was seen first, that of the slope for which it does. A look at it is a likelihood
//! ratio of an output that stays and of a surface:
//!
//! - a quarter of a radian after the one before, for two looks tell the slope, and the third where the range should be (the one
//!   for a robot that is held, [`Look`]);
//! - or so far ahead that a surface of that slope would be seen at an incidence at which the sensor sees nothing: a robot that drives
//!   at what it sees comes nearer, however that lies.
//!
//! One look alone says little, for what is seen may go with the robot, and they are summed (Page 1954) until the output changes. What tells a
//! frozen sensor from a held robot are the others: a look counts only where as many of them changed of late as stayed.
//!
//! A range that goes with the robot (its own body, a thing that it pushes) is as good as frozen: no wall is to be drawn of it.

use crate::geometry::angle::sin_cos;
use crate::geometry::pose::Pose;
use crate::holds::stillness::{CHANGED, LOOK_RAD, Look, SWING_M, log_odds};
use crate::jolts::confirmation::SURE;
use crate::measurement::data_association::change;
use crate::measurement::sensor::Sensor;
use crate::motion::step::MIDDLE_M;
use crate::rig::{RangeModel, RangeSensor, Rig};
use crate::sample::RangeInput;
use crate::sensing::range::SURFACE_M;
use core::f32::consts::{PI, TAU};

/// Log odds from which on a sensor is frozen: once in 250 hours of cleaning beforehand, with four thousand looks in each, and twenty to one
/// after.
const FROZEN: f32 = 13.8 + SURE;

/// And by outputs that repeat: of eight sensors there are a hundred and sixty in a second, 1.4e8 in that time.
const REPEATED: f32 = 18.8 + SURE;

/// What one look says of an output that changes: it is as seldom that one that is frozen does so as that a wall does not.
const ONE_LOOK: f32 = 3.9;

/// A sensor that is as likely frozen as twenty to one, over motion that others confirmed, says nothing of a hold.
const SUSPECT: f32 = SURE;

/// It says so much at most: five looks that changed show that it sees again.
const MOST: f32 = 5.0 * ONE_LOOK;

/// Of a robot that moves at least two others are to have changed; one whose reading then met the wall that the map has there counts for two.
const OTHERS: u32 = 2;

/// What changed is of late for once to twice such a way of the beams' middles, metres.
const LATELY_M: f32 = 0.25;

/// What is ahead is looked at anew where it should be nearer by so much at least, metres: more than the noise of most sensors.
const AHEAD_M: f32 = 0.12;

/// A robot that drove so far, metres, sees another place: the first look is there.
const ELSEWHERE_M: f32 = 0.5;

/// Units in which headings, radians, ranges and positions, metres, and log odds are kept, in eight bytes a sensor.
const PER_RAD: f32 = 256.0 / TAU;
const PER_M: f32 = 4000.0;
const PER_M_DRIVEN: f32 = 100.0;
const PER_NAT: f32 = 12.0;

/// So far a look is from the one before, and from the first at most, units: beyond that it begins anew.
const LOOK: i16 = (PER_RAD * LOOK_RAD) as i16 + 1;
const FARTHEST: u8 = 100;

/// A robot that turned by no more than this, units, drove straight: half a radian.
const STRAIGHT: u8 = 20;

/// What a sensor read since its output last changed.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// The first range, none where that is zero.
    first: u16,
    /// The position and the heading then, by the wheels.
    at: [u8; 2],
    heading: u8,
    /// From there, the heading of the last look, which is the farthest to its side, and of the one farthest to the other.
    last_at: i8,
    other_at: i8,
    /// What it says for being frozen, as log odds.
    says: u8,
}

/// Which sensors changed, a bit each.
#[derive(Clone, Copy, Debug)]
struct Changes {
    changed: u16,
    /// Of these, those that then met the wall that the map has there.
    fitted: u16,
}

/// Which sensors are frozen, and what speaks for it. Each is looked at in its turn, one a step.
#[derive(Clone, Debug)]
pub struct Frozen<const S: usize> {
    kept: [Kept; S],
    /// Since when changes are the latest: the length of the path, metres, and the heading.
    since_m: f32,
    /// The latest changes and those before.
    changes: [Changes; 2],
    /// Sensors that stayed at their last look, that say more than one look can, and that are frozen, a bit each.
    stayed: u16,
    suspects: u16,
    frozen: u16,
    since_heading: u8,
    /// Index of the one whose turn it is.
    turn: u8,
}

/// What a sensor's output is seen by.
pub struct View<'a, const S: usize> {
    /// The robot.
    pub rig: &'a Rig<S>,
    /// How much larger the variance of outputs is than stated, and the same where it is less.
    pub noise: f32,
    pub true_noise: f32,
    /// The motion of this step, in the robot's frame.
    pub motion: &'a Pose,
    /// The pose by the wheels alone, which nothing holds, and the length of the path, metres.
    pub wheels: &'a Pose,
    pub path_m: f32,
    /// The reading met the wall that the map has there.
    pub fits: bool,
}

impl<const S: usize> Frozen<S> {
    /// None, and nothing was read.
    pub const NONE: Self = Self {
        kept: [Kept { first: 0, at: [0; 2], heading: 0, last_at: 0, other_at: 0, says: 0 }; S],
        since_m: 0.0,
        changes: [Changes::NONE; 2],
        stayed: 0,
        suspects: 0,
        frozen: 0,
        since_heading: 0,
        turn: 0,
    };

    /// Sensors that are frozen, a bit each.
    pub fn sensors(&self) -> u16 {
        self.frozen
    }

    /// Sensors that stayed the same over motion that others confirmed, a bit each.
    pub fn suspects(&self) -> u16 {
        self.suspects
    }

    /// Index of the next of so many sensors that is to be looked at.
    pub fn next(&mut self, sensors: usize) -> usize {
        self.turn += 1;
        if usize::from(self.turn) >= sensors {
            self.turn = 0;
        }
        self.turn.into()
    }

    /// Looks at what a sensor says; whether it was found frozen just now.
    pub fn look(&mut self, sensor: &Sensor, input: RangeInput, view: &View<S>) -> bool {
        self.age(view);
        let Some(kept) = self.kept.get(sensor.index) else { return false };
        let (bit, first) = (1 << (sensor.index & 15), kept.first);
        let was_frozen = self.frozen & bit != 0;
        match view.range(sensor.limits, input) {
            _ if input == RangeInput::Missing => {}
            Some(range) if first > 0 => self.weigh(sensor, range, view),
            Some((range_m, _)) => self.begin(sensor.index, range_m, view),
            None => {
                // What was well within its reach has gone.
                let has_gone = f32::from(first) * (1.0 + LOOK_RAD) < PER_M * sensor.limits.max_m;
                self.stayed &= !bit;
                if first > 0 {
                    self.change(sensor.index, has_gone, false);
                }
            }
        }
        !was_frozen && self.frozen & bit != 0
    }

    /// What changed is not of late for ever.
    fn age(&mut self, view: &View<S>) {
        let turned = view.heading().wrapping_sub(self.since_heading) as i8;
        let moved_m = view.path_m - self.since_m + (MIDDLE_M / PER_RAD) * f32::from(turned.unsigned_abs());
        if !(0.0..LATELY_M).contains(&moved_m) {
            (self.since_m, self.since_heading) = (view.path_m, view.heading());
            self.changes = [Changes::NONE, self.changes[0]];
        }
    }

    /// The first look at what a sensor sees is here.
    #[inline(never)]
    fn begin(&mut self, index: usize, range_m: f32, view: &View<S>) {
        let Some(kept) = self.kept.get_mut(index) else { return };
        *kept = Kept {
            first: (PER_M * range_m) as u16,
            at: view.at(),
            heading: view.heading(),
            last_at: 0,
            other_at: 0,
            says: kept.says,
        };
    }

    /// A sensor's output is another one: whether that shows that the robot moves, and moves as it seems to.
    #[inline(never)]
    fn change(&mut self, index: usize, is_seen: bool, fits: bool) {
        let Some(kept) = self.kept.get_mut(index) else { return };
        let bit = 1 << (index & 15);
        kept.first = 0;
        kept.says = if self.frozen & bit != 0 { kept.says.saturating_sub((PER_NAT * ONE_LOOK) as u8) } else { 0 };
        if kept.says == 0 {
            (self.frozen, self.suspects) = (self.frozen & !bit, self.suspects & !bit);
        }
        self.stayed &= !bit;
        let [latest, _] = &mut self.changes;
        latest.changed |= if is_seen { bit } else { 0 };
        latest.fitted |= if is_seen && fits { bit } else { 0 };
    }

    /// Whether the others show that the robot moves.
    fn is_told(&self) -> bool {
        let [latest, before] = self.changes;
        let but = !(self.frozen | self.stayed);
        let (changed, fitted) = ((latest.changed | before.changed) & but, (latest.fitted | before.fitted) & but);
        let changed = changed.count_ones();
        changed + fitted.count_ones() >= OTHERS && changed >= (self.stayed & !self.frozen).count_ones()
    }

    /// Weighs a range, metres, of this variance, m^2.
    fn weigh(&mut self, sensor: &Sensor, (range_m, noise_m2): (f32, f32), view: &View<S>) {
        let Some(kept) = self.kept.get(sensor.index).copied() else { return };
        let off_m = range_m - f32::from(kept.first) * (1.0 / PER_M);
        let variance_m2 = 2.0 * noise_m2;
        let beyond_m = off_m.abs() - SWING_M;
        if beyond_m > 0.0 && beyond_m * beyond_m > CHANGED * CHANGED * variance_m2 {
            self.change(sensor.index, true, view.fits);
            self.begin(sensor.index, range_m, view);
            return;
        }
        let is_frozen = self.frozen >> (sensor.index & 15) & 1 != 0;
        if !is_frozen && view.repeats(sensor) {
            self.say(sensor.index, MOST);
            return;
        }
        let looked = Looked { range_m, off_m, variance_m2, sensor };
        let [dx, dy] = kept.driven_m(view.at());
        let now = view.heading().wrapping_sub(kept.heading) as i8;
        let (driven_m2, beyond) = (dx * dx + dy * dy, kept.beyond(now));
        let ahead = if driven_m2 > AHEAD_M * AHEAD_M { looked.ahead([dx, dy], kept.heading, now) } else { None };
        if ahead.is_none() && beyond < LOOK && driven_m2 < ELSEWHERE_M * ELSEWHERE_M {
            return;
        }
        let is_elsewhere = driven_m2 > ELSEWHERE_M * ELSEWHERE_M || now.unsigned_abs() > FARTHEST;
        if ahead.is_some() || beyond >= LOOK {
            self.stayed |= 1 << (sensor.index & 15);
            let tells = ahead.is_some() || kept.last_at != 0;
            if !tells || self.is_told() {
                let says = ahead.unwrap_or_else(|| looked.turned(&kept, now, view.motion));
                self.say(sensor.index, says);
            } else if !is_elsewhere {
                // The look is put off until others show that the robot moves.
                return;
            }
        }
        if ahead.is_some() || is_elsewhere {
            self.begin(sensor.index, range_m, view);
        } else if let Some(kept) = self.kept.get_mut(sensor.index) {
            let (least, most) = kept.seen();
            kept.other_at = if now > most { least } else { most };
            kept.last_at = now;
        }
    }

    /// A sensor says so much more for being frozen, as log odds.
    #[inline(never)]
    fn say(&mut self, index: usize, more: f32) {
        let Some(kept) = self.kept.get_mut(index) else { return };
        let says = (f32::from(kept.says) + PER_NAT * more).clamp(0.0, PER_NAT * MOST);
        kept.says = says as u8;
        let bit = 1 << (index & 15);
        self.suspects |= if says > PER_NAT * SUSPECT { bit } else { 0 };
        self.frozen |= if says > PER_NAT * FROZEN { bit } else { 0 };
    }
}

impl Changes {
    const NONE: Self = Self { changed: 0, fitted: 0 };
}

impl<const S: usize> View<'_, S> {
    /// The range that an output says, metres, and its variance, m^2; none where the sensor sees nothing within its limits.
    fn range(&self, limits: &RangeSensor, input: RangeInput) -> Option<(f32, f32)> {
        let (range_m, noise_m2) = match (input, &limits.model, &self.rig.adc) {
            (RangeInput::Counts(counts), &RangeModel::Sharp { scale_m, exponent, noise_v }, Some(adc))
                if counts > 0 =>
            {
                let volts = adc.volts(counts);
                let range_m = scale_m * libm::powf(volts, exponent);
                let sigma_m = exponent * range_m / volts * noise_v;
                (range_m, self.noise * sigma_m * sigma_m)
            }
            (RangeInput::Metres(range_m), &RangeModel::Metric { noise_m, noise_rel }, _) => {
                (range_m, noise_m * noise_m + noise_rel * noise_rel * range_m * range_m)
            }
            _ => return None,
        };
        (limits.min_m..=limits.max_m).contains(&range_m).then_some((range_m, noise_m2))
    }

    /// Whether an analogue sensor's output repeats as that of a live one does not: the difference of two outputs that do, but for a
    /// count, is one of three among those that their noise spreads over, 2 sqrt(pi) of its standard deviations.
    fn repeats(&self, sensor: &Sensor) -> bool {
        let repeats = sensor.state.front_end.repeats();
        let (&RangeModel::Sharp { noise_v, .. }, Some(adc), true) = (&sensor.limits.model, &self.rig.adc, repeats > 3)
        else {
            return false;
        };
        let spread = 2.0 * libm::sqrtf(PI * self.true_noise.min(1.0)) * noise_v / adc.volts(1);
        f32::from(repeats) * libm::logf(spread * (1.0 / 3.0)) > REPEATED
    }

    fn heading(&self) -> u8 {
        (PER_RAD * self.wheels.theta_rad) as i32 as u8
    }

    fn at(&self) -> [u8; 2] {
        [self.wheels.x_m, self.wheels.y_m].map(|m| (PER_M_DRIVEN * m) as i32 as u8)
    }
}

impl Kept {
    /// The farthest that it saw to both sides of the first look.
    fn seen(&self) -> (i8, i8) {
        (self.last_at.min(self.other_at), self.last_at.max(self.other_at))
    }

    /// How far beyond that this is, negative where it is not.
    fn beyond(&self, now: i8) -> i16 {
        let (least, most) = self.seen();
        (i16::from(now) - i16::from(most)).max(i16::from(least) - i16::from(now))
    }

    /// How far the robot is from the first look, in the frame of the wheels, metres.
    fn driven_m(&self, at: [u8; 2]) -> [f32; 2] {
        core::array::from_fn(|axis| f32::from(at[axis].wrapping_sub(self.at[axis]) as i8) * (1.0 / PER_M_DRIVEN))
    }
}

/// A range that stayed: itself, and how far it is from the first, metres, with its variance, m^2.
struct Looked<'a> {
    range_m: f32,
    off_m: f32,
    variance_m2: f32,
    sensor: &'a Sensor<'a>,
}

impl Looked<'_> {
    /// Log odds by a turn of the robot: as if it were held, but what it would see out of the sensor's reach tells, too.
    fn turned(&self, kept: &Kept, now: i8, motion: &Pose) -> f32 {
        let look = Look {
            now_rad: f32::from(now) * (1.0 / PER_RAD),
            last_rad: f32::from(kept.last_at) * (1.0 / PER_RAD),
            turn_rad: f32::from(kept.beyond(now)) * (1.0 / PER_RAD),
            range_m: self.range_m,
            off_m: self.off_m,
            last_m: 0.0,
            variance_m2: self.variance_m2,
            from_m: self.sensor.state.past_axle_m(self.range_m, motion.x_m / motion.theta_rad),
            limits: self.sensor.limits,
        };
        look.log_odds(false)
    }

    /// Log odds by how the robot drove since the first look; none where a surface could be so that it stays.
    ///
    /// In the frame of the first beam, with a sensor that moved by (a, c) and turned by t, the range to the plane whose normal is turned by
    /// f is `((r - a) - c tan f) / (cos t + sin t tan f)`, which is r where `tan f = (r - a - r cos t) / (c + r sin t)`.
    fn ahead(&self, [dx, dy]: [f32; 2], heading: u8, now: i8) -> Option<f32> {
        if now.unsigned_abs() > STRAIGHT {
            return None;
        }
        let Sensor { limits, state, .. } = self.sensor;
        let first = sin_cos(f32::from(heading as i8) * (1.0 / PER_RAD) + limits.mount.bearing_rad);
        let t = f32::from(now) * (1.0 / PER_RAD);
        let [along_m, across_m] = [first.1 * dx + first.0 * dy, first.1 * dy - first.0 * dx];
        let nearer_m = along_m - 0.5 * self.range_m * t * t;
        let aside_m = across_m + self.range_m * t;
        let slope = libm::sqrtf(1.0 - state.min_cos * state.min_cos) / state.min_cos;
        let least_m = (nearer_m.abs() - slope * aside_m.abs()) / (1.0 + slope * t.abs());
        if least_m.is_nan() || least_m <= AHEAD_M {
            return None;
        }
        let moves = (least_m, self.variance_m2 + SURFACE_M * SURFACE_M, change(nearer_m.abs()));
        Some(log_odds(moves, (self.off_m, self.variance_m2), limits.span_m()))
    }
}
