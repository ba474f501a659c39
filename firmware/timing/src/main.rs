//! A bare program that runs each case once on the robot's processor and prints what it cost.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

mod cases;

use instruction_count::{Bench, finish};

#[cortex_m_rt::entry]
fn main() -> ! {
    cases::run(&Bench::start());
    finish()
}
