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

use crate::holds::outputs::{
    FARTHEST, Kept, PER_M, PER_M_OFF, PER_NAT, PER_RAD, Seen, View, is_another, is_near, off_m,
};
use crate::holds::stillness::LOOK_RAD;
use crate::jolts::confirmation::SURE;
use crate::measurement::sensor::Sensor;
use crate::motion::step::MIDDLE_M;
use crate::sample::RangeInput;
use core::f32::consts::FRAC_PI_2;

/// Log odds from which on a sensor is frozen: once in 250 hours of cleaning beforehand, with four thousand looks in each, and twenty to one
/// after.
const FROZEN: f32 = 13.8 + SURE;

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

/// What is near is looked at after so much of a turn, units: a quarter of one.
const QUARTER: u8 = (PER_RAD * FRAC_PI_2) as u8;

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

    /// The path is counted anew from what it is by now, metres.
    pub fn count_anew(&mut self, path_m: f32) {
        self.since_m -= path_m;
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
        let was_near = kept.was_near(sensor.limits);
        if was_near || is_another((range_m, noise_m2), kept.first) {
            self.change(sensor.index, !was_near, view.fits);
            self.begin(sensor.index, range_m, view);
            return;
        }
        let now = kept.turned(view);
        let from_m = sensor.state.past_axle_m(range_m, 0.0);
        if !kept.is_on_spot(from_m, view) || now.unsigned_abs() > FARTHEST {
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
        let is_other = kept.first > 0 && (!kept.was_near(sensor.limits) || is_another(range, kept.first));
        self.stayed &= !(1 << (sensor.index & 15));
        if is_other {
            self.change(sensor.index, false, false);
        }
        let is_on_spot = kept.is_on_spot(sensor.state.past_axle_m(range.0, 0.0), view);
        if self.is_behind || kept.first == 0 || is_other || !is_on_spot {
            self.begin(sensor.index, range.0, view);
        } else if kept.turned(view).unsigned_abs() >= QUARTER && self.is_told() {
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

impl Changes {
    const NONE: Self = Self { changed: 0, fitted: 0 };
}
