//! What the job is about, whatever it is at: what it comes back to after a pause, a lift or a jump of the pose.

use slam_core::Pose;
use slam_core::angle::wrap;

use super::astray::{Astray, towards};
use super::near::free_ahead_m;
use super::wave::Aim;
use super::{FloorJob, Phase};
use crate::condition::Condition;
use crate::pilot::Senses;
use crate::traits::WheelSpeeds;

/// What the job is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Errand {
    /// To sweep the floor, and then to go home by such a way.
    Sweep { then: Way },
    /// To go home with floor left to sweep, since the battery is nearly empty, and then to sweep it as before.
    Recharge { then: Way },
    /// To go home for good.
    Finish(Way),
}

impl Errand {
    /// To sweep the floor, as a job begins.
    pub(super) const FIRST: Self = Self::Sweep { then: Way::Open };

    pub(super) fn is_to_sweep(self) -> bool {
        matches!(self, Self::Sweep { .. })
    }

    /// The way home for good.
    pub(super) fn way(self) -> Way {
        let (Self::Sweep { then } | Self::Recharge { then } | Self::Finish(then)) = self;
        then
    }
}

/// The way home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Open,
    /// No way was found, or it was blocked: what opens it may lead to floor that was left, too.
    Barred,
    /// It was barred before, and floor that was left was swept since: that is done once.
    SweptAgain,
    /// It was home before and waited there for what barred the way to floor that is left: that is done once, too.
    Waited,
}

/// A pose that moved by more than this, or turned by more, between two steps has jumped: metres and radians.
const JUMP_M: f32 = 0.1;
const JUMP_RAD: f32 = 0.17;
/// When a step was is kept in such units, microseconds, and a step is so many of them. They come round after two seconds: a longer gap is
/// taken for a shorter one.
const TICK_US: u64 = 8000;
const STEP_TICKS: u8 = 5;

/// Where much floor is left behind something that bars the way, the robot waits at home for so long, microseconds, and looks once more: doors are
/// shut for minutes.
const WAIT_US: u64 = 600_000_000;

impl<const S: usize> FloorJob<S> {
    /// Where home is, in the map frame; none before the first step.
    pub(crate) fn home(&self) -> Option<Pose> {
        self.home
    }

    /// The dock that it began in, in the map frame.
    pub(crate) fn began_in_dock(&self) -> Option<Pose> {
        self.home.filter(|_| self.has_dock)
    }

    /// Home is there, in the map frame, metres.
    pub fn go_home_to(&mut self, home: Pose) {
        self.home = Some(home);
    }

    /// Home is there, in the map frame, and whether it is a dock: for a job that was begun anew, which knows of none.
    pub(crate) fn take_home(&mut self, home: Pose, has_dock: bool) {
        (self.home, self.has_dock) = (Some(home), has_dock);
    }

    /// Stops on request: the robot stands until [`FloorJob::resume`].
    pub fn pause(&mut self) {
        if matches!(self.phase, Phase::Wait { .. }) {
            // Who has it go on later does not want it to wait then.
            self.look_once_more();
        }
        if !self.is_over() {
            self.phase = Phase::Paused;
        }
    }

    /// Goes on after a pause, and waits no longer.
    pub fn resume(&mut self) {
        match &mut self.phase {
            Phase::Paused => self.phase = Phase::Plan { aim: self.aim(), escape: 5, begun: false },
            Phase::Wait { is_told } => *is_told = true,
            _ => {}
        }
    }

    /// Where the errand leads.
    pub(super) fn aim(&self) -> Aim {
        match self.errand {
            Errand::Sweep { .. } => Aim::Floor,
            Errand::Recharge { .. } | Errand::Finish(_) => self.aim_home(),
        }
    }

    /// On with the errand from here.
    pub(super) fn go_about(&mut self, now_us: u64) {
        self.go_about_from(5, now_us);
    }

    /// The same from a place that may be narrow for so many cells.
    pub(super) fn go_about_from(&mut self, escape: i16, now_us: u64) {
        self.begin(Phase::Plan { aim: self.aim(), escape, begun: false }, now_us);
    }

    /// Back home for good: over, unless much floor is left that no way led to.
    pub(super) fn come_home(&mut self, now_us: u64) {
        // One that came home for want of charge, and has no dock, has none to look once more with.
        let may_wait = !matches!(self.errand, Errand::Recharge { .. } | Errand::Finish(Way::Waited));
        let waits = may_wait && self.tally.is_room_left() && self.is_path_left();
        self.begin(if waits { Phase::Wait { is_told: false } } else { Phase::Over { is_home: true } }, now_us);
    }

