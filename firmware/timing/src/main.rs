//! A bare program that runs each case once on the robot's processor and prints what it cost.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

mod cases;

use core::panic::PanicInfo;
use cortex_m_semihosting::{debug, hprintln};

#[cortex_m_rt::entry]
fn main() -> ! {
    cases::run(&instruction_count::Bench::start());
    exit(debug::EXIT_SUCCESS)
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    hprintln!("{}", info);
    exit(debug::EXIT_FAILURE)
}

fn exit(status: debug::ExitStatus) -> ! {
    loop {
        debug::exit(status);
    }
}
