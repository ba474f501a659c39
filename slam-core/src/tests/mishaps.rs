//! What befalls a robot at an unlucky moment.

use std::boxed::Box;

use super::runs::{Truth, rig};
use crate::kept::Kept;
use crate::measurement::slippage::Slippage;
use crate::{
    Config, DriveModel, Health, Motion, Mount, RangeInput, RangeModel, RangeSensor, Rig, RobotSlam, Sample, Slip, Ticks,
};

const NOTHING: [RangeInput; 8] = [RangeInput::Missing; 8];

/// In the middle of a drive through its room.
fn mapped() -> (Box<RobotSlam>, Truth) {
    let (mut slam, mut truth) = (Box::new(RobotSlam::new(rig()).expect("the rig is valid")), Truth::new(3));
    for number in 0..2000 {
        slam.step(&truth.step(&rig(), number));
    }
    (slam, truth)
}

/// Four sensors ahead, to the sides and back.
fn cross() -> Rig<8> {
    let sensors = [0.0f32, 90.0, 180.0, -90.0].map(|bearing_deg| {
        let bearing_rad = bearing_deg.to_radians();
        RangeSensor {
            mount: Mount { x_m: 0.1 * bearing_rad.cos(), y_m: 0.1 * bearing_rad.sin(), bearing_rad },
            min_m: 0.04,
            max_m: 2.0,
            max_incidence_rad: 1.05,
            gain_sigma: 0.01,
            model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.01 },
        }
    });
    let drive = DriveModel::Wheels {
        track_m: 0.235,
        track_sigma: 0.0,
        metres_per_tick: 0.000_445,
        scale_sigma: 0.005,
        noise_m2_per_m: 1e-5,
    };
    Rig { drive, adc: None, sensors: sensors.into_iter().collect() }
}

/// A robot of that rig, and what its wheels count.
struct Robot {
    slam: Box<RobotSlam>,
    ticks: Ticks,
    number: u32,
}

impl Robot {
    fn new() -> Self {
        // The encoders tell the sign of motion.
        let mut config = Config::for_rig(&cross());
        config.motion.find_sign = false;
        let slam = Box::new(RobotSlam::with_config(cross(), config).expect("the rig is valid"));
        Self { slam, ticks: Ticks { left: 0, right: 0 }, number: 0 }
    }

    /// Steps in which the wheels count so much more, and each sensor reads this, metres, give or take some millimetres.
    fn go(&mut self, steps: usize, by: [i32; 2], ranges_m: [Option<f32>; 4]) {
        for _ in 0..steps {
            (self.ticks.left, self.ticks.right) = (self.ticks.left + by[0], self.ticks.right + by[1]);
            self.number += 1;
            let noise_m = |sensor: u32| 0.004 * (((self.number * 7 + sensor * 3) % 5) as f32 - 2.0);
            let mut ranges = NOTHING;
            for ((input, range_m), sensor) in ranges.iter_mut().zip(ranges_m).zip(0..) {
                *input = range_m.map_or(RangeInput::Missing, |range_m| RangeInput::Metres(range_m + noise_m(sensor)));
            }
            let time_us = 40_000 * u64::from(self.number);
            self.slam.step(&Sample { time_us, motion: Motion::Ticks(self.ticks), ranges });
        }
    }
}

#[test]
fn a_hold_that_is_found_as_the_first_wall_is_born_leaves_the_robot_where_it_is() {
    let mut robot = Robot::new();
    // So far without a wall that the filter begins anew where the first one is drawn.
    robot.go(1000, [22, 22], [None; 4]);
    let before = robot.slam.pose();
    // Something holds it: ranges that stay are taken for walls beside its way, and as its wheels turn for others.
    robot.go(60, [22, 22], [Some(1.2), Some(0.5), Some(0.9), Some(0.6)]);
    assert!(!robot.slam.map.walls().is_empty());
    robot.go(150, [-5, 5], [Some(1.2), Some(0.5), Some(0.9), Some(0.6)]);
    let after = robot.slam.pose();
    assert!(robot.slam.counters().holds > 0, "no hold was found");
    assert!((after.x_m - before.x_m).hypot(after.y_m - before.y_m) < 0.1, "{before:?} {after:?}");
}

