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
    /// Where the map started, as it was last known; no number before that.
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
            started: Pose { x_m: f32::NAN, y_m: f32::NAN, theta_rad: f32::NAN },
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
        // A map that is begun anew counts from 0 again.
        let is_redrawn = self.redrawn.replace(redrawn).is_some_and(|before| redrawn > before);
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
        // No home is near a start that was not known: after a reset it is where it was saved.
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
mod tests;
