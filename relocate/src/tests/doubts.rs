//! When a robot that knows its place gives it up.

use std::vec::Vec;

use slam_core::Elsewhere;

use super::Map;
use crate::locator::CLAIM;
use crate::{Event, Locator, State, Step};

/// How far the robot goes in a step: so far that readings count in each.
const STEP_M: f32 = 0.06;

/// Drives so many steps with readings that agree with the kept map, and that do not; what there was to do.
fn drive(locator: &mut Locator, steps: usize, readings: [u8; 2], log_odds: f32) -> Option<Event> {
    let map = Map { bend_m: 0.0, sigma_m: 0.0, is_common: true };
    let step = |number| Step {
        readings,
        elsewhere: Elsewhere { log_odds, since: None },
        ..Step::moved([STEP_M * number as f32, 0.0], STEP_M)
    };
    (0..steps).find_map(|number| locator.step(&map, Some(&map), &step(number), 0))
}

#[test]
fn much_that_hides_walls_is_doubt_and_no_reason_to_give_a_place_up() {
    let mut locator = Locator::new(State::Tracking);
    assert_eq!(drive(&mut locator, 100, [1, 3], 0.9 * CLAIM), None);
    assert_eq!(locator.state(), State::Doubtful);
    assert_eq!(drive(&mut locator, 100, [3, 1], 0.0), None);
    assert_eq!(locator.state(), State::Tracking);
    assert_eq!(drive(&mut locator, 100, [3, 1], 1.1 * CLAIM), None, "readings that mostly agree are not of elsewhere");
    assert_eq!(locator.times_lost(), 0);
    assert_eq!(drive(&mut locator, 100, [1, 3], 1.1 * CLAIM), Some(Event::Lost));
    assert_eq!((locator.state(), locator.times_lost()), (State::Searching, 1));
    locator.lost();
    assert_eq!(locator.times_lost(), 1, "it did not know before");
}

#[test]
fn a_claim_is_revoked_by_readings_alone() {
    let mut locator = Locator::new(State::Probation);
    assert_eq!(drive(&mut locator, 40, [1, 3], 0.0), Some(Event::Lost));
}

#[test]
fn a_searching_robot_that_comes_to_stand_in_a_dock_begins_its_fresh_map_there_once() {
    let map = Map { bend_m: 0.0, sigma_m: 0.0, is_common: true };
    let step = |is_docked| Step { is_docked, ..Step::moved([0.0; 2], 0.0) };
    let mut locator = Locator::new(State::Searching);
    let mut events = |docked: &[bool]| -> Vec<Option<Event>> {
        docked.iter().map(|is_docked| locator.step(&map, Some(&map), &step(*is_docked), 0)).collect()
    };
    assert_eq!(events(&[false, true, true, false, true]), [None, Some(Event::Docked), None, None, None]);
    locator.lost();
    assert_eq!(locator.step(&map, Some(&map), &step(true), 0), Some(Event::Docked), "it was carried meanwhile");
    let mut knows = Locator::new(State::Tracking);
    assert_eq!(knows.step(&map, Some(&map), &step(true), 0), None);
}

#[test]
fn a_robot_with_a_hundred_kilometres_behind_it_still_counts_its_path() {
    let map = Map { bend_m: 0.0, sigma_m: 0.0, is_common: true };
    let step = |readings, by_m| Step { readings, ..Step::moved([0.0; 2], by_m) };
    let mut locator = Locator::new(State::Tracking);
    locator.step(&map, Some(&map), &step([3, 1], 1e5), 0);
    for _ in 0..6000 {
        locator.step(&map, Some(&map), &step([1, 3], 0.001), 0);
    }
    assert_eq!(locator.state(), State::Doubtful, "after six metres of readings that do not agree");
}
