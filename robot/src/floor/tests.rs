//! The floor job by itself, without a home around it.

mod rooms;
mod world;

use super::swept::CELLS;
use super::*;
use crate::condition::Condition;
use crate::contact::Contacts;
use crate::pilot::memory::Cell;
use crate::wild::Wild;
use slam_core::angle::wrap;
extern crate std;
use std::vec::Vec;

#[test]
fn the_job_of_the_robot_fits_in_12_kib() {
    assert!(size_of::<FloorJob<8>>() <= 12_288, "{}", size_of::<FloorJob<8>>());
}

#[test]
fn floor_swept_before_the_grid_was_known_counts_once() {
    let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    let sweep = |job: &mut FloorJob<8>, steps: core::ops::Range<u16>| {
        for step in steps {
            let pose = Pose::new(0.02 * f32::from(step), 0.0, 0.0);
            let (contacts, condition) = (Contacts::default(), Condition::default());
            job.step(&Senses { time_us: 40_000 * u64::from(step), pose, ranges_m: [None; 8], contacts, condition });
        }
    };
    sweep(&mut job, 0..100);
    job.align(0.3);
    assert_eq!((job.progress().swept_m2, job.trail.last_m()), (0.0, None));
    sweep(&mut job, 0..100);
    let cells = (0..CELLS as i16).flat_map(|row| (0..CELLS as i16).map(move |col| Cell { col, row }));
    let swept: u32 = cells.map(|cell| 4 - job.sheet.swept.left_in(cell)).sum();
    assert_eq!(job.tally.swept(), swept);
    assert!(swept > 0);
}

/// Counts the floor that is left.
fn count(job: &mut FloorJob<8>) {
    (0..400).for_each(|step| job.tally.step(&job.sheet, FloorState::Planning, step));
}

/// A robot in a swept room of 15 by 15 cells that has a door of one cell, beyond which some floor was seen and, where it ends, there are walls or
/// nothing was seen: where it plans to go.
fn plan_in_a_room(ends_at_walls: bool) -> Option<Target> {
    let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    let middle = job.sheet.picture.cell_at(0.0, 0.0);
    for (cols, rows) in (-8..=12).flat_map(|cols| (-8_i16..=8).map(move |rows| (cols, rows))) {
        let cell = middle.offset(cols, rows);
        let is_wall = cols.min(rows) == -8 || rows == 8 || (cols == 8 && rows != 0);
        if is_wall || (ends_at_walls && cols > 8 && (cols == 12 || rows.abs() == 2)) {
            job.sheet.picture.block(cell);
        } else if cols <= 8 || (cols < 12 && rows.abs() < 2) {
            job.sheet.picture.see_free(cell);
            job.sheet.swept.set(cell, cols <= 8);
        }
    }
    job.tally.take_up(900, [0; FloorState::ALL.len()]);
    count(&mut job);
    assert!(!job.tally.is_room_left() && job.progress().share() > 0.96, "{:?}", job.progress());
    job.plan(Aim::Floor, 0);
    for step in 0..1000 {
        match job.phase {
            Phase::Plan { aim, escape, begun } => job.search(aim, escape, begun, &Pose::ORIGIN, step),
            Phase::Trace { target, .. } => return Some(target),
            _ => break,
        };
    }
    None
}

/// Of a way of more than 96 cells only the first part is remembered: at its end the robot is not where it was to come.
#[test]
fn at_the_end_of_the_part_that_it_remembers_it_looks_for_the_rest_of_its_way() {
    let at_the_end = |cols: i16| {
        let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
        let place = job.sheet.picture.cell_at(0.0, 0.0).offset(cols, 0);
        let (target, aim) = (Target::Place(place), job.aim_home());
        job.phase = Phase::Transit { target, aim };
        job.transit(target, aim, &Pose::ORIGIN, 0);
        job.phase
    };
    assert!(matches!(at_the_end(30), Phase::Plan { aim: Aim::Place(_), .. }), "{:?}", at_the_end(30));
    assert_eq!(at_the_end(1), Phase::Home);
}

