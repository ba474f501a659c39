//! The pilot in every plan: it visits every room and never gets stuck, with a pose that is as wrong as an estimate may
//! be. The truth reaches it only through such a pose.
use hal_sim::rng::Rng;
use hal_sim::{ClosedLoop, Estimate, Frame, Plan, SimOptions, Simulation, default_rig_with, nominal_ranges, plan_file};
use robot::PilotConfig;
use slam_core::Pose;

/// Errors of the pose that the pilot is given.
#[derive(Clone, Copy, Default)]
struct PoseError {
    noise_m: f64,
    /// The frame turns by this much in ten minutes.
    drift_rad: f32,
    /// Every other twenty seconds the pose is off by this much.
    jump_m: f32,
}

struct Drive {
    /// Seconds until the last room was entered.
    last_room_s: f64,
    /// Longest time within one circle of 0.4 m, seconds.
    standstill_s: f64,
    path_m: f64,
    frames: Vec<Frame>,
}

fn drive(plan: &Plan, sensors: &[usize], seed: u64, error: PoseError, minutes: f64) -> Drive {
    let rig = default_rig_with(sensors);
    let simulation = Simulation::new(plan, &rig, SimOptions::default(), seed).unwrap();
    let mut robot = ClosedLoop::new(simulation, &rig, PilotConfig::default());
    let mut noise = Rng::stream(seed, "test-pose", 0);
    let mut truth = Pose::default();
    let mut entered_s = vec![f64::INFINITY; plan.rooms.len()];
    let mut result = Drive { last_room_s: 0.0, standstill_s: 0.0, path_m: 0.0, frames: Vec::new() };
    let (mut anchor, mut since_s) = (Pose::default(), 0.0);
    while robot.simulation.time_s() < 60.0 * minutes {
        let time_s = robot.simulation.time_s();
        let frame = robot.step(&mut |sample| {
            let turned = Pose::new(0.0, 0.0, error.drift_rad * time_s as f32 / 600.0).compose(&truth);
            let jump_m = if (time_s / 20.0) as u32 % 2 == 1 { error.jump_m } else { 0.0 };
            let mut blur = || (error.noise_m * noise.gaussian()) as f32;
            let pose = Pose::new(turned.x_m + jump_m + blur(), turned.y_m + blur(), turned.theta_rad + blur());
            Estimate { pose, ranges_m: nominal_ranges(&rig, sample) }
        });
        let before = truth;
        truth = frame.truth.to_pose();
        result.path_m += f64::from(f32::hypot(truth.x_m - before.x_m, truth.y_m - before.y_m));
        if f32::hypot(truth.x_m - anchor.x_m, truth.y_m - anchor.y_m) > 0.4 {
            (anchor, since_s) = (truth, time_s);
        }
        result.standstill_s = result.standstill_s.max(time_s - since_s);
        let place = robot.simulation.pose_in_plan();
        for (room, entered_s) in plan.rooms.iter().zip(&mut entered_s) {
            if room.contains(place.x_m, place.y_m) {
                *entered_s = entered_s.min(time_s);
            }
        }
        result.frames.push(frame);
    }
    result.last_room_s = entered_s.into_iter().fold(0.0, f64::max);
    result
}

