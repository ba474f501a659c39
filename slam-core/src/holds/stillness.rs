//! Readings that stay as they are while the wheels turn the robot.
//!
//! Whatever a robot sees, its readings change when it turns: by a wall's slant, by the next thing beside it. No map is needed to
//! tell so, and none can mislead: beside a wall the sensors that see it are nearly blind, others see nothing, and a robot whose pose ran on
//! takes what it sees for other walls.
//!
//! Over a turn t the range to a wall changes by `a t + r t^2 / 2`, with a slope `a` that may be any and a range r from the middle of the
//! turn. So one look at another bearing that finds the same range says nothing, for the foot of the wall may be midway, and in a
//! room with right angles it is so for all sensors at once. The next one says much, for then the slope is known. Each look is a
//! likelihood ratio of a robot that stands and one that turns, and they are summed (Wald 1945) until a reading changes.

use crate::filter::density::density;
use crate::geometry::pose::Pose;
use crate::jolts::confirmation::SURE;
use crate::measurement::data_association::{CHANGES, change};
use crate::measurement::sensor::Sensor;
use crate::motion::step::MIDDLE_M;
use crate::rig::RangeSensor;
use crate::sensing::range::SURFACE_M;

/// A look at what a sensor sees is such a turn, radians, after the one before: the range to a wall half a metre away, which curves away on
/// both sides of its foot, then differs by 3 cm from what two equal looks before would have it, more than the sensors' noise.
pub const LOOK_RAD: f32 = 0.25;

/// Log odds from which on the robot is held: one hold in an hour beforehand, in which a robot that cleans turns by a thousand radians
/// (840 to 1,300 in four simulated homes), four thousand looks, and twenty to one after.
pub const HELD: f32 = 8.3 + SURE;

/// What one sensor can say at most: it may be what it sees that turns with the robot, for as long as it does.
const SENSOR_SAYS: f32 = 6.0;

/// Chance that a reading stays though the robot moves: what it sees goes with it, or the wall is not as the map has it. In
/// simulated homes that was so in one to three of a hundred looks.
const STAYS: f32 = 0.02;

/// So many sensors say that the robot has not begun to move again, while its beams should have moved by so much, metres.
const WITNESSES: u8 = 2;
const STILL_M: f32 = 0.12;

/// So many readings are in a mean at most, and each after them has such a share in it. The first may be over such a turn, units.
const FIRST: u8 = 4;
const FIRST_TURN: u8 = LOOK / 2;

/// What is held swings a little, metres.
pub const SWING_M: f32 = 0.01;

/// A mean that moved by so many of its standard deviations more has changed: of a held robot it does so once in 16 thousand readings,
/// some minutes.
pub const CHANGED: f32 = 4.0;

/// Under so many times its least range a sensor's output hardly changes with the range, and folds back: two such are one witness.
pub const NEAR: f32 = 1.3;

/// A sensor that had no reading for so many steps sees something else with its next.
const UNSEEN: u8 = 8;

/// Units in which ranges, metres, turns, radians, and log odds are kept, in sixteen bytes a sensor: of up to 16 m, and four radians either way.
const PER_M: f32 = 4000.0;
const PER_RAD: f32 = 32.0;
const PER_NAT: f32 = 16.0;
const LOOK: u8 = (PER_RAD * LOOK_RAD) as u8;

/// What a sensor read since a reading last changed.
#[derive(Clone, Copy, Debug)]
struct Kept {
    /// Means of the first readings, of those of the last look, and of those since.
    first: u16,
    last: u16,
    mean: u16,
    /// How far the wheels had turned the robot at the first and at the last look.
    first_at: i8,
    last_at: i8,
    /// How far the wheels had turned the robot meanwhile, at least and at most.
    least: i8,
    most: i8,
    /// And until the last look, between the two.
    looked: u8,
    /// What it says, as log odds.
    says: u8,
    /// Steps since its last reading.
    age: u8,
    /// How many readings are in the first, none while they are counted, and in the mean.
    readings: (u8, u8),
    /// Whether the last was near.
    is_near: bool,
}

/// Where a robot is held, in the map, and the 1-sigma vector of what is in doubt of that, metres and radians.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    pub pose: Pose,
    pub in_doubt: [f32; 3],
}

