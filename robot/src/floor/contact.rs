//! What the job does where it runs into something, or gets nowhere.

use slam_core::Pose;
use slam_core::angle::wrap;

use super::near::free_ahead_m;
use super::place::Place;
use super::trail::APART_M;
use super::wave::{Aim, Target};
use super::{FloorJob, Phase};
use crate::contact::Contacts;
use crate::pilot::Senses;
use crate::pilot::memory::Cell;
use crate::pilot::steer::limited;

/// Without coming 5 cm farther for so long, the way is given up, microseconds.
const PATIENCE_US: u64 = 6_000_000;
/// Backing off takes this long, microseconds.
const BACK_US: u64 = 300_000;
/// Bumps nearer to each other than this are at one place, metres; after so many there the robot is stuck.
const AWAY_M: f32 = 0.12;
const MAX_STRIKES: u8 = 60;
/// It turns away by this much longer for each bump at one place, microseconds.
const TURN_US: u64 = 150_000;
/// So far it goes back the way that it came from where it is stuck, metres; a point of it is passed where it is this near, and left out
/// after so long, microseconds.
const RETREAT_M: f32 = 1.0;
const PASSED_M: f32 = 0.08;
const RETREAT_US: u64 = 4_000_000;
/// So often the robot is held at one place until it stands for so long, microseconds: its motors stay cool.
const MAX_HOLDS: u8 = 3;
const HELD_US: u64 = 60_000_000;
/// A robot that sees nothing stands for so long, microseconds: it goes blindly for a tenth of the time at most.
const BLIND_US: u64 = 300_000_000;
/// A point that the bumper felt is kept so long, microseconds.
const FELT_US: u64 = 30_000_000;

impl<const S: usize> FloorJob<S> {
    /// Answers what it meets on its way over the floor; speed and turn rate where that needs no other phase.
    pub(super) fn answer(&mut self, senses: &Senses<S>, pose: &Pose) -> Option<(f32, f32)> {
        let now_us = senses.time_us;
        let is_still = self.traction.is_held() && !self.is_nothing_in_reach(pose);
        // A search stands and ends by itself: through a large home it takes longer.
        let is_searching = matches!(self.phase, Phase::Plan { .. });
        if is_still && self.holds + 1 >= MAX_HOLDS && self.sees_nothing() {
            // Wheels alone said where it was.
            self.doubt_what_it_swept();
            self.begin(Phase::Blind, now_us);
        } else if is_still || senses.condition.is_stalled {
            self.be_held(now_us);
        } else if senses.condition.is_charging {
            self.meet_dock(pose, now_us);
        } else if senses.contacts.any() {
            self.touch(&senses.contacts, pose, now_us);
        } else if !is_searching && now_us.saturating_sub(self.moved.1) > PATIENCE_US {
            self.lose_patience(pose, now_us);
        } else {
            return self.look_about(now_us);
        }
        None
    }

    /// Turns on the spot and back where nothing that it sees changes. Away from an edge first: on a way round what stands there its readings
    /// would stay as they are, too, and tell nothing.
    fn look_about(&mut self, now_us: u64) -> Option<(f32, f32)> {
        let turn_radps = self.traction.look_about(self.config.drive.turn_radps, now_us)?;
        let side = if let Phase::Edge { side } = self.phase { side } else { 1.0 };
        Some((0.0, side * turn_radps))
    }

    /// Remembers what was touched and backs off from it.
    pub(super) fn touch(&mut self, contacts: &Contacts, pose: &Pose, now_us: u64) {
        let Contacts { bump_left, bump_right, .. } = *contacts;
        if let Some(beyond_m) = self.strike(contacts, pose, now_us) {
            self.sheet.picture.block(self.sheet.picture.cell_at(beyond_m[0], beyond_m[1]));
        }
        self.turn_sign = if bump_left == bump_right {
            self.turn_sign
        } else if bump_left {
            -1
        } else {
            1
        };
        if matches!(self.phase, Phase::Transit { .. }) {
            self.block_narrow();
        }
        self.resume = self.phase;
        if self.strikes > MAX_STRIKES {
            self.resume = Phase::Over { is_home: false };
        } else if self.strikes > 0 && self.strikes.is_multiple_of(8) {
            // A place hardly wider than the body: it turns to where it cannot go.
            self.turn_sign = -self.turn_sign;
            self.give_up();
            self.begin_retreat(now_us);
            return;
        }
        self.phase = Phase::Back;
        self.since_us = now_us;
    }

    /// It ran into something here, or lost patience; whether it did so here before.
    fn count_strike(&mut self, pose: &Pose) -> bool {
        let [x_m, y_m] = self.struck_m;
        let is_again = slam_core::pose::length(pose.x_m - x_m, pose.y_m - y_m) < AWAY_M;
        if is_again {
            self.strikes = self.strikes.saturating_add(1);
        } else {
            (self.struck_m, self.strikes) = ([pose.x_m, pose.y_m], 0);
        }
        is_again
    }

