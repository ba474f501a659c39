//! The floor job on a robot that may keep a map: by which map it goes, and what it is told of where things are.
//!
//! ```text
//! begun -> own     the pose is in the frame of the map that is kept, or none is kept
//! begun -> fresh   a map is kept, and the robot does not know where it is in it: it sweeps by its fresh map
//! fresh -> own     found: what was swept so far lies in the kept map as the robot does; home is where that map began, or the dock that the
//!                  job began in, where it was moved
//! own   -> fresh   lost, and looked for itself for as long a path as what was swept is worth: all anew; home is here where it was
//!                  carried, and else where it was: somebody pushed it aside
//! fresh -> fresh   carried, or that map begins elsewhere now: all anew from here
//! own   -> own     the home was in it twice: what was swept meanwhile lies who knows where; all anew, home is where it was
//! ```

use slam_core::Pose;

use crate::condition::Condition;
use crate::floor::{BRUSH_M, Bounds, FloorJob, FloorState};
use crate::job::{AreaCorner, Whereabouts};
use crate::pilot::Senses;
use crate::traits::WheelSpeeds;

/// A dock that is farther than this from where the map began was moved, metres: fresh maps are off by less where they are found.
const MOVED_M: f32 = 0.3;

/// By which map the job goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Map {
    /// By the one that is kept, or the start's where none is.
    Own,
    /// By the one since the last start or lift, in which the robot has not found itself.
    Fresh,
}

/// What a floor job knows of the map. It is not one with the job, so that the program has the constant of a job that begins once, whoever begins it.
#[derive(Clone, Debug)]
pub(crate) struct Bearings {
    /// By which map it goes, since the first step.
    map: Option<Map>,
    world: Option<u32>,
    redrawn: Option<u32>,
    fresh: u8,
    /// Path without knowing where it is in its own map, metres.
    searched_m: f32,
    /// Somebody lifted it, and it has not found itself since.
    is_carried: bool,
    /// Where it was in the last step, in the map and by the wheels alone.
    last: Option<[Pose; 2]>,
    /// Where the map started, as it was last known.
    started: Pose,
    /// Areas of the kept map as far as they were told, and the corner that comes next.
    bounds: Bounds,
    next_corner: u8,
}

impl Bearings {
    /// Before the first step.
    pub(crate) const fn new() -> Self {
        Self {
            map: None,
            world: None,
            redrawn: None,
            fresh: 0,
            searched_m: 0.0,
            is_carried: false,
            last: None,
            started: Pose::ORIGIN,
            bounds: Bounds::NONE,
            next_corner: 0,
        }
    }

    /// Whether something is to be known of the job after a reset: it is not over, and goes by a map that is there then.
    pub(crate) fn is_worth_noting<const S: usize>(&self, job: &FloorJob<S>) -> bool {
        self.map == Some(Map::Own) && !job.is_over()
    }

    /// The job about to begin is the one that was saved.
    pub(crate) fn go_by_own_map(&mut self) {
        self.map = Some(Map::Own);
    }

    /// Has the job make its step, by the map that is the right one now.
    pub(crate) fn step<const S: usize>(
        &mut self,
        job: &mut FloorJob<S>,
        senses: &Senses<S>,
        whereabouts: &Whereabouts,
    ) -> WheelSpeeds {
        let Whereabouts { is_located, grid_rad, corner, fresh, .. } = *whereabouts;
        let begins_elsewhere = core::mem::replace(&mut self.fresh, fresh) != fresh;
        if begins_elsewhere {
            // Nothing links the two frames.
            self.last = None;
        }
        self.search(senses, whereabouts);
        let map = self.choose_map(job, senses, whereabouts, begins_elsewhere);
        let is_lost = !is_located && map == Map::Own;
        let knows_areas = self.hear_areas(corner);
        if is_located && !knows_areas {
            // Some seconds at most: it may stand before one to stay out of.
            return WheelSpeeds::STOP;
        }
        let bounds = if is_located { &self.bounds } else { &Bounds::NONE };
        let condition = Condition { is_lost, ..senses.condition };
        let speeds = job.step_within(&Senses { condition, ..*senses }, bounds);
        if let Some(grid_rad) = grid_rad.filter(|_| is_located || map == Map::Fresh) {
            job.align(grid_rad);
        }
        speeds
    }