/// Standard deviation of what is spread evenly over a length, of half of that: one over the root of three.
const EVEN: f32 = 0.577_350_3;

/// The readings of all sensors since one of them last changed.
#[derive(Clone, Debug)]
pub struct Stillness<const S: usize> {
    kept: [Kept; S],
    /// How far the wheels have turned the robot since, radians, and how far beams have moved, metres.
    turned_rad: f32,
    moved_m: f32,
    /// How far they have driven it ahead since, metres.
    ahead_m: f32,
    /// Where it was then, in the map.
    begun: Option<Pose>,
    is_changed: bool,
    /// Sensors that look along the way, a bit each.
    along: u16,
}

impl<const S: usize> Stillness<S> {
    /// Nothing was read.
    pub const NONE: Self = Self {
        kept: [Kept::NONE; S],
        turned_rad: 0.0,
        moved_m: 0.0,
        ahead_m: 0.0,
        begun: None,
        is_changed: false,
        along: 0,
    };

    /// The wheels move the robot so, in its frame, and its beams by so much, metres.
    pub fn follow(&mut self, motion: &Pose, moved_m: f32) {
        self.turned_rad += motion.theta_rad;
        self.ahead_m += motion.x_m;
        self.moved_m += moved_m;
    }

    /// Takes in a range of a sensor, with its standard deviation, metres.
    #[inline(never)]
    pub fn note(&mut self, sensor: &Sensor, range_m: f32, sigma_m: f32) {
        let Some(kept) = self.kept.get_mut(sensor.index) else { return };
        if kept.age > UNSEEN {
            kept.begin_anew();
        }
        kept.age = 0;
        let bit = 1 << (sensor.index & 15);
        self.along = if sensor.state.looks_along() { self.along | bit } else { self.along & !bit };
        kept.is_near = range_m < NEAR * sensor.limits.min_m;
        let turned = (PER_RAD * self.turned_rad) as i8;
        if kept.readings.0 == 0 && (kept.readings.1 == FIRST || kept.readings.1 > 0 && kept.over(turned) > FIRST_TURN) {
            (kept.first, kept.readings) = (kept.mean, (kept.readings.1, 0));
            kept.first_at = kept.least.midpoint(kept.most);
            (kept.last, kept.last_at) = (kept.first, kept.first_at);
        }
        let count = kept.readings.1;
        let mean = f32::from(kept.mean);
        let mean = mean + (PER_M * range_m - mean) / f32::from(count + 1);
        kept.mean = (mean + 0.5) as u16;
        kept.readings.1 = (count + 1).min(FIRST);
        if kept.readings.0 == 0 && count == 0 {
            (kept.least, kept.most) = (turned, turned);
        }
        (kept.least, kept.most) = (kept.least.min(turned), kept.most.max(turned));
        if kept.readings.0 == 0 {
            return;
        }
        let off_m = (mean - f32::from(kept.first)) * (1.0 / PER_M);
        let variance_m2 = sigma_m * sigma_m * (1.0 / f32::from(count + 1) + 1.0 / f32::from(kept.readings.0));
        let beyond_m = off_m.abs() - SWING_M;
        self.is_changed |= beyond_m > 0.0 && beyond_m * beyond_m > CHANGED * CHANGED * variance_m2;
        let over = kept.most.abs_diff(kept.least);
        if over.saturating_sub(kept.looked) >= LOOK {
            // What was averaged was seen before, halfway from the look before.
            let at = if count > 0 { turned.midpoint(kept.last_at) } else { turned };
            let look = Look {
                now_rad: kept.since_first(at),
                last_rad: kept.since_first(kept.last_at),
                turn_rad: f32::from(over - kept.looked) * (1.0 / PER_RAD),
                range_m,
                off_m,
                last_m: (f32::from(kept.last) - f32::from(kept.first)) * (1.0 / PER_M),
                variance_m2,
                // How far what it sees is from the middle of the arc that its beam would draw there.
                from_m: sensor.state.past_axle_m(range_m, self.ahead_m / self.turned_rad),
                limits: sensor.limits,
            };
            let says = f32::from(kept.says) + PER_NAT * look.log_odds(true);
            kept.says = says.clamp(0.0, PER_NAT * SENSOR_SAYS) as u8;
            (kept.looked, kept.readings.1) = (over, 0);
            (kept.last, kept.last_at) = (kept.mean, at);
        }
    }

