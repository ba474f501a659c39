//! One step of the robot's estimator, and what the back end does in it.
//!
//! Generic code is compiled with the profile of the crate that names its types. This crate has the one for speed; the
//! tasks around it, which seldom run, have the one for size.
#![no_std]
#![forbid(unsafe_code)]

use look_back::RobotBackEnd;
use slam_core::{RobotSlam, Sample, StepReport};

/// [`RobotSlam::step`].
#[inline(never)]
pub fn step(slam: &mut RobotSlam, sample: &Sample<8>) -> StepReport<8> {
    slam.step(sample)
}

/// Writes the estimator's last step down.
#[inline(never)]
pub fn record(back_end: &mut RobotBackEnd, slam: &RobotSlam, report: &StepReport<8>) {
    back_end.record(slam, report);
}
