//! The executors of the loop, one a level: each runs when no task above it can go on. When none can, the host is turned to.
#![allow(unsafe_code, reason = "the executor wants its wake-up function under a fixed name, and one caller of poll")]

use super::clock;
use crate::Levels;
use crate::link::Link;
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_executor::raw;
use static_cell::StaticCell;

static LEVELS: StaticCell<[raw::Executor; 3]> = StaticCell::new();
/// Whether the executor of this number has to be polled.
static PENDING: [AtomicBool; 3] = [const { AtomicBool::new(false) }; 3];

#[unsafe(export_name = "__pender")]
fn pend(executor: *mut ()) {
    if let Some(pending) = PENDING.get(executor as usize) {
        pending.store(true, Ordering::Release);
    }
}

/// Runs the tasks that `spawn` spawns for ever.
pub fn run(spawn: impl FnOnce(Levels), mut link: Link) -> ! {
    let level = |number: usize| raw::Executor::new(core::ptr::without_provenance_mut(number));
    let levels = LEVELS.init([level(0), level(1), level(2)]);
    let [step, drive, below] = &*levels;
    spawn(Levels { step: step.spawner(), drive: drive.spawner(), below: below.spawner() });
    loop {
        let highest = PENDING.iter().position(|pending| pending.swap(false, Ordering::Acquire));
        match highest.and_then(|number| levels.get(number)) {
            // SAFETY: the only call, on an executor that lives for ever, and not from within a task.
            Some(level) => unsafe { level.poll() },
            None => clock::advance(link.exchange()),
        }
    }
}
