//! Odometry that says forwards where the robot drove backwards.

use std::vec::Vec;

use crate::motion::travel::Travel;
use crate::sensing::sign::Sign;
use crate::sensing::surface::{Motion as Row, Surface};
use crate::{
    Config, DriveModel, HostSlam, Increment, Motion, Mount, RangeInput, RangeModel, RangeSensor, Rig, Sample,
    VEER_SIGMA,
};

/// Walls at x = 3 and -1, y = 1.5 and -1.5.
const ROOM: [f64; 4] = [3.0, -1.0, 1.5, -1.5];

fn rig() -> Rig<16> {
    let sensor = |bearing_deg: f32| RangeSensor {
        mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: bearing_deg.to_radians() },
        min_m: 0.1,
        max_m: 5.0,
        max_incidence_rad: 1.2,
        gain_sigma: 0.0,
        model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 },
    };
    let drive = DriveModel::Odometry {
        scale_sigma: 0.02,
        noise_m2_per_m: 2e-4,
        noise_rad2_per_m: 2e-4,
        noise_rad2_per_rad: 2e-4,
        veer_sigma: VEER_SIGMA,
    };
    Rig { drive, adc: None, sensors: [-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0].map(sensor).into_iter().collect() }
}

fn range_m([x, y, theta]: [f64; 3], bearing_rad: f64) -> f32 {
    let (s, c) = (theta + bearing_rad).sin_cos();
    let hits = [(ROOM[0] - x) / c, (ROOM[1] - x) / c, (ROOM[2] - y) / s, (ROOM[3] - y) / s];
    hits.into_iter().filter(|m| *m > 0.0).fold(f64::MAX, f64::min) as f32
}

/// (speed, turn rate, rows): to and fro and round, with stops, five rows a second.
fn drive() -> Vec<(f64, f64, usize)> {
    let mut parts = Vec::new();
    for _ in 0..6 {
        parts.extend([(0.4, 0.0, 15), (0.0, 0.0, 3), (-0.4, 0.0, 10), (0.0, 0.5, 6), (0.0, -0.5, 6), (-0.3, 0.0, 7)]);
    }
    parts
}

/// People walk ahead of a robot in a corridor, each twice as fast as it drives until the next one does: by them it drives
/// backwards. How far the estimated position ends from the true one, metres.
fn miss_behind_people_m(find_sign: bool) -> f64 {
    let (rig, mut config) = (rig(), Config::real_rooms());
    config.motion.find_sign = find_sign;
    let mut slam = HostSlam::with_config(rig.clone(), config).unwrap();
    let (mut x_m, mut person_m) = (0.0f64, 1.0);
    for number in 0..40u64 {
        person_m = if person_m > x_m + 4.5 { x_m + 1.0 } else { person_m + 0.16 };
        let mut ranges = [RangeInput::Missing; 16];
        for (range, sensor) in ranges.iter_mut().zip(&rig.sensors) {
            let bearing_rad = f64::from(sensor.mount.bearing_rad);
            let metres = if bearing_rad == 0.0 { person_m - x_m } else { ROOM[2] / bearing_rad.sin().abs() };
            *range = RangeInput::Metres(metres as f32);
        }
        let forward_m = if number == 0 { 0.0 } else { 0.08 };
        let motion = Increment { forward_m, left_m: 0.0, turn_rad: 0.0 };
        slam.step(&Sample { time_us: 200_000 * number, motion: Motion::Increment(motion), ranges });
        x_m += f64::from(forward_m);
    }
    let found = slam.start_pose().inverse().compose(&slam.pose());
    (f64::from(found.x_m) - x_m).abs()
}

/// Backs off by twelve centimetres again and again.
fn short_ways_back() -> Vec<(f64, f64, usize)> {
    (0..8)
        .flat_map(|_| [(0.4, 0.0, 6), (0.0, 0.0, 3), (-0.3, 0.0, 2), (0.0, 0.0, 3), (0.0, 0.5, 3), (0.0, -0.5, 3)])
        .collect()
}

/// How far the estimated position ends from the true one, metres, and how far the robot drove backwards.
fn miss_m(has_sign: bool, find_sign: bool) -> (f64, f64) {
    miss_of_drive_m(&drive(), has_sign, find_sign, 0.0)
}

