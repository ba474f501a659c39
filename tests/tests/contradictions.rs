//! Where readings contradict its map a robot keeps it, and finds itself in it.

use lab::evaluate::{score, smoother};
use lab::input::built_in_robot;
use lab::input::log::Row;
use lab::recording::{Pose2, Step};
use slam_core::{DriveModel, Motion};
use tests::crowds::{CROWD_S, crowded, drive_through_crowd, session};

/// When they are gone, and the robot has driven on for a while.
const AFTER_S: f64 = 345.0;

/// Before all of them have found themselves, seconds.
const UNTIL_S: f64 = 355.0;

/// How far the robot is turned among the people, radians, and its wheels do not tell: 25 degrees, half a degree in each row.
const TURNED_RAD: f64 = 0.4363;
const TURNED_IN: f64 = 50.0;

/// Turns the robot untold at the beginning of the crowd: its wheels count as if it had not.
fn turn(rows: &mut [Row], drive: &DriveModel) {
    let DriveModel::Wheels { track_m, metres_per_tick, .. } = *drive else { panic!("a robot with wheels") };
    let counts = 0.5 * TURNED_RAD * f64::from(track_m) / f64::from(metres_per_tick);
    let begin = rows.partition_point(|row| row.t_s < CROWD_S.start);
    for (row, after) in rows[begin..].iter_mut().zip(1..) {
        let missed = (counts * (f64::from(after) / TURNED_IN).min(1.0)) as i32;
        if let Motion::Ticks(ticks) = &mut row.sample.motion {
            (ticks.left, ticks.right) = (ticks.left + missed, ticks.right - missed);
        }
    }
}

#[test]
fn a_contradicted_map_is_kept_and_the_robot_finds_itself_in_it() {
    // Of 144 such drives: `cargo run --release --package tests --example crowds -- 1 144`.
    let drives: Vec<_> = (73..=84).map(drive_through_crowd).collect();
    let back = drives.iter().filter(|drive| drive.is_back()).count();
    assert!(back >= 10, "{back} of {} lost their map among the people and found it", drives.len());
    for (drive, seed) in drives.iter().zip(73..) {
        // Along a wall whose end it has not seen since it knows its place to 10 or 15 cm, 1-sigma, and says so.
        let is_there = |error: Pose2| error.x_m.hypot(error.y_m) < 0.35 && error.theta_rad.abs() < 0.1;
        assert!(drive.found_error.is_none_or(is_there), "seed {seed}: {drive:?}");
        assert!(drive.found_sigmas < 4.0, "seed {seed}: {drive:?}");
    }
    // Of the 144 four.
    let far = drives.iter().filter(|drive| drive.found_off_m() > 0.15).count();
    assert!(far <= 1, "{far} of {} find themselves 15 cm off", drives.len());
    // Of the 144 one.
    let off = drives.iter().filter(|drive| drive.off_m > 0.15).count();
    assert!(off <= 1, "{off} of {} are off in the end", drives.len());
    // Readings that fit nothing for a hundred seconds are not those of a robot that somebody moved.
    let jolts: u32 = drives.iter().map(|drive| drive.jolts).sum();
    assert!(jolts <= 3, "{jolts} jolts");
}

/// Drives that are turned and whose map is contradicted.
const TURNED: u64 = 15;

#[test]
fn a_look_back_across_a_contradiction_has_all_of_it_on_one_grid() {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    let (mut contradicted, mut found) = (0, 0);
    for seed in 1.. {
        if contradicted == TURNED {
            break;
        }
        let mut rows = crowded(seed);
        turn(&mut rows, &robot.rig.drive);
        rows.retain(|row| row.t_s < UNTIL_S);
        let mut session = session();
        for row in &rows {
            session.push(row);
        }
        let mut recording = session.finish();
        if !recording.steps.iter().any(|step| step.searching) {
            assert!(seed < 2 * TURNED, "{contradicted} of {seed} maps were contradicted");
            continue;
        }
        contradicted += 1;
        if recording.steps.last().is_none_or(|step| step.searching) {
            continue;
        }
        found += 1;
        score::score(&mut recording, &[], None);
        let back = smoother::add(&mut recording, &robot.rig, &mut |_| ()).expect("there are walls");
        let after = back.steps.iter().filter(|step| step.t_s > AFTER_S);
        let errors: Vec<Pose2> = after.filter_map(Step::error).collect();
        assert!(!errors.is_empty(), "seed {seed}: no truth");
        let is_there = |error: &Pose2| error.theta_rad.abs() < 0.1 && error.x_m.hypot(error.y_m) < 0.5;
        assert!(errors.iter().all(is_there), "seed {seed}: {:?}", errors.last());
    }
    // One that is lost only after the people have gone takes longer.
    assert!(5 * found >= 4 * TURNED, "{found} of {TURNED} have found themselves");
}
