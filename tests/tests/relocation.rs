//! A robot that is put down somewhere finds itself in the map that it kept, or says that it cannot tell.

use hal_sim::random_home::random_home;
use hal_sim::{Plan, Pose2, plan_file};
use kept_map::{Record, Writer, rig_hash};
use relocate::{Event, Locator, State, Step};
use slam_core::kept::Kept;
use slam_core::{HostSlam, Unfit};
use tests::carries::{Driven, carried, drive, rig};

fn home(name: &str) -> Plan {
    plan_file::load(name).unwrap_or_else(|error| panic!("{error}"))
}

fn map_of(name: &str) -> Box<HostSlam> {
    drive(&home(name), &rig(8), 600.0, 1, |_| true)
}

fn record_of(slam: &HostSlam) -> Vec<u8> {
    let mut bytes = Vec::new();
    Writer::new(slam, 1, rig_hash(slam.rig())).bytes(|piece| bytes.extend_from_slice(piece));
    bytes
}

/// Where a carried robot finds itself.
struct Found {
    /// Path until then, metres.
    path_m: f64,
    /// Error of the pose in the kept map at that moment.
    error: Pose2,
    /// Its normalised square.
    nees: f64,
}

/// Puts the robot down in one home with the map of another: where it finds itself, or how far it drove in vain, metres.
fn search(there: &Plan, map_of: &Plan, kept: &HostSlam, seed: u64, seconds: f64) -> Result<Found, f64> {
    let mut locator = Locator::new(State::Searching);
    let (mut found, mut last_m) = (None, 0.0);
    drive(&carried(there, seed), &rig(8), seconds, seed, |Driven { slam, path_m, in_plan, .. }| {
        let position_m = [slam.state_mean(0), slam.state_mean(1)];
        let travelled_m = (path_m - std::mem::replace(&mut last_m, path_m)) as f32;
        let step = Step::moved(position_m, travelled_m);
        let Some(Event::Found(place)) = locator.step(&*slam, Some(kept), &step, u32::MAX) else { return true };
        slam.take_up(kept, &place).expect("a map to go on in");
        let (estimate, truth) = (slam.estimate(), map_of.start.relative(&in_plan));
        let pose: Pose2 = estimate.pose.into();
        let error = Pose2::new(pose.x_m - truth.x_m, pose.y_m - truth.y_m, pose.theta_rad - truth.theta_rad);
        let e = nalgebra::Vector3::new(error.x_m, error.y_m, error.theta_rad);
        let inverse = estimate.covariance.map(f64::from).try_inverse().expect("a covariance");
        found = Some(Found { path_m, error, nees: (e.transpose() * inverse * e).x });
        false
    });
    found.ok_or(last_m)
}

#[test]
fn a_kept_map_is_read_back_to_the_last_bit() {
    let slam = map_of("flat");
    let bytes = record_of(&slam);
    let record = Record::parse(&bytes).and_then(|record| record.of_rig(rig_hash(slam.rig()))).expect("its own record");
    let (frame, walls) = (slam.frame(), usize::from(slam.frame().walls));
    assert_eq!(record.frame(), frame);
    assert!(walls > 20 && (0..=walls).all(|i| record.wall(i) == slam.wall(i)));
    for i in 3..usize::from(frame.states) {
        assert_eq!(record.mean(i).to_bits(), slam.mean(i).to_bits());
        for j in 3..usize::from(frame.states) {
            assert_eq!(record.covariance(i, j).to_bits(), slam.covariance(i, j).to_bits());
        }
    }
}

