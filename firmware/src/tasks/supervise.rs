//! The supervisor: feeds the watchdog only when every task has reported.

use crate::periodic::{Periodic, SUPERVISE_MS};
use crate::shared::Shared;

/// What the supervisor needs from the processor.
pub trait Platform {
    /// All is well: the watchdog waits for another period before it restarts the robot.
    fn feed_watchdog(&mut self);

    /// The most stack that was ever in use, bytes.
    fn stack_used_bytes(&mut self) -> u32;
}

/// Feeds the watchdog while all tasks live; without one of them it lets the robot restart.
pub async fn supervise(platform: &mut impl Platform, shared: &Shared) -> ! {
    let mut beat = Periodic::every_ms(SUPERVISE_MS);
    platform.feed_watchdog();
    loop {
        beat.next().await;
        let stack_used_bytes = platform.stack_used_bytes();
        shared.faults.update(|faults| faults.stack_used_bytes = stack_used_bytes);
        if shared.reports.take_all() {
            platform.feed_watchdog();
        } else {
            shared.faults.count(|faults| &mut faults.late_tasks);
        }
    }
}
