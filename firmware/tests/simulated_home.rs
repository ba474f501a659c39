//! The robot's tasks, as they are, on this machine: peripherals of the simulated board, a clock that the test moves.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{Home, estimates};
use common::ranges::Ranges;
use hal_sim::Pose2;
use robot::rig::BuiltIn;
use wire::{Command, Frame};

/// A minute's frames: where the robot is, the room's walls, and every kind of frame beside.
fn assert_mapped(said: &[Frame], truth: Pose2) {
    let last = estimates(said).next_back().expect("estimates are told");
    let error_m = (f64::from(last.pose[0]) - truth.x_m).hypot(f64::from(last.pose[1]) - truth.y_m);
    assert!(error_m < 0.1, "estimate {:?}, truth {truth:?}", last.pose);
    assert!(last.walls >= 4, "{} walls", last.walls);
    assert!((1500..=1560).contains(&estimates(said).count()), "25 estimates a second");
    for kind in ["Sample", "Wall", "Calibration", "Faults"] {
        assert!(said.iter().any(|frame| format!("{frame:?}").starts_with(kind)), "no {kind} frame");
    }
}

#[test]
fn the_tasks_map_a_simulated_room() {
    let home = Home::new("room", BuiltIn::Sharp);
    home.run(BuiltIn::Sharp, Ranges(home.board.range_sensors()), |tasks| {
        tasks.drive(2.0);
        let still = home.truth();
        assert!(still.x_m.hypot(still.y_m) < 1e-6, "the robot waits to be told: {still:?}");
        assert!(!home.enabled.get() && home.fed.get() >= 3, "it can be pushed, watchdog fed: {}", home.fed.get());

        home.command(Command::Start);
        tasks.drive(60.0);
        assert!(home.enabled.get(), "motors enabled");
        assert_mapped(&home.heard(), home.truth());
        let faults = home.shared.faults.get();
        let lost = [faults.samples_dropped, faults.frames_dropped, faults.late_tasks, faults.dead_man_stops];
        assert_eq!(lost, [0; 4], "{faults:?}");

        home.command(Command::Stop);
        home.command(Command::ResetMap);
        tasks.drive(2.0);
        let said = home.heard();
        let last = estimates(&said).next_back().expect("estimates are told");
        assert!(last.pose[0].hypot(last.pose[1]) < 0.05, "where it stands is the new origin: {:?}", last.pose);

        home.say(&[7; 300]);
        home.say(&[0]);
        tasks.drive(0.5);
        assert_eq!(home.shared.faults.get().bytes_lost, 1, "noise on the line is counted");
    });
}