#[test]
fn a_door_that_looks_too_narrow_is_gone_through_where_nobody_knows_what_is_beyond() {
    let Some(Target::Open(cell)) = plan_in_a_room(false) else { panic!("the room beyond is left out") };
    let job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    assert!(cell.col > job.sheet.picture.cell_at(0.0, 0.0).col + 8, "{cell:?}");
    assert!(matches!(plan_in_a_room(true), None | Some(Target::Place(_))), "a niche is not worth it");
}

/// A robot that stands at home with a room of 60 cells left behind a wall: the job, about to go home for good.
fn home_before_a_room_shut_off() -> FloorJob<8> {
    let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    let middle = job.sheet.picture.cell_at(0.0, 0.0);
    for (cols, rows) in (-8..=18).flat_map(|cols| (-8_i16..=8).map(move |rows| (cols, rows))) {
        let cell = middle.offset(cols, rows);
        if [-8, 8, 18].contains(&cols) || rows.abs() == 8 {
            job.sheet.picture.block(cell);
        } else {
            job.sheet.picture.see_free(cell);
            job.sheet.swept.set(cell, cols < 8);
        }
    }
    (job.home, job.errand) = (Some(Pose::ORIGIN), Errand::Finish(errand::Way::Open));
    job.tally.take_up(900, [0; FloorState::ALL.len()]);
    count(&mut job);
    job
}

/// So many seconds of a job whose robot stands: what it is doing then.
fn stand(job: &mut FloorJob<8>, seconds: core::ops::Range<u64>) -> FloorState {
    for step in seconds.start * 25..seconds.end * 25 {
        let (contacts, condition) = (Contacts::default(), Condition::default());
        let (time_us, pose) = (40_000 * step, Pose::ORIGIN);
        job.step(&Senses { time_us, pose, ranges_m: [None; 8], contacts, condition });
    }
    job.state()
}

#[test]
fn with_a_room_left_behind_a_door_it_waits_at_home_and_looks_once_more() {
    let mut job = home_before_a_room_shut_off();
    assert_eq!(stand(&mut job, 0..60), FloorState::Waiting);
    assert_eq!(stand(&mut job, 60..590), FloorState::Waiting);
    let end_s = (590..640).find(|second| stand(&mut job, *second..second + 1) != FloorState::Waiting).unwrap();
    assert_eq!(job.errand, Errand::Sweep { then: errand::Way::Waited });
    // Once: home again it is over.
    job.errand = Errand::Finish(errand::Way::Waited);
    job.go_about(1_000_000 * end_s);
    assert_eq!(stand(&mut job, end_s + 1..700), FloorState::Done);
}

#[test]
fn one_that_waits_goes_on_at_once_when_it_is_told_to() {
    let is_told: [fn(&mut FloorJob<8>); 2] = [FloorJob::resume, |job| {
        job.pause();
        job.resume();
    }];
    for tell in is_told {
        let mut job = home_before_a_room_shut_off();
        stand(&mut job, 0..60);
        tell(&mut job);
        stand(&mut job, 60..61);
        assert!(job.errand.is_to_sweep(), "{:?}", job.errand);
    }
}

#[test]
fn where_nothing_leads_on_it_goes_back_the_way_that_it_came() {
    let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    let (mut pose, mut jitter) = (Pose::default(), Wild::new());
    for step in 0..3000_u64 {
        let retreats = matches!(job.phase, Phase::Retreat { .. });
        let seen = Pose { x_m: pose.x_m + 0.004 * jitter.share(), ..pose };
        let (contacts, condition) = (Contacts::default(), Condition::default());
        let speeds = job.step(&Senses { time_us: 40_000 * step, pose: seen, ranges_m: [None; 8], contacts, condition });
        // A metre and a half along a corridor to where it is barred but for the way back.
        let forward_m = 0.02 * (speeds.left_mps + speeds.right_mps);
        if step < 100 {
            pose.x_m += 0.015;
        } else if retreats {
            pose.x_m += forward_m;
        }
    }
    assert!(pose.x_m < 0.9, "{pose:?}");
}