/// The same of any drive; of each row's motion the odometry tells this share with the next one.
fn miss_of_drive_m(drive: &[(f64, f64, usize)], has_sign: bool, find_sign: bool, late: f64) -> (f64, f64) {
    let (rig, mut config) = (rig(), Config::real_rooms());
    config.motion.find_sign = find_sign;
    let mut slam = HostSlam::with_config(rig.clone(), config).unwrap();
    let (mut pose, mut backwards_m, mut before) = ([0.0f64; 3], 0.0, [0.0; 2]);
    let rows = drive.iter().flat_map(|&(speed, rate, rows)| std::iter::repeat_n((speed, rate), rows));
    for (number, (speed, rate)) in rows.enumerate() {
        let (s, c) = pose[2].sin_cos();
        pose = [pose[0] + 0.2 * speed * c, pose[1] + 0.2 * speed * s, pose[2] + 0.2 * rate];
        backwards_m += 0.2 * (-speed).max(0.0);
        let logged = if has_sign { speed } else { speed.abs() };
        let mut ranges = [RangeInput::Missing; 16];
        for (range, sensor) in ranges.iter_mut().zip(&rig.sensors) {
            *range = RangeInput::Metres(range_m(pose, sensor.mount.bearing_rad.into()));
        }
        let told = [logged, rate].map(|a| 0.2 * (1.0 - late) * a);
        let [forward_m, turn_rad] = [0, 1].map(|i| (told[i] + before[i]) as f32);
        before = [logged, rate].map(|a| 0.2 * late * a);
        let motion = Increment { forward_m, left_m: 0.0, turn_rad };
        slam.step(&Sample { time_us: 200_000 * number as u64, motion: Motion::Increment(motion), ranges });
    }
    let found = slam.start_pose().inverse().compose(&slam.pose());
    ((f64::from(found.x_m) - pose[0]).hypot(f64::from(found.y_m) - pose[1]), backwards_m)
}

#[test]
fn what_was_driven_backwards_is_found_where_odometry_has_no_sign() {
    let (miss, backwards_m) = miss_m(false, true);
    assert!(backwards_m > 4.0, "{backwards_m} m");
    assert!(miss < 0.1, "{miss} m off");
    let (without, _) = miss_m(false, false);
    assert!(without > 0.5, "{without} m off without looking for it");
}

#[test]
fn a_short_way_back_is_found_where_the_odometry_of_a_row_is_late() {
    let (miss, backwards_m) = miss_of_drive_m(&short_ways_back(), false, true, 0.5);
    assert!(backwards_m > 0.9, "{backwards_m} m");
    // Twice the first one, which nobody expects.
    assert!(miss < 0.24, "{miss} m off");
}

/// A robot drives to and fro, backs off, and drives ahead again without a row in which it stands, the slowest seen at `slow_m_s`; from
/// there on it sees nothing. By how many of its standard deviations the estimated position ends from the true one.
fn miss_of_who_hardly_stops(slow_m_s: f64) -> f64 {
    let rig = rig();
    let mut slam = HostSlam::with_config(rig.clone(), Config::real_rooms()).unwrap();
    let mut x_m = 0.0f64;
    let seen = [(0.4, 15), (0.0, 3), (-0.4, 12), (0.0, 3), (0.4, 12), (0.0, 3), (-0.4, 12)];
    let unseen = [(slow_m_s, 1), (0.4, 8), (0.0, 3)];
    let rows = seen.map(|part| (true, part)).into_iter().chain(unseen.map(|part| (false, part)));
    let rows = rows.flat_map(|(sees, (speed, rows))| std::iter::repeat_n((sees, speed), rows));
    for (number, (sees, speed)) in rows.enumerate() {
        x_m += 0.2 * speed;
        let mut ranges = [RangeInput::Missing; 16];
        for (range, sensor) in ranges.iter_mut().zip(&rig.sensors).filter(|_| sees) {
            *range = RangeInput::Metres(range_m([x_m, 0.0, 0.0], sensor.mount.bearing_rad.into()));
        }
        let motion = Increment { forward_m: (0.2 * speed.abs()) as f32, left_m: 0.0, turn_rad: 0.0 };
        slam.step(&Sample { time_us: 200_000 * number as u64, motion: Motion::Increment(motion), ranges });
    }
    let found = slam.start_pose().inverse().compose(&slam.pose());
    (f64::from(found.x_m) - x_m).abs() / f64::from(slam.estimate().covariance[(0, 0)]).sqrt()
}

