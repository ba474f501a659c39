//! The last pose outlives the power: after a reset in the middle of a drive the robot finds itself sooner than without it. A robot that was lifted
//! leaves none.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{self, Home, Tasks};
use common::ranges::Ranges;
use hal_sim::mishap::Kidnap;
use hal_sim::{SimOptions, plan_file};
use robot::POSE_RECORD_BYTES;
use robot::rig::BuiltIn;
use wire::{Command, Frame, Place, PlaceState};

/// When its power fails, seconds, one after the other: how soon a robot finds itself is a matter of where, too.
const FIRST_CUT_S: f64 = 143.0;
const BETWEEN_CUTS_S: f64 = 7.0;
const CUTS: u32 = 18;

/// Longest that the robot may take to find itself, seconds.
const LONGEST_S: u32 = 300;

fn run(home: &Home, story: impl FnOnce(&mut Tasks<'_>)) {
    home.run(BuiltIn::Sharp, Ranges(home.board.range_sensors()), story);
}

/// What the robot said last of its place.
fn place(said: &[Frame]) -> Place {
    home::place(said).expect("the place is told")
}

/// A robot whose power fails in the middle of its second drive, with a map that it saved before; somebody may carry it then.
fn cut_in_a_drive(cut_s: f64, carried: Option<Kidnap>) -> Home {
    let mut plan = plan_file::load("flat").expect("a built-in plan");
    plan.mishaps.kidnaps.extend(carried);
    let home = Home::of(&plan, BuiltIn::Sharp, SimOptions::default());
    run(&home, |tasks| {
        home.command(Command::Start);
        tasks.drive(cut_s - 23.0);
        home.command(Command::Stop);
        tasks.drive(3.0);
        home.command(Command::Start);
        tasks.drive(20.0);
        assert_eq!(place(&home.heard()).state, PlaceState::Tracking);
    });
    home.restarted()
}

/// The power of that robot fails once more before it has moved.
fn cut_before_it_moves(cut_s: f64) -> Home {
    let home = cut_in_a_drive(cut_s, None);
    assert!(!knows_nothing(&home), "it is written while it drives");
    let written = *home.pose_backup.borrow();
    run(&home, |tasks| tasks.drive(1.0));
    assert_eq!(*home.pose_backup.borrow(), written, "it stands where it stood");
    home
}

/// When the robot claims the place where it is, seconds after it is told to start.
fn find(home: &Home, tasks: &mut Tasks<'_>) -> u32 {
    tasks.drive(1.5);
    assert_eq!(place(&home.heard()).state, PlaceState::Searching);
    home.command(Command::Start);
    for seconds in 1..=LONGEST_S {
        tasks.drive(1.0);
        let said = home.heard();
        if place(&said).state != PlaceState::Searching {
            let error_m = home.error_m(&said);
            assert!(error_m < 0.3, "{error_m} m off");
            return seconds;
        }
    }
    panic!("not found");
}

#[test]
fn a_robot_that_was_reset_finds_itself_sooner_where_it_was() {
    let [mut aware, mut unaware] = [0; 2];
    for cut in 0..CUTS {
        let cut = cut_before_it_moves(FIRST_CUT_S + BETWEEN_CUTS_S * f64::from(cut));
        let home = cut.restarted();
        run(&home, |tasks| aware += find(&home, tasks));

        // The same without a cell at VBAT.
        let home = cut.restarted();
        home.pose_backup.borrow_mut().fill(0);
        run(&home, |tasks| {
            unaware += find(&home, tasks);
            tasks.drive(40.0);
            assert_eq!(place(&home.heard()).state, PlaceState::Tracking);
        });
    }
    assert!(aware < unaware, "{aware} {unaware}");

    // Lifted before it has moved, it does not know where it is set down.
    let home = cut_in_a_drive(FIRST_CUT_S, Some(Kidnap { at_s: FIRST_CUT_S + 1.0, carried_s: 5.0, to: None }));
    assert!(!knows_nothing(&home));
    run(&home, |tasks| tasks.drive(2.0));
    assert!(knows_nothing(&home));
}

/// Whether no record begins as one does.
fn knows_nothing(home: &Home) -> bool {
    home.pose_backup.borrow().chunks(POSE_RECORD_BYTES / 2).all(|record| record[..4] == [0; 4])
}
