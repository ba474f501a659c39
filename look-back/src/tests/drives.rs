use nalgebra::{Matrix3, Vector3};
use slam_core::{Displaced, Increment, Pose};

use super::drive::{DRIVE, Robot, SCALE};
use crate::{Diary, Hit, LookBack, Progress, Unknown, border_len, packed_len};

const W: usize = 16;
const B: usize = border_len(W);
type SmallDiary = Diary<64, 256, W>;
type Small = LookBack<64, W, B, { packed_len(B) }>;

fn finish(look_back: &mut Small, diary: &mut SmallDiary, budget: u32) -> Progress {
    look_back.begin(diary);
    go_on(look_back, diary, budget)
}

fn go_on(look_back: &mut Small, diary: &mut SmallDiary, budget: u32) -> Progress {
    loop {
        let progress = look_back.work(diary, budget);
        if progress != Progress::Working {
            return progress;
        }
    }
}

/// Largest distance of the robot from where it is, of the walls from where they are, metres, and how many walls there are.
fn errors(robot: &Robot, diary: &SmallDiary) -> (f64, f64, usize) {
    let walls = robot.walls();
    let off = |wall: &crate::Wall| {
        let normal = [f64::from(wall.beta_rad).cos(), f64::from(wall.beta_rad).sin()];
        let true_wall = walls.iter().find(|(_, n)| n[0] * normal[0] + n[1] * normal[1] > 0.95);
        true_wall.map_or(f64::INFINITY, |(rho_m, _)| (rho_m - f64::from(wall.rho_m)).abs())
    };
    let seen: std::vec::Vec<_> = diary.walls().filter(|(_, wall)| wall.hits > 0).map(|(_, wall)| off(wall)).collect();
    (robot.error_m(&diary.robot()), seen.iter().fold(0.0, |a, b| f64::max(a, *b)), seen.len())
}

#[test]
fn a_drive_is_placed_and_walls_seen_twice_become_one() {
    let (mut robot, mut diary) = (Robot::new(1), SmallDiary::new(&DRIVE, Pose::ORIGIN));
    robot.drive(&mut diary, 700);
    assert!(robot.laps >= 2, "{}", robot.laps);
    let mut look_back = Small::new();
    assert_eq!(finish(&mut look_back, &mut diary, u32::MAX), Progress::Done);
    let (pose_m, wall_m, walls) = errors(&robot, &diary);
    assert!(robot.reckoned_error_m() > 0.1, "the odometry is wrong: {}", robot.reckoned_error_m());
    assert!(pose_m < 0.02 && wall_m < 0.02, "{pose_m} {wall_m}");
    assert_eq!(walls, 4, "of eight that the filter had");
    let scale = f64::from(diary.calibration().distance);
    assert!((scale - SCALE).abs() < 0.005, "{scale}");
}

#[test]
fn slices_of_any_size_give_the_same_bits() {
    let run = |budget| {
        let (mut robot, mut diary) = (Robot::new(2), SmallDiary::new(&DRIVE, Pose::ORIGIN));
        robot.drive(&mut diary, 400);
        while diary.make_some_room(8, 32, 0).is_some() {}
        let mut look_back = Small::new();
        assert_eq!(finish(&mut look_back, &mut diary, budget), Progress::Done);
        let placed = look_back.effort();
        // What was written down meanwhile is taken in in slices, too.
        robot.drive(&mut diary, 12);
        look_back.catch_up();
        assert_eq!(go_on(&mut look_back, &mut diary, budget), Progress::Done);
        look_back.arrive();
        assert_eq!(go_on(&mut look_back, &mut diary, budget), Progress::Done);
        let [x, theta] = [Unknown::X, Unknown::Theta].map(|unknown| look_back.covariance(unknown, Unknown::Offset(0)));
        (diary.robot(), placed, look_back.effort(), x, theta, look_back.present.pose())
    };
    let (whole, sliced) = (run(u32::MAX), run(1));
    assert_eq!(whole, sliced);
    let (placed, caught_up) = (sliced.1, sliced.2);
    assert!(u64::from(placed.costliest) < placed.cost / 50, "{placed:?}");
    assert!(caught_up.cost > placed.cost && caught_up.costliest == placed.costliest, "{caught_up:?}");
}

