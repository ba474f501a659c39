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
const UNSEEN: u32 = 8;

/// What a sensor read since a reading last changed.
#[derive(Clone, Copy, Debug)]
struct Kept {
    first_m: f32,
    mean_m: f32,
    /// How far the wheels had turned the robot meanwhile, at least and at most, radians.
    least_rad: f32,
    most_rad: f32,
    /// Step of its last reading.
    step: u32,
    /// How many of the first there were.
    count: u8,
    /// What it counts for, in halves of a witness.
    halves: u8,
}

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
    step: u32,
}

impl<const S: usize> Stillness<S> {
    /// Nothing was read.
    pub const NONE: Self = Self {
        kept: [Kept { first_m: 0.0, mean_m: 0.0, least_rad: 0.0, most_rad: 0.0, step: 0, count: 0, halves: 0 }; S],
        turned_rad: 0.0,
        moved_m: 0.0,
        begun: None,
        is_changed: false,
        step: 0,
    };

    /// The wheels turn the robot by so much, radians, and its beams move by so much, metres.
    pub fn follow(&mut self, turn_rad: f32, moved_m: f32) {
        self.turned_rad += turn_rad;
        self.moved_m += moved_m;
    }

    /// The step of this number begins.
    pub fn begin(&mut self, step: u32) {
        self.step = step;
    }

    /// Takes in a range of a sensor, with its standard deviation, metres.
    pub fn note(&mut self, sensor: &Sensor, range_m: f32, sigma_m: f32) {
        let Some(kept) = self.kept.get_mut(sensor.index) else { return };
        if self.step.wrapping_sub(kept.step) > UNSEEN {
            kept.count = 0;
        }
        kept.step = self.step;
        kept.halves = if range_m < NEAR * sensor.limits.min_m { 1 } else { 2 };
        if kept.count < FIRST {
            kept.count += 1;
            kept.mean_m += (range_m - kept.mean_m) / f32::from(kept.count);
            (kept.first_m, kept.least_rad, kept.most_rad) = (kept.mean_m, self.turned_rad, self.turned_rad);
            return;
        }
        kept.mean_m += NEW_SHARE * (range_m - kept.mean_m);
        kept.least_rad = kept.least_rad.min(self.turned_rad);
        kept.most_rad = kept.most_rad.max(self.turned_rad);
        self.is_changed |= (kept.mean_m - kept.first_m).abs() > CHANGE.0 + CHANGE.1 * sigma_m;
    }

    /// After the readings of a step, with the pose in the map.
    pub fn settle(&mut self, map: Pose) {
        if self.is_changed || self.begun.is_none() {
            self.begun = Some(map);
            (self.turned_rad, self.moved_m, self.is_changed) = (0.0, 0.0, false);
            for kept in &mut self.kept {
                kept.count = 0;
            }
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
    fn is_same_over(&self, moved_m: f32, turn_rad: f32) -> bool {
        let says = |kept: &&Kept| {
            let is_seen = kept.count == FIRST && self.step.wrapping_sub(kept.step) < UNSEEN;
            is_seen && kept.most_rad - kept.least_rad >= turn_rad
        };
        self.moved_m > moved_m && self.kept.iter().filter(says).map(|kept| kept.halves).sum::<u8>() >= 2 * WITNESSES
    }
}
