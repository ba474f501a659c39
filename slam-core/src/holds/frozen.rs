//! Sensors that are frozen: what they say stays as it is, whatever is before them. A driver hangs, a line breaks, a lens is covered.
//!
//! Two things tell. The noise of an analogue sensor is many counts of its converter, so that an output which repeats to the
//! count is none of a live one, moved or not. And the range to a surface stays the same while the robot moves only where the
//! surface lies so that it can: of all planes through what was seen first, that of the slope for which it does. A look at it is a likelihood
//! ratio of an output that stays and of a surface, a quarter of a radian after the one before in a turn on the spot: two looks tell the
//! slope, and the third where the range should be (the one for a robot that is held, [`Look`]). Of a robot that drives meanwhile it tells nothing: one that goes along a wall or about a
//! chair's leg steers so that what it reads stays the same.
//!
//! Under 1.3 times its least range the output of an analogue sensor hardly changes with the range: there a look is a quarter of a turn on the spot,
//! after which nothing that stands so near is as near as before. A cover or dirt on a lens shows itself so.
//!
//! One look alone says little, for what is seen may go with the robot, and they are summed (Page 1954) until the output differs from the first
//! of all of them. What tells a frozen sensor from a held robot are the others: a look counts only where as many of them changed of late as stayed.
//!
//! A range that goes with the robot (its own body, a thing that it pushes) is as good as frozen: no wall is to be drawn of it.

use crate::geometry::pose::Pose;
use crate::holds::stillness::{CHANGED, LOOK_RAD, Look, NEAR, SWING_M, log_odds};
use crate::jolts::confirmation::SURE;
use crate::measurement::data_association::change;
use crate::measurement::sensor::Sensor;
use crate::motion::step::MIDDLE_M;
use crate::rig::{RangeModel, RangeSensor, Rig};
use crate::sample::RangeInput;
use core::f32::consts::{FRAC_PI_2, PI, TAU};

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

/// Units in which headings, radians, ranges and positions, metres, and log odds are kept, in eight bytes a sensor.
const PER_RAD: f32 = 256.0 / TAU;
const PER_M: f32 = 4000.0;
const PER_M_DRIVEN: f32 = 100.0;
const PER_M_OFF: f32 = 250.0;
const PER_NAT: f32 = 12.0;

/// So far a look is from the one before, and from the first at most, units: beyond that a wall that was met at right angles is met at none.
const LOOK: u8 = (PER_RAD * LOOK_RAD) as u8 + 1;
const FARTHEST: u8 = 50;

/// What is near is looked at after so much of a turn, units: a quarter of one.
const QUARTER: u8 = (PER_RAD * FRAC_PI_2) as u8;

/// A robot turns on the spot where it drives no farther than such a share of the way of what it turns past, and this, metres.
const SPOT: f32 = 0.5;
const SPOT_M: f32 = 0.02;

/// What a sensor read since its output last changed.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// The range that is to stay, none where that is zero: the first one since anything spoke for it.
    first: u16,
    /// The position and the heading from which looks are taken, by the wheels.
    at: [u8; 2],
    heading: u8,
    /// From there, the heading of the last look, none where that is zero, and by how much its range differed.
    last_at: i8,
    last_off: i8,
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

/// Which sensors are frozen, and what speaks for it.
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
    /// Whether none was looked at in the last step.
    is_behind: bool,
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

impl<const S: usize> Frozen<S> {
    /// None, and nothing was read.
    pub const NONE: Self = Self {
        kept: [Kept { first: 0, at: [0; 2], heading: 0, last_at: 0, last_off: 0, says: 0 }; S],
        since_m: 0.0,
        changes: [Changes::NONE; 2],
        stayed: 0,
        suspects: 0,
        frozen: 0,
        since_heading: 0,
        is_behind: false,
    };

    /// Sensors that are frozen, a bit each.
    pub fn sensors(&self) -> u16 {
        self.frozen
    }

    /// Whether this one is.
    pub fn is_frozen(&self, index: usize) -> bool {
        self.frozen >> (index & 15) & 1 != 0
    }

