//! Executors in interrupts: their tasks run while those below are still at work, down to the back end in thread mode.
#![allow(unsafe_code, reason = "an interrupt handler polls its executor")]

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};

static GUARD: InterruptExecutor = InterruptExecutor::new();
static STEP: InterruptExecutor = InterruptExecutor::new();
static DRIVE: InterruptExecutor = InterruptExecutor::new();

/// Starts the guard's executor, above the others, in the interrupt of a peripheral that the robot does not use.
pub fn guard() -> SendSpawner {
    interrupt::UART5.set_priority(Priority::P6);
    GUARD.start(interrupt::UART5)
}

/// Starts the executor of what belongs to the estimator's step, likewise.
pub fn step() -> SendSpawner {
    interrupt::UART4.set_priority(Priority::P7);
    STEP.start(interrupt::UART4)
}

/// Starts the executor of what may wait for a step, likewise.
pub fn drive() -> SendSpawner {
    interrupt::USART6.set_priority(Priority::P8);
    DRIVE.start(interrupt::USART6)
}

#[interrupt]
unsafe fn UART5() {
    // SAFETY: called by this interrupt only, which `start` enables.
    unsafe { GUARD.on_interrupt() }
}

#[interrupt]
unsafe fn UART4() {
    // SAFETY: as above.
    unsafe { STEP.on_interrupt() }
}

#[interrupt]
unsafe fn USART6() {
    // SAFETY: as above.
    unsafe { DRIVE.on_interrupt() }
}