/// A robot on a floor with nothing on it but its dock, which its sensors do not see: where it is, in the dock's frame, and where it
/// believes that it is, off by so much, metres.
struct Docked {
    job: FloorJob<8>,
    at: Pose,
    off_m: [f32; 2],
    /// How far its wheels turned in vain, metres.
    in_vain_m: f32,
}

impl Docked {
    fn new() -> Self {
        let job = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
        Self { job, at: Pose::default(), off_m: [0.0; 2], in_vain_m: 0.0 }
    }

    /// Drives from one time to another, seconds, with this voltage of the battery; whether it is in the dock then.
    fn drive(&mut self, seconds: core::ops::Range<u64>, battery_v: f32) -> bool {
        let mut is_charging = true;
        for step in seconds.start * 25..seconds.end * 25 {
            is_charging = self.at.x_m > -0.005 && self.at.y_m.abs() < 0.03 && self.at.theta_rad.abs() < 0.17;
            let condition = Condition { is_charging, battery_v: Some(battery_v), ..Condition::default() };
            let bump = self.at.x_m > -0.002 && !is_charging;
            let contacts = Contacts { bump_left: bump, bump_right: bump, ..Contacts::default() };
            let [x_m, y_m] = [self.at.x_m + self.off_m[0], self.at.y_m + self.off_m[1]];
            let pose = Pose { x_m, y_m, ..self.at };
            let speeds =
                self.job.step(&Senses { time_us: 40_000 * step, pose, ranges_m: [None; 8], contacts, condition });
            let forward_m = 0.02 * (speeds.left_mps + speeds.right_mps);
            let turn_rad = 0.04 * (speeds.right_mps - speeds.left_mps) / self.job.config.drive.track_m;
            let [x_m, y_m] = self.at.transform([forward_m, 0.0]);
            self.in_vain_m += x_m.max(0.0);
            self.at = Pose { x_m: x_m.min(0.0), y_m, theta_rad: wrap(self.at.theta_rad + turn_rad) };
        }
        is_charging
    }
}

#[test]
fn a_robot_that_comes_back_into_its_dock_backs_off() {
    let mut robot = Docked::new();
    robot.drive(0..60, 12.0);
    assert!(robot.in_vain_m < 0.05, "{} m", robot.in_vain_m);
}

/// One that does not know where it is presses on no more than one that does.
#[test]
fn a_lost_robot_whose_wheels_stall_backs_off() {
    let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    let (mut step, mut pose) = (0, Pose::ORIGIN);
    let mut drive = |is_stalled: bool| {
        step += 1;
        let condition = Condition { is_lost: true, is_stalled, ..Condition::default() };
        let contacts = Contacts::default();
        let speeds = job.step(&Senses { time_us: 40_000 * step, pose, ranges_m: [None; 8], contacts, condition });
        let WheelSpeeds { left_mps, right_mps } = speeds;
        pose = pose.compose(&Pose::new(0.02 * (left_mps + right_mps), 0.0, 0.04 * (right_mps - left_mps) / 0.235));
        speeds
    };
    assert!(drive(false).is_forward());
    assert!((0..10).all(|_| drive(true).left_mps < 0.0));
    // It goes on another way.
    assert!((0..50).map(|_| drive(false)).any(|speeds| speeds.left_mps < 0.0 && speeds.right_mps > 0.0));
    assert!((0..200).any(|_| drive(false).is_forward()));
}

