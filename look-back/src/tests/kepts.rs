//! A drive in a map that was there before.

use std::vec::Vec;

use nalgebra::{Matrix3, Vector3};
use slam_core::kept::{Direction, Kept, KeptFrame, KeptWall, POSE_STATES};
use slam_core::{Displaced, Pose};

use super::drive::{DRIVE, Robot};
use super::random::Random;
use crate::gains::Gains;
use crate::{Diary, LookBack, Progress, Unknown, border_len, packed_len};

const W: usize = 16;
const B: usize = border_len(W);
type SmallDiary = Diary<64, 256, W>;
type Small = LookBack<64, W, B, { packed_len(B) }>;

/// 1-sigma of where the map as a whole is, of how it is turned, and of each wall by itself: metres and radians.
const MOVED_M: f64 = 0.02;
const TURNED_RAD: f64 = 0.01;
const OWN_M: f64 = 0.004;

/// The number of a wall that the robot never sees.
const FAR: usize = 4;
const FAR_ID: u16 = 50;

/// Numbers of two walls of another room, and how far apart they are, metres; how well that room is known along their normal, 1-sigma, metres.
const OTHER_ROOM: [usize; 2] = [5, 6];
const APART_M: f64 = 0.3;
const ROOM_M: f64 = 0.05;

/// A map of the room's four walls, of one far away, and of two in another room, with errors that all share, that those two share, and own ones.
struct Map {
    alpha_rad: f64,
    /// Offset and direction of the normal of each.
    walls: Vec<[f64; 2]>,
    /// By x, y and turn of the whole, and by the other room's place, of each offset.
    by: Vec<[f64; 4]>,
}

impl Map {
    fn of(robot: &Robot, random: &mut Random) -> (Self, Pose) {
        let [x, y, turn] = [MOVED_M, MOVED_M, TURNED_RAD].map(|sigma| sigma * random.normal());
        let mut room = robot.walls();
        room.extend([(20.0, [1.0, 0.0]), (30.0, [1.0, 0.0]), (30.0 + APART_M, [1.0, 0.0])]);
        let walls =
            room.iter().map(|(rho, n)| [rho + n[0] * x + n[1] * y + OWN_M * random.normal(), n[1].atan2(n[0]) + turn]);
        let by = room
            .iter()
            .enumerate()
            .map(|(index, (_, n))| [n[0], n[1], 0.0, if OTHER_ROOM.contains(&index) { 1.0 } else { 0.0 }]);
        let map = Self { alpha_rad: turn, walls: walls.collect(), by: by.collect() };
        (map, Pose::new(x as f32, y as f32, turn as f32))
    }
}

impl Kept for Map {
    fn frame(&self) -> KeptFrame {
        let walls = self.walls.len() as u16;
        let common = POSE_STATES as u16 + 1;
        let (start, anchor) = (Pose::ORIGIN, None);
        KeptFrame {
            states: common + walls,
            common,
            walls,
            next_id: 100,
            has_grid: true,
            has_dock: false,
            exactness: 0,
            start,
            anchor,
            number: 0,
        }
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        let [_, beta_rad] = self.walls.get(index)?;
        let quarter = ((beta_rad - self.alpha_rad) / std::f64::consts::FRAC_PI_2).round() as i32 & 3;
        Some(KeptWall {
            id: if index == FAR { FAR_ID } else { index as u16 },
            rho: (POSE_STATES + 1 + index) as u16,
            direction: Direction::Grid(quarter as u8),
            lo_m: -6.0,
            hi_m: 6.0,
            updates: if index < FAR { 500 } else { 100 },
            score: 10,
            drawn: None,
        })
    }

    fn mean(&self, i: usize) -> f32 {
        match i.checked_sub(POSE_STATES + 1) {
            Some(wall) => self.walls[wall][0] as f32,
            None => self.alpha_rad as f32,
        }
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        let by = |state: usize| match state.checked_sub(POSE_STATES + 1) {
            Some(wall) => self.by[wall],
            None => [0.0, 0.0, 1.0, 0.0],
        };
        let (a, b) = (by(i), by(j));
        let own = if i == j && i > POSE_STATES { OWN_M * OWN_M } else { 0.0 };
        let sigmas = [MOVED_M, MOVED_M, TURNED_RAD, ROOM_M];
        (sigmas.iter().zip(a).zip(b).map(|((sigma, a), b)| sigma * sigma * a * b).sum::<f64>() + own) as f32
    }
}

