//! Variables in the core-coupled RAM, above the stack: what only the core reaches and what is large, but for the back end,
//! which fills the other bank. DMA does not reach this memory.
#![allow(
    unsafe_code,
    reason = "the linker must be told where a variable lies, and start-up zeroes it before Rust begins"
)]

use firmware::Job;
use robot::rig::BuiltIn;
use slam_core::RobotSlam;
use static_cell::{ConstStaticCell, StaticCell};

/// The estimator.
// SAFETY: start-up zeroes the section, as it does other variables whose bytes are zero.
#[unsafe(link_section = ".ccram")]
pub static SLAM: ConstStaticCell<RobotSlam> = ConstStaticCell::new(RobotSlam::IDLE);

/// Pilot or floor job.
// SAFETY: as above.
#[unsafe(link_section = ".ccram")]
static JOB: StaticCell<Job> = StaticCell::new();

/// The job of a robot like this one. What start-up needs of the stack is free again when this returns.
#[inline(never)]
pub fn job(robot: BuiltIn) -> &'static mut Job {
    let job = JOB.init_with(Job::idle);
    job.explore(&robot.rig());
    job.pause();
    job
}

// Called by start-up before it zeroes the other bank.
core::arch::global_asm!(
    ".section .text.__pre_init, \"ax\"",
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "ldr r0, =__sccram",
    "ldr r1, =__eccram",
    "movs r2, #0",
    "0:",
    "cmp r1, r0",
    "beq 1f",
    "stm r0!, {{r2}}",
    "b 0b",
    "1:",
    "bx lr",
    ".pool",
);
