//! A robot whose sensors reach 0.8 m hardly knows its heading for minutes, finds walls whose directions turn out to be others by degrees,
//! and must not grow sure of either by that.

use lab::evaluate::statistics::{mean, median};
use lab::input::built_in_robot;
use tests::simulated::drive_of;

const REACH_M: f32 = 0.8;

#[test]
fn a_robot_that_sees_little_is_as_sure_as_it_is_right() {
    let (mut robot, _) = built_in_robot().expect("the built-in rig is good");
    for sensor in &mut robot.rig.sensors {
        sensor.max_m = REACH_M;
    }
    let nees: Vec<f64> = (41..=60)
        .map(|seed| {
            drive_of(&robot, "flat", 6.0, seed, |_| ())
                .figures
                .estimate
                .and_then(|score| score.nees)
                .expect("a true path")
        })
        .collect();
    // 3 is ideal. Jacobians at ever newer normals have a median of 10 to 20 and a mean of 50 to 100.
    assert!(median(&nees).is_some_and(|median| median < 5.0), "{nees:?}");
    assert!(mean(&nees).is_some_and(|mean| mean < 10.0), "{nees:?}");
}
