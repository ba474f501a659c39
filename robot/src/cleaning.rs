//! The floor job on a robot that keeps a map: what it is told of where things are, and when.

use slam_core::{Pose, Rig};

use crate::condition::Condition;
use crate::floor::{Bounds, FloorConfig, FloorJob, FloorProgress};
use crate::job::{AreaCorner, Whereabouts};
use crate::pilot::Senses;
use crate::pilot::beam::Beam;
use crate::traits::WheelSpeeds;

/// A robot that has not found itself in its kept map after so long a path sweeps by its fresh map, metres: homes that look the same
/// from two places never tell.
const SEARCHED_M: f32 = 20.0;

/// By which map the job knows what is where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Knows {
    /// By the one that it began in.
    Start,
    /// By none: it looks for itself in the kept one.
    Nothing,
    /// By a fresh one: it has not found itself.
    FreshMap,
    /// By the kept one: it has found itself.
    KeptMap,
}

/// A floor job and what it knows of the map.
#[derive(Clone, Debug)]
pub(crate) struct Cleaning<const S: usize> {
    job: FloorJob<S>,
    /// Where it is, since the first step.
    knows: Option<(u32, Knows)>,
    /// The wall of the map that it is told of next; none where it knows all, or wants none.
    next_wall: Option<u8>,
    /// Path while it looked for itself, metres, and where it was last.
    searched_m: f32,
    last: Option<Pose>,
    /// Areas of the kept map as far as they were told, and the corner that comes next.
    bounds: Bounds,
    next_corner: u8,
}

impl<const S: usize> Cleaning<S> {
    /// Of no robot: to be begun.
    pub(crate) const BLANK: Self = Self {
        job: FloorJob::BLANK,
        knows: None,
        next_wall: None,
        searched_m: 0.0,
        last: None,
        bounds: Bounds::NONE,
        next_corner: 0,
    };

    pub(crate) fn begin(&mut self, rig: &Rig<S>) {
        self.job.prepare(FloorConfig::DEFAULT, Beam::of_rig(rig));
    }

    pub(crate) fn pause(&mut self) {
        self.job.pause();
    }

    pub(crate) fn resume(&mut self) {
        self.job.resume();
    }

    pub(crate) fn is_over(&self) -> bool {
        self.job.is_over()
    }

    pub(crate) fn progress(&self) -> FloorProgress {
        self.job.progress()
    }

    pub(crate) fn step(&mut self, senses: &Senses<S>, whereabouts: &Whereabouts) -> WheelSpeeds {
        self.search(&senses.pose, whereabouts.is_located);
        let knows = self.learn(whereabouts);
        let is_lost = !whereabouts.is_located && knows != Knows::FreshMap;
        if !is_lost && let Some(grid_rad) = whereabouts.grid_rad {
            self.job.align(grid_rad);
        }
        if let Some(wall) = whereabouts.wall.filter(|wall| self.next_wall == Some(wall.index)) {
            self.job.know_wall(wall.ends_m);
            self.next_wall = Some(wall.index + 1).filter(|next| *next < wall.of);
        }
        let knows_areas = self.hear_areas(whereabouts.corner) && whereabouts.is_located;
        let bounds = if knows_areas { &self.bounds } else { &Bounds::NONE };
        let condition = Condition { is_lost, ..senses.condition };
        self.job.step_within(&Senses { condition, ..*senses }, bounds)
    }

    /// Takes in the next corner of an area; whether all are known.
    fn hear_areas(&mut self, corner: Option<AreaCorner>) -> bool {
        let Some(AreaCorner { index, of, kind, is_first, at_m }) = corner else { return true };
        if index == self.next_corner {
            // A kept map has no more areas than there is room for.
            let _ = self.bounds.add_corner(kind, is_first, at_m);
            self.next_corner += 1;
        }
        self.next_corner >= of
    }

    /// Counts how far it looked for itself.
    fn search(&mut self, pose: &Pose, is_located: bool) {
        let last = self.last.replace(*pose).unwrap_or(*pose);
        let moved_m = libm::hypotf(pose.x_m - last.x_m, pose.y_m - last.y_m);
        if !is_located && moved_m.is_finite() {
            self.searched_m += moved_m;
        }
    }