/// A robot that was kicked is elsewhere, which the filter knows roughly.
#[test]
fn a_drive_goes_on_where_the_robot_is_found_elsewhere() {
    for seed in 1..=4 {
        let (mut robot, mut diary) = (Robot::new(seed), SmallDiary::new(&DRIVE, Pose::ORIGIN));
        robot.drive(&mut diary, 300);
        robot.kick([0.2, -0.15, 0.3], [0.05, 0.05, -0.06]);
        diary.go_on_elsewhere(&robot.reckoned, Displaced::Jolted);
        robot.drive(&mut diary, 300);
        assert_eq!(finish(&mut Small::new(), &mut diary, u32::MAX), Progress::Done);
        let (pose_m, wall_m, walls) = errors(&robot, &diary);
        assert!(pose_m < 0.03 && wall_m < 0.03, "seed {seed}: {pose_m} {wall_m}");
        assert_eq!(walls, 4, "seed {seed}");
    }
}

/// A log that has no motion for a while says nothing of where the robot went meanwhile.
#[test]
fn a_drive_goes_on_after_a_motion_that_was_lost() {
    for seed in 1..=4 {
        let (mut robot, mut diary) = (Robot::new(seed), SmallDiary::new(&DRIVE, Pose::ORIGIN));
        robot.drive(&mut diary, 300);
        robot.kick([0.3, 0.1, 0.3], [-0.3, -0.1, -0.3]);
        diary.lose_motion([0.3, 0.3], &robot.reckoned);
        robot.drive(&mut diary, 300);
        assert_eq!(finish(&mut Small::new(), &mut diary, u32::MAX), Progress::Done);
        let (pose_m, wall_m, walls) = errors(&robot, &diary);
        assert!(pose_m < 0.03 && wall_m < 0.03, "seed {seed}: {pose_m} {wall_m}");
        assert_eq!(walls, 4, "seed {seed}");
    }
}

#[test]
fn hours_fit_and_are_no_worse_than_minutes() {
    let (mut robot, mut diary) = (Robot::new(3), SmallDiary::new(&DRIVE, Pose::ORIGIN));
    let mut look_back = Small::new();
    let mut worst_m = 0.0f64;
    for round in 0..600 {
        robot.drive(&mut diary, 60);
        assert_eq!(finish(&mut look_back, &mut diary, u32::MAX), Progress::Done);
        let (pose_m, wall_m, walls) = errors(&robot, &diary);
        if round > 20 {
            assert_eq!(walls, 4, "round {round}");
            worst_m = worst_m.max(pose_m).max(wall_m);
        }
    }
    assert!(diary.losses().thinned > 1000, "{:?}", diary.losses());
    assert_eq!((diary.losses().hits, diary.losses().walls), (0, 0));
    let mut kept = diary.keyframes().map(|(serial, _)| serial);
    let first = [kept.next(), kept.next(), kept.next()];
    assert!(first[..2] == [Some(0), Some(1)] && first[2] > Some(2), "the first is made one with no other: {first:?}");
    assert!(worst_m < 0.03, "{worst_m}");
}

#[test]
fn a_full_diary_interrupts_a_look_back_that_can_begin_again() {
    let (mut robot, mut diary) = (Robot::new(4), SmallDiary::new(&DRIVE, Pose::ORIGIN));
    robot.drive(&mut diary, 500);
    let mut look_back = Small::new();
    look_back.begin(&diary);
    let before = diary.losses().thinned;
    let mut steps = 0;
    let progress = loop {
        match look_back.work(&mut diary, 1) {
            Progress::Working => robot.drive(&mut diary, 1),
            ended => break ended,
        }
        steps += 1;
    };
    assert_eq!(progress, Progress::Interrupted, "after {steps}");
    assert!(diary.losses().thinned > before);
    assert_eq!(finish(&mut look_back, &mut diary, u32::MAX), Progress::Done);
    let (pose_m, wall_m, walls) = errors(&robot, &diary);
    assert!(pose_m < 0.02 && wall_m < 0.02 && walls == 4, "{pose_m} {wall_m} {walls}");
}

