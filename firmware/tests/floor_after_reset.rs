//! The floor job outlives the power: what was swept is known after it, in the kept map, and nothing is once the floor is done.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{self, Home, Tasks};
use common::ranges::Ranges;
use hal_sim::{SimOptions, plan_file};
use robot::FloorState;
use robot::rig::BuiltIn;
use wire::{Command, Floor};

/// Longest that the rest of the floor may take, tens of seconds.
const LONGEST: usize = 120;

fn run(home: &Home, story: impl FnOnce(&mut Tasks<'_>)) {
    home.run(BuiltIn::Sharp, Ranges(home.board.range_sensors()), story);
}

/// What the robot said last of the floor, after this time (seconds).
fn floor(home: &Home, tasks: &mut Tasks<'_>, seconds: f64) -> Floor {
    tasks.drive(seconds);
    home::floor(&home.heard()).expect("the floor is told")
}

/// It is told to clean after a reset: what it says of the floor then.
fn after_reset(home: &Home, tasks: &mut Tasks<'_>) -> Floor {
    tasks.drive(1.5);
    home.command(Command::Clean { anew: false });
    floor(home, tasks, 3.0)
}

#[test]
fn what_was_swept_is_known_after_a_reset() {
    let plan = plan_file::load("l-shape").expect("a built-in plan");
    let home = Home::of(&plan, BuiltIn::Sharp, SimOptions::default());
    let mut before = Floor::default();
    run(&home, |tasks| {
        home.command(Command::Clean { anew: true });
        before = floor(&home, tasks, 240.0);
        // The power fails in the middle of the job. Nobody told it to stand, where it saves its map, but it did on its own.
    });
    assert!(before.swept_m2 > 5.0, "{before:?}");

    let home = home.restarted();
    run(&home, |tasks| {
        let after = after_reset(&home, tasks);
        assert_eq!(after.state(), Some(FloorState::Lost), "it looks for itself");
        let lost_m2 = before.swept_m2 - after.swept_m2;
        assert!((-0.1..1.0).contains(&lost_m2), "but for the last seconds' it knows the floor: {before:?} {after:?}");
        let mut last = after;
        for _ in 0..LONGEST {
            last = floor(&home, tasks, 10.0);
            if last.state() == Some(FloorState::Done) {
                break;
            }
        }
        assert_eq!(last.state(), Some(FloorState::Done), "{last:?}");
        assert!(last.swept_m2 > 17.0, "{last:?}");
    });

    // Done is done: the next time it begins anew.
    let home = home.restarted();
    run(&home, |tasks| {
        let anew = after_reset(&home, tasks);
        assert!(anew.swept_m2 < 1.0, "{anew:?}");
    });
}
