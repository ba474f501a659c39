//! Into the dock by map and contact, and out of it.
//!
//! The dock is where the charging contact was closed when the job began. The robot goes to a place in front of it, turns
//! towards it and stands until the readings have settled the pose, comes slowly straight on, and presses until the contact closes:
//! that alone is success.

use slam_core::Pose;
use slam_core::angle::wrap;

use super::{Errand, FloorJob, Phase};
use crate::condition::Condition;
use crate::contact::Contacts;
use crate::pilot::Senses;

/// The place in front of the dock is so far out, metres.
const STAGING_M: f32 = 0.6;
/// The robot is there when it is this near, metres, and looks to the dock within this angle, radians.
const THERE_M: f32 = 0.02;
const ALIGNED_RAD: f32 = 0.02;
/// It stands there for so long, microseconds: a dozen readings of each sensor.
const SETTLE_US: u64 = 600_000;
/// On its way to the dock it comes to the line of the try from so far beside it, metres.
const SHIFT_M: f32 = 0.1;
/// Speed towards the dock, back from it after a try in vain, and against it, m/s.
const APPROACH_MPS: f32 = 0.08;
const BACK_MPS: f32 = 0.12;
const PRESS_MPS: f32 = 0.04;
/// It presses from so far before the dock, metres, over so much path in the first round; against what closes no contact for so long,
/// microseconds.
const PRESS_FROM_M: f32 = 0.02;
const PRESS_M: f32 = 0.1;
const TOUCH_US: u64 = 1_500_000;
/// No part of docking takes longer, microseconds.
const LONGEST_US: u64 = 20_000_000;
/// A battery is full after so long in the dock, whatever its gauge shows, microseconds: one that reads 3 % low never shows it. Lithium cells
/// take three hours.
const CHARGE_US: u64 = 4 * 3600 * 1_000_000;
/// Three tries make a round: at the dock's middle, and beside it to either side, in the first round by so much, metres: the contacts of a dock
/// meet a few centimetres to each side of it. A pose is off by a centimetre or two, and by more after a kick, but the readings of each
/// try make it better.
const ASIDE_M: f32 = 0.05;
const TRIES: u8 = 3;
/// Each round goes farther by as much, and after so many the robot is not in the dock.
const ROUNDS: u8 = 8;

/// A part of docking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// To the place in front of the dock.
    Staging,
    /// Turning towards it, then standing.
    Aligning,
    /// Slowly straight on.
    Approaching,
    /// Against the dock.
    Pressing,
    /// Back to the place in front of it after a try in vain, and to the line of the next one.
    BackingOut,
}

impl<const S: usize> FloorJob<S> {
    /// The dock in the job's frame, and how a pose lies to it: metres before it, metres to its left, radians off its direction.
    fn dock(&self) -> Pose {
        self.frame.pose(&self.home.unwrap_or(Pose::ORIGIN))
    }

    fn before_dock(&self, pose: &Pose) -> [f32; 3] {
        let dock = self.dock();
        let [ahead_m, left_m] = dock.inverse().transform([pose.x_m, pose.y_m]);
        [-ahead_m, left_m, wrap(pose.theta_rad - dock.theta_rad)]
    }

    /// The place in front of the dock, metres.
    pub(super) fn staging_m(&self) -> [f32; 2] {
        self.dock().transform([-STAGING_M, 0.0])
    }

    /// Backwards out of the dock.
    pub(super) fn undock(&mut self, now_us: u64) -> (f32, f32) {
        if self.path_m - self.begun_m > STAGING_M || now_us.saturating_sub(self.since_us) > LONGEST_US {
            if self.tally.is_new() {
                self.begin(Phase::Seek { to_m: None }, now_us);
            } else {
                self.go_about(now_us);
            }
        }
        (-APPROACH_MPS, 0.0)
    }

    /// Into the dock from the place in front of it.
    pub(super) fn begin_docking(&mut self, now_us: u64) {
        self.begin(Phase::Dock { stage: Stage::Staging, tries: 0 }, now_us);
    }