#[test]
fn a_carried_robot_finds_itself_and_no_stored_wall_moves() {
    let (flat, kept) = (home("flat"), map_of("flat"));
    let mut slam = drive(&flat, &rig(8), 60.0, 2, |_| true);
    // The start is the same, so each wall is near itself.
    let near = |a: &slam_core::WallView, b: &slam_core::WallView| {
        (a.rho_m - b.rho_m).abs() < 0.05 && (a.beta_rad - b.beta_rad).abs() < 0.02 && a.hi_m > b.lo_m && a.lo_m < b.hi_m
    };
    let mut pairs: Vec<_> = slam.walls().filter_map(|a| kept.walls().find(|b| near(&a, b)).map(|b| (a, b))).collect();
    // Short ones are furniture, whose directions a minute does not tell.
    pairs.sort_by(|(a, _), (b, _)| (b.hi_m - b.lo_m).total_cmp(&(a.hi_m - a.lo_m)));
    let pairs: Vec<(u16, u16, f32)> = pairs.iter().map(|(a, b)| (a.id, b.id, b.beta_rad)).collect();
    let first = pairs[0];
    let across = pairs.iter().find(|pair| (pair.2 - first.2).sin().abs() > 0.9).expect("a wall across");
    let (before, found) =
        (slam.estimate(), slam_core::Match { quarters: 0, pairs: [(first.0, first.1), (across.0, across.1)] });
    slam.take_up(&*kept, &found).expect("a map to go on in");
    let after = slam.pose();
    // After a minute it is known so well where it is: three sigma, of both axes together.
    let covariance: [[f32; 3]; 3] = before.covariance.into();
    let moved_m = (before.pose.x_m - after.x_m).hypot(before.pose.y_m - after.y_m);
    let bound_m = 3.0 * (covariance[0][0] + covariance[1][1]).sqrt();
    assert!(moved_m < bound_m && bound_m < 0.3, "{moved_m} m of {bound_m}, {before:?} {after:?}");
    let common = usize::from(kept.frame().common);
    for i in common..usize::from(kept.frame().states) {
        assert_eq!(slam.mean(i).to_bits(), kept.mean(i).to_bits());
        assert!((common..=i).all(|j| slam.covariance(i, j).to_bits() == kept.covariance(i, j).to_bits()));
    }
    let not_there = slam_core::Match { quarters: 0, pairs: [(first.0, 60_000), (across.0, across.1)] };
    assert_eq!(slam.take_up(&*kept, &not_there), Err(Unfit::NoMatch));
    let parallel = slam_core::Match { quarters: 0, pairs: [(first.1, first.1); 2] };
    assert_eq!(slam.take_up(&*kept, &parallel), Err(Unfit::NoMatch));
}

#[test]
fn carried_robots_are_right_and_know_how_well() {
    let (flat, kept) = (home("flat"), map_of("flat"));
    let (mut found, mut missed_m) = (Vec::new(), Vec::new());
    for seed in 1..=10 {
        match search(&flat, &flat, &kept, seed, 90.0) {
            Ok(place) => found.push(place),
            Err(path_m) => missed_m.push(path_m),
        }
    }
    // Two are put down between furniture, out of which the pilot does not find in that time.
    assert!(found.len() >= 8 && missed_m.iter().all(|path_m| *path_m < 10.0), "missed after {missed_m:?} m");
    for Found { error, path_m, .. } in &found {
        assert!(error.x_m.hypot(error.y_m) < 0.1 && error.theta_rad.abs() < 0.05, "{error:?} after {path_m} m");
    }
    let nees = found.iter().map(|found| found.nees).sum::<f64>() / found.len() as f64;
    // Chi-square of three times ten degrees of freedom, 99.9 %.
    assert!(nees < 6.0, "{nees}");
}

#[test]
fn another_home_is_not_claimed() {
    let (flat, kept) = (home("flat"), map_of("flat"));
    for (name, seed) in [("corridor-loop", 3), ("l-shape", 4), ("room", 5), ("diagonal", 6)] {
        assert!(search(&home(name), &flat, &kept, seed, 60.0).is_err(), "{name}");
    }
}

#[test]
fn a_home_that_looks_the_same_from_two_sides_stays_ambiguous() {
    const HALL: &str = "[start]\nx_m = 1.0\ny_m = 1.0\n[[outline]]\n\
        points_m = [[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [0.0, 3.0]]\n\
        [[room]]\nname = \"hall\"\nmin_m = [0.0, 0.0]\nmax_m = [5.0, 3.0]\n";
    let hall = plan_file::parse("hall", "hall", HALL).expect("a plan");
    let kept = drive(&hall, &rig(8), 120.0, 1, |_| true);
    for seed in 1..=4 {
        assert!(search(&hall, &hall, &kept, seed, 90.0).is_err());
    }
}

#[test]
fn homes_whose_rooms_are_alike_in_size_are_told_apart() {
    // Many walls of either stand where one of the other does, by chance.
    let kept = drive(&random_home(1), &rig(8), 600.0, 1, |_| true);
    for seed in 1000..1004 {
        assert!(search(&random_home(2), &random_home(1), &kept, seed, 100.0).is_err(), "{seed}");
    }
}
