//! Between the pieces of floor: looking for the next one, on the way there, and home.

use slam_core::Pose;
use slam_core::angle::wrap;

use super::areas::within_picture;
use super::errand::{Errand, Way};
use super::near::free_ahead_m;
use super::swept::{BRUSH_M, CELLS};
use super::wave::{Aim, Slice, Target};
use super::{FloorJob, FloorProgress, Phase};
use crate::pilot::memory::Cell;
use crate::pilot::search::is_passable;
use crate::pilot::steer::limited;

/// A target whose way was blocked more often is given up.
const MAX_BLOCKED: u8 = 4;
/// Where a search reaches fewer cells than this the robot is in a pocket, which it leaves along its walls for so long a path
/// (metres), so often at most.
const POCKET: u16 = 40;
const POCKET_M: f32 = 2.0;
const MAX_POCKETS: u8 = 12;
/// As far from where it is as the picture reaches, in cells.
const ANYWHERE: i16 = CELLS as i16;
/// A job that has swept less than this of the floor that it has seen is not done: that is what is aimed at.
const SWEPT_SHARE: f32 = 0.96;
/// A way through narrow places is looked for where much floor is left; so many of them are tried at most.
const MAX_SQUEEZES: u8 = 12;
/// So many where little was seen of what is behind: each takes ten seconds, in which half a square metre is swept elsewhere.
const FEW_SQUEEZES: u8 = 3;
/// A way home is looked for so often.
const MAX_RETURNS: u8 = 12;
/// After so many it is what was seen that bars the way.
const DOUBTED_RETURNS: u8 = 4;
/// Home is this near, metres.
const HOME_M: f32 = 0.03;

impl<const S: usize> FloorJob<S> {
    /// What cells were called before they are other places by now.
    pub(super) fn rename_cells(&mut self) {
        self.route.clear();
        self.target = None;
        self.is_noted = false;
        self.areas.draw_anew();
    }

    pub(super) fn plan(&mut self, aim: Aim, time_us: u64) {
        self.begin(Phase::Plan { aim, escape: 2, begun: false }, time_us);
    }

    /// Where home is, in the job's frame: the place in front of the dock, where there is one.
    pub(super) fn home_m(&self) -> [f32; 2] {
        let home = self.frame.pose(&self.home.unwrap_or(Pose::ORIGIN));
        if self.has_dock { self.staging_m() } else { [home.x_m, home.y_m] }
    }

    fn is_home_in_picture(&self) -> bool {
        let [x_m, y_m] = self.home_m();
        self.sheet.picture.is_inside(self.sheet.picture.cell_at(x_m, y_m))
    }

    pub(super) fn aim_home(&self) -> Aim {
        let [x_m, y_m] = self.home_m();
        let cell = self.sheet.picture.cell_at(x_m, y_m);
        // As far as the picture reaches: it moves on before the robot is there.
        match self.areas.dares {
            true => Aim::Place(within_picture(cell)),
            false if self.sheet.picture.is_inside(cell) => Aim::Place(cell),
            false => Aim::Away,
        }
    }

    /// Whether nothing came of what it was after.
    pub(super) fn is_target_left(&self) -> bool {
        match self.target {
            Some(Target::Edge { at, .. }) => self.sheet.swept.left_in(at) == 4,
            Some(Target::Open(cell)) => self.gained == 0 && self.sheet.swept.left_in(cell) > 0,
            _ => false,
        }
    }

    /// What it was after is done, or cannot be done from here: on to the next.
    pub(super) fn finish_target(&mut self, now_us: u64) {
        if self.is_target_left() {
            // It was there, nothing stood in its way, and the brush does not reach it.
            self.leave();
        }
        self.target = None;
        self.go_about_from(2, now_us);
    }

