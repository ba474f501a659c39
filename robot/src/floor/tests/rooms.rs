//! The floor job in a room that it has seen, on a robot that goes where it is told.

use super::errand::Way;
use super::*;

const RECHARGE: Errand = Errand::Recharge { then: Way::Waited };

/// The robot, and all that it senses.
struct InRoom {
    job: FloorJob<8>,
    at: Pose,
    condition: Condition,
    bounds: Bounds,
    time_us: u64,
}

impl InRoom {
    /// In the middle of a square room with walls so many cells from there, whose columns before this one are swept. It is home.
    fn new(half: i16, swept_before: i16) -> Self {
        let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
        let middle = job.sheet.picture.cell_at(0.0, 0.0);
        for (cols, rows) in (-half..=half).flat_map(|cols| (-half..=half).map(move |rows| (cols, rows))) {
            let cell = middle.offset(cols, rows);
            if cols.abs() == half || rows.abs() == half {
                job.sheet.picture.block(cell);
            } else {
                (0..3).for_each(|_| job.sheet.picture.see_free(cell));
                job.sheet.swept.set(cell, cols < swept_before);
            }
        }
        job.home = Some(Pose::ORIGIN);
        job.tally.take_up(16_000, [0; FloorState::ALL.len()]);
        job.go_about(0);
        let (condition, bounds) = (Condition::default(), Bounds::NONE);
        Self { job, at: Pose::ORIGIN, condition, bounds, time_us: 0 }
    }

    /// Drives for so many seconds; the path, metres.
    fn drive(&mut self, seconds: u64) -> f32 {
        (0..25 * seconds).map(|_| self.step()).sum()
    }

    /// The same for a robot that comes on by nothing.
    fn stand(&mut self, seconds: u64) {
        let at = self.at;
        (0..25 * seconds).for_each(|_| {
            self.step();
            self.at = at;
        });
    }

    /// A pause of half a minute.
    fn pause(&mut self) {
        self.job.pause();
        self.drive(30);
        self.job.resume();
    }

    fn step(&mut self) -> f32 {
        self.time_us += 40_000;
        let (time_us, pose, condition) = (self.time_us, self.at, self.condition);
        let senses = Senses { time_us, pose, ranges_m: [None; 8], contacts: Contacts::default(), condition };
        let WheelSpeeds { left_mps, right_mps } = self.job.step_within(&senses, &self.bounds);
        let [forward_m, turn_rad] = [0.02 * (left_mps + right_mps), 0.04 * (right_mps - left_mps) / 0.235];
        self.at = self.at.compose(&Pose::new(forward_m, 0.0, turn_rad));
        forward_m.abs()
    }
}

/// All of a room of more than 100 m^2 is searched in nine seconds.
#[test]
fn a_search_through_a_large_room_ends() {
    let mut robot = InRoom::new(38, 38);
    let path_m = robot.drive(120);
    assert_eq!(robot.job.state(), FloorState::Done, "after {path_m} m");
}

#[test]
fn a_pause_leaves_the_job_what_it_was() {
    let mut robot = InRoom::new(20, 0);
    for _ in 0..2 {
        robot.pause();
        robot.stand(2);
    }
    assert!(robot.job.given_up.is_empty());
    // It has hardly any charge left, and does not sweep on the way home.
    robot.job.home = Some(Pose::new(-2.5, 0.0, 0.0));
    robot.job.errand = RECHARGE;
    robot.pause();
    robot.drive(3);
    assert_eq!(robot.job.state(), FloorState::Return);
}

#[test]
fn one_that_is_to_go_home_and_gets_nowhere_along_a_wall_looks_for_its_home() {
    let mut robot = InRoom::new(20, 0);
    robot.job.home = Some(Pose::new(-2.5, 0.0, 0.0));
    robot.job.errand = RECHARGE;
    robot.job.begin_edge(1.0, 0);
    robot.job.credit_m = 100.0;
    robot.stand(7);
    robot.drive(3);
    assert_eq!(robot.job.state(), FloorState::Return);
}

/// It may have stood for a minute before it was told to clean.
#[test]
fn a_job_has_patience_from_its_first_step_on() {
    let mut robot = Adrift::new();
    robot.step = 1500;
    assert_eq!(robot.drive(1, Contacts::default(), [Some(1.0); 8]).0, FloorState::Edge);
}

/// The voltage rises when the motors are off.
#[test]
fn one_whose_battery_was_empty_goes_on_saying_so() {
    let mut robot = InRoom::new(20, 0);
    for battery_v in [11.0, 9.9, 10.2] {
        robot.condition.battery_v = Some(battery_v);
        robot.drive(10);
    }
    assert_eq!(robot.job.state(), FloorState::Flat);
}

#[test]
fn one_that_dared_to_go_home_sweeps_what_it_saw_when_it_has_charged() {
    let mut robot = InRoom::new(20, 0);
    (robot.job.errand, robot.job.has_dock, robot.job.areas.dares) = (RECHARGE, true, true);
    robot.condition.is_charging = true;
    robot.drive(1);
    assert_eq!((robot.job.errand, robot.job.areas.dares), (Errand::Sweep { then: Way::Waited }, false));
}

