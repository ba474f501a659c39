//! Into the dock by map and contact, and out of it.
//!
//! The dock is where the charging contact was closed when the job began. The robot goes to a place in front of it, turns
//! towards it and stands until the readings have settled the pose, comes slowly straight on, and presses until the contact closes:
//! that alone is success.

use slam_core::Pose;
use slam_core::angle::wrap;

use super::{Errand, FloorJob, Phase};
use crate::condition::Condition;

/// The place in front of the dock is so far out, metres.
const STAGING_M: f32 = 0.6;
/// The robot is there when it is this near, metres, and looks to the dock within this angle, radians.
const THERE_M: f32 = 0.02;
const ALIGNED_RAD: f32 = 0.02;
/// It stands there for so long, microseconds: a dozen readings of each sensor.
const SETTLE_US: u64 = 600_000;
/// Speed towards the dock, and against it, m/s.
const APPROACH_MPS: f32 = 0.08;
const PRESS_MPS: f32 = 0.04;
/// It presses from so far before the dock, metres, over so much path.
const PRESS_FROM_M: f32 = 0.02;
const PRESS_M: f32 = 0.1;
/// No part of docking takes longer, microseconds.
const LONGEST_US: u64 = 20_000_000;
/// How far beside the dock's middle each try aims, metres, in rounds of three: a pose is off by a centimetre or two, and by more after a kick,
/// but the readings of each try make it better.
const ASIDE_M: [[f32; 3]; 3] = [[0.0, 0.02, -0.02], [0.0, 0.05, -0.05], [0.0, 0.08, -0.08]];
/// After so many ways home and rounds it is not in the dock.
const MAX_ROUNDS: u8 = 6;

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
    /// Back out after a try in vain.
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

    /// One step of docking.
    pub(super) fn dock_step(
        &mut self,
        stage: Stage,
        tries: u8,
        condition: &Condition,
        pose: &Pose,
        now_us: u64,
    ) -> (f32, f32) {
        if condition.is_charging && matches!(stage, Stage::Approaching | Stage::Pressing) {
            self.arrive_in_dock(now_us);
            return (0.0, 0.0);
        }
        let next = |stage| Phase::Dock { stage, tries };
        let [before_m, left_m, off_rad] = self.before_dock(pose);
        let round = ASIDE_M[usize::from(self.retries) % ASIDE_M.len()];
        let aside_m = round.get(usize::from(tries)).copied().unwrap_or(0.0);
        let elapsed_us = now_us.saturating_sub(self.since_us);
        let straight = (3.0 * -off_rad - 10.0 * (left_m - aside_m).clamp(-0.05, 0.05)).clamp(-0.5, 0.5);
        if elapsed_us > LONGEST_US {
            self.try_again(tries, now_us);
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
                // Standing begins when it looks to the dock; a turn takes as long as it takes.
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
                if before_m < PRESS_FROM_M {
                    self.begin(next(Stage::Pressing), now_us);
                }
                (APPROACH_MPS, straight)
            }
            Stage::Pressing => {
                // By time, too: against the dock the wheels may slip.
                let most_us = (1.5e6 * PRESS_M / PRESS_MPS) as u64;
                if self.path_m - self.begun_m > PRESS_M || elapsed_us > most_us {
                    self.begin(next(Stage::BackingOut), now_us);
                }
                (PRESS_MPS, 0.0)
            }
            Stage::BackingOut => {
                if before_m > 0.5 * STAGING_M {
                    self.try_again(tries, now_us);
                }
                (-APPROACH_MPS, 0.0)
            }
        }
    }

    /// After three tries it comes anew, every second time from farther along the walls, which tell it where it is.
    fn try_again(&mut self, tries: u8, now_us: u64) {
        let tries = tries + 1;
        if usize::from(tries) < ASIDE_M[0].len() {
            self.begin(Phase::Dock { stage: Stage::Staging, tries }, now_us);
        } else if self.retries < MAX_ROUNDS {
            self.come_again(now_us);
        } else {
            self.begin(Phase::Over { is_home: false }, now_us);
        }
    }

    fn arrive_in_dock(&mut self, now_us: u64) {
        match self.errand {
            Errand::Finish(_) => self.begin(Phase::Over { is_home: true }, now_us),
            Errand::Sweep { .. } | Errand::Recharge => self.begin(Phase::Charge, now_us),
        }
    }

    /// In the dock until the battery is full; then on with the floor.
    pub(super) fn charge(&mut self, condition: &Condition, now_us: u64) -> (f32, f32) {
        if !condition.is_charging {
            self.begin(Phase::Dock { stage: Stage::Pressing, tries: 0 }, now_us);
        } else if self.battery_v.is_nan() || self.battery_v > self.config.full_v {
            self.errand = Errand::Sweep { again: false };
            // What barred its ways before may be gone.
            self.retries = 0;
            self.begin(Phase::Undock, now_us);
        }
        (0.0, 0.0)
    }

    /// Takes note of the battery: where it is nearly empty, the robot goes home.
    pub(super) fn watch_battery(&mut self, condition: &Condition, now_us: u64) {
        let Some(battery_v) = condition.battery_v.filter(|battery_v| battery_v.is_finite()) else { return };
        if self.battery_v.is_nan() {
            self.battery_v = battery_v;
        }
        // A mean over two seconds: motors that start pull the voltage down.
        self.battery_v += 0.02 * (battery_v - self.battery_v);
        let is_sweeping = !matches!(self.phase, Phase::Over { .. } | Phase::Charge | Phase::Paused | Phase::Lost);
        if self.errand.is_to_sweep() && self.battery_v < self.config.low_v && is_sweeping {
            self.errand = Errand::Recharge;
            self.go_about(now_us);
        }
    }
}