    /// Takes in the next corner of an area, or where the map has one now that was told before; whether all are known.
    fn hear_areas(&mut self, corner: Option<AreaCorner>) -> bool {
        let Some(AreaCorner { index, of, kind, is_first, at_m }) = corner else { return true };
        if index == self.next_corner {
            // A kept map has no more areas than there is room for.
            let _ = self.bounds.add_corner(kind, is_first, at_m);
            self.next_corner += 1;
        } else {
            self.bounds.move_corner(index, at_m);
        }
        self.next_corner >= of
    }

    /// Counts how far it looked for itself.
    fn search<const S: usize>(&mut self, senses: &Senses<S>, whereabouts: &Whereabouts) {
        let reckoned = whereabouts.reckoned;
        let [_, last] = self.last.unwrap_or([reckoned; 2]);
        let moved_m = slam_core::pose::length(reckoned.x_m - last.x_m, reckoned.y_m - last.y_m);
        self.is_carried = senses.contacts.lifted || self.is_carried && !whereabouts.is_located;
        if whereabouts.is_located {
            self.searched_m = 0.0;
        } else if moved_m.is_finite() && !senses.contacts.lifted {
            self.searched_m += moved_m;
        }
    }

    /// By which map it goes from now on. It begins anew where nothing is any more where it was.
    fn choose_map<const S: usize>(
        &mut self,
        job: &mut FloorJob<S>,
        senses: &Senses<S>,
        whereabouts: &Whereabouts,
        begins_elsewhere: bool,
    ) -> Map {
        let Whereabouts { world, redrawn, is_located, start, reckoned, .. } = *whereabouts;
        let is_elsewhere = self.world.replace(world).is_some_and(|before| before != world);
        let is_redrawn = self.redrawn.replace(redrawn).is_some_and(|before| before != redrawn);
        let last = self.last.replace([senses.pose, reckoned]);
        match (self.map, last) {
            (None, _) => {}
            (Some(Map::Fresh), Some([pose, before])) if is_located && !is_elsewhere => {
                let now_in_fresh = pose.compose(&before.inverse().compose(&reckoned));
                let in_map = |fresh: Pose| senses.pose.compose(&now_in_fresh.inverse().compose(&fresh));
                let is_far = |at: &Pose| slam_core::pose::length(at.x_m - start.x_m, at.y_m - start.y_m) > MOVED_M;
                let moved = job.began_in_dock().map(in_map).filter(is_far);
                job.go_on_in(&now_in_fresh, &senses.pose);
                job.go_home_to(moved.unwrap_or(start));
            }
            (Some(Map::Fresh), _) if senses.contacts.lifted || begins_elsewhere => self.begin_anew(job, None),
            (Some(Map::Own), _) if !is_located && self.is_worth_less_than_the_search(job) => {
                self.begin_anew(job, job.home().filter(|_| !self.is_carried));
            }
            _ if is_elsewhere => self.begin_anew(job, None),
            (Some(map), _) => {
                if is_redrawn {
                    self.begin_anew(job, job.home());
                }
                if map == Map::Own && is_located {
                    self.follow_start(job, start);
                }
                return map;
            }
        }
        let map = if is_located { Map::Own } else { Map::Fresh };
        self.map = Some(map);
        self.started = start;
        map
    }

    /// A map holds its walls where they were drawn: what moves, where it knows them better, is where it started, and home with that.
    fn follow_start<const S: usize>(&mut self, job: &mut FloorJob<S>, start: Pose) {
        let before = core::mem::replace(&mut self.started, start);
        let is_near = |home: &Pose| slam_core::pose::length(home.x_m - before.x_m, home.y_m - before.y_m) < MOVED_M;
        if before != start
            && let Some(home) = job.home().filter(is_near)
        {
            job.go_home_to(start.compose(&before.inverse()).compose(&home));
        }
    }

    /// Whether it could have swept again what it knows on the path on which it looked for itself.
    fn is_worth_less_than_the_search<const S: usize>(&self, job: &FloorJob<S>) -> bool {
        job.progress().swept_m2 < BRUSH_M * self.searched_m
    }

