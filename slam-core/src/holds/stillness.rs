//! Readings that stay as they are while the wheels turn the robot.
//!
//! Whatever a robot sees, its readings change when it turns: by a wall's slant, by the next thing beside it. No map is needed to
//! tell so, and none can mislead: beside a wall the sensors that see it are nearly blind, others see nothing, and a robot whose pose ran on
//! takes what it sees for other walls.

use crate::geometry::pose::Pose;
use crate::measurement::sensor::Sensor;

/// With no reading that changed over such a turn, radians, by as many sensors, the robot does not turn. In forty hours in simulated
/// homes the largest such turn of a robot that moved was 0.87 by two sensors.
const HELD_RAD: f32 = 1.0;
const WITNESSES: u8 = 2;

/// While the same is so over such a turn, radians, nothing else moved the robot either; and while its beams should have moved by so
/// much, metres, it has not begun to move again.
const UNTURNED_RAD: f32 = 0.3;
const STILL_M: f32 = 0.12;

/// So many readings are what a sensor reads at first; of those after them each has this share in the mean.
const FIRST: u8 = 4;
const NEW_SHARE: f32 = 0.25;

/// A mean that moved by more than this has changed: metres, and standard deviations of a reading. What is held swings a little.
const CHANGE: (f32, f32) = (0.01, 2.5);

/// Under so many times its least range a sensor's output hardly changes with the range, and folds back: two such are one witness.
const NEAR: f32 = 1.3;

/// A sensor that had no reading for so many steps sees something else with its next.
const UNSEEN: u8 = 8;

/// Units in which ranges, metres, and turns, radians, are kept, in eight bytes a sensor: of up to 16 m, and two radians either way.
const PER_M: f32 = 4000.0;
const PER_RAD: f32 = 64.0;

/// What a sensor read since a reading last changed.
#[derive(Clone, Copy, Debug)]
struct Kept {
    first: u16,
    mean: u16,
    /// How far the wheels had turned the robot meanwhile, at least and at most.
    least: i8,
    most: i8,
    /// Steps since its last reading.
    age: u8,
    /// How many of the first there were, and whether the last was near.
    count: u8,
}

/// The bit of the count that says that the last reading was near.
const IS_NEAR: u8 = 0x80;

/// The readings of all sensors since one of them last changed.
#[derive(Clone, Debug)]
pub struct Stillness<const S: usize> {
    kept: [Kept; S],
    /// How far the wheels have turned the robot since, radians, and how far beams have moved, metres.
    turned_rad: f32,
    moved_m: f32,
    /// Where it was then, in the map.
    begun: Option<Pose>,
    is_changed: bool,
}

impl<const S: usize> Stillness<S> {
    /// Nothing was read.
    pub const NONE: Self = Self {
        kept: [Kept { first: 0, mean: 0, least: 0, most: 0, age: 0, count: 0 }; S],
        turned_rad: 0.0,
        moved_m: 0.0,
        begun: None,
        is_changed: false,
    };

    /// The wheels turn the robot by so much, radians, and its beams move by so much, metres.
    pub fn follow(&mut self, turn_rad: f32, moved_m: f32) {
        self.turned_rad += turn_rad;
        self.moved_m += moved_m;
    }

    /// Takes in a range of a sensor, with its standard deviation, metres.
    #[inline(never)]
    pub fn note(&mut self, sensor: &Sensor, range_m: f32, sigma_m: f32) {
        let Some(kept) = self.kept.get_mut(sensor.index) else { return };
        let count = if kept.age > UNSEEN { 0 } else { kept.count & !IS_NEAR };
        let near = if range_m < NEAR * sensor.limits.min_m { IS_NEAR } else { 0 };
        kept.age = 0;
        let turned = (PER_RAD * self.turned_rad) as i8;
        let share = if count < FIRST { 1.0 / f32::from(count + 1) } else { NEW_SHARE };
        let mean = f32::from(kept.mean);
        let mean = mean + share * (PER_M * range_m - mean);
        kept.mean = (mean + 0.5) as u16;
        kept.count = count.saturating_add(1).min(FIRST) | near;
        if count < FIRST {
            (kept.first, kept.least, kept.most) = (kept.mean, turned, turned);
            return;
        }
        (kept.least, kept.most) = (kept.least.min(turned), kept.most.max(turned));
        let off = mean - f32::from(kept.first);
        self.is_changed |= off.abs() > PER_M * (CHANGE.0 + CHANGE.1 * sigma_m);
    }

    /// After the readings of a step, with the pose in the map.
    pub fn settle(&mut self, map: Pose) {
        let begins = self.is_changed || self.begun.is_none();
        for kept in &mut self.kept {
            kept.age = kept.age.saturating_add(1);
            if begins {
                kept.count = 0;
            }
        }
        if begins {
            self.begun = Some(map);
            (self.turned_rad, self.moved_m, self.is_changed) = (0.0, 0.0, false);
        }
    }

    /// Whether the robot has not begun to move again.
    pub fn is_still(&self) -> bool {
        self.is_same_over(STILL_M, 0.0)
    }

    /// Whether it did not turn of late, whatever its wheels said.
    pub fn is_unturned(&self) -> bool {
        self.is_same_over(0.0, UNTURNED_RAD)
    }

    /// Where it is held.
    pub fn held_at(&self) -> Option<Pose> {
        self.begun.filter(|_| self.is_same_over(0.0, HELD_RAD))
    }

    /// Where it was when a reading last changed, if its beams should have moved by more than this since, metres.
    pub fn begun(&self, moved_m: f32) -> Option<Pose> {
        self.begun.filter(|_| self.is_same_over(moved_m, 0.0))
    }

    /// Whether enough sensors said the same while beams should have moved by so much, metres, and over such a turn, radians.
    #[inline(never)]
    fn is_same_over(&self, moved_m: f32, turn_rad: f32) -> bool {
        let says = |kept: &&Kept| {
            let is_told = kept.count & !IS_NEAR == FIRST && kept.age < UNSEEN;
            is_told && i16::from(kept.most) - i16::from(kept.least) >= (PER_RAD * turn_rad) as i16
        };
        let halves = |kept: &Kept| if kept.count & IS_NEAR == 0 { 2 } else { 1 };
        self.moved_m > moved_m && self.kept.iter().filter(says).map(halves).sum::<u8>() >= 2 * WITNESSES
    }
}