#[test]
fn a_motion_that_is_lost_is_no_longer_however_much_wheels_slip() {
    let (mut slam, _) = mapped();
    slam.config.motion.slip = Slip::Learned;
    slam.slippage = Slippage::BELIEVED;
    assert!(slam.wheel_level() > 1.0, "{}", slam.wheel_level());
    let motion = Motion::Ticks(Ticks { left: i32::MAX / 2, right: 0 });
    slam.step(&Sample { time_us: 81_000_000, motion, ranges: NOTHING });
    // Half a metre and a radian for each second beyond a fifth of one, and what one step is.
    let [by_m, by_rad] = slam.lost_motion().expect("it is lost");
    assert!((0.3..=0.45).contains(&by_m) && (0.6..=0.9).contains(&by_rad), "{by_m} m, {by_rad} rad");
}

#[test]
fn a_sample_that_is_refused_tells_how_the_estimator_is() {
    let (mut slam, _) = mapped();
    slam.monitor.note(&crate::Outcome::Refused(crate::Refusal::Degenerate), 0.0, None);
    let sample = |time_us| Sample { time_us, motion: Motion::Ticks(Ticks { left: 0, right: 0 }), ranges: NOTHING };
    slam.step(&sample(81_000_000));
    assert_eq!(slam.step(&sample(81_000_000)).health, Health::Degenerate);
    assert_eq!(slam.lost_motion(), None);
}

#[test]
fn a_robot_that_was_carried_without_a_map_to_find_itself_in_knows_no_start_and_no_dock() {
    let mut robot = Robot::new();
    robot.go(1, [0, 0], [None; 4]);
    robot.slam.stands_in_dock();
    robot.go(150, [22, 22], [None; 4]);
    robot.slam.restart_elsewhere();
    let frame = robot.slam.frame();
    assert!(!frame.has_dock && frame.start == crate::Pose::ORIGIN);
    assert!(robot.slam.pose().x_m.abs() < 1e-3, "its frame begins where it is: {:?}", robot.slam.pose());
}

#[test]
fn what_held_a_robot_does_not_hold_it_once_it_is_lifted() {
    let mut robot = Robot::new();
    robot.go(150, [-5, 5], [Some(1.2), Some(0.5), Some(0.9), Some(0.6)]);
    assert!(robot.slam.is_held());
    robot.slam.release();
    robot.slam.restart_map();
    let before = robot.slam.pose();
    robot.go(30, [22, 22], [None; 4]);
    let after = robot.slam.pose();
    assert!((after.x_m - before.x_m).hypot(after.y_m - before.y_m) > 0.25, "{before:?} {after:?}");
}

#[test]
fn a_hold_beside_walls_that_tell_nothing_of_the_way_may_have_begun_anywhere_on_it() {
    let held_after = |ahead_m: Option<f32>| {
        let mut robot = Robot::new();
        robot.go(300, [22, 22], [ahead_m, Some(0.5), None, Some(0.6)]);
        let driven_m = robot.slam.pose().x_m;
        robot.go(150, [-5, 5], [ahead_m, Some(0.5), None, Some(0.6)]);
        assert!(robot.slam.is_held());
        (driven_m, robot.slam.pose().x_m, robot.slam.ekf.covariance(0, 0).sqrt())
    };
    let (driven_m, place_m, sigma_m) = held_after(None);
    assert!((place_m - 0.5 * driven_m).abs() < 0.1, "{place_m} of {driven_m} m");
    assert!(sigma_m > 0.25 * driven_m, "{sigma_m} of {driven_m} m");
    // What stays as far ahead as it was shows that it never drove.
    let (_, place_m, sigma_m) = held_after(Some(1.2));
    assert!(place_m.abs() < 0.1 && sigma_m < 0.15, "{place_m} +- {sigma_m} m");
}