    /// Begins anew, with home, and the dock if it is there, where it was; none: here.
    fn begin_anew<const S: usize>(&mut self, job: &mut FloorJob<S>, home: Option<Pose>) {
        let has_dock = job.began_in_dock().is_some();
        match job.state() {
            FloorState::Done | FloorState::Unreached | FloorState::Flat | FloorState::Away => {}
            FloorState::Paused => {
                job.begin_anew();
                job.pause();
            }
            _ => job.begin_anew(),
        }
        if let Some(home) = home {
            job.take_home(home, has_dock);
        }
        self.searched_m = 0.0;
        (self.bounds, self.next_corner) = (Bounds::NONE, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Contacts;
    use crate::floor::{AreaKind, FloorConfig, FloorState};
    use crate::rig::default_rig;

    /// A robot that comes on by 5 cm a step along its wheels' x axis, in a map whose origin lies somewhere in theirs.
    struct Robot {
        job: FloorJob<8>,
        bearings: Bearings,
        steps: u32,
        map: Pose,
        contacts: Contacts,
    }

    impl Robot {
        fn new() -> Self {
            let job = FloorJob::new(FloorConfig::DEFAULT, &default_rig());
            Self { job, bearings: Bearings::new(), steps: 0, map: Pose::ORIGIN, contacts: Contacts::default() }
        }

        fn step(&mut self, whereabouts: &Whereabouts) -> FloorState {
            self.steps += 1;
            let reckoned = Pose::new(0.05 * self.steps as f32, 0.0, 0.0);
            let senses = Senses {
                time_us: 40_000 * u64::from(self.steps),
                pose: self.map.inverse().compose(&reckoned),
                ranges_m: [None; 8],
                contacts: self.contacts,
                condition: Condition::default(),
            };
            self.bearings.step(&mut self.job, &senses, &Whereabouts { reckoned, ..*whereabouts });
            self.job.state()
        }

        fn swept_m2(&self) -> f32 {
            self.job.progress().swept_m2
        }
    }

    const FOUND: Whereabouts = Whereabouts { grid_rad: Some(0.0), ..Whereabouts::START };
    const LOST: Whereabouts = Whereabouts { is_located: false, ..FOUND };

    #[test]
    fn it_sweeps_by_its_fresh_map_and_goes_on_with_that_in_the_kept_one() {
        let mut robot = Robot::new();
        for _ in 0..100 {
            assert_ne!(robot.step(&LOST), FloorState::Lost);
        }
        let by_fresh_map_m2 = robot.swept_m2();
        assert!(by_fresh_map_m2 > 1.0, "{by_fresh_map_m2}");
        // The kept map's frame lies across the fresh one's.
        robot.map = Pose::new(3.0, -2.0, 2.0);
        robot.step(&FOUND);
        robot.step(&FOUND);
        let new_m2 = robot.swept_m2() - by_fresh_map_m2;
        assert!((0.0..0.08).contains(&new_m2), "neither jumped nor forgot: {new_m2}");
    }

    #[test]
    fn carried_in_a_fresh_map_it_begins_anew() {
        let mut robot = Robot::new();
        (0..40).for_each(|_| {
            robot.step(&LOST);
        });
        robot.contacts.lifted = true;
        robot.step(&LOST);
        assert_eq!(robot.swept_m2(), 0.0);
    }

    #[test]
    fn carried_in_its_own_map_it_looks_for_itself_as_long_as_what_it_swept_is_worth() {
        let mut robot = Robot::new();
        (0..100).for_each(|_| {
            robot.step(&FOUND);
        });
        let known_m2 = robot.swept_m2();
        for _ in 0..90 {
            assert_eq!(robot.step(&LOST), FloorState::Lost);
        }
        assert_eq!(robot.swept_m2(), known_m2);
        (0..60).for_each(|_| {
            robot.step(&LOST);
        });
        assert_ne!(robot.step(&LOST), FloorState::Lost);
        assert!(robot.swept_m2() < known_m2, "all anew");
    }

    #[test]
    fn what_is_saved_goes_on_in_the_same_map_only() {
        let mut robot = Robot::new();
        let mut bytes = [0; crate::FLOOR_RECORD_BYTES];
        robot.step(&LOST);
        assert!(!robot.bearings.is_worth_noting(&robot.job), "a fresh map is not there after a reset");
        let mut robot = Robot::new();
        (0..100).for_each(|_| {
            robot.step(&FOUND);
        });
        assert!(robot.bearings.is_worth_noting(&robot.job));
        robot.job.save(3, &mut bytes);
        let mut again = Robot::new();
        again.job.restore(3, &bytes).unwrap();
        again.bearings.go_by_own_map();
        assert_eq!(again.step(&LOST), FloorState::Lost);
        assert_ne!(again.step(&FOUND), FloorState::Lost);
        assert!((again.swept_m2() - robot.swept_m2()).abs() < 0.1);
    }

    #[test]
    fn where_nothing_is_as_it_was_the_job_begins_anew() {
        let mut robot = Robot::new();
        (0..20).for_each(|_| {
            robot.step(&FOUND);
        });
        let before_m2 = robot.swept_m2();
        robot.step(&Whereabouts { world: 1, ..FOUND });
        assert!(robot.swept_m2() < before_m2);
    }

    #[test]
    fn where_a_fresh_map_begins_elsewhere_the_job_begins_anew() {
        let mut robot = Robot::new();
        (0..40).for_each(|_| {
            robot.step(&LOST);
        });
        let before_m2 = robot.swept_m2();
        assert!(before_m2 > 0.2, "{before_m2}");
        robot.map = Pose::new(2.0, 0.0, 0.0);
        let anew = Whereabouts { fresh: 1, ..LOST };
        robot.step(&anew);
        assert_eq!(robot.swept_m2(), 0.0);
        robot.step(&anew);
        robot.step(&anew);
        assert!(robot.swept_m2() > 0.0);
        // In the kept map it is no matter.
        let mut robot = Robot::new();
        (0..40).for_each(|_| {
            robot.step(&FOUND);
        });
        let before_m2 = robot.swept_m2();
        robot.step(&Whereabouts { fresh: 1, ..LOST });
        assert_eq!(robot.swept_m2(), before_m2);
    }

    #[test]
    fn areas_count_when_all_their_corners_are_known() {
        let corners = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]];
        let corner_at = |index: u8, at_m: [f32; 2]| AreaCorner {
            index,
            of: 3,
            kind: AreaKind::KeepOut,
            is_first: index == 0,
            at_m,
        };
        let corner = |index: u8| corner_at(index, corners[usize::from(index)]);
        let mut bearings = Bearings::new();
        assert!(bearings.hear_areas(None), "there are none");
        let known = [1, 0, 0, 2, 1, 2].map(|index| bearings.hear_areas(Some(corner(index))));
        assert_eq!(known, [false, false, false, false, false, true]);
        let mut whole = Bounds::NONE;
        whole.add(AreaKind::KeepOut, &corners).unwrap();
        assert_eq!(bearings.bounds, whole);
        // The map moved where the area is.
        assert!(bearings.hear_areas(Some(corner_at(2, [2.1, 2.2]))));
        let area = bearings.bounds.areas(AreaKind::KeepOut).next();
        assert_eq!(area, Some(&[[1.0, 1.0], [2.0, 1.0], [2.1, 2.2]][..]));
    }