    pub(super) fn search(&mut self, aim: Aim, escape: i16, begun: bool, pose: &Pose, now_us: u64) -> (f32, f32) {
        if self.waits_for_areas(aim) {
            return (0.0, 0.0);
        }
        if aim == Aim::Away {
            self.find_exit(now_us);
            return (0.0, 0.0);
        }
        if !begun {
            let here = self.sheet.picture.cell_at(pose.x_m, pose.y_m);
            let dares = self.areas.begin_search();
            self.sheet.begin_search(matches!(aim, Aim::Exit(_)), self.errand.is_to_sweep());
            self.wave.begin(here, escape, dares);
            self.phase = Phase::Plan { aim, escape, begun: true };
        }
        match self.wave.search(&mut self.sheet, aim) {
            Slice::More => {}
            Slice::Found(_) if self.leads_to_what_was_left() => self.sweep_again(now_us),
            Slice::Found(target) => {
                if self.target.replace(target) != Some(target) {
                    (self.gained, self.blocked) = (0, 0);
                }
                self.squeezes += u8::from(escape == ANYWHERE);
                self.route.clear();
                self.begin(Phase::Trace { target, aim }, now_us);
            }
            Slice::Nothing if escape < 5 => self.begin(Phase::Plan { aim, escape: 5, begun: false }, now_us),
            Slice::Nothing => match self.squeeze_to(aim, escape) {
                Some(aim) => self.begin(Phase::Plan { aim, escape: ANYWHERE, begun: false }, now_us),
                None => self.find_nothing(aim, now_us),
            },
        }
        (0.0, 0.0)
    }

    /// The way home is blocked: what the bumper felt may be gone. Then the robot goes straight through what it has not seen, for where it was
    /// before it knew its grid is not in the picture, and from farther along the walls, by turns. Walls that led to new floor are no try.
    pub(super) fn return_again(&mut self, now_us: u64) {
        // What is beyond the picture is not barred.
        if self.errand == Errand::Finish(Way::Open) && self.is_home_in_picture() {
            self.errand = Errand::Finish(Way::Barred);
        }
        let leads_on = core::mem::take(&mut self.gained) > 0;
        if !leads_on {
            self.retries = self.retries.saturating_add(1);
        }
        let is_first = !leads_on && self.retries == 1;
        let along_walls = self.areas.settle() || (self.areas.is_spent() && !is_first);
        self.areas.dares = !along_walls && !is_first;
        if self.retries > MAX_RETURNS {
            self.begin(Phase::Over { is_home: false }, now_us);
        } else {
            self.come_again(along_walls, now_us);
        }
    }

    /// Looks for home anew from here, or from farther along the walls.
    pub(super) fn come_again(&mut self, along_walls: bool, now_us: u64) {
        self.blocked = 0;
        match self.retries {
            0..=DOUBTED_RETURNS => self.sheet.picture.forget_visits(),
            _ => self.sheet.picture.doubt_obstacles(),
        }
        if along_walls {
            self.begin_along_walls(now_us);
        } else {
            self.go_about(now_us);
        }
    }

    /// Along the walls from here, as far as leads out of a pocket.
    fn begin_along_walls(&mut self, now_us: u64) {
        self.begin_edge(1.0, now_us);
        self.credit_m = POCKET_M;
    }

    /// What to look for next through places that seem too narrow, after a search for this found nothing: a door may seem so, by bumps and by cells
    /// that its frame or somebody in it shares.
    fn squeeze_to(&self, aim: Aim, escape: i16) -> Option<Aim> {
        let is_first = escape < ANYWHERE;
        let tries_little = self.squeezes < FEW_SQUEEZES;
        match aim {
            _ if self.squeezes >= MAX_SQUEEZES => None,
            Aim::Floor if is_first && self.is_much_left() => Some(aim),
            // Little was seen of it: there may be a room.
            Aim::Floor => (tries_little && self.wave.reached >= POCKET).then_some(Aim::Beyond),
            Aim::Beyond => (tries_little && is_first).then_some(aim),
            Aim::Place(_) | Aim::Away | Aim::Exit(_) => is_first.then_some(aim),
        }
    }