/// A robot in the middle of its room that is at this stage of docking and whose wheels stall: what it is doing after so many seconds.
fn stall(stage: Stage, seconds: u64) -> FloorState {
    let mut robot = InRoom::new(20, 0);
    (robot.job.errand, robot.job.has_dock) = (RECHARGE, true);
    robot.job.home = Some(Pose::new(0.5, 0.0, 0.5));
    robot.job.begin(Phase::Dock { stage, tries: 0 }, 0);
    robot.condition.is_stalled = true;
    robot.stand(seconds);
    robot.job.state()
}

#[test]
fn one_whose_wheels_stall_on_its_way_into_the_dock_backs_out() {
    assert_eq!(stall(Stage::Approaching, 1), FloorState::Pressing);
    assert_eq!(stall(Stage::Approaching, 3), FloorState::Staging);
}

#[test]
fn one_that_cannot_turn_towards_its_dock_gives_up_that_try() {
    assert_eq!(stall(Stage::Aligning, 15), FloorState::Aligning);
    assert_ne!(stall(Stage::Aligning, 21), FloorState::Aligning);
}

/// An area to stay out of that begins so far from the start, metres.
fn keep_out(x_m: f32) -> Bounds {
    let mut bounds = Bounds::NONE;
    bounds.add(AreaKind::KeepOut, &[[x_m, -1.0], [x_m + 1.6, -1.0], [x_m + 1.6, 1.0], [x_m, 1.0]]).unwrap();
    bounds
}

#[test]
fn what_lies_where_it_must_not_go_is_no_floor_that_is_left() {
    let mut robot = InRoom::new(20, 8);
    let cells = (8..20_i16).flat_map(|col| (-20..20_i16).map(move |row| (col, row)));
    for (col, row) in cells.filter(|(col, row)| *col > 15 || !(-6..7).contains(row)) {
        let middle = robot.job.sheet.picture.cell_at(0.0, 0.0);
        robot.job.sheet.swept.set(middle.offset(col, row), true);
    }
    robot.bounds = keep_out(1.2);
    robot.pause();
    // Before the way home is looked for once more.
    robot.job.sheet.picture.forget_visits();
    robot.drive(60);
    assert!(
        robot.job.state() == FloorState::Done && robot.job.path_m < 0.1,
        "{:?} at {:?}",
        robot.job.state(),
        robot.at
    );
}

#[test]
fn where_the_map_moves_an_area_to_stay_out_of_the_floor_beside_it_is_open_again() {
    let mut robot = InRoom::new(20, 0);
    let middle = robot.job.sheet.picture.cell_at(0.0, 0.0);
    let row = |job: &FloorJob<8>| [8, 12, 18].map(|col| job.sheet.picture.is_obstacle(middle.offset(col, 0)));
    for (x_m, blocked) in [(1.2, [true, true, false]), (1.6, [false, true, true]), (1.2, [true, true, false])] {
        robot.bounds = keep_out(x_m);
        robot.pause();
        assert_eq!(row(&robot.job), blocked, "from {x_m} m on");
        assert_eq!(robot.job.sheet.swept.left_in(middle.offset(8, 0)), if blocked[0] { 0 } else { 4 });
    }
}

#[test]
fn one_that_has_charged_tries_its_ways_anew() {
    let mut robot = InRoom::new(20, 0);
    (robot.job.errand, robot.job.retries, robot.job.squeezes, robot.job.pockets) = (RECHARGE, 2, 12, 12);
    robot.job.begin(Phase::Charge, 0);
    robot.condition.is_charging = true;
    robot.drive(1);
    assert_eq!([robot.job.retries, robot.job.squeezes, robot.job.pockets], [0; 3]);
    assert_eq!(robot.job.errand, Errand::Sweep { then: Way::Waited }, "it does not wait twice");
}

#[test]
fn steps_that_are_lost_on_the_way_are_no_jump_of_the_pose() {
    let mut room = InRoom::new(20, -20);
    room.drive(20);
    let before = room.job.progress().swept_m2;
    // Half a second of every four, in which it drives on.
    for _ in 0..10 {
        room.drive(3);
        let drives = room.job.step_within(
            &Senses {
                time_us: room.time_us,
                pose: room.at,
                ranges_m: [None; 8],
                contacts: Contacts::default(),
                condition: room.condition,
            },
            &room.bounds,
        );
        room.time_us += 500_000;
        let [ahead_m, turn_rad] =
            [0.25 * (drives.left_mps + drives.right_mps), 0.5 * (drives.right_mps - drives.left_mps) / 0.235];
        room.at = room.at.compose(&Pose::new(ahead_m, 0.0, turn_rad));
        let swept = room.job.progress().swept_m2;
        room.step();
        assert!(room.job.progress().swept_m2 >= swept, "the last metres count as swept");
    }
    assert!(room.job.progress().swept_m2 > before + 1.0);
}
