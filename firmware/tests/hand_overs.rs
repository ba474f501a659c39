//! The back end at work beside the robot's tasks: it is lent and returned step by step, and hands over.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{Home, estimates};
use common::ranges::Ranges;
use robot::rig::BuiltIn;
use wire::{Command, Frame};

#[test]
fn look_backs_are_handed_over_while_the_robot_drives() {
    let home = Home::new("room", BuiltIn::TimeOfFlight);
    home.run(BuiltIn::TimeOfFlight, Ranges(home.board.range_sensors()), |tasks| {
        home.command(Command::Start);
        tasks.drive(90.0);
        let said = home.heard();
        let last =
            said.iter().rev().find_map(|frame| if let Frame::LookBack(back) = frame { Some(*back) } else { None });
        let back = last.expect("the back end is told of");
        assert!(back.taken_over >= 1 && back.keyframes > 10 && back.groups > 10, "{back:?}");
        assert_eq!(back.late, 0, "the work of a step is done before the next one");
        let epochs: Vec<u32> = estimates(&said).map(|estimate| estimate.epoch).collect();
        let changes = epochs.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(changes as u32 >= back.taken_over, "{changes} epochs for {} hand-overs", back.taken_over);
        let (last, truth) = (estimates(&said).next_back().expect("estimates are told"), home.truth());
        let error_m = (f64::from(last.pose[0]) - truth.x_m).hypot(f64::from(last.pose[1]) - truth.y_m);
        assert!(error_m < 0.1, "estimate {:?}, truth {truth:?}", last.pose);

        home.command(Command::ResetMap);
        tasks.drive(2.0);
        let counts = |frame: &Frame| if let Frame::LookBack(back) = frame { Some(back.keyframes) } else { None };
        let keyframes = home.heard().iter().rev().find_map(counts).expect("the back end is told of");
        assert!(keyframes < 10, "a new map has a new diary: {keyframes} keyframes");
    });
}