    /// By which map it knows what is where from now on; begins anew where nothing is any more where it was.
    fn learn(&mut self, whereabouts: &Whereabouts) -> Knows {
        let Whereabouts { world, is_located, start, .. } = *whereabouts;
        let before = match self.knows {
            Some((known, knows)) if known == world => knows,
            Some(_) => {
                self.begin_anew();
                if is_located { Knows::Start } else { Knows::Nothing }
            }
            None if is_located => Knows::Start,
            None => Knows::Nothing,
        };
        let now = match before {
            Knows::Nothing | Knows::FreshMap if is_located => Knows::KeptMap,
            Knows::Nothing if self.searched_m > SEARCHED_M => Knows::FreshMap,
            _ => before,
        };
        self.knows = Some((world, now));
        if now != before {
            if before == Knows::FreshMap {
                self.begin_anew();
            }
            self.job.go_home_to(start);
            self.next_wall = Some(0);
        }
        now
    }

    fn begin_anew(&mut self) {
        self.job.begin_anew();
        (self.next_wall, self.searched_m) = (None, 0.0);
        (self.bounds, self.next_corner) = (Bounds::NONE, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Contacts;
    use crate::floor::{AreaKind, FloorState};
    use crate::rig::default_rig;

    /// A robot that comes on by 5 cm a step.
    struct Robot {
        cleaning: Cleaning<8>,
        steps: u32,
    }

    impl Robot {
        fn new() -> Self {
            let mut cleaning = Cleaning::BLANK;
            cleaning.begin(&default_rig());
            Self { cleaning, steps: 0 }
        }

        fn step(&mut self, whereabouts: &Whereabouts) -> FloorState {
            self.steps += 1;
            let senses = Senses {
                time_us: 40_000 * u64::from(self.steps),
                pose: Pose::new(0.05 * self.steps as f32, 0.0, 0.0),
                ranges_m: [None; 8],
                contacts: Contacts::default(),
                condition: Condition::default(),
            };
            self.cleaning.step(&senses, whereabouts);
            self.cleaning.progress().state
        }
    }

    const LOST: Whereabouts =
        Whereabouts { world: 0, is_located: false, grid_rad: Some(0.0), start: Pose::ORIGIN, wall: None, corner: None };
    const FOUND: Whereabouts = Whereabouts { is_located: true, ..LOST };

    #[test]
    fn it_looks_for_itself_then_sweeps_by_its_fresh_map_and_begins_anew_when_it_is_found() {
        let mut robot = Robot::new();
        robot.step(&LOST);
        for _ in 0..390 {
            assert_eq!(robot.step(&LOST), FloorState::Lost);
        }
        (0..60).for_each(|_| {
            robot.step(&LOST);
        });
        assert_ne!(robot.step(&LOST), FloorState::Lost);
        let by_fresh_map_m2 = robot.cleaning.progress().swept_m2;
        assert!(by_fresh_map_m2 > 0.2);
        robot.step(&FOUND);
        assert!(robot.cleaning.progress().swept_m2 < by_fresh_map_m2);
        assert_eq!(robot.cleaning.next_wall, Some(0), "the kept map's walls are awaited");
    }

    #[test]
    fn walls_of_the_kept_map_come_one_by_one_from_the_first() {
        let wall = |index| {
            let ends_m = [[0.0, f32::from(index)], [1.0, f32::from(index)]];
            Whereabouts { wall: Some(crate::job::MapWall { index, of: 3, ends_m }), ..FOUND }
        };
        let mut robot = Robot::new();
        robot.step(&LOST);
        let awaited: [Option<u8>; 5] = [2, 0, 2, 1, 2].map(|index| {
            robot.step(&wall(index));
            robot.cleaning.next_wall
        });
        assert_eq!(awaited, [Some(0), Some(1), Some(1), Some(2), None]);
    }

    #[test]
    fn where_nothing_is_as_it_was_the_job_begins_anew() {
        let mut robot = Robot::new();
        (0..20).for_each(|_| {
            robot.step(&FOUND);
        });
        let before_m2 = robot.cleaning.progress().swept_m2;
        robot.step(&Whereabouts { world: 1, ..FOUND });
        assert!(robot.cleaning.progress().swept_m2 < before_m2);
    }

    #[test]
    fn areas_count_when_all_their_corners_are_known() {
        let corners = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]];
        let corner = |index: u8| AreaCorner {
            index,
            of: 3,
            kind: AreaKind::KeepOut,
            is_first: index == 0,
            at_m: corners[usize::from(index)],
        };
        let mut cleaning = Robot::new().cleaning;
        assert!(cleaning.hear_areas(None), "there are none");
        let known = [1, 0, 0, 2, 1, 2].map(|index| cleaning.hear_areas(Some(corner(index))));
        assert_eq!(known, [false, false, false, false, false, true]);
        let mut whole = Bounds::NONE;
        whole.add(AreaKind::KeepOut, &corners).unwrap();
        assert_eq!(cleaning.bounds, whole);
    }
}