    /// Remembers what was touched, and how often here; a point beyond it (metres) where that was not known to be near.
    fn strike(&mut self, contacts: &Contacts, pose: &Pose, now_us: u64) -> Option<[f32; 2]> {
        self.count_strike(pose);
        let Contacts { bump_left, bump_right, .. } = *contacts;
        let bearing_rad = f32::from(i8::from(bump_left) - i8::from(bump_right)) * 0.6;
        let radius_m = self.config.drive.radius_m;
        let (s, c) = slam_core::angle::sin_cos(bearing_rad);
        // Each half of the bumper is felt up to a quarter turn from straight ahead.
        let sector_rad = [if bump_right { -1.4 } else { -0.3 }, if bump_left { 1.4 } else { 0.3 }];
        if self.near.touch(sector_rad, radius_m, pose, now_us) {
            return None;
        }
        self.near.add(
            pose.transform([radius_m * c, radius_m * s]),
            [0.0; 2],
            now_us.saturating_add(FELT_US),
            pose,
            now_us,
        );
        Some(pose.transform([(radius_m + 0.06) * c, (radius_m + 0.06) * s]))
    }

    /// Backs off from what it touched while it is lost, and turns away from the wall that it goes along, farther each time: none where it
    /// touched nothing of late.
    pub(super) fn shy(&mut self, contacts: &Contacts, pose: &Pose, now_us: u64) -> Option<(f32, f32)> {
        if contacts.any() {
            self.strike(contacts, pose, now_us);
            self.since_us = now_us;
        }
        if !self.struck_m[0].is_finite() {
            return None;
        }
        let turn_us = u64::from(self.strikes.min(10) + 1) * TURN_US;
        match now_us.saturating_sub(self.since_us) {
            ..=BACK_US if !self.is_blocked_behind(pose, now_us) => Some((-0.5 * self.config.drive.speed_mps, 0.0)),
            elapsed_us if elapsed_us <= BACK_US + turn_us => Some((0.0, 0.8)),
            _ => None,
        }
    }

    fn is_blocked_behind(&self, pose: &Pose, now_us: u64) -> bool {
        let behind = self.near.seen_from(pose, now_us).map(|[x_m, y_m]| [-x_m, -y_m]);
        free_ahead_m(behind, self.config.drive.radius_m) < 0.015
    }

    /// Goes back the way that it came.
    pub(super) fn begin_retreat(&mut self, now_us: u64) {
        self.begin(Phase::Retreat { left_m: RETREAT_M }, now_us);
    }

    /// Backwards along the way that it came, whatever it touches, and on with the errand from there.
    pub(super) fn retreat(&mut self, left_m: f32, pose: &Pose, now_us: u64) -> (f32, f32) {
        let Some([x_m, y_m]) = self.trail.last_m().filter(|_| left_m > 0.0) else {
            self.go_about(now_us);
            return (0.0, 0.0);
        };
        let [dx, dy] = [x_m - pose.x_m, y_m - pose.y_m];
        let is_there = slam_core::pose::length(dx, dy) < PASSED_M;
        if is_there || now_us.saturating_sub(self.since_us) > RETREAT_US {
            self.trail.drop_last();
            self.begin(Phase::Retreat { left_m: left_m - APART_M }, now_us);
        }
        // Its back towards the point.
        let drive = &self.config.drive;
        let off_rad = wrap(libm::atan2f(-dy, -dx) - pose.theta_rad);
        let forward_mps = if off_rad.abs() < 0.1 { -0.5 * drive.speed_mps } else { 0.0 };
        (forward_mps, limited(3.0 * off_rad, drive.turn_radps))
    }

    /// Turns away from what was touched, farther each time.
    pub(super) fn turn_away(&mut self, sign: f32, now_us: u64) -> (f32, f32) {
        let time_us = u64::from(self.strikes.min(10)) * TURN_US;
        if now_us.saturating_sub(self.since_us) > time_us {
            self.go_on(now_us);
        }
        (0.0, 0.8 * sign)
    }

    /// Backs off. What is touched after it came that far is nothing that stands on the floor.
    pub(super) fn back(&mut self, senses: &Senses<S>, pose: &Pose) -> (f32, f32) {
        let now_us = senses.time_us;
        let is_off = now_us.saturating_sub(self.since_us) > BACK_US;
        if is_off || self.is_blocked_behind(pose, now_us) {
            if is_off && self.insistence.is_for_good() {
                self.begin(Phase::Touched { by: senses.contacts }, now_us);
            } else if self.strikes > 1 {
                self.phase = Phase::Turn { sign: self.turn_sign.into() };
                self.since_us = now_us;
            } else {
                self.go_on(now_us);
            }
            return (0.0, 0.0);
        }
        (-0.5 * self.config.drive.speed_mps, 0.0)
    }