    /// Takes in that a sensor sees nothing within its reach.
    pub fn note_absence(&mut self, sensor: &Sensor) {
        if let Some(kept) = self.kept.get(sensor.index) {
            let is_within_reach = f32::from(kept.first) * (1.0 + LOOK_RAD) < PER_M * sensor.limits.max_m;
            self.is_changed |= kept.is_told() && is_within_reach;
        }
    }

    /// After the readings of a step, with the pose in the map.
    pub fn settle(&mut self, map: Pose) {
        // Where nothing was read of late, nothing stays.
        let begins = self.is_changed || self.begun.is_none() || !self.kept.iter().any(Kept::is_read);
        for kept in &mut self.kept {
            kept.age = kept.age.saturating_add(1);
            if begins {
                kept.begin_anew();
            }
        }
        if begins {
            self.begun = Some(map);
            (self.turned_rad, self.moved_m, self.ahead_m, self.is_changed) = (0.0, 0.0, 0.0, false);
        }
    }

    /// The map has the places of the robot's way elsewhere, by this motion.
    pub fn go_with(&mut self, moved: impl Fn(&Pose) -> Pose) {
        self.begun = self.begun.as_ref().map(moved);
    }

    /// Whether a reading of this step changed.
    pub fn is_changed(&self) -> bool {
        self.is_changed
    }

    /// Whether the robot has not begun to move again.
    pub fn is_still(&self) -> bool {
        self.is_same_over(STILL_M)
    }

    /// What these sensors said, a bit each, is forgotten.
    #[cold]
    #[inline(never)]
    pub fn forget(&mut self, sensors: u16) {
        for (index, kept) in self.kept.iter_mut().enumerate() {
            if sensors >> (index & 15) & 1 != 0 {
                kept.age = UNSEEN;
            }
        }
    }

    /// Whether it did not turn of late, whatever its wheels said.
    pub fn is_unturned(&self) -> bool {
        self.says() > SURE
    }

    /// Where it is held.
    pub fn held_at(&self) -> Option<Held> {
        self.place().filter(|_| self.says() > HELD)
    }

    /// Where it is held, if its beams should have moved by more than this since a reading last changed, metres.
    pub fn begun(&self, moved_m: f32) -> Option<Held> {
        self.place().filter(|_| self.is_same_over(moved_m))
    }

    /// Where something holds it that turned its wheels since a reading last changed. Beside a wall, with nothing before it and behind it,
    /// readings stay as well while it drives ahead: it was held from any place of that way on.
    fn place(&self) -> Option<Held> {
        let is_seen =
            self.kept.iter().enumerate().any(|(index, kept)| kept.is_told() && self.along >> (index & 15) & 1 != 0);
        let ahead_m = if is_seen { 0.0 } else { self.ahead_m };
        let begun = self.begun?;
        let pose = begun.compose(&Pose { x_m: 0.5 * ahead_m, ..Pose::ORIGIN });
        let [x_m, y_m] = [pose.x_m - begun.x_m, pose.y_m - begun.y_m];
        Some(Held { pose, in_doubt: [EVEN * x_m, EVEN * y_m, 0.0] })
    }

    /// Log odds of a robot that does not turn, by all sensors.
    #[inline(never)]
    fn says(&self) -> f32 {
        let says = |kept: &Kept| f32::from(kept.says) * if kept.is_near { 0.5 } else { 1.0 };
        self.kept.iter().filter(|kept| kept.is_told()).map(says).sum::<f32>() * (1.0 / PER_NAT)
    }

    /// Whether enough sensors said the same while beams should have moved by so much, metres.
    fn is_same_over(&self, moved_m: f32) -> bool {
        self.moved_m > moved_m && self.is_witnessed()
    }

    /// Whether enough sensors say so.
    #[inline(never)]
    pub fn is_witnessed(&self) -> bool {
        let halves = |kept: &Kept| if kept.is_near { 1 } else { 2 };
        self.kept.iter().filter(|kept| kept.is_told()).map(halves).sum::<u8>() >= 2 * WITNESSES
    }
}

