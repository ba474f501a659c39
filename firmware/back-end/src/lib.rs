//! The slices of a look back, and its hand-over.
//!
//! Generic code is compiled with the profile of the crate that names its types. This crate has one for size: a look back is the largest
//! piece of the program, and may take a third more time than it does when it is compiled for speed.
#![no_std]
#![forbid(unsafe_code)]

use look_back::{Progress, RobotBackEnd, RobotDiary, RobotLookBack, STEP_US};
use slam_core::{NotTaken, RobotSlam};

/// Looks back for the work of one step.
#[inline(never)]
pub fn look_back(back_end: &mut RobotBackEnd) {
    back_end.work(STEP_US);
}

/// One slice of a look back over a diary.
#[inline(never)]
pub fn slice(look_back: &mut RobotLookBack, diary: &mut RobotDiary) -> Progress {
    look_back.work(diary, 1)
}

/// Hands over what a look back found, if one has caught up with the estimator.
#[inline(never)]
pub fn hand_over(back_end: &mut RobotBackEnd, slam: &mut RobotSlam) -> Option<Result<(), NotTaken>> {
    back_end.hand_over(slam)
}
