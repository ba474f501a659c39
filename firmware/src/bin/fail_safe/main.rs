//! Fails in one way, named on its command line, with the robot's own handlers: `cargo xtask test fail-safe` runs it in the
//! emulator and looks at what reaches the motor driver's enable line.
#![no_std]
#![no_main]

#[path = "../../fail_safe.rs"]
mod fail_safe;
mod last_words;
mod ways;

#[cortex_m_rt::entry]
fn main() -> ! {
    last_words::mark(last_words::RUNNING);
    ways::fail(ways::wanted())
}