#[test]
fn walls_that_come_while_it_looks_back_find_room() {
    let (mut robot, mut diary) = (Robot::new(5), SmallDiary::new(&DRIVE, Pose::ORIGIN));
    robot.drive(&mut diary, 500);
    let met = |id: u16, diary: &mut SmallDiary| {
        let (from_m, end_m) = ([0.0; 2], [1.0, 0.0]);
        diary.hit(&Hit { from_m, end_m, variance_m2: 1e-4, alike: 1.0, sensor: 0, wall: Some(id) });
    };
    // More than there is room for, each seen by the way.
    (1000..1100).for_each(|id| met(id, &mut diary));
    while diary.make_some_room(0, 0, 2).is_some() {}
    let mut look_back = Small::new();
    look_back.begin(&diary);
    assert_eq!(look_back.work(&mut diary, 1), Progress::Working);
    (2000..2002).for_each(|id| met(id, &mut diary));
    assert_eq!(look_back.work(&mut diary, u32::MAX), Progress::Done);
    look_back.begin(&diary);
    (3000..3000 + W as u16).for_each(|id| met(id, &mut diary));
    assert_eq!(look_back.work(&mut diary, u32::MAX), Progress::Interrupted, "there is no room for so many");
}

#[test]
fn what_is_no_number_is_not_written_down_and_nothing_is_not_placed() {
    let mut diary = SmallDiary::new(&DRIVE, Pose::ORIGIN);
    let mut look_back = Small::new();
    assert_eq!(finish(&mut look_back, &mut diary, u32::MAX), Progress::Nothing);
    let good =
        crate::Hit { from_m: [0.0; 2], end_m: [1.0, 0.0], variance_m2: 1e-4, alike: 1.0, sensor: 0, wall: Some(1) };
    diary.hit(&crate::Hit { end_m: [f32::NAN, 0.0], ..good });
    diary.hit(&crate::Hit { variance_m2: 0.0, ..good });
    diary.hit(&crate::Hit { alike: 0.0, ..good });
    assert_eq!(diary.group_count(), 0);
    diary.hit(&good);
    assert_eq!(diary.group_count(), 1);
}

/// The errors of the last pose against their covariance, over many drives: three for an honest look back. The odometry errs less
/// than its model, which is for robots that slip, and a robust weight takes a fifth off what a good group tells.
#[test]
fn the_covariance_of_the_last_pose_is_that_of_its_errors() {
    let drives = 60;
    let mut nees = 0.0;
    for seed in 0..drives {
        let (mut robot, mut diary) = (Robot::new(100 + seed), SmallDiary::new(&DRIVE, Pose::ORIGIN));
        robot.drive(&mut diary, 500);
        let at = robot.begin_keyframe(&mut diary);
        let mut look_back = Small::new();
        assert_eq!(finish(&mut look_back, &mut diary, u32::MAX), Progress::Done);
        assert!(look_back.is_positive());
        let last = diary.keyframes().last().expect("there are some").1;
        let unknowns = [Unknown::X, Unknown::Y, Unknown::Theta];
        let covariance = Matrix3::from_fn(|i, j| {
            f64::from(look_back.covariance(unknowns[i], unknowns[j]).expect("a pose is always placed"))
        });
        let error = Vector3::new(
            f64::from(last.x_m) - at[0],
            f64::from(last.y_m) - at[1],
            f64::from(slam_core::angle::wrap(last.theta_rad - at[2] as f32)),
        );
        nees += (error.transpose() * covariance.try_inverse().expect("positive") * error)[0] / drives as f64;
    }
    assert!((1.0..4.0).contains(&nees), "{nees}");
}

/// Where hits are seen from is known best at the nearer of two keyframes.
#[test]
fn hits_are_seen_from_the_nearer_keyframe() {
    let mut diary = SmallDiary::new(&DRIVE, Pose::ORIGIN);
    let hit = Hit { from_m: [0.0; 2], end_m: [0.0, 1.0], variance_m2: 1e-4, alike: 1.0, sensor: 0, wall: Some(1) };
    for way_m in [0.1, 0.1, 0.1] {
        diary.travel(&Increment { forward_m: way_m, left_m: 0.0, turn_rad: 0.0 });
        if diary.is_due() {
            diary.begin_keyframe(&Pose::new(0.3, 0.0, 0.0));
        }
        diary.hit(&hit);
    }
    let seen: std::vec::Vec<_> = diary.sightings().flat_map(|(_, groups)| groups.iter()).collect();
    assert_eq!(seen.iter().map(|group| group.hits).collect::<std::vec::Vec<_>>(), [1, 2]);
    let along_m: std::vec::Vec<f32> = seen.iter().map(|group| group.mean_m[0]).collect();
    let expected_m = [0.1, -0.05];
    assert!(along_m.iter().zip(expected_m).all(|(along_m, at_m)| (along_m - at_m).abs() < 1e-6), "{along_m:?}");
}