    /// One step of docking.
    pub(super) fn dock_step(&mut self, stage: Stage, tries: u8, senses: &Senses<S>, pose: &Pose) -> (f32, f32) {
        let now_us = senses.time_us;
        let is_touched = senses.contacts.or_stopped(senses.condition.is_stalled).any();
        if senses.condition.is_charging && matches!(stage, Stage::Approaching | Stage::Pressing) {
            self.arrive_in_dock(now_us);
            return (0.0, 0.0);
        }
        let next = |stage| Phase::Dock { stage, tries };
        let [before_m, left_m, off_rad] = self.before_dock(pose);
        let aside_m = self.aside_m(tries);
        let elapsed_us = now_us.saturating_sub(self.since_us);
        let back_to_line = 10.0 * (left_m - aside_m).clamp(-SHIFT_M, SHIFT_M);
        let straight = |to_line: f32| (to_line - 3.0 * off_rad).clamp(-0.5, 0.5);
        // A robot that turns, or cannot, does not come on.
        if elapsed_us.max(now_us.saturating_sub(self.moved.1)) > LONGEST_US {
            self.try_at(Stage::Staging, tries + 1, now_us);
            return (0.0, 0.0);
        }
        match stage {
            Stage::Staging => {
                let to_m = self.dock().transform([-STAGING_M, aside_m]);
                if slam_core::pose::length(to_m[0] - pose.x_m, to_m[1] - pose.y_m) < THERE_M {
                    self.begin(next(Stage::Aligning), now_us);
                }
                self.towards(to_m, pose, now_us)
            }
            Stage::Aligning if off_rad.abs() > ALIGNED_RAD => {
                // Standing begins when it looks to the dock.
                self.since_us = now_us;
                (0.0, (-2.0 * off_rad).clamp(-0.8, 0.8))
            }
            Stage::Aligning => {
                if elapsed_us > SETTLE_US {
                    self.begin(next(Stage::Approaching), now_us);
                }
                (0.0, 0.0)
            }
            Stage::Approaching => {
                // What is touched is the dock, or something beside it.
                if before_m < PRESS_FROM_M || is_touched {
                    self.begin(next(Stage::Pressing), now_us);
                }
                (APPROACH_MPS, straight(-back_to_line))
            }
            Stage::Pressing => self.press(tries, is_touched, now_us),
            Stage::BackingOut => {
                if before_m > STAGING_M {
                    let is_on_line = (left_m - aside_m).abs() < SHIFT_M;
                    self.try_at(if is_on_line { Stage::Aligning } else { Stage::Staging }, tries, now_us);
                }
                (-BACK_MPS, straight(back_to_line))
            }
        }
    }

    /// On against the dock, by time, too: the wheels may slip.
    fn press(&mut self, tries: u8, is_touched: bool, now_us: u64) -> (f32, f32) {
        let elapsed_us = now_us.saturating_sub(self.since_us);
        let most_m = PRESS_M + self.round_m() - ASIDE_M;
        let most_us = (1.5e6 * most_m / PRESS_MPS) as u64;
        let is_no_dock = is_touched && elapsed_us > TOUCH_US;
        if is_no_dock || self.path_m - self.begun_m > most_m || elapsed_us > most_us {
            self.begin(Phase::Dock { stage: Stage::BackingOut, tries: tries + 1 }, now_us);
        }
        (PRESS_MPS, 0.0)
    }

    /// How far off the dock may be in this round, metres.
    fn round_m(&self) -> f32 {
        ASIDE_M * f32::from(self.rounds + 1)
    }

    /// How far to the left of the dock's middle this try of the round aims, metres.
    fn aside_m(&self, tries: u8) -> f32 {
        [0.0, self.round_m(), -self.round_m()].get(usize::from(tries)).copied().unwrap_or(0.0)
    }