    /// Before one to stay out of it may stand already.
    #[test]
    fn it_stands_until_it_knows_its_areas() {
        let mut robot = Robot::new();
        let corner = |index: u8| {
            Some(AreaCorner {
                index,
                of: 4,
                kind: AreaKind::KeepOut,
                is_first: index == 0,
                at_m: [1.0, f32::from(index)],
            })
        };
        for index in [2, 3, 0, 1, 2] {
            robot.step(&Whereabouts { corner: corner(index), ..FOUND });
            assert_eq!(robot.swept_m2(), 0.0, "corner {index}");
        }
        for index in [3, 0, 1] {
            robot.step(&Whereabouts { corner: corner(index), ..FOUND });
        }
        assert!(robot.swept_m2() > 0.0);
    }

    #[test]
    fn home_is_where_the_map_knows_now_that_it_started() {
        let mut robot = Robot::new();
        robot.step(&FOUND);
        let start = Pose::new(0.2, -0.1, 0.05);
        robot.step(&Whereabouts { start, ..FOUND });
        let home = robot.job.home().expect("a home");
        let off_m = slam_core::pose::length(home.x_m - start.x_m, home.y_m - start.y_m);
        assert!(off_m < 0.06, "{home:?}: a step from it");
        // In another frame than its own map's nothing moves it.
        robot.step(&Whereabouts { start: Pose::new(5.0, 5.0, 0.0), ..LOST });
        assert_eq!(robot.job.home(), Some(home));
        robot.step(&Whereabouts { start, ..FOUND });
        assert_eq!(robot.job.home(), Some(home));
        // A robot that somebody set down elsewhere goes home to there.
        let there = Pose::new(3.0, 2.0, 1.0);
        robot.job.go_home_to(there);
        robot.step(&FOUND);
        assert_eq!(robot.job.home(), Some(there));
    }
}
