//! A kept map that the estimator has no room for is none: the robot does not look for itself in what it cannot take up.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::Home;
use common::ranges::Ranges;
use embedded_storage::nor_flash::NorFlash;
use kept_map::{Writer, rig_hash};
use robot::rig::BuiltIn;
use slam_core::RobotSlam;
use slam_core::kept::{Kept, KeptFrame, KeptWall};
use wire::{Frame, PlaceState};

/// States that [`RobotSlam`] has room for.
const ROOM: u16 = 80;

/// An empty map with a grid and so many states.
struct Padded {
    slam: Box<RobotSlam>,
    states: u16,
}

impl Kept for Padded {
    fn frame(&self) -> KeptFrame {
        KeptFrame { states: self.states, has_grid: true, ..self.slam.frame() }
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        self.slam.wall(index)
    }

    fn mean(&self, i: usize) -> f32 {
        self.slam.mean(i)
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        self.slam.covariance(i, j)
    }
}

/// What a robot says that begins with a map of so many states in its flash.
fn state_with(states: u16) -> PlaceState {
    let rig = BuiltIn::Sharp.rig();
    let slam = Box::new(RobotSlam::new(rig.clone()).unwrap());
    let home = Home::new("room", BuiltIn::Sharp);
    let mut record = Vec::new();
    Writer::new(&Padded { slam, states }, 1, rig_hash(&rig)).bytes(|piece| record.extend_from_slice(piece));
    for (offset, word) in (0..).step_by(4).zip(record.chunks(4)) {
        home.flash.borrow_mut().write(offset, word).unwrap();
    }
    let mut state = None;
    home.run(BuiltIn::Sharp, Ranges(home.board.range_sensors()), |tasks| {
        tasks.drive(1.5);
        let said = home.heard();
        let place =
            said.iter().rev().find_map(|frame| if let Frame::Place(place) = frame { Some(place.state) } else { None });
        state = place;
    });
    state.expect("the place is told")
}

#[test]
fn a_map_with_more_states_than_there_is_room_for_is_none() {
    assert_eq!(state_with(ROOM), PlaceState::Searching);
    assert_eq!(state_with(ROOM + 1), PlaceState::Fresh);
}
