//! The executor of the loop: when no task has anything left to do, it turns to the host instead of sleeping.
#![allow(unsafe_code, reason = "the executor wants its wake-up function under a fixed name, and one caller of poll")]

use core::sync::atomic::{AtomicBool, Ordering};
use embassy_executor::{Spawner, raw};
use static_cell::StaticCell;

static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();
static PENDING: AtomicBool = AtomicBool::new(false);

#[unsafe(export_name = "__pender")]
fn pend(_context: *mut ()) {
    PENDING.store(true, Ordering::Release);
}

/// Runs the tasks that `spawn` spawns, for ever; calls `idle` whenever none can go on.
pub fn run(spawn: impl FnOnce(Spawner), mut idle: impl FnMut()) -> ! {
    let executor = EXECUTOR.init(raw::Executor::new(core::ptr::null_mut()));
    spawn(executor.spawner());
    loop {
        while PENDING.swap(false, Ordering::Acquire) {
            // SAFETY: the only call, on the executor that lives for ever, and not from within a task.
            unsafe { executor.poll() };
        }
        idle();
    }
}