    /// Goes on with what backing off interrupted.
    pub(super) fn go_on(&mut self, now_us: u64) {
        let resume = self.resume;
        match resume {
            Phase::Transit { aim, .. } => self.plan(aim, now_us),
            Phase::Lane(lane) | Phase::Enter { lane, .. } => self.next_lane(lane, now_us),
            _ => self.begin(resume, now_us),
        }
    }

    /// The way to what it is after leads nowhere: gives that up, and where it did so before, goes back the way that it came: there was room.
    pub(super) fn lose_patience(&mut self, pose: &Pose, now_us: u64) {
        self.moved = ([pose.x_m, pose.y_m], now_us);
        let is_again = self.count_strike(pose);
        match self.phase {
            Phase::Home | Phase::Dock { .. } | Phase::Transit { aim: Aim::Place(_), .. } => self.return_again(now_us),
            _ => {
                self.give_up();
                self.go_about_from(2, now_us);
            }
        }
        if self.is_over() {
            return;
        }
        if is_again {
            return self.begin_retreat(now_us);
        }
        self.resume = self.phase;
        self.phase = Phase::Back;
        self.since_us = now_us;
    }

    /// The wheels stall, or turn and nothing comes of it: backs off, and after the third time stands for a while.
    pub(super) fn be_held(&mut self, now_us: u64) {
        self.traction.begin();
        self.holds += 1;
        if self.holds >= MAX_HOLDS {
            self.begin(Phase::Held, now_us);
            return;
        }
        self.give_up();
        self.strikes = self.strikes.saturating_add(2);
        self.resume = Phase::Plan { aim: self.aim(), escape: 5, begun: false };
        self.phase = Phase::Back;
        self.since_us = now_us;
    }

    /// Whatever holds it may let go: it tries again now and then.
    pub(super) fn stay_held(&mut self, now_us: u64) -> (f32, f32) {
        if now_us.saturating_sub(self.since_us) > HELD_US {
            self.holds = 0;
            self.go_about(now_us);
        }
        (0.0, 0.0)
    }

    /// Three of four sensors showed nothing for ten seconds: of eight that are dead, one has a spike in that time.
    fn sees_nothing(&self) -> bool {
        let beams = || self.beams.iter().filter(|beam| beam.max_m > 0.0);
        4 * beams().filter(|beam| beam.age == u8::MAX).count() >= 3 * beams().count()
    }

    /// Whether it sees nothing, and as far as is known there is nothing that it could see: in the middle of a hall.
    fn is_nothing_in_reach(&mut self, pose: &Pose) -> bool {
        let reach_m = self.beams.iter().map(|beam| beam.max_m).fold(0.0, f32::max);
        let moves = (core::f32::consts::FRAC_1_SQRT_2 * reach_m / self.config.drive.cell_m) as i16;
        let here = self.sheet.picture.cell_at(pose.x_m, pose.y_m);
        let is_nothing = self.sees_nothing() && !self.sheet.picture.obstacle_within(here, moves);
        if is_nothing {
            self.traction.begin();
        }
        is_nothing
    }

    /// Whatever silenced the sensors may end; one that shows something is a spike. Where nothing is in their reach it has to go and see.
    pub(super) fn stay_blind(&mut self, now_us: u64) -> (f32, f32) {
        let sees = self.beams.iter().filter(|beam| beam.age == 0).count() > 1;
        if sees || now_us.saturating_sub(self.since_us) > BLIND_US {
            self.holds = if sees { 0 } else { MAX_HOLDS - 1 };
            self.traction.begin();
            self.go_about(now_us);
        }
        (0.0, 0.0)
    }

    /// Somebody frees the bumper, or wipes the cliff sensor. What it told of before was nothing.
    pub(super) fn stay_touched(&mut self, by: Contacts, senses: &Senses<S>) -> (f32, f32) {
        if by.struck_since(senses.contacts) {
            self.doubt_what_it_saw();
            self.go_about(senses.time_us);
        }
        (0.0, 0.0)
    }

    /// Leaves the target aside, to be tried once more at the end: what is in the way may be gone then.
    pub(super) fn give_up(&mut self) {
        if let Some(cell) = self.leave() {
            let _ = self.given_up.push(Place::of_m(self.sheet.picture.centre_m(cell)));
        }
    }

    /// Leaves the target for good; its cell, where there is floor left in it.
    pub(super) fn leave(&mut self) -> Option<Cell> {
        let cell = match self.target.take()? {
            Target::Open(cell) | Target::Place(cell) | Target::Exit(cell) => cell,
            Target::Edge { at, .. } => at,
        };
        let is_left = self.sheet.swept.left_in(cell) > 0;
        self.sheet.swept.set(cell, true);
        is_left.then_some(cell)
    }
}