#[test]
fn a_wall_that_only_the_last_keyframe_sees_is_not_placed() {
    let (mut robot, mut diary) = (Robot::new(1), SmallDiary::new(&DRIVE, Pose::ORIGIN));
    robot.drive(&mut diary, 300);
    robot.begin_keyframe(&mut diary);
    let hit = Hit { from_m: [0.0; 2], end_m: [0.5, 0.0], variance_m2: 1e-6, alike: 1.0, sensor: 0, wall: Some(99) };
    (0..100).for_each(|_| diary.hit(&hit));
    let mut look_back = Small::new();
    assert_eq!(finish(&mut look_back, &mut diary, u32::MAX), Progress::Done);
    let variance = |wall: usize| look_back.covariance(Unknown::Offset(wall), Unknown::Offset(wall));
    let new = diary.wall_named(99).expect("a wall");
    assert_eq!(variance(new), None);
    assert!((0..W).filter_map(variance).all(|variance_m2| variance_m2 < 0.01), "walls that were seen before are known");
}

/// Nothing but one wall ties what comes after a jolt to what was before.
#[test]
fn a_wall_after_a_jolt_is_not_any_wall_that_the_jolt_could_have_brought_there() {
    for (second_m, expected) in [(0.58, 1), (1.2, 2)] {
        let mut diary = SmallDiary::new(&DRIVE, Pose::ORIGIN);
        let mut x_m = 0.0;
        // Along a wall on the left; a jolt to the right by 30 cm; back along a wall on the left.
        for (forward_m, y_m, wall, left_m) in [(0.04, 0.0, 0, 0.3), (-0.04, -0.3, 1, second_m)] {
            if wall == 1 {
                diary.go_on_elsewhere(&Pose::new(x_m, y_m, 0.0), Displaced::Jolted);
            }
            for _ in 0..50 {
                x_m += forward_m;
                diary.travel(&Increment { forward_m, left_m: 0.0, turn_rad: 0.0 });
                if diary.is_due() {
                    diary.begin_keyframe(&Pose::new(x_m, y_m, 0.0));
                }
                for (sensor, ahead_m) in [(0, -0.2), (1, 0.2)] {
                    let end_m = [ahead_m, left_m];
                    diary.hit(&Hit {
                        from_m: [0.0; 2],
                        end_m,
                        variance_m2: 1e-4,
                        alike: 1.0,
                        sensor,
                        wall: Some(wall),
                    });
                }
            }
        }
        assert_eq!(finish(&mut Small::new(), &mut diary, u32::MAX), Progress::Done);
        let walls = diary.walls().filter(|(_, wall)| wall.hits > 0).count();
        assert_eq!(walls, expected, "{second_m} m");
        let y_m = diary.robot().y_m;
        // What nothing ties is where the wheels have it.
        let expected_m = if expected == 1 { -0.28 } else { 0.0 };
        assert!((y_m - expected_m).abs() < 0.01, "{second_m} m: {y_m}");
    }
}

/// The filter took walls for the grid's that turn out to be askew to it: no wall is left that says what its direction is.
#[test]
fn a_grid_without_a_wall_is_none() {
    for (grid_rad, is_known) in [(0.01, true), (0.35, false)] {
        let (mut robot, mut diary) = (Robot::new(6), SmallDiary::new(&DRIVE, Pose::ORIGIN));
        robot.drive(&mut diary, 100);
        diary.grid(grid_rad);
        robot.drive(&mut diary, 600);
        let mut look_back = Small::new();
        assert_eq!(finish(&mut look_back, &mut diary, u32::MAX), Progress::Done);
        let grid = look_back.grid(&diary);
        assert_eq!(grid.map(|grid_rad| grid_rad.abs() < 0.02), is_known.then_some(true), "{grid:?}");
    }
}