#[test]
fn a_lost_robot_that_is_put_into_its_dock_charges_and_backs_out() {
    let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
    let mut step = 0;
    let mut drive = |seconds: u64, is_lost: bool, is_charging: bool, battery_v: f32| {
        let mut speeds = WheelSpeeds::STOP;
        for _ in 0..25 * seconds {
            step += 1;
            let condition = Condition { is_lost, is_charging, battery_v: Some(battery_v), ..Condition::default() };
            let (pose, contacts) = (Pose::new(1.0, 0.0, 0.0), Contacts::default());
            speeds = job.step(&Senses { time_us: 40_000 * step, pose, ranges_m: [None; 8], contacts, condition });
        }
        speeds
    };
    drive(2, false, false, 11.0);
    drive(10, true, false, 11.0);
    assert_eq!(drive(600, true, true, 11.0), WheelSpeeds::STOP);
    assert!(drive(20, true, true, 12.5).left_mps < 0.0, "charged");
    // The same after hours, where the gauge never shows that.
    drive(10, false, false, 12.1);
    assert_eq!(drive(3 * 3600, true, true, 12.1), WheelSpeeds::STOP);
    drive(3600, true, true, 12.1);
    assert!(drive(1, true, true, 12.1).left_mps < 0.0 && drive(1, true, true, 12.1).left_mps < 0.0);
}

/// A gauge that reads too little never shows a full battery.
#[test]
fn charging_ends() {
    let mut robot = Docked::new();
    robot.drive(0..60, 12.0);
    assert!(robot.drive(60..330, 10.4));
    assert_eq!(robot.job.state(), FloorState::Charging);
    assert!(robot.drive(330..4 * 3600, 12.1) && robot.job.state() == FloorState::Charging);
    robot.drive(4 * 3600..4 * 3600 + 600, 12.1);
    assert_ne!(robot.job.state(), FloorState::Charging);
}

#[test]
fn one_that_is_paused_stands_in_a_dock_that_it_is_put_into() {
    let mut robot = Docked::new();
    robot.job.pause();
    assert!(robot.drive(0..200, 12.0));
    assert_eq!((robot.job.state(), robot.at), (FloorState::Paused, Pose::default()));
}

#[test]
fn a_dock_is_found_where_its_place_in_the_map_is_off() {
    for off_m in [[0.0, 0.0], [0.03, 0.02], [0.0, -0.07], [-0.08, 0.12], [0.1, -0.15], [0.12, 0.2]] {
        let mut robot = Docked::new();
        robot.drive(0..60, 12.0);
        robot.off_m = off_m;
        // Four and a half minutes: what the voltage at which it goes home leaves of a battery for twenty.
        assert!(robot.drive(60..330, 10.4), "off by {off_m:?} m: {:?} at {:?}", robot.job.state(), robot.at);
    }
}

/// A job whose robot goes where it is told, in a home that it does not see.
struct Adrift {
    job: FloorJob<8>,
    at: Pose,
    step: u64,
}

impl Adrift {
    fn new() -> Self {
        let job = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
        Self { job, at: Pose::ORIGIN, step: 0 }
    }

    /// Drives for so many seconds; what the job is doing then, and the path meanwhile, metres.
    fn drive(&mut self, seconds: u64, contacts: Contacts, ranges_m: [Option<f32>; 8]) -> (FloorState, f32) {
        let mut path_m = 0.0;
        for _ in 0..25 * seconds {
            self.step += 1;
            let (pose, condition) = (self.at, Condition::default());
            let speeds = self.job.step(&Senses { time_us: 40_000 * self.step, pose, ranges_m, contacts, condition });
            let WheelSpeeds { left_mps, right_mps } = contacts.guard(speeds);
            let [forward_m, turn_rad] = [0.02 * (left_mps + right_mps), 0.04 * (right_mps - left_mps) / 0.235];
            self.at = self.at.compose(&Pose::new(forward_m, 0.0, turn_rad));
            path_m += forward_m.abs();
        }
        (self.job.state(), path_m)
    }
}