    /// Whether the way home that was found opened after it had been barred: nobody knows how much floor was barred with it. It is swept once.
    fn leads_to_what_was_left(&self) -> bool {
        self.errand == Errand::Finish(Way::Barred) && !self.areas.dares && self.is_home_in_picture()
    }

    fn sweep_again(&mut self, now_us: u64) {
        self.errand = Errand::Sweep { then: Way::SweptAgain };
        self.go_about(now_us);
    }

    /// What bars the way may be gone, or have been seen from elsewhere than the robot believed.
    pub(super) fn doubt_what_bars(&mut self) {
        self.retries = 2;
        self.squeezes = 0;
        self.sheet.picture.doubt_obstacles();
    }

    /// Whether much is left: a room, or so much in scraps that it is not what lies about beside furniture.
    fn is_much_left(&self) -> bool {
        self.tally.is_room_left() || self.progress().share() < SWEPT_SHARE
    }

    /// Whether it drove less than it would take to sweep all that it has seen twice: it is to come home in the end, too.
    pub(super) fn is_path_left(&self) -> bool {
        let FloorProgress { swept_m2, left_m2, .. } = self.progress();
        BRUSH_M * self.path_m < 2.0 * (swept_m2 + left_m2)
    }

    /// Takes the way to the target from the search: a step of its own, since it may be long.
    pub(super) fn trace(&mut self, target: Target, aim: Aim, now_us: u64) -> (f32, f32) {
        self.route = self.wave.route(&self.sheet, target);
        self.begin(Phase::Transit { target, aim }, now_us);
        (0.0, 0.0)
    }

    pub(super) fn find_nothing(&mut self, aim: Aim, now_us: u64) {
        if self.areas.may_dare() {
            self.areas.dares = true;
            self.go_about(now_us);
        } else if let (Aim::Exit(exit), true) = (aim, self.errand.is_to_sweep()) {
            self.give_up_exit(exit);
            self.go_about(now_us);
        } else if matches!(aim, Aim::Place(_) | Aim::Exit(_)) {
            self.return_again(now_us);
        } else if self.wave.reached < POCKET && self.pockets < MAX_POCKETS {
            // It came into a pocket along its walls, and so it gets out.
            self.pockets += 1;
            self.begin_along_walls(now_us);
        } else if aim != Aim::Away && self.may_leave() {
            self.plan(Aim::Away, now_us);
        } else if self.retries == 0 && (self.is_much_left() || !self.given_up.is_empty() || self.areas.missed != 0) {
            self.retries = 1;
            self.sheet.picture.forget_visits();
            while let Some(place) = self.given_up.pop() {
                let [x_m, y_m] = place.at_m();
                self.sheet.swept.set(self.sheet.picture.cell_at(x_m, y_m), false);
            }
            self.plan(Aim::Floor, now_us);
        } else if self.retries == 1 && self.is_much_left() && self.is_path_left() {
            self.doubt_what_bars();
            self.plan(Aim::Floor, now_us);
        } else {
            self.errand = Errand::Finish(self.errand.way());
            self.gained = 0;
            self.areas.turn_home();
            self.go_about(now_us);
        }
    }

