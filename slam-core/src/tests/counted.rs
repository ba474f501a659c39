//! Path, noise and calibration of dead reckoning counted anew in the middle of a drive.

use std::vec::Vec;

use super::runs::{Truth, rig};
use crate::RobotSlam;
use crate::counted::COUNTED_M;
use crate::kept::Kept;

/// What is left of walls and candidates, each as it depends on what is counted: how far ago each wall was seen, and of each
/// candidate the noise since and how it moves with the calibration.
fn differences(slam: &RobotSlam) -> Vec<f32> {
    let so_far = slam.drive.dead_reckoning;
    let walls = (0..slam.map.walls().len()).filter_map(|index| slam.unseen_m(index));
    let candidates = slam.candidates.buffer.iter().flat_map(|point| {
        let now = so_far.by_factor(point.hit_m);
        let moved = now.as_flattened().iter().zip(point.by_factor.as_flattened()).map(|(now, then)| now - then);
        let noise =
            [so_far.position_variance - point.position_variance, so_far.heading_variance - point.heading_variance];
        moved.chain(noise).collect::<Vec<_>>()
    });
    walls.chain(candidates).collect()
}

/// So many steps of a centimetre.
fn drive(slam: &mut RobotSlam, seed: u64, steps: u64) {
    let (rig, mut truth) = (rig(), Truth::new(seed));
    for number in 0..steps {
        slam.step(&truth.step(&rig, number));
    }
}

#[test]
fn only_what_is_counted_changes() {
    let mut slam = RobotSlam::new(rig()).expect("the rig is valid");
    drive(&mut slam, 1, 600);
    let before = differences(&slam);
    assert!(slam.map.walls().len() > 2 && before.len() > 20, "{} differences", before.len());
    slam.count_anew();
    assert_eq!(slam.drive.dead_reckoning.path_m, 0.0);
    for (before, after) in before.iter().zip(differences(&slam)) {
        assert!((before - after).abs() <= 1e-4 * before.abs().max(0.01), "{before} became {after}");
    }
}

#[test]
fn a_long_way_behind_it_the_robot_still_counts_its_steps() {
    let mut far = RobotSlam::new(rig()).expect("the rig is valid");
    far.drive.dead_reckoning.path_m = 1e6;
    drive(&mut far, 1, 600);
    let path_m = far.drive.dead_reckoning.path_m;
    assert!((path_m - 6.0).abs() < 0.3, "{path_m} m of 6");
}

#[test]
fn a_drive_goes_on_as_it_would_have() {
    let driven = |from_m: f32| {
        let mut slam = RobotSlam::new(rig()).expect("the rig is valid");
        slam.drive.dead_reckoning.path_m = from_m;
        drive(&mut slam, 2, 3000);
        slam
    };
    // The second one counts anew after half of its 30 m.
    let (one, other) = (driven(0.0), driven(COUNTED_M - 15.0));
    assert!(other.drive.dead_reckoning.path_m < 16.0);
    assert_eq!(one.map.walls().len(), other.map.walls().len());
    let (one, other) = (one.pose(), other.pose());
    assert!((one.x_m - other.x_m).hypot(one.y_m - other.y_m) < 1e-3, "{one:?} {other:?}");
}
