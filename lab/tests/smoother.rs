//! A look back on a run: it repairs what the filter could not know at the time.

use std::f64::consts::{FRAC_PI_2, TAU};

use lab::evaluate::score;
use lab::evaluate::smoother;
use lab::input::rig_file::MAX_SENSORS;
use lab::recording::{Pose2, Recording, SensorInfo, Step};
use slam_core::{DriveModel, Mount, Outcome, RangeModel, RangeSensor, ReadingReport, Rig};

const ROOM_M: [f64; 2] = [3.0, 2.0];
const STEPS_A_LAP: usize = 250;

fn rig() -> Rig<MAX_SENSORS> {
    let sensor = |i: usize| RangeSensor {
        mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: (FRAC_PI_2 * i as f64) as f32 },
        min_m: 0.05,
        max_m: 8.0,
        max_incidence_rad: 1.2,
        gain_sigma: 0.0,
        model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 },
    };
    let drive = DriveModel::Odometry {
        scale_sigma: 0.05,
        noise_m2_per_m: 1e-4,
        noise_rad2_per_m: 1e-5,
        noise_rad2_per_rad: 1e-5,
        veer_sigma: 0.0,
    };
    Rig { drive, adc: None, sensors: (0..4).map(sensor).collect() }
}

/// Round and round an ellipse in a room.
fn truth(step: usize) -> Pose2 {
    let angle = TAU * step as f64 / STEPS_A_LAP as f64;
    let (s, c) = angle.sin_cos();
    Pose2::new(1.8 * c, s, c.atan2(-1.8 * s))
}

/// The range to the wall that a beam meets, and which of the four that is.
fn meet(pose: &Pose2, bearing_rad: f64) -> (f64, usize) {
    let (s, c) = (pose.theta_rad + bearing_rad).sin_cos();
    let along = |at: f64, by: f64, half: f64| (half * by.signum() - at) / by;
    let (x_m, y_m) = (along(pose.x_m, c, ROOM_M[0]), along(pose.y_m, s, ROOM_M[1]));
    if x_m < y_m { (x_m, usize::from(c < 0.0)) } else { (y_m, 2 + usize::from(s < 0.0)) }
}

/// A filter that believed an odometry that reads long, and had new walls in every lap.
fn misled(laps: usize, reads_long: f64) -> Recording {
    let first = truth(0);
    let mut dead_reckoning = Pose2::default();
    let mut recording = Recording {
        sensors: (0..4)
            .map(|i| SensorInfo { bearing_rad: FRAC_PI_2 * f64::from(i), span_m: [0.05, 8.0], ..SensorInfo::default() })
            .collect(),
        ..Recording::default()
    };
    for step in 0..laps * STEPS_A_LAP {
        if step > 0 {
            let moved = truth(step - 1).relative(&truth(step));
            let sensed = Pose2::new(reads_long * moved.x_m, reads_long * moved.y_m, moved.theta_rad);
            dead_reckoning = dead_reckoning.compose(&sensed);
        }
        let here = truth(step);
        for sensor in &recording.sensors {
            let (range_m, wall) = meet(&here, sensor.bearing_rad);
            let (s, c) = sensor.bearing_rad.sin_cos();
            let hit_m = dead_reckoning.transform([range_m * c, range_m * s]).map(|metres| metres as f32);
            let wall = (wall + 4 * (step / STEPS_A_LAP)) as u16;
            let outcome = Outcome::Updated { wall, innovation_m: 0.0, variance_m2: 1e-3, noise_m2: 1e-3 };
            recording.readings.push(ReadingReport { outcome, range_m: Some(range_m as f32), hit_m: Some(hit_m) });
        }
        recording.steps.push(Step {
            t_s: 0.2 * step as f64,
            pose: dead_reckoning,
            dead_reckoning,
            sensed: dead_reckoning,
            truth: Some(first.relative(&here)),
            alpha: Some((0.0, 0.01)),
            ..Step::default()
        });
    }
    score::score(&mut recording, &[], None);
    recording
}

#[test]
fn a_scale_that_was_wrong_and_walls_that_were_two_are_put_right() {
    let mut recording = misled(2, 1.05);
    let before = recording.figures.clone();
    let back = smoother::add(&mut recording, &rig(), &mut |_| ()).expect("there are walls");
    assert_eq!(back.walls().len(), 4, "both laps saw the same four walls");
    let score = recording.figures.looking_back.as_ref().expect("it is scored");
    let ate_m = |score: Option<lab::recording::PathScore>| score.expect("there is a truth").ate_m;
    let (was_m, is_m) = (ate_m(before.estimate), ate_m(score.estimate));
    assert!(was_m > 0.05 && is_m < 0.01, "{was_m} m, looking back {is_m} m");
    let entropy = |score: &Option<lab::recording::Consistency>| score.as_ref().expect("there are hits").entropy_nats;
    assert!(entropy(&score.consistency) < entropy(&before.consistency) - 0.5);
    assert_eq!(recording.figures.estimate, before.estimate, "what the robot knew stays what it knew");
}

#[test]
fn a_path_that_was_right_stays() {
    let mut recording = misled(1, 1.0);
    let back = smoother::add(&mut recording, &rig(), &mut |_| ()).expect("there are walls");
    for (live, later) in recording.steps.iter().zip(&back.steps) {
        let off = live.pose.relative(&later.pose);
        assert!(off.x_m.hypot(off.y_m) < 0.005 && off.theta_rad.abs() < 0.002, "{off:?} at {} s", live.t_s);
    }
}