    /// Stands at home; then what barred the way may be gone.
    pub(super) fn wait(&mut self, is_told: bool, now_us: u64) -> (f32, f32) {
        if is_told || now_us.saturating_sub(self.since_us) > WAIT_US {
            self.look_once_more();
            if self.has_dock {
                self.begin(Phase::Undock, now_us);
            } else {
                self.go_about(now_us);
            }
        }
        (0.0, 0.0)
    }

    fn look_once_more(&mut self) {
        self.errand = Errand::Sweep { then: Way::Waited };
        self.doubt_what_bars();
    }

    /// Whether the pose can be used; takes note of a lift.
    pub(super) fn is_located(&mut self, senses: &Senses<S>) -> bool {
        let is_located = !(senses.contacts.lifted || senses.condition.is_lost);
        match self.phase {
            Phase::Over { .. } | Phase::Paused => {}
            Phase::Lost { .. } if is_located => {
                // Before it knew that it was lost it saw things where they are not.
                self.doubt_what_it_saw();
                self.last = None;
                self.go_about(senses.time_us);
            }
            Phase::Lost { .. } => {}
            _ if !is_located => {
                self.near.clear();
                self.last = None;
                self.struck_m = [f32::INFINITY; 2];
                self.astray = Astray::NEW;
                self.begin(Phase::Lost { is_charged: false }, senses.time_us);
            }
            _ => {}
        }
        is_located
    }

    /// What stands where is seen anew; what was swept is known.
    pub(super) fn doubt_what_it_saw(&mut self) {
        self.near.clear();
        self.sheet.picture.doubt_obstacles();
    }

    /// The floor of the last metres is not sure to be swept: the robot was elsewhere.
    pub(super) fn doubt_what_it_swept(&mut self) {
        let quarters = self.trail.undo(&mut self.sheet);
        self.tally.take_back(quarters);
    }

    /// Off the floor the robot stands, and in its dock until the battery is full; else it goes along walls until it is located, after a lap
    /// along others.
    pub(super) fn find_oneself(&mut self, senses: &Senses<S>) -> WheelSpeeds {
        let Phase::Lost { is_charged } = self.phase else { return WheelSpeeds::STOP };
        if senses.contacts.lifted || self.insistence.is_for_good() {
            return WheelSpeeds::STOP;
        }
        let pose = senses.pose;
        let now_us = senses.time_us;
        let Condition { is_charging, is_stalled, .. } = senses.condition;
        if is_charging && !is_charged {
            self.phase = Phase::Lost { is_charged: self.is_charged(now_us) };
            return WheelSpeeds::STOP;
        }
        self.feel(senses, &pose, None);
        let turned_rad = self.last.replace(pose).map_or(0.0, |last| wrap(pose.theta_rad - last.theta_rad));
        let along = self.hug().along(self.near.seen_from(&pose, now_us), 1.0);
        let shy = self.shy(&senses.contacts.or_stopped(is_charging || is_stalled), &pose, now_us);
        let drive = &self.config.drive;
        let free_m = free_ahead_m(self.near.seen_from(&pose, now_us), drive.radius_m);
        let across = self.astray.heading_rad(turned_rad, &pose, free_m);
        let (forward_mps, turn_radps) = match shy.or(across.map(|heading_rad| towards(heading_rad, &pose, drive))) {
            Some(command) => command,
            None if along.is_beside => (along.forward_mps, along.turn_radps),
            None => (drive.speed_mps, 0.0),
        };
        WheelSpeeds::from_twist(forward_mps, turn_radps, drive.track_m)
    }

    /// How much longer ago the last step was than one takes, seconds.
    fn lost_s(&mut self, now_us: u64) -> f32 {
        let now = (now_us / TICK_US) as u8;
        let since = now.wrapping_sub(core::mem::replace(&mut self.stepped_at, now));
        1e-6 * TICK_US as f32 * f32::from(since.saturating_sub(STEP_TICKS))
    }

    /// Where the pose jumps, the floor of the last metres is not sure to be swept, and what was near is elsewhere.
    pub(super) fn watch_jumps(&mut self, pose: &Pose, now_us: u64) {
        let lost_s = self.lost_s(now_us);
        let Some(last) = self.last else { return };
        let moved_m = slam_core::pose::length(pose.x_m - last.x_m, pose.y_m - last.y_m);
        // Where steps are lost the robot drives on meanwhile.
        let most_m = JUMP_M + self.config.open_mps * lost_s;
        let most_rad = JUMP_RAD + self.config.drive.turn_radps * lost_s;
        if moved_m < most_m && wrap(pose.theta_rad - last.theta_rad).abs() < most_rad {
            return;
        }
        self.doubt_what_it_swept();
        self.near.clear();
        self.last = None;
        let is_under_way =
            matches!(self.phase, Phase::Edge { .. } | Phase::Transit { .. } | Phase::Enter { .. } | Phase::Lane(_));
        if is_under_way {
            self.go_about(now_us);
        }
    }
}