impl Kept {
    /// Nothing was read.
    const NONE: Self = Self {
        first: 0,
        last: 0,
        mean: 0,
        first_at: 0,
        last_at: 0,
        least: 0,
        most: 0,
        looked: 0,
        says: 0,
        age: 0,
        readings: (0, 0),
        is_near: false,
    };

    /// Readings from now on are the first.
    fn begin_anew(&mut self) {
        (self.readings, self.looked, self.says) = ((0, 0), 0, 0);
    }

    /// Turn over which there were readings, with another one here, units.
    fn over(&self, turned: i8) -> u8 {
        self.most.max(turned).abs_diff(self.least.min(turned))
    }

    /// Turn since the first look, radians.
    fn since_first(&self, at: i8) -> f32 {
        (f32::from(at) - f32::from(self.first_at)) * (1.0 / PER_RAD)
    }

    /// Whether there were readings of late.
    fn is_read(&self) -> bool {
        self.readings != (0, 0) && self.age < UNSEEN
    }

    /// Whether it had first readings, and has some still.
    fn is_told(&self) -> bool {
        self.readings.0 > 0 && self.age < UNSEEN
    }
}

/// What a sensor reads after a turn.
pub struct Look<'a> {
    /// The turn since the first, and that of the last look, radians: zero where this is the first one after the first readings.
    pub now_rad: f32,
    pub last_rad: f32,
    /// How much farther than all before it looks, radians.
    pub turn_rad: f32,
    /// By how much the mean differs from the first, as that of the last look did, metres, and the variance of that by the sensor's noise, m^2.
    pub off_m: f32,
    pub last_m: f32,
    pub variance_m2: f32,
    /// How far what is seen is from the middle of the turn, metres; negative where that is beyond.
    pub from_m: f32,
    /// What is read, metres, and what can be.
    pub range_m: f32,
    pub limits: &'a RangeSensor,
}

impl Look<'_> {
    /// Log odds of a robot that did not turn against one that did; of a hold it says nothing where what one that turns sees might be out of reach.
    #[inline(never)]
    pub fn log_odds(&self, of_hold: bool) -> f32 {
        // A robot that drives round something sees it so all the time; one that turned there and back draws no arc.
        // And a wall of any slope is met twice at the same range about its foot: where sensors and walls stand at right angles, by all.
        if self.from_m.is_nan() || self.from_m <= 0.0 || self.last_rad.abs() < 0.5 * LOOK_RAD {
            return 0.0;
        }
        // Over a turn t, the range to a wall changes by a t + r t^2 / 2.
        let rough_m2 = self.variance_m2 + SURFACE_M * SURFACE_M;
        // The slope a is known as well as the range at the last look.
        let times = self.now_rad / self.last_rad;
        let to_m = times * self.last_m + 0.5 * self.from_m * self.now_rad * (self.now_rad - self.last_rad);
        let variance_m2 = rough_m2 * (1.0 + times * times);
        if of_hold && self.range_m + to_m + float::sqrtf(variance_m2) > self.limits.max_m {
            return 0.0;
        }
        let moves = (self.off_m - to_m, variance_m2, change(MIDDLE_M * self.turn_rad));
        log_odds(moves, (self.off_m, self.variance_m2), self.limits.span_m())
    }
}

/// Log odds of a reading that stayed against one that moved, within such a span: by how far it is from where one that moved would be, with its
/// variance and the chance that it is of something else, and from where one that stayed would be, with the variance of the sensor's noise.
#[inline(never)]
pub fn log_odds(
    (from_moved_m, moved_m2, other): (f32, f32, f32),
    (from_stayed_m, noise_m2): (f32, f32),
    span_m: f32,
) -> f32 {
    let likelihood = |off_m, variance_m2, other| (1.0 - other) * density(off_m, variance_m2) + other / span_m;
    let stays = likelihood(from_stayed_m, noise_m2 + SWING_M * SWING_M, CHANGES.0);
    log_odds_of_staying(stays, likelihood(from_moved_m, moved_m2, other))
}

/// Log odds of a robot that did not move against one that did, by these likelihoods of a reading of the one and of the other.
pub fn log_odds_of_staying(stays: f32, moves: f32) -> f32 {
    libm::logf(stays / ((1.0 - STAYS) * moves + STAYS * stays))
}