#[test]
fn readings_that_were_given_to_a_wrong_wall_are_outweighed() {
    let mut recording = misled(1, 1.0);
    // One in ten.
    for reading in recording.readings.iter_mut().step_by(10) {
        if let Outcome::Updated { wall, .. } = &mut reading.outcome {
            *wall = (*wall + 1) % 4;
        }
    }
    let back = smoother::add(&mut recording, &rig(), &mut |_| ()).expect("there are walls");
    assert_eq!(back.walls().len(), 4);
    let score = recording.figures.looking_back.and_then(|score| score.estimate).expect("there is a truth");
    assert!(score.ate_m < 0.03, "{} m", score.ate_m);
}

#[test]
fn readings_that_the_filter_could_not_place_are_placed() {
    let mut recording = misled(2, 1.05);
    // It knew no wall in its second lap, but for a few readings.
    let second = recording.readings.len() / 2;
    for (i, reading) in recording.readings.iter_mut().enumerate().skip(second) {
        if i % 20 > 3 {
            reading.outcome = Outcome::Unexplained;
        }
    }
    let back = smoother::add(&mut recording, &rig(), &mut |_| ()).expect("there are walls");
    let on_walls: u32 = back.walls().iter().map(|wall| wall.updates).sum();
    // In the corners beams graze the walls.
    assert_eq!((back.walls().len(), on_walls as usize * 100 / recording.readings.len()), (4, 98));
}

#[test]
fn a_wall_that_readings_went_through_is_not_there() {
    let mut recording = misled(3, 1.0);
    // In the second of three laps somebody stands half a metre before a wall: too short to be that wall in another place.
    let lap = recording.readings.len() / 3;
    let poses: Vec<Pose2> = recording.steps.iter().map(|step| step.pose).collect();
    let mut stood = 0;
    for (i, reading) in recording.readings.iter_mut().enumerate().skip(lap).take(lap) {
        let (Outcome::Updated { wall: wall @ 4, .. }, Some(hit_m)) = (&mut reading.outcome, &mut reading.hit_m) else {
            continue;
        };
        let pose = poses[i / 4];
        let [dx, dy] = [f64::from(hit_m[0]) - pose.x_m, f64::from(hit_m[1]) - pose.y_m];
        let share = (dy + 0.5) / dy;
        let before_m = [pose.x_m + share * dx, pose.y_m + share * dy];
        if !(-0.2..0.2).contains(&before_m[0]) {
            continue;
        }
        *hit_m = before_m.map(|metres| metres as f32);
        *wall = 99;
        stood += 1;
    }
    assert!(stood > 10, "{stood}");
    let back = smoother::add(&mut recording, &rig(), &mut |_| ()).expect("there are walls");
    assert_eq!(back.walls().len(), 4);
}

#[test]
fn where_there_is_nothing_to_see_there_is_no_look_back() {
    assert!(smoother::add(&mut Recording::default(), &rig(), &mut |_| ()).is_none());
    let mut blind = misled(1, 1.0);
    blind.readings.fill(ReadingReport::default());
    assert!(smoother::add(&mut blind, &rig(), &mut |_| ()).is_none());
    assert_eq!(blind.figures.looking_back, None);
}

/// Draws that are as often positive as negative, nearly normal, of deviation one.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

#[test]
fn readings_of_an_analogue_sensor_that_came_out_short_count_no_more_than_those_that_came_out_long() {
    const MODEL: (f64, f64, f64) = (0.60374, -1.16, 0.02);
    let mut recording = misled(3, 1.0);
    let mut draws = Draws(7);
    let sensors = recording.sensors.len();
    let (scale_m, exponent, noise_v) = MODEL;
    for (i, reading) in recording.readings.iter_mut().enumerate() {
        let truth_m = f64::from(reading.range_m.expect("it is there"));
        let volts = (truth_m / scale_m).powf(1.0 / exponent);
        let range_m = scale_m * (volts + noise_v * draws.next()).max(0.2 * volts).powf(exponent);
        let pose = recording.steps[i / sensors].pose;
        let bearing_rad = recording.sensors[i % sensors].bearing_rad;
        let hit_m = pose.transform([range_m * bearing_rad.cos(), range_m * bearing_rad.sin()]);
        reading.range_m = Some(range_m as f32);
        reading.hit_m = Some(hit_m.map(|metres| metres as f32));
        if let Outcome::Updated { innovation_m, .. } = &mut reading.outcome {
            *innovation_m = (range_m - truth_m) as f32;
        }
    }
    let mut rig = rig();
    let model = RangeModel::Sharp { scale_m: scale_m as f32, exponent: exponent as f32, noise_v: noise_v as f32 };
    rig.sensors.iter_mut().for_each(|sensor| sensor.model = model);
    let back = smoother::add(&mut recording, &rig, &mut |_| ()).expect("there are walls");
    let width_m = |axis: f32| -> f32 {
        let walls = back.walls().iter().filter(|wall| (wall.beta_rad.cos().abs() - axis).abs() < 0.1);
        walls.map(|wall| wall.rho_m).sum()
    };
    // The drive begins along y.
    let off = [width_m(0.0) / (2.0 * ROOM_M[0] as f32) - 1.0, width_m(1.0) / (2.0 * ROOM_M[1] as f32) - 1.0];
    // Of long ranges those that go past a corner are missing.
    assert!(off[0].abs() < 0.01 && off[1].abs() < 0.003, "the room is larger by {off:?}");
}