    /// Sensors that stayed the same over motion that others confirmed, a bit each.
    pub fn suspects(&self) -> u16 {
        self.suspects
    }

    /// No sensor is looked at in this step: each begins anew with its next reading, for it may see something else meanwhile.
    pub fn skip(&mut self) {
        self.is_behind = true;
    }

    /// All were looked at in this step.
    pub fn settle(&mut self) {
        self.is_behind = false;
    }

    /// Looks at what a sensor says; whether it was found frozen just now.
    pub fn look(&mut self, sensor: &Sensor, input: RangeInput, view: &View<S>) -> bool {
        self.age(view);
        let Some(kept) = self.kept.get(sensor.index) else { return false };
        let (bit, first) = (1 << (sensor.index & 15), kept.first);
        let was_frozen = self.frozen & bit != 0;
        let limits = sensor.limits;
        let range = view.range(limits, input);
        let seen = range.filter(|(range_m, _)| (limits.min_m..=limits.max_m).contains(range_m));
        let end_m = limits.max_m..(1.0 + LOOK_RAD) * limits.max_m;
        match seen {
            _ if input == RangeInput::Missing => {}
            Some(_) if !was_frozen && view.repeats(sensor) => self.say(sensor.index, MOST),
            Some(range) if !is_near(limits, range.0) => self.weigh(sensor, range, view),
            Some(range) => self.weigh_near(sensor, range, view),
            // At the end of its reach an output that stays is out of it now and then, by its noise.
            None if first > 0 && range.is_some_and(|range| end_m.contains(&range.0) && !is_another(range, first)) => {}
            seen => {
                // What was well within its reach has gone.
                let has_gone = seen.is_none() && f32::from(first) * (1.0 + LOOK_RAD) < PER_M * limits.max_m;
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

    /// Looks are taken from here.
    #[inline(never)]
    fn begin(&mut self, index: usize, range_m: f32, view: &View<S>) {
        let Some(kept) = self.kept.get_mut(index) else { return };
        *kept = Kept {
            first: if kept.first > 0 && kept.says > 0 { kept.first } else { (PER_M * range_m) as u16 },
            at: view.at(),
            heading: view.heading(),
            last_at: 0,
            last_off: 0,
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
        if self.is_behind || self.kept.get(sensor.index).is_some_and(|kept| kept.first == 0) {
            self.begin(sensor.index, range_m, view);
        }
        let Some(kept) = self.kept.get(sensor.index).copied() else { return };
        let off_m = off_m(range_m, kept.first);
        let variance_m2 = 2.0 * noise_m2;
        let was_near = is_near(sensor.limits, f32::from(kept.first) * (1.0 / PER_M));
        if was_near || is_another((range_m, noise_m2), kept.first) {
            self.change(sensor.index, !was_near, view.fits);
            self.begin(sensor.index, range_m, view);
            return;
        }
        let now = view.heading().wrapping_sub(kept.heading) as i8;
        let driven_m = kept.driven_m(view.at());
        // Of a robot that drives meanwhile nothing is told: it may follow what it sees.
        let from_m = sensor.state.past_axle_m(range_m, 0.0);
        let is_on_spot = driven_m <= SPOT_M + SPOT * from_m * f32::from(now.unsigned_abs()) * (1.0 / PER_RAD);
        if !is_on_spot || now.unsigned_abs() > FARTHEST {
            self.begin(sensor.index, range_m, view);
        } else if kept.is_look(now) {
            self.stayed |= 1 << (sensor.index & 15);
            // The look is put off until others show that the robot moves.
            if kept.last_at == 0 || self.is_told() {
                let says = kept.log_odds(now, Seen { range_m, off_m, variance_m2, from_m }, sensor.limits);
                self.say(sensor.index, says);
                if let Some(kept) = self.kept.get_mut(sensor.index) {
                    (kept.last_at, kept.last_off) = (now, (PER_M_OFF * off_m) as i8);
                }
            }
        }
    }

    /// Weighs a range, metres, of this variance, m^2, that is so near that the output hardly changes with it. What stands there has changed
    /// after a quarter turn on the spot: a wall is met at 45 degrees then, before it or after it, and of a corner the corner.
    fn weigh_near(&mut self, sensor: &Sensor, range: (f32, f32), view: &View<S>) {
        let Some(kept) = self.kept.get(sensor.index).copied() else { return };
        let was_near = is_near(sensor.limits, f32::from(kept.first) * (1.0 / PER_M));
        let is_other = kept.first > 0 && (!was_near || is_another(range, kept.first));
        self.stayed &= !(1 << (sensor.index & 15));
        if is_other {
            self.change(sensor.index, false, false);
        }
        let now = view.heading().wrapping_sub(kept.heading) as i8;
        let from_m = sensor.state.past_axle_m(range.0, 0.0);
        let is_on_spot =
            kept.driven_m(view.at()) <= SPOT_M + SPOT * from_m * f32::from(now.unsigned_abs()) * (1.0 / PER_RAD);
        if self.is_behind || kept.first == 0 || is_other || !is_on_spot {
            self.begin(sensor.index, range.0, view);
        } else if now.unsigned_abs() >= QUARTER && self.is_told() {
            self.say(sensor.index, ONE_LOOK);
            self.begin(sensor.index, range.0, view);
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

/// Whether the output of an analogue sensor hardly changes with the range, or folds back: it stays though what is seen does not.
fn is_near(limits: &RangeSensor, range_m: f32) -> bool {
    matches!(limits.model, RangeModel::Sharp { .. }) && range_m < NEAR * limits.min_m
}

/// How far a range is from the one that is to stay, metres.
fn off_m(range_m: f32, first: u16) -> f32 {
    range_m - f32::from(first) * (1.0 / PER_M)
}

/// Whether a range, metres, of this variance, m^2, is another one than that which is to stay.
fn is_another((range_m, noise_m2): (f32, f32), first: u16) -> bool {
    let beyond_m = off_m(range_m, first).abs() - SWING_M;
    beyond_m > 0.0 && beyond_m * beyond_m > CHANGED * CHANGED * 2.0 * noise_m2
}

impl Changes {
    const NONE: Self = Self { changed: 0, fitted: 0 };
}

impl<const S: usize> View<'_, S> {
    /// The range that an output says, within the sensor's limits or not, metres, and its variance, m^2; none where it says none.
    fn range(&self, limits: &RangeSensor, input: RangeInput) -> Option<(f32, f32)> {
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
    fn repeats(&self, sensor: &Sensor) -> bool {
        let repeats = sensor.state.front_end.repeats();
        let (&RangeModel::Sharp { noise_v, .. }, Some(adc), true) = (&sensor.limits.model, &self.rig.adc, repeats > 3)
        else {
            return false;
        };
        let spread = 2.0 * float::sqrtf(PI * self.true_noise.min(1.0)) * noise_v / adc.volts(1);
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
    /// Whether this is a look farther than the last one.
    fn is_look(&self, now: i8) -> bool {
        now.abs_diff(self.last_at) >= LOOK && now.unsigned_abs() > self.last_at.unsigned_abs()
    }

    /// How far the robot is from where looks are taken from, metres: no less than along one axis, which at worst is two thirds of it.
    fn driven_m(&self, [x, y]: [u8; 2]) -> f32 {
        let along = |now: u8, then: u8| (now.wrapping_sub(then) as i8).unsigned_abs();
        f32::from(along(x, self.at[0]).max(along(y, self.at[1]))) * (1.0 / PER_M_DRIVEN)
    }

    /// Log odds of a sensor that is frozen against one that sees a surface, by a look after the robot turned on the spot: as if it were held,
    /// but what it would see out of the sensor's reach tells, too.
    fn log_odds(&self, now: i8, seen: Seen, limits: &RangeSensor) -> f32 {
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
struct Seen {
    range_m: f32,
    off_m: f32,
    variance_m2: f32,
    from_m: f32,
}
