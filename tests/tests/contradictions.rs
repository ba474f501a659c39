//! Where readings contradict its map a robot keeps it, and finds itself in it.

use hal_sim::rng::Rng;
use lab::input::built_in_robot;
use lab::input::log::Row;
use lab::run::Session;
use slam_core::kept::Kept;
use slam_core::{Config, Health, RangeInput};
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

/// The estimator's drive over these rows.
fn session() -> Session {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    Session::new(&robot, Config::for_rig(&robot.rig), "").expect("a good rig")
}

#[test]
fn a_contradicted_map_is_kept_and_the_robot_finds_itself_in_it() {
    for seed in 1..=3 {
        let mut session = session();
        let (mut walls, mut lost_s, mut found_s) = (0, None, None);
        for row in &crowded(seed) {
            let step = session.push(row).clone();
            match lost_s {
                None if step.searching => {
                    assert_eq!(step.health, Health::Contradicted);
                    let kept = usize::from(session.sought().expect("a kept map").frame().walls);
                    assert!(kept > 15 && kept <= walls, "{kept} of {walls} walls");
                    lost_s = Some(row.t_s);
                }
                Some(_) if !step.searching && found_s.is_none() => {
                    let error = step.error().expect("truth is known");
                    assert!(error.x_m.hypot(error.y_m) < 0.15 && error.theta_rad.abs() < 0.1, "seed {seed}: {error:?}");
                    found_s = Some(row.t_s);
                }
                _ => {}
            }
            walls = step.walls;
        }
        println!("seed {seed}: lost {lost_s:?} found {found_s:?} restarts {}", session.slam().counters().restarts);
        let is_lost = lost_s.is_some_and(|lost_s| CROWD_S.contains(&lost_s));
        assert!(is_lost && found_s.is_some(), "seed {seed}: lost at {lost_s:?}, found at {found_s:?}");
        let recording = session.finish();
        assert!(recording.is_one_frame(), "the odometry links all of it");
    }
}