#[test]
fn a_bumper_that_is_jammed_stops_it_until_it_is_freed() {
    let mut robot = Adrift::new();
    let mut drive = |seconds: u64, contacts: Contacts| robot.drive(seconds, contacts, [Some(1.0); 8]);
    let jammed = Contacts { bump_left: true, ..Contacts::default() };
    let begun = drive(2, Contacts::default());
    assert!(begun.1 > 0.3, "{begun:?}");
    let tried = drive(8, jammed);
    assert!(tried.0 != FloorState::Touched && tried.1 > 0.2, "{tried:?}");
    assert_eq!(drive(6, jammed).0, FloorState::Touched);
    assert_eq!(drive(600, jammed), (FloorState::Touched, 0.0));
    // Another half that is pressed, and let go, changes nothing.
    let both = Contacts { bump_right: true, ..jammed };
    assert_eq!(drive(2, both), (FloorState::Touched, 0.0));
    assert_eq!(drive(2, jammed), (FloorState::Touched, 0.0));
    let freed = drive(6, Contacts::default());
    assert!(freed.0 != FloorState::Touched && freed.1 > 0.3, "{freed:?}");
}

#[test]
fn a_robot_that_sees_nothing_any_more_stands_until_it_does() {
    let mut robot = Adrift::new();
    robot.drive(2, Contacts::default(), [Some(1.0); 8]);
    let (mut state, mut path_m) = (FloorState::Edge, 0.0);
    let mut swept = 0;
    while state != FloorState::Blind && path_m < 30.0 {
        swept = robot.job.tally.swept();
        let (now, driven_m) = robot.drive(1, Contacts::default(), [None; 8]);
        (state, path_m) = (now, path_m + driven_m);
    }
    assert!(state == FloorState::Blind && path_m > 12.0, "{state:?} after {path_m} m");
    assert!(robot.job.tally.swept() + 50 < swept, "what it swept of late is not sure to be swept");
    let mut drive = |seconds: u64, ranges_m: [Option<f32>; 8]| robot.drive(seconds, Contacts::default(), ranges_m);
    let mut spike = [None; 8];
    spike[3] = Some(0.5);
    assert_eq!(drive(100, spike), (FloorState::Blind, 0.0));
    let (state, path_m) = drive(5, [Some(0.8); 8]);
    assert!(state != FloorState::Blind && path_m > 0.3, "{state:?} after {path_m} m");
    // Where it stands nothing may be in reach: it goes and sees.
    let path_m: f32 = (0..10).map(|_| drive(360, [None; 8]).1).sum();
    assert!((30.0..120.0).contains(&path_m), "{path_m} m in an hour");
}

#[test]
fn whatever_it_is_told_the_speeds_are_finite_and_limited() {
    let config = FloorConfig::default();
    let mut job: FloorJob<8> = FloorJob::new(config, &crate::rig::default_rig());
    let mut wild = Wild::new();
    let limit_mps = config.drive.speed_mps + 0.5 * config.drive.track_m * config.drive.turn_radps + 1e-6;
    for step in 0..20_000 {
        let (pose, ranges_m, battery_v) = (wild.pose(), wild.ranges(), Some(wild.value()));
        let [is_charging, is_stalled, is_lost] = [(); 3].map(|()| wild.once_in(60));
        let condition = Condition { battery_v, is_charging, is_stalled, is_lost };
        let contacts = wild.contacts();
        if step == 5000 {
            job.align(f32::NAN);
            job.align(0.3);
        }
        let time_us = if step % 100 == 0 { u64::MAX } else { u64::from(wild.bits()) };
        let speeds = job.step(&Senses { time_us, pose, ranges_m, contacts, condition });
        for speed_mps in [speeds.left_mps, speeds.right_mps] {
            assert!(speed_mps.abs() <= limit_mps, "{step}: {speeds:?}");
        }
    }
}
