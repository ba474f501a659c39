use slam_core::{ReadingReport, WallKind, WallView};

use super::*;
use crate::recording::{MapSnapshot, SensorInfo, Step};

/// Faces +y: seen from below.
fn wall(id: u16, rho_m: f32, (from_m, to_m): (f32, f32)) -> WallView {
    WallView {
        id,
        kind: WallKind::Free,
        rho_m,
        beta_rad: std::f32::consts::FRAC_PI_2,
        // The tangent of a wall that faces +y is -x.
        lo_m: -to_m,
        hi_m: -from_m,
        sigma_rho_m: 0.01,
        updates: 10,
    }
}

/// A robot that looks along +y, with a map that is known in advance.
struct Drive(Recording);

impl Drive {
    fn new(walls: Vec<WallView>) -> Self {
        let sensors = vec![SensorInfo::default()];
        Self(Recording { sensors, maps: vec![MapSnapshot { step: 0, walls }], ..Recording::default() })
    }

    /// Passes from x = 0 to 2 m under what stands at y(x), from `begin_s` on; `drift_m` is dead reckoning's.
    fn pass(mut self, begin_s: f64, drift_m: f64, y_m: impl Fn(f64) -> f64) -> Self {
        for i in 0..40 {
            let x_m = 0.05 * f64::from(i);
            let pose = Pose2::new(x_m, 0.0, std::f64::consts::FRAC_PI_2);
            let dead_reckoning = Pose2 { y_m: drift_m, ..pose };
            self.0.steps.push(Step { t_s: begin_s + 0.1 * f64::from(i), pose, dead_reckoning, ..Step::default() });
            self.0.readings.push(ReadingReport { range_m: Some(y_m(x_m) as f32), ..ReadingReport::default() });
        }
        self
    }

    fn seen(&self, wall: u16) -> SeenWall {
        let walls = walls_seen(&self.0);
        walls.into_iter().find(|seen| seen.wall == wall).expect("the wall was seen")
    }
}

fn near(found: Option<f64>, expected: f64) -> bool {
    found.is_some_and(|found| (found - expected).abs() < 1e-6)
}

#[test]
fn a_wall_seen_at_two_places_has_a_gap_a_thickness_and_no_closure() {
    let drive = Drive::new(vec![wall(7, 1.0, (0.0, 2.0))]).pass(0.0, 0.0, |_| 1.05).pass(100.0, 0.3, |_| 0.95);
    let seen = drive.seen(7);
    assert_eq!((seen.readings, seen.visits.len()), (80, 2));
    assert!(near(seen.gap_m, 0.1) && near(seen.closure_m, -0.1), "{seen:?}");
    // Dead reckoning went 0.3 m farther meanwhile.
    assert!(near(seen.odometry_closure_m, 0.2), "{seen:?}");
    assert!((seen.thickness_m - 0.05).abs() < 1e-6, "{seen:?}");
    assert!((seen.visits[0].mean_m - 0.05).abs() < 1e-6 && (seen.visits[1].begin_s - 100.0).abs() < 1e-9, "{seen:?}");
}

#[test]
fn a_second_copy_of_a_wall_does_not_hide_the_gap() {
    let walls = vec![wall(1, 1.0, (0.0, 2.0)), wall(2, 1.5, (0.0, 2.0))];
    let drive = Drive::new(walls).pass(0.0, 0.0, |_| 1.0).pass(100.0, 0.0, |_| 1.5);
    assert!(near(drive.seen(1).gap_m, 0.5) && near(drive.seen(2).gap_m, 0.5), "{:?}", walls_seen(&drive.0));
}

#[test]
fn a_cupboard_before_a_wall_is_no_gap() {
    let walls = vec![wall(1, 1.6, (0.0, 2.0)), wall(2, 1.1, (0.5, 1.0))];
    let furnished = |x: f64| if (0.5..1.0).contains(&x) { 1.1 } else { 1.6 };
    let drive = Drive::new(walls).pass(0.0, 0.0, furnished).pass(100.0, 0.0, furnished);
    assert!(near(drive.seen(1).gap_m, 0.0) && near(drive.seen(2).gap_m, 0.0), "{:?}", walls_seen(&drive.0));
}

#[test]
fn a_chair_that_came_later_is_no_gap() {
    let with_chair = |x: f64| if (0.5..0.8).contains(&x) { 1.1 } else { 1.6 };
    let drive = Drive::new(vec![wall(1, 1.6, (0.0, 2.0))]).pass(0.0, 0.0, |_| 1.6).pass(100.0, 0.0, with_chair);
    assert!(near(drive.seen(1).gap_m, 0.0), "{:?}", drive.seen(1));
}

#[test]
fn visits_that_saw_different_stretches_are_not_compared() {
    let first = |x: f64| if x < 0.9 { 1.0 } else { 9.0 };
    let second = |x: f64| if x < 1.1 { 9.0 } else { 1.1 };
    let drive = Drive::new(vec![wall(1, 1.0, (0.0, 2.0))]).pass(0.0, 0.0, first).pass(100.0, 0.0, second);
    assert_eq!((drive.seen(1).visits.len(), drive.seen(1).gap_m), (2, None));
}

#[test]
fn what_goes_on_round_a_corner_is_no_gap() {
    // Aslant by 30 degrees, mapped to x = 1.5 m and seen farther on.
    let slanting = |x: f64| (1.919 - 0.5 * x) / 0.75f64.sqrt();
    let mut other = wall(2, 1.919, (0.0, 0.0));
    other.beta_rad = std::f32::consts::FRAC_PI_3;
    (other.lo_m, other.hi_m) = (-0.6, 0.5);
    let second = |x: f64| if x < 1.5 { 9.0 } else { slanting(x) };
    let drive = Drive::new(vec![wall(1, 1.0, (0.0, 2.0)), other]).pass(0.0, 0.0, |_| 1.0).pass(100.0, 0.0, second);
    assert_eq!(drive.seen(1).gap_m, None, "{:?}", drive.seen(1));
}

#[test]
fn one_pass_is_one_visit_and_a_wall_seen_from_behind_is_another() {
    let mut facing_away = wall(2, -1.0, (0.0, 2.0));
    facing_away.beta_rad = -std::f32::consts::FRAC_PI_2;
    (facing_away.lo_m, facing_away.hi_m) = (0.0, 2.0);
    let drive =
        Drive::new(vec![wall(1, 1.0, (0.0, 2.0)), facing_away]).pass(0.0, 0.0, |_| 1.0).pass(10.0, 0.0, |_| 1.2);
    let walls = walls_seen(&drive.0);
    assert_eq!((walls.len(), walls[0].wall, walls[0].visits.len(), walls[0].gap_m), (1, 1, 1, None));
}

#[test]
fn the_densest_band_keeps_out_what_stands_before_the_wall() {
    let values = [0.5, 0.51, -0.3, 0.0, 0.02, 0.04, 0.06, -0.7];
    assert_eq!(densest(values.into_iter()), [0.0, 0.02, 0.04, 0.06]);
    assert_eq!(densest([f64::NAN].into_iter()), [0.0; 0]);
}