#[test]
fn who_may_have_turned_round_within_a_row_is_not_sure_of_where_it_is() {
    for slow_m_s in [0.05, 0.11, 0.15] {
        let sigmas = miss_of_who_hardly_stops(slow_m_s);
        assert!(sigmas < 3.0, "{sigmas} sigmas off where the slowest row is seen at {slow_m_s} m/s");
    }
}

#[test]
fn an_odometry_with_a_sign_is_believed() {
    let (looking, without) = (miss_m(true, true).0, miss_m(true, false).0);
    assert!((looking - without).abs() < 0.005, "{looking} and {without} m off");
}

#[test]
fn who_walks_ahead_does_not_turn_the_odometry_round() {
    let (looking, without) = (miss_behind_people_m(true), miss_behind_people_m(false));
    assert!((looking - without).abs() < 0.005, "{looking} and {without} m off");
}

/// Whether an odometry is taken for one without a sign while three walls ahead say forwards, and a surface that said so, too, and is
/// taken for a wall of the map says backwards from then on, as one does when its beam has passed a corner.
fn is_turned_round_by_one_surface() -> bool {
    let rig = rig();
    let mut sign = Sign::<16>::unknown(&rig.drive);
    let travel = Travel::Body(Increment { forward_m: 0.05, left_m: 0.0, turn_rad: 0.0 });
    let ahead = &rig.sensors[2..5];
    let sensors = [ahead, &ahead[..1]].concat();
    let mut ranges_m = [4.0f32; 4];
    (0..40).any(|row| {
        let turns_back = row >= 20;
        for (range_m, mount) in ranges_m.iter_mut().zip(sensors.iter().map(|sensor| &sensor.mount)) {
            *range_m -= 0.05 / mount.bearing_rad.cos();
        }
        ranges_m[3] += if turns_back { 0.1 / sensors[3].mount.bearing_rad.cos() } else { 0.0 };
        let _ = sign.follow(&travel, 0.0, 0.2);
        let claims = sign.tell(&sensors, &ranges_m.map(RangeInput::Metres)).is_some();
        (0..4).for_each(|sensor| sign.met(sensor, || Some(std::f32::consts::PI)));
        claims
    })
}

#[test]
fn one_surface_is_not_heard_against_all_others() {
    assert!(!is_turned_round_by_one_surface());
}

#[test]
fn a_surface_that_says_now_this_and_now_that_says_nothing() {
    let rig = rig();
    let mut sign = Sign::<16>::unknown(&rig.drive);
    let travel = Travel::Body(Increment { forward_m: 0.05, left_m: 0.0, turn_rad: 0.0 });
    let sensors = &rig.sensors[3..5];
    let mut ranges_m = [3.0f32; 2];
    for row in 0..60 {
        // As of people who let a robot come near, walk on and wait again.
        let change_m = if row % 12 < 6 { -0.05 } else { 0.05 };
        for (range_m, sensor) in ranges_m.iter_mut().zip(sensors) {
            *range_m += change_m / sensor.mount.bearing_rad.cos();
        }
        let _ = sign.follow(&travel, 0.0, 0.2);
        assert!(sign.tell(sensors, &ranges_m.map(RangeInput::Metres)).is_none(), "turned round at row {row}");
    }
}

/// The highest log odds of backwards that a surface says in all, which is no wall of the map and recedes from a beam 30 degrees to the left by
/// half of what is driven, as one does that stands askew beside a robot which drives forwards; a new one after so many rows.
fn says_of_what_recedes(rows: usize) -> f32 {
    let sensor = &rig().sensors[4];
    let motion = Row { forward_m: 0.05, turn_rad: 0.0, longest_m: 0.05 };
    let (mut surface, mut range_m, mut heard, mut most) = (Surface::NONE, 1.0f32, 0.0f32, 0.0f32);
    for row in 0..40 {
        range_m += 0.025 + if row % rows == rows - 1 { 0.6 } else { 0.0 };
        let says = surface.look(sensor, RangeInput::Metres(range_m), &motion);
        surface.hear(says.more);
        heard += says.more;
        most = most.max(heard);
    }
    most
}

#[test]
fn a_surface_that_stands_askew_says_once_what_it_does() {
    let (one, two) = (says_of_what_recedes(usize::MAX), says_of_what_recedes(20));
    assert!(one < 3.5, "{one}");
    assert!(two > 1.5 * one, "{two} of two surfaces, {one} of one");
}
