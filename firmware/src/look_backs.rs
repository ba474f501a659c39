//! The back end goes to and fro between the estimator and the task that looks back: who has it may write to it.
//!
//! ```text
//! estimator   step n, tell ── record ─┐        step n + 1, tell ── record ─┐                    ┌─ hand over ── step n + 2
//! look back                           └─ work of one step ─┘               └─ work of one step ─┘
//! ```
//!
//! The work between two steps is a fixed number of operations, not a time: so the host that repeats a drive gets the same bits. A step
//! waits for it only where something may be handed over before: once in eight metres, a few steps.

use core::sync::atomic::{AtomicU32, Ordering};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex as Raw;
use embassy_sync::signal::Signal;
use look_back::RobotBackEnd;

/// Where a back end changes hands.
pub struct LookBacks {
    to_work: Signal<Raw, &'static mut RobotBackEnd>,
    done: Signal<Raw, &'static mut RobotBackEnd>,
    late: AtomicU32,
}

impl LookBacks {
    /// With nobody's back end.
    pub const fn new() -> Self {
        Self { to_work: Signal::new(), done: Signal::new(), late: AtomicU32::new(0) }
    }

    /// Hands it to the estimator.
    pub fn give_back(&self, back_end: &'static mut RobotBackEnd) {
        self.done.signal(back_end);
    }

    /// Hands it to the task that looks back.
    pub fn lend(&self, back_end: &'static mut RobotBackEnd) {
        self.to_work.signal(back_end);
    }

    /// The estimator's, when the work of the last step is done; where that is not yet, counts it.
    pub async fn returned(&self) -> &'static mut RobotBackEnd {
        if !self.done.signaled() {
            // One task only counts.
            self.late.store(self.late().saturating_add(1), Ordering::Relaxed);
        }
        self.done.wait().await
    }

    /// The same before the next step, which waits for what may be handed over.
    pub async fn found(&self) -> &'static mut RobotBackEnd {
        self.done.wait().await
    }

    /// That of the task that looks back, when there is work.
    pub async fn lent(&self) -> &'static mut RobotBackEnd {
        self.to_work.wait().await
    }

    /// Steps whose work was not done when the next one was.
    pub fn late(&self) -> u32 {
        self.late.load(Ordering::Relaxed)
    }
}

impl Default for LookBacks {
    fn default() -> Self {
        Self::new()
    }
}