    pub(super) fn transit(&mut self, target: Target, aim: Aim, pose: &Pose, now_us: u64) -> (f32, f32) {
        let here_m = [pose.x_m, pose.y_m];
        // On to the farthest of the next cells that a straight line leads to.
        let is_straight =
            |cell: &[u8; 2]| self.sheet.is_passable(here_m, self.sheet.picture.centre_m(Cell::unpacked(*cell)));
        let skip = (0..6).rev().find(|ahead| self.route.iter().rev().nth(*ahead).is_some_and(is_straight));
        self.route.truncate(self.route.len() - skip.unwrap_or(0));
        let Some(next) = self.route.last() else {
            let here = self.sheet.picture.cell_at(pose.x_m, pose.y_m);
            if here.moves_to(target.stand()) <= 1 {
                self.arrive(target, pose, now_us);
            } else {
                // Of a long way only the first part is remembered.
                self.plan(aim, now_us);
            }
            return (0.0, 0.0);
        };
        let to_m = self.sheet.picture.centre_m(Cell::unpacked(*next));
        if self.sees_obstacle_on_way() {
            self.plan(aim, now_us);
            return (0.0, 0.0);
        }
        if slam_core::pose::length(to_m[0] - here_m[0], to_m[1] - here_m[1]) < 0.06 {
            self.route.pop();
        }
        let command = self.towards(to_m, pose, now_us);
        if command.0 <= 0.01 && command.1.abs() < 0.1 && self.blocked > MAX_BLOCKED {
            self.lose_patience(pose, now_us);
        } else if command.0 <= 0.01 && command.1.abs() < 0.1 {
            // Something stands in the way.
            self.block_narrow();
            let [x_m, y_m] = pose.transform([self.config.drive.radius_m + 0.06, 0.0]);
            self.sheet.picture.block(self.sheet.picture.cell_at(x_m, y_m));
            self.blocked += 1;
            self.plan(aim, now_us);
        }
        command
    }

    /// The next cell of the way cannot be driven to: where it is narrow there is no way, and the next search finds another one.
    pub(super) fn block_narrow(&mut self) {
        let next = self.route.last().map(|cell| Cell::unpacked(*cell));
        if let Some(cell) = next.filter(|cell| !is_passable(&self.sheet.picture, *cell)) {
            self.sheet.picture.block(cell);
        }
    }

    /// A forward speed and a turn rate straight to a point, metres.
    pub(super) fn towards(&self, to_m: [f32; 2], pose: &Pose, now_us: u64) -> (f32, f32) {
        let drive = &self.config.drive;
        let bearing_rad = libm::atan2f(to_m[1] - pose.y_m, to_m[0] - pose.x_m);
        let off_rad = wrap(bearing_rad - pose.theta_rad);
        let aligned = (1.0 - off_rad.abs() / 0.6).max(0.0);
        let free_m = free_ahead_m(self.near.seen_from(pose, now_us), drive.radius_m + 0.004);
        let forward_mps = (self.config.open_mps * aligned).min(2.0 * (free_m - 0.01)).max(0.0);
        (forward_mps, limited(3.0 * off_rad, drive.turn_radps))
    }

    pub(super) fn arrive(&mut self, target: Target, pose: &Pose, now_us: u64) {
        let dared = self.areas.settle();
        match target {
            Target::Place(_) if self.leads_to_what_was_left() => self.sweep_again(now_us),
            Target::Place(_) if self.has_dock => self.begin_docking(now_us),
            Target::Place(_) => self.begin(Phase::Home, now_us),
            Target::Exit(_) => self.go_about(now_us),
            // What it sees from there tells where to begin.
            _ if dared => self.finish_target(now_us),
            Target::Edge { at, .. } => {
                self.begin(Phase::Seek { to_m: Some(self.sheet.picture.centre_m(at)) }, now_us);
            }
            Target::Open(cell) => match self.first_lane(cell, pose) {
                Some((lane, at_m)) => self.begin(Phase::Enter { lane, at_m }, now_us),
                None => {
                    self.leave();
                    self.plan(Aim::Floor, now_us);
                }
            },
        }
    }

    pub(super) fn go_home(&mut self, pose: &Pose, now_us: u64) -> (f32, f32) {
        let [x_m, y_m] = self.home_m();
        if slam_core::pose::length(x_m - pose.x_m, y_m - pose.y_m) < HOME_M {
            self.come_home(now_us);
        }
        self.towards([x_m, y_m], pose, now_us)
    }
}
