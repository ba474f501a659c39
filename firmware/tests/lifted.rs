//! A robot that is lifted in its first drive finds itself in what it has mapped so far, though it was never told to stand, and goes on with
//! its floor.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{self, Home, place};
use common::ranges::Ranges;
use hal_sim::mishap::Kidnap;
use hal_sim::{SimOptions, plan_file};
use robot::FloorState;
use robot::rig::BuiltIn;
use wire::{Command, Floor, Frame, Place, PlaceState};

/// When it is lifted in each drive, and how long it is off the floor, seconds.
const LIFTED_S: [f64; 4] = [232.0, 236.0, 240.0, 244.0];
const CARRIED_S: f64 = 6.0;

/// Longest that it may take to find itself and to sweep the rest of the floor, tens of seconds.
const LONGEST: usize = 120;

/// What the robot said last of its floor and its place.
fn told(said: &[Frame]) -> (Floor, Place) {
    home::floor(said).zip(place(said)).expect("both are told once a second")
}

/// How much farther off it is than before the lift, from the moment on at which it has found itself after a lift at this time, metres, once in ten
/// seconds until its floor is done: its map lies in the home as it did before.
fn errors_m(lifted_s: f64) -> Vec<f64> {
    let mut plan = plan_file::load("l-shape").expect("a built-in plan");
    plan.mishaps.kidnaps.push(Kidnap { at_s: lifted_s, carried_s: CARRIED_S, to: None });
    let home = Home::of(&plan, BuiltIn::Sharp, SimOptions::default());
    let mut errors_m = Vec::new();
    home.run(BuiltIn::Sharp, Ranges(home.board.range_sensors()), |tasks| {
        home.command(Command::Clean { anew: true });
        tasks.drive(lifted_s - 1.0);
        let said = home.heard();
        let ((before, driving), [estimated, truth]) = (told(&said), [home::estimate(&said), home.truth()]);
        assert!(before.swept_m2 > 5.0, "{before:?}");

        tasks.drive(CARRIED_S - 1.0);
        let (_, lifted) = told(&home.heard());
        assert_eq!((lifted.state, lifted.lost), (PlaceState::Searching, driving.lost + 1));
        assert_eq!((lifted.saves, lifted.failed), (driving.saves + 1, 0), "all of its map is saved: {driving:?}");

        let mut found = None;
        for _ in 0..LONGEST {
            tasks.drive(10.0);
            let said = home.heard();
            let (floor, place) = told(&said);
            if place.state == PlaceState::Tracking {
                let expected = estimated.compose(&truth.relative(&home.truth()));
                let now = home::estimate(&said);
                errors_m.push((now.x_m - expected.x_m).hypot(now.y_m - expected.y_m));
            }
            if place.state == PlaceState::Tracking && found.is_none() {
                assert!(floor.swept_m2 > before.swept_m2, "the floor is what it was: {before:?} {floor:?}");
                found = Some(place);
            }
            if floor.state() == Some(FloorState::Done) {
                assert!(found.is_some() && floor.swept_m2 > 17.0, "{found:?} {floor:?}");
                return;
            }
        }
        panic!("not done: {found:?}");
    });
    errors_m
}

#[test]
fn a_first_drive_goes_on_after_a_lift() {
    let drives = LIFTED_S.map(errors_m);
    let at_once = drives.iter().filter(|errors_m| errors_m[0] < 0.1).count();
    assert!(at_once >= 3, "{drives:?}");
    for errors_m in &drives {
        let mean_m = errors_m.iter().take(6).sum::<f64>() / 6.0;
        assert!(mean_m < 0.1, "{mean_m} m off in the first minute: {errors_m:?}");
        assert!(errors_m.iter().all(|error_m| *error_m < 0.15), "{errors_m:?}");
    }
}
