use core::mem::size_of;

use crate::{RobotDiary, RobotLookBack};

#[test]
fn a_robot_has_room_for_the_diary_and_its_solver() {
    let kib = |bytes: usize| bytes as f64 / 1024.0;
    assert!(kib(size_of::<RobotDiary>()) <= 60.0, "diary: {} KiB", kib(size_of::<RobotDiary>()));
    assert!(kib(size_of::<RobotLookBack>()) <= 56.0, "solver: {} KiB", kib(size_of::<RobotLookBack>()));
}