    /// The next try of the round; after the round it comes anew from farther along the walls, which tell it where it is.
    fn try_at(&mut self, stage: Stage, tries: u8, now_us: u64) {
        if tries < TRIES {
            self.begin(Phase::Dock { stage, tries }, now_us);
        } else if self.rounds + 1 < ROUNDS {
            self.rounds += 1;
            self.come_again(true, now_us);
        } else {
            self.begin(Phase::Over { is_home: false }, now_us);
        }
    }

    /// The contact closes away from docking: where the robot wants to be, or something in its way that its sensors may not see.
    pub(super) fn meet_dock(&mut self, pose: &Pose, now_us: u64) {
        if self.errand.is_to_sweep() {
            self.touch(&Contacts { bump_left: true, bump_right: true, ..Contacts::default() }, pose, now_us);
        } else {
            self.arrive_in_dock(now_us);
        }
    }

    fn arrive_in_dock(&mut self, now_us: u64) {
        self.rounds = 0;
        self.areas.settle();
        match self.errand {
            Errand::Finish(_) => self.come_home(now_us),
            Errand::Sweep { .. } | Errand::Recharge { .. } => self.begin(Phase::Charge, now_us),
        }
    }

    /// In the dock until the battery is full; then on with the floor.
    pub(super) fn charge(&mut self, condition: &Condition, now_us: u64) -> (f32, f32) {
        if !condition.is_charging {
            self.begin(Phase::Dock { stage: Stage::Pressing, tries: 0 }, now_us);
        } else if self.is_charged(now_us) {
            self.errand = Errand::Sweep { then: self.errand.way() };
            // What barred its ways before may be gone.
            (self.retries, self.squeezes, self.pockets) = (0, 0, 0);
            self.begin(Phase::Undock, now_us);
        }
        (0.0, 0.0)
    }

    /// Whether the battery is full, as far as that is known: one that never shows it is after so long.
    pub(super) fn is_charged(&self, now_us: u64) -> bool {
        let has_time = now_us.saturating_sub(self.since_us) <= CHARGE_US;
        self.battery_v.is_nan() || self.battery_v > self.config.full_v || !has_time
    }

    /// Whether it is over for want of charge: home without a dock to charge in, or on the way with an empty battery.
    pub(super) fn is_flat(&self, is_home: bool) -> bool {
        if is_home { matches!(self.errand, Errand::Recharge { .. }) } else { self.is_empty() }
    }

    fn is_empty(&self) -> bool {
        self.battery_v < self.config.empty_v
    }

    /// Takes note of the battery: where it is nearly empty, the robot goes home; where it is empty, it stays where it is, unless it is
    /// about to touch the dock.
    pub(super) fn watch_battery(&mut self, condition: &Condition, now_us: u64) {
        let Some(battery_v) = condition.battery_v.filter(|battery_v| battery_v.is_finite()) else { return };
        // A job that has not begun has no home to go to; of one that is over the voltage says why, and rises when the motors are off.
        if self.home.is_none() || self.is_over() {
            return;
        }
        if self.battery_v.is_nan() {
            self.battery_v = battery_v;
        }
        // A mean over two seconds: motors that start pull the voltage down.
        self.battery_v += 0.02 * (battery_v - self.battery_v);
        let is_driving = !matches!(self.phase, Phase::Charge | Phase::Wait { .. } | Phase::Paused);
        let is_docking = matches!(self.phase, Phase::Dock { stage: Stage::Approaching | Stage::Pressing, .. });
        if is_driving && !is_docking && !condition.is_charging && self.is_empty() {
            self.errand = Errand::Recharge { then: self.errand.way() };
            return self.begin(Phase::Over { is_home: false }, now_us);
        }
        let is_sweeping = is_driving && !matches!(self.phase, Phase::Lost { .. }) && self.errand.is_to_sweep();
        if is_sweeping && self.battery_v < self.config.low_v {
            self.errand = Errand::Recharge { then: self.errand.way() };
            if condition.is_charging {
                self.begin(Phase::Charge, now_us);
            } else {
                self.go_about(now_us);
            }
        }
    }
}
