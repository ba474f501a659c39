//! Variables in the core-coupled RAM, above the stack: what only the core reaches and what is large, but for the back end,
//! which fills the other bank. DMA does not reach this memory.
#![allow(
    unsafe_code,
    reason = "the linker must be told where a variable lies, and start-up zeroes it before Rust begins"
)]

use firmware::Pilot;
use slam_core::RobotSlam;
use static_cell::{ConstStaticCell, StaticCell};

/// The estimator.
// SAFETY: start-up zeroes the section, as it does other variables whose bytes are zero.
#[unsafe(link_section = ".ccram")]
pub static SLAM: ConstStaticCell<RobotSlam> = ConstStaticCell::new(RobotSlam::IDLE);

/// The pilot.
// SAFETY: as above.
#[unsafe(link_section = ".ccram")]
pub static PILOT: StaticCell<Pilot> = StaticCell::new();

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
