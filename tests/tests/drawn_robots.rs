//! Robots of other builds than the built-in one sweep their homes and come back.

use robot::FloorState;
use tests::drawn_robots::{job, robot};

/// Seven sensors look ahead and to the sides by thirty degrees each: along a wall the outer ones are nearer to it than their least range, and
/// what they show is folded back. Two of them must not agree on a turn by the angle between them.
#[test]
fn sensors_whose_readings_fold_back_along_a_wall_do_not_turn_the_robot() {
    for number in [510, 524, 744] {
        assert_eq!(robot("sharp", number).rig.sensors.len(), 7, "robot {number}");
        let drive = job("sharp", number);
        assert_eq!(drive.progress.state, FloorState::Done, "robot {number}");
        assert!(drive.score.home_m < 0.2, "robot {number} is {} m from where it started", drive.score.home_m);
        assert!(drive.worst_m < 1.0, "robot {number} was {} m off", drive.worst_m);
    }
}

/// Before its first wall such a robot knows its heading to twenty degrees, for its wheels are known to two in a hundred. Once the walls tell
/// how large they are, so do they where it started.
#[test]
fn a_robot_that_turned_by_wheels_that_it_did_not_know_finds_where_it_started() {
    for number in [583, 671, 704] {
        let drive = job("sharp", number);
        assert_eq!(drive.progress.state, FloorState::Done, "robot {number}");
        assert!(drive.score.home_m < 0.2, "robot {number} is {} m from where it started", drive.score.home_m);
    }
}
