//! An estimator in a static, as a program without a heap has it: no copy of it is ever on the stack, and being all zero
//! it takes no flash.
//!
//! Built by `cargo build -p slam-core --example no_std_static`, for any target.
#![no_std]

use slam_core::{Rig, RigError, RobotSlam, Sample, StepReport};
use static_cell::ConstStaticCell;

static SLAM: ConstStaticCell<RobotSlam> = ConstStaticCell::new(RobotSlam::IDLE);

/// The estimator, started; to be called once.
///
/// # Errors
/// A value of the rig that cannot be.
pub fn start(rig: Rig<8>) -> Result<&'static mut RobotSlam, RigError> {
    let slam = SLAM.take();
    slam.start(rig)?;
    Ok(slam)
}

/// One sample from the task that senses.
pub fn on_sample(slam: &mut RobotSlam, sample: &Sample<8>) -> StepReport<8> {
    slam.step(sample)
}
