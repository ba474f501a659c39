//! Where readings contradict its map a robot keeps it, and finds itself in it.

use hal_sim::rng::Rng;
use lab::evaluate::{score, smoother};
use lab::input::built_in_robot;
use lab::input::log::Row;
use lab::recording::{Pose2, Step};
use lab::run::Session;
use slam_core::kept::Kept;
use slam_core::{Config, DriveModel, Health, Motion, RangeInput};
use tests::simulated::rows;

/// When people stand around the robot, seconds.
const CROWD_S: std::ops::Range<f64> = 200.0..300.0;

/// A drive through the flat, on which nearly all that the sensors see for a while is nearer than the walls.
fn crowded(seed: u64) -> Vec<Row> {
    let mut rows = rows("flat", 10.0, seed);
    let mut random = Rng::stream(seed, "crowd", 0);
    for row in rows.iter_mut().filter(|row| CROWD_S.contains(&row.t_s)) {
        for range in &mut row.sample.ranges {
            if let RangeInput::Counts(counts) = range {
                *counts = (f64::from(*counts) * random.uniform(1.2, 2.0)).min(4000.0) as u16;
            }
        }
    }
    rows
}

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

/// The estimator's drive over these rows.
fn session() -> Session {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    Session::new(&robot, Config::for_rig(&robot.rig), "").expect("a good rig")
}

/// What a drive through a crowd came to.
struct Crowded {
    /// When the map was given up, and when the robot found itself in it, seconds.
    lost_s: Option<f64>,
    found_s: Option<f64>,
    /// Displacements that were taken for real among the people; nobody moves the robot.
    jolts: u32,
    /// Error of the position at the end, metres.
    off_m: f64,
}

fn drive_through_crowd(seed: u64) -> Crowded {
    let mut session = session();
    let (mut walls, mut lost_s, mut found_s, mut jolts, mut off_m) = (0, None, None, 0, f64::NAN);
    for row in &crowded(seed) {
        let step = session.push(row).clone();
        let error = step.error();
        off_m = error.map_or(off_m, |error| error.x_m.hypot(error.y_m));
        match lost_s {
            None if step.searching => {
                assert_eq!(step.health, Health::Contradicted);
                let kept = usize::from(session.sought().expect("a kept map").frame().walls);
                assert!(kept > 15 && kept <= walls, "{kept} of {walls} walls");
                lost_s = Some(row.t_s);
            }
            Some(_) if !step.searching && found_s.is_none() => {
                let error = error.expect("truth is known");
                assert!(off_m < 0.15 && error.theta_rad.abs() < 0.1, "seed {seed}: {error:?}");
                found_s = Some(row.t_s);
            }
            _ => {}
        }
        walls = step.walls;
        if row.t_s < CROWD_S.end {
            jolts = session.slam().counters().jolts;
        }
    }
    assert!(session.finish().is_one_frame(), "the odometry links all of it");
    Crowded { lost_s, found_s, jolts, off_m }
}

#[test]
fn a_contradicted_map_is_kept_and_the_robot_finds_itself_in_it() {
    let drives: Vec<_> = (1..=12).map(drive_through_crowd).collect();
    let is_back =
        |drive: &&Crowded| drive.lost_s.is_some_and(|at_s| CROWD_S.contains(&at_s)) && drive.found_s.is_some();
    let back = drives.iter().filter(is_back).count();
    assert!(back >= 10, "{back} of {} lost their map among the people and found it", drives.len());
    for (drive, seed) in drives.iter().zip(1..) {
        assert!(drive.off_m < 0.15, "seed {seed}: {} m off in the end", drive.off_m);
    }
    // Readings that fit nothing for a hundred seconds are not those of a robot that somebody moved.
    let jolts: u32 = drives.iter().map(|drive| drive.jolts).sum();
    assert!(jolts <= 3, "{jolts} jolts");
}

/// Drives that are turned, and of those that find themselves how many are looked back on.
const TURNED: u64 = 15;
const LOOKED_BACK: u64 = 5;

#[test]
fn a_look_back_across_a_contradiction_has_all_of_it_on_one_grid() {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    let mut found = 0;
    for seed in 1..=TURNED {
        let mut rows = crowded(seed);
        turn(&mut rows, &robot.rig.drive);
        rows.retain(|row| row.t_s < UNTIL_S);
        let mut session = session();
        for row in &rows {
            session.push(row);
        }
        let mut recording = session.finish();
        assert!(recording.steps.iter().any(|step| step.searching), "seed {seed}: nothing was contradicted");
        if recording.steps.last().is_none_or(|step| step.searching) {
            continue;
        }
        found += 1;
        if found > LOOKED_BACK {
            continue;
        }
        score::score(&mut recording, &[], None);
        let back = smoother::add(&mut recording, &robot.rig, &mut |_| ()).expect("there are walls");
        let after = back.steps.iter().filter(|step| step.t_s > AFTER_S);
        let errors: Vec<Pose2> = after.filter_map(Step::error).collect();
        assert!(!errors.is_empty(), "seed {seed}: no truth");
        for error in errors {
            assert!(error.theta_rad.abs() < 0.1, "seed {seed}: {error:?}");
            assert!(error.x_m.hypot(error.y_m) < 0.5, "seed {seed}: {error:?}");
        }
    }
    // One that is lost only after the people have gone takes longer.
    assert!(5 * found >= 4 * TURNED, "{found} of {TURNED} have found themselves");
}