const ALL: [usize; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

fn assert_explores(sensors: &[usize], error: PoseError, seeds: std::ops::Range<u64>) {
    for (name, _) in plan_file::BUILT_IN {
        let plan = plan_file::load(name).unwrap();
        for seed in seeds.clone() {
            let drive = drive(&plan, sensors, seed, error, 10.0);
            let what = format!(
                "{name}, seed {seed}: last room at {:.0} s, standstill {:.0} s, path {:.0} m",
                drive.last_room_s, drive.standstill_s, drive.path_m
            );
            assert!(drive.last_room_s < 480.0, "{what}");
            assert!(drive.standstill_s < 45.0, "{what}");
            assert!(drive.path_m > 80.0, "{what}");
        }
    }
}

#[test]
fn every_room_is_visited_with_a_good_pose() {
    assert_explores(&ALL, PoseError { noise_m: 0.005, ..PoseError::default() }, 1..3);
}

#[test]
fn every_room_is_visited_while_the_frame_drifts() {
    assert_explores(&ALL, PoseError { noise_m: 0.005, drift_rad: 0.15, ..PoseError::default() }, 1..3);
}

#[test]
fn every_room_is_visited_with_a_pose_that_jumps() {
    assert_explores(&ALL, PoseError { noise_m: 0.01, jump_m: 0.1, ..PoseError::default() }, 1..2);
}

#[test]
fn four_sensors_are_enough_for_every_room() {
    assert_explores(&[0, 2, 4, 6], PoseError { noise_m: 0.005, ..PoseError::default() }, 1..2);
}

#[test]
fn sensors_as_noisy_as_real_ones_are_enough_for_every_room() {
    let plan = plan_file::load("flat").unwrap();
    let rig = hal_sim::measured_rig();
    let options = SimOptions { sharp: hal_sim::SharpOptions::measured(), ..SimOptions::default() };
    let simulation = Simulation::new(&plan, &rig, options, 1).unwrap();
    let mut robot = ClosedLoop::new(simulation, &rig, PilotConfig::default());
    let mut entered = vec![false; plan.rooms.len()];
    let mut truth = Pose::default();
    for _ in 0..25 * 600 {
        let frame = robot.step(&mut |sample| Estimate { pose: truth, ranges_m: nominal_ranges(&rig, sample) });
        truth = frame.truth.to_pose();
        let place = robot.simulation.pose_in_plan();
        for (room, entered) in plan.rooms.iter().zip(&mut entered) {
            *entered |= room.contains(place.x_m, place.y_m);
        }
    }
    assert!(entered.iter().all(|&entered| entered), "{entered:?}");
}

#[test]
fn walls_stay_in_sight() {
    // The estimator lives on walls: nearly always some sensor should see one.
    for (name, _) in plan_file::BUILT_IN {
        let plan = plan_file::load(name).unwrap();
        let drive = drive(&plan, &ALL, 1, PoseError { noise_m: 0.005, ..PoseError::default() }, 5.0);
        let rig = default_rig_with(&ALL);
        let seen = |frame: &&Frame| nominal_ranges(&rig, &frame.sample).iter().flatten().any(|&range_m| range_m < 1.2);
        let share = drive.frames.iter().filter(seen).count() as f64 / drive.frames.len() as f64;
        assert!(share > 0.9, "{name}: {share}");
        let soon = drive.frames[..50].iter().filter(seen).count();
        assert!(soon > 25, "{name}: a wall comes into range within the first two seconds, {soon}");
    }
}

#[test]
fn a_door_that_closes_and_people_do_not_trap_it() {
    let mut plan = plan_file::load("flat").unwrap();
    plan.doors.push(hal_sim::plan::Door {
        from_m: [2.2, 3.35],
        to_m: [3.1, 3.35],
        closes_at_s: 60.0,
        opens_at_s: 240.0,
    });
    let path_m = vec![[1.5, 2.5], [4.0, 2.0], [5.5, 1.5]];
    plan.people.push(hal_sim::plan::Person { radius_m: 0.15, speed_mps: 0.4, path_m, gives_way: false });
    let drive = drive(&plan, &ALL, 1, PoseError { noise_m: 0.005, ..PoseError::default() }, 10.0);
    assert!(drive.last_room_s < 580.0 && drive.standstill_s < 60.0, "{} {}", drive.last_room_s, drive.standstill_s);
}

#[test]
fn a_home_larger_than_the_pilot_s_picture_is_explored() {
    // Four rooms in a row, 18 m long; the picture measures 12 m.
    let mut text = String::from("[start]\nx_m = 1.0\ny_m = 1.0\n");
    text += "[[outline]]\npoints_m = [[0.0, 0.0], [18.0, 0.0], [18.0, 3.5], [0.0, 3.5]]\n";
    for (room, x_m) in [0.0, 4.5, 9.0, 13.5].into_iter().enumerate() {
        let far_m = x_m + 4.5;
        text += &format!("[[room]]\nname = \"{room}\"\nmin_m = [{x_m}, 0.0]\nmax_m = [{far_m}, 3.5]\n");
        if room > 0 {
            let wall_m = x_m + 0.1;
            text += &format!("[[box]]\nmin_m = [{x_m}, 0.0]\nmax_m = [{wall_m}, 1.3]\n");
            text += &format!("[[box]]\nmin_m = [{x_m}, 2.2]\nmax_m = [{wall_m}, 3.5]\n");
        }
    }
    let plan = plan_file::parse("row", "row", &text).unwrap();
    let drive = drive(&plan, &ALL, 1, PoseError { noise_m: 0.005, ..PoseError::default() }, 15.0);
    assert!(drive.last_room_s < 600.0 && drive.standstill_s < 60.0, "{} {}", drive.last_room_s, drive.standstill_s);
    // It comes back to rooms that it has forgotten.
    let late = &drive.frames[drive.frames.len() / 2..];
    let reach_m = |pick: fn(f64, f64) -> f64, from| late.iter().map(|f| f.truth.x_m).fold(from, pick);
    let (near_m, far_m) = (reach_m(f64::min, 99.0), reach_m(f64::max, -99.0));
    assert!(far_m - near_m > 9.0, "{near_m} to {far_m}");
}

#[test]
fn a_drive_repeats_bit_for_bit() {
    let plan = plan_file::load("flat").unwrap();
    let error = PoseError { noise_m: 0.005, ..PoseError::default() };
    let run = || drive(&plan, &ALL, 5, error, 2.0).frames;
    assert_eq!(run(), run());
}

#[test]
fn a_pose_that_is_no_number_stops_the_robot() {
    let plan = plan_file::load("room").unwrap();
    let rig = default_rig_with(&ALL);
    let simulation = Simulation::new(&plan, &rig, SimOptions::default(), 1).unwrap();
    let mut robot = ClosedLoop::new(simulation, &rig, PilotConfig::default());
    let pose = Pose { x_m: f32::NAN, y_m: 0.0, theta_rad: 0.0 };
    let frames = robot.record(2.0, &mut |sample| Estimate { pose, ranges_m: nominal_ranges(&rig, sample) });
    assert_eq!(frames.len(), 51);
    assert_eq!(frames[50].truth, frames[0].truth);
}
