//! Drives through the flat among people, who stand nearer to the robot than the walls for a hundred seconds.

use std::ops::Range;

use hal_sim::rng::Rng;
use lab::input::built_in_robot;
use lab::input::log::Row;
use lab::recording::Pose2;
use lab::run::Session;
use slam_core::kept::Kept;
use slam_core::{Config, Health, RangeInput};

use crate::simulated::rows;

/// When people stand around the robot, seconds.
pub const CROWD_S: Range<f64> = 200.0..300.0;

/// A drive through the flat, on which nearly all that the sensors see for a while is nearer than the walls.
pub fn crowded(seed: u64) -> Vec<Row> {
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
///
/// # Panics
/// The built-in rig is no good one.
pub fn session() -> Session {
    let (robot, _) = built_in_robot().expect("the built-in rig is good");
    Session::new(&robot, Config::for_rig(&robot.rig), "").expect("a good rig")
}

/// What a drive through a crowd came to.
#[derive(Clone, Copy, Debug)]
pub struct Crowded {
    /// When the map was given up, seconds.
    pub lost_s: Option<f64>,
    /// When the robot found itself in it, seconds.
    pub found_s: Option<f64>,
    /// How far off it was then.
    pub found_error: Option<Pose2>,
    /// How far off in x, y and heading by what the robot said of itself, in standard deviations, the largest.
    pub found_sigmas: f64,
    /// Displacements that were taken for real among the people; nobody moves the robot.
    pub jolts: u32,
    /// Error of the position at the end, metres.
    pub off_m: f64,
}

impl Crowded {
    /// How far off it was when it found itself, metres; nought where it did not.
    pub fn found_off_m(&self) -> f64 {
        self.found_error.map_or(0.0, |error| error.x_m.hypot(error.y_m))
    }

    /// Whether the robot gave its map up among the people and found itself in it.
    pub fn is_back(&self) -> bool {
        self.lost_s.is_some_and(|at_s| CROWD_S.contains(&at_s)) && self.found_s.is_some()
    }
}

/// What the drive of this seed came to.
///
/// # Panics
/// The map was given up for another reason than that readings contradict it, or what was kept of it is not what it was.
pub fn drive_through_crowd(seed: u64) -> Crowded {
    let mut session = session();
    let mut drive =
        Crowded { lost_s: None, found_s: None, found_error: None, found_sigmas: 0.0, jolts: 0, off_m: f64::NAN };
    let mut walls = 0;
    for row in &crowded(seed) {
        let step = session.push(row).clone();
        drive.off_m = step.error().map_or(drive.off_m, |error| error.x_m.hypot(error.y_m));
        match drive.lost_s {
            None if step.searching => {
                assert_eq!(step.health, Health::Contradicted);
                let kept = usize::from(session.sought().expect("a kept map").frame().walls);
                assert!(kept > 15 && kept <= walls, "{kept} of {walls} walls");
                drive.lost_s = Some(row.t_s);
            }
            Some(_) if !step.searching && drive.found_s.is_none() => {
                (drive.found_s, drive.found_error) = (Some(row.t_s), step.error());
                drive.found_sigmas = step.error().map_or(f64::NAN, |error| sigmas(&error, &step.covariance));
            }
            _ => {}
        }
        walls = step.walls;
        if row.t_s < CROWD_S.end {
            drive.jolts = session.slam().counters().jolts;
        }
    }
    assert!(session.finish().is_one_frame(), "the odometry links all of it");
    drive
}

/// The largest of an error's parts, in standard deviations.
fn sigmas(error: &Pose2, covariance: &[[f32; 3]; 3]) -> f64 {
    let parts = [error.x_m, error.y_m, error.theta_rad];
    (0..3).map(|i| parts[i].abs() / f64::from(covariance[i][i]).sqrt()).fold(0.0, f64::max)
}
