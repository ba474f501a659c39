//! An executor in an interrupt: its tasks run while the estimator is still at work.
#![allow(unsafe_code, reason = "an interrupt handler polls the executor")]

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};

static EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// Starts the executor in the interrupt of a peripheral that the robot does not use.
pub fn spawner() -> SendSpawner {
    interrupt::UART5.set_priority(Priority::P6);
    EXECUTOR.start(interrupt::UART5)
}

#[interrupt]
unsafe fn UART5() {
    // SAFETY: called by this interrupt only, which `start` enables.
    unsafe { EXECUTOR.on_interrupt() }
}
