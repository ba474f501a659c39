//! By which map a floor job goes, step by step.

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

/// A map that is begun anew counts its second copies from 0: that draws nothing again.
#[test]
fn where_the_map_is_redrawn_the_job_begins_anew() {
    let mut robot = Robot::new();
    let mut drive = |redrawn: u32| {
        (0..20).for_each(|_| {
            robot.step(&Whereabouts { redrawn, ..FOUND });
        });
        robot.swept_m2()
    };
    let [first_m2, after_reset_m2, redrawn_m2] = [2, 0, 1].map(&mut drive);
    assert!(after_reset_m2 > 1.5 * first_m2, "{after_reset_m2} m2 after {first_m2}");
    assert!(redrawn_m2 < 1.5 * first_m2, "{redrawn_m2} m2 after {first_m2}");
}

#[test]
fn areas_count_when_all_their_corners_are_known() {
    let corners = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]];
    let corner_at =
        |index: u8, at_m: [f32; 2]| AreaCorner { index, of: 3, kind: AreaKind::KeepOut, is_first: index == 0, at_m };
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
        Some(AreaCorner { index, of: 4, kind: AreaKind::KeepOut, is_first: index == 0, at_m: [1.0, f32::from(index)] })
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

#[test]
fn home_stays_where_it_was_saved() {
    let (mut robot, mut bytes) = (Robot::new(), [0; crate::FLOOR_RECORD_BYTES]);
    let found = Whereabouts { start: Pose::new(0.15, -0.1, 0.06), ..FOUND };
    robot.step(&FOUND);
    robot.step(&found);
    robot.job.save(3, &mut bytes);
    let mut again = Robot::new();
    again.job.restore(3, &bytes).unwrap();
    again.bearings.go_by_own_map();
    again.step(&Whereabouts { is_located: false, ..found });
    again.step(&found);
    assert_eq!(again.job.home(), robot.job.home());
}