/// A drive in such a map: the diary and its look back, and by how much the last pose is off.
fn drive(seed: u64, steps: usize) -> (SmallDiary, Small, Vector3<f64>) {
    let mut random = Random(1000 + seed);
    let mut robot = Robot::new(seed);
    let (map, moved) = Map::of(&robot, &mut random);
    // Found again, to three centimetres and two degrees.
    let [x, y, theta] = [0.03, 0.03, 0.03].map(|sigma| (sigma * random.normal()) as f32);
    robot.reckoned = moved.compose(&Pose::new(x, y, theta));
    let mut diary = SmallDiary::IDLE;
    diary.begin(&DRIVE, Gains::KNOWN, robot.reckoned);
    diary.begin_in(&map, &robot.reckoned);
    diary.grid(map.alpha_rad as f32);
    robot.drive(&mut diary, steps);
    let [x, y, theta] = robot.begin_keyframe(&mut diary);
    let mut look_back = Small::new();
    look_back.begin(&diary);
    assert_eq!(look_back.work(&mut diary, u32::MAX), Progress::Done);
    let found = look_back.present.pose();
    let turned = slam_core::angle::wrap(found.theta_rad - theta as f32);
    (diary, look_back, Vector3::new(f64::from(found.x_m) - x, f64::from(found.y_m) - y, turned.into()))
}

#[test]
fn a_robot_in_a_kept_map_knows_where_it_is_to_what_that_knows() {
    let mut sum = 0.0;
    const DRIVES: u64 = 60;
    for seed in 1..=DRIVES {
        let (_, look_back, off) = drive(seed, 300);
        let pose = [Unknown::X, Unknown::Y, Unknown::Theta];
        let covariance = Matrix3::from_fn(|i, j| f64::from(look_back.covariance(pose[i], pose[j]).expect("done")));
        assert!(covariance[(0, 0)].sqrt() > 0.9 * MOVED_M, "where the map is nothing here tells: {covariance}");
        sum += off.dot(&(covariance.try_inverse().expect("positive") * off));
    }
    let nees = sum / DRIVES as f64;
    // The odometry errs less than its model allows.
    assert!((1.4..4.0).contains(&nees), "{nees}");
}

#[test]
fn walls_that_a_drive_does_not_see_stay_in_the_map() {
    let (diary, look_back, _) = drive(1, 700);
    assert_eq!(diary.id_of(FAR), Some(FAR_ID));
    let wall = diary.walls().find(|(place, _)| *place == FAR).expect("it is there").1;
    assert!(wall.hits > 10 && wall.hi_m - wall.lo_m > 10.0, "{wall:?}");
    let sigma_m = f64::from(look_back.covariance(Unknown::Offset(FAR), Unknown::Offset(FAR)).expect("done")).sqrt();
    // Where the map is, and the wall in it, which is the same to three millimetres since.
    let known_m = (MOVED_M * MOVED_M + OWN_M * OWN_M + 9e-6).sqrt();
    assert!((0.7..1.3).contains(&(sigma_m / known_m)), "{sigma_m} {known_m}");
    // Walls drawn anew are the kept ones.
    assert_eq!(diary.walls().filter(|(_, wall)| wall.hits > 0).count(), 7);
}

#[test]
fn walls_of_a_room_that_is_badly_known_lie_to_each_other_as_the_map_has_them() {
    let (diary, look_back, _) = drive(1, 300);
    let [a, b] = OTHER_ROOM.map(Unknown::Offset);
    let covariance = |a, b| f64::from(look_back.covariance(a, b).expect("done, and two walls still"));
    assert!(covariance(a, a).sqrt() > 0.9 * ROOM_M, "where the room is nothing here tells");
    let apart_m = (covariance(a, a) + covariance(b, b) - 2.0 * covariance(a, b)).sqrt();
    assert!(apart_m < 3.0 * OWN_M, "{apart_m}");
    let [first, second] =
        OTHER_ROOM.map(|wall| diary.walls().find(|(place, _)| *place == wall).expect("it is there").1);
    assert!((f64::from(second.rho_m - first.rho_m) - APART_M).abs() < 3.0 * OWN_M);
}

#[test]
fn the_map_is_seen_from_where_it_is_however_full_the_diary_gets() {
    let (mut diary, ..) = drive(1, 700);
    while diary.make_some_room(56, 0, 0).is_some() {}
    let seen: Vec<_> = diary.sightings().map(|(key, groups)| (key.holds_map(), groups.len())).collect();
    assert_eq!(seen[..3], [(true, 0), (true, 5), (false, 2)]);
    diary.go_on_elsewhere(&Pose::ORIGIN, Displaced::Held);
    assert!(diary.keyframes[0].holds_map());
}
