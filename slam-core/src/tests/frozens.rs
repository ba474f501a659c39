//! Sensors whose output stays the same.

use crate::geometry::pose::Pose;
use crate::holds::frozen::Frozen;
use crate::holds::outputs::View;
use crate::measurement::sensor::{Sensor, SensorState};
use crate::{DriveModel, Mount, RangeInput, RangeModel, RangeSensor, Rig};

const SENSORS: usize = 4;

/// From one to the next, radians.
const BEARING_RAD: f32 = core::f32::consts::FRAC_PI_2;

/// A robot that turns by so much in a step, radians, and drives so far, metres, with sensors that read what `read` says by their index, the
/// turn and the way until then; which of them are frozen in the end, a bit each.
fn frozen(steps: usize, motion: [f32; 2], read: impl Fn(usize, f32, f32) -> Option<f32>) -> u16 {
    let mut frozen = Frozen::<SENSORS>::NONE;
    drive(&mut frozen, steps, motion, read);
    frozen.sensors()
}

fn drive(
    frozen: &mut Frozen<SENSORS>,
    steps: usize,
    [turn_rad, ahead_m]: [f32; 2],
    read: impl Fn(usize, f32, f32) -> Option<f32>,
) {
    let limits: [RangeSensor; SENSORS] = core::array::from_fn(|index| RangeSensor {
        mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: BEARING_RAD * index as f32 },
        min_m: 0.05,
        max_m: 2.0,
        max_incidence_rad: 1.2,
        gain_sigma: 0.0,
        model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 },
    });
    let states = limits.map(|limits| SensorState::new(&limits, None));
    let motion = Pose { x_m: ahead_m, y_m: 0.0, theta_rad: turn_rad };
    let drive = DriveModel::Odometry {
        scale_sigma: 0.0,
        noise_m2_per_m: 0.0,
        noise_rad2_per_m: 0.0,
        noise_rad2_per_rad: 0.0,
        veer_sigma: 0.0,
    };
    let rig = Rig { drive, adc: None, sensors: limits.into_iter().collect() };
    let mut wheels = Pose::ORIGIN;
    for step in 0..steps {
        wheels = wheels.compose(&motion);
        let (turned_rad, path_m) = (turn_rad * step as f32, ahead_m * step as f32);
        let view = View { rig: &rig, noise: 1.0, true_noise: 1.0, wheels: &wheels, path_m, fits: false };
        for (index, (limits, state)) in limits.iter().zip(&states).enumerate() {
            let range_m = read(index, turned_rad, path_m).unwrap_or(9.0);
            frozen.look(&Sensor { index, limits, state }, RangeInput::Metres(range_m), &view);
        }
        frozen.settle();
    }
}

/// What a sensor that points to such a side reads in a room of 2 m by 1.6 m, from its middle, metres.
fn room(index: usize, turned_rad: f32) -> f32 {
    let (s, c) = (turned_rad + BEARING_RAD * index as f32 + 0.3).sin_cos();
    (1.0 / c.abs()).min(0.8 / s.abs())
}

/// The same, but one of them reads this.
fn but(sensor: usize, range_m: f32) -> impl Fn(usize, f32, f32) -> Option<f32> {
    move |index, turned_rad, _| Some(if index == sensor { range_m } else { room(index, turned_rad) })
}

#[test]
fn an_output_that_stays_while_the_others_change_is_frozen() {
    assert_eq!(frozen(60, [0.02, 0.0], but(2, 0.65)), 0, "after a radian it is early");
    assert_eq!(frozen(200, [0.02, 0.0], but(2, 0.65)), 1 << 2);
    assert_eq!(frozen(200, [-0.02, 0.0], but(2, 0.65)), 1 << 2);
    assert_eq!(frozen(200, [0.02, 0.0], but(2, 1.9)), 1 << 2, "near the end of its reach");
}

#[test]
fn it_is_believed_again_when_it_changes() {
    let mut sensors = Frozen::<SENSORS>::NONE;
    drive(&mut sensors, 200, [0.02, 0.0], but(2, 0.65));
    assert_eq!(sensors.sensors(), 1 << 2);
    drive(&mut sensors, 20, [0.02, 0.0], |index, turned_rad, _| Some(room(index, turned_rad)));
    assert_eq!(sensors.sensors(), 1 << 2, "one change is none");
    drive(&mut sensors, 300, [0.02, 0.0], |index, turned_rad, _| Some(room(index, turned_rad)));
    assert_eq!(sensors.sensors(), 0);
}

#[test]
fn what_tells_nothing_is_not_frozen() {
    assert_eq!(frozen(900, [0.02, 0.0], |index, turned_rad, _| Some(room(index, turned_rad))), 0, "a room");
    let along = |index, _, _| if index == 1 { Some(0.3) } else { Some(1.0) };
    assert_eq!(frozen(900, [0.0, 0.01], along), 0, "along a wall");
    assert_eq!(frozen(900, [0.02, 0.0], |_, _, _| Some(0.65)), 0, "one that is held: all stay");
    let blocked = |index, _, _| Some(if index == 0 { 0.2 } else { 0.5 });
    assert_eq!(frozen(900, [0.0, 0.01], blocked), 0, "wheels that turn before a wall");
    // A sensor at the side of what the robot goes about has it at the same range, and so has one at the other side of a round room.
    assert_eq!(frozen(900, [0.03, 0.006], but(1, 0.2)), 0, "a chair's leg that is driven round");
    assert_eq!(frozen(900, [0.03, 0.03], but(3, 0.2)), 0, "a curved wall that is followed");
    let blind = |index, turned_rad, _| if index == 2 { None } else { Some(room(index, turned_rad)) };
    assert_eq!(frozen(900, [0.02, 0.0], blind), 0, "one that sees nothing");
    // Round a post, at its left: a sensor that looks there sees it at the same range all the way.
    assert_eq!(frozen(900, [0.02, 0.01], but(1, 0.5)), 0, "a post half a metre to the left that is driven round");
    assert_eq!(frozen(900, [0.02, 0.0], but(1, 0.5)), 1 << 1, "the same range in a turn on the spot");
}
