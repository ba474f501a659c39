//! The map outlives the power: saved where the robot stands, and where it drives and has mapped twice what is kept; found again after a reset in
//! the middle of a drive, and the old one after a power cut in the middle of a save.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{self, Home, Tasks};
use common::ranges::Ranges;
use robot::rig::BuiltIn;
use wire::{Command, Frame, Place, PlaceState};

fn run(home: &Home, story: impl FnOnce(&mut Tasks<'_>)) {
    home.run(BuiltIn::Sharp, Ranges(home.board.range_sensors()), story);
}

/// Longest that the robot may take to find itself, tens of seconds. In a home of which the map has a third, one in seven has
/// not after 20 m of path (docs/results/relocation.md).
const LONGEST: usize = 40;

/// What the robot said last of its place.
fn place(said: &[Frame]) -> Place {
    home::place(said).expect("the place is told")
}

/// Drives until the robot knows where it is, and checks that it is there.
fn find(home: &Home, tasks: &mut Tasks<'_>) {
    tasks.drive(1.5);
    assert_eq!(place(&home.heard()).state, PlaceState::Searching);
    home.command(Command::Start);
    let mut told = None;
    for _ in 0..LONGEST {
        tasks.drive(10.0);
        let said = home.heard();
        if told.insert(place(&said)).state == PlaceState::Tracking {
            let error_m = home.error_m(&said);
            assert!(error_m < 0.1, "{error_m} m off");
            return;
        }
    }
    panic!("not found: {told:?}");
}

#[test]
fn the_map_outlives_resets_and_power_cuts() {
    let home = Home::new("l-shape", BuiltIn::Sharp);
    let mut kept = 0;
    run(&home, |tasks| {
        home.command(Command::Start);
        let mut off_ms = 0;
        for step in 1..=10_000 {
            tasks.drive(0.02);
            off_ms += if home.enabled.get() { 0 } else { 20 };
            assert!(step != 3000 || place(&home.heard()).saves > 0, "nothing is saved in the first minute");
        }
        let driving = place(&home.heard());
        assert_eq!((driving.state, driving.failed), (PlaceState::Tracking, 0));
        assert!((2..=5).contains(&driving.saves), "twice what is kept, each time: {driving:?}");
        assert!(
            (20..1000 * driving.saves).contains(&off_ms),
            "it stands for it, and not for long: {off_ms} ms, {driving:?}"
        );
        home.command(Command::Stop);
        tasks.drive(3.0);
        let stopped = place(&home.heard());
        kept = driving.saves + 1;
        assert_eq!((stopped.state, stopped.saves, stopped.sequence), (PlaceState::Tracking, kept, kept));
        tasks.drive(5.0);
        assert_eq!(place(&home.heard()).saves, stopped.saves, "and once only");
        home.command(Command::Start);
        tasks.drive(20.0);
        // The power fails in the middle of this drive.
    });

    let home = home.restarted();
    run(&home, |tasks| {
        find(&home, tasks);
    });

    // The next save is cut short: what was kept is still there.
    let home = home.restarted();
    home.flash.borrow_mut().words_left = 300;
    run(&home, |tasks| {
        find(&home, tasks);
        tasks.drive(20.0);
        home.command(Command::Stop);
        tasks.drive(3.0);
        let cut = place(&home.heard());
        assert_eq!((cut.saves, cut.failed, cut.sequence), (0, 1, kept));
    });
    let home = home.restarted();
    run(&home, |tasks| {
        find(&home, tasks);
        tasks.drive(20.0);
        home.command(Command::Stop);
        tasks.drive(3.0);
        let saved = place(&home.heard());
        assert_eq!((saved.saves, saved.failed, saved.sequence), (1, 0, kept + 1));
    });
}
