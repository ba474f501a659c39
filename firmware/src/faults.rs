//! Counts of what went wrong, and which tasks are alive.

use core::cell::Cell;
use core::sync::atomic::{AtomicU8, Ordering};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use wire::BoardFaults;

/// The firmware's fault counters; they saturate.
pub struct FaultCounts(Mutex<CriticalSectionRawMutex, Cell<BoardFaults>>);

impl FaultCounts {
    /// All zero.
    pub const fn new() -> Self {
        Self(Mutex::new(Cell::new(BoardFaults {
            ranges_failed: 0,
            encoders_failed: 0,
            motors_failed: 0,
            samples_dropped: 0,
            frames_dropped: 0,
            commands_dropped: 0,
            bytes_lost: 0,
            contact_stops: 0,
            dead_man_stops: 0,
            watchdog_resets: 0,
            late_tasks: 0,
            stack_used_bytes: 0,
        })))
    }

    /// Changes the faults.
    pub fn update(&self, change: impl FnOnce(&mut BoardFaults)) {
        self.0.lock(|cell| {
            let mut faults = cell.get();
            change(&mut faults);
            cell.set(faults);
        });
    }

    /// Adds one to the counter that `pick` points at.
    pub fn count(&self, pick: impl FnOnce(&mut BoardFaults) -> &mut u32) {
        self.update(|faults| {
            let counter = pick(faults);
            *counter = counter.saturating_add(1);
        });
    }

    /// The counts now.
    pub fn get(&self) -> BoardFaults {
        self.0.lock(Cell::get)
    }
}

impl Default for FaultCounts {
    fn default() -> Self {
        Self::new()
    }
}

/// A task that must report to the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Range sensors.
    Sample = 1,
    /// Encoders.
    Odometry = 2,
    /// Estimator.
    Estimate = 4,
    /// Motors.
    Drive = 8,
    /// Bumper and cliff.
    Guard = 16,
    /// Frames to the serial line.
    Telemetry = 32,
}

/// Every task that must report.
const ALL: u8 = 63;

/// Who has reported since the supervisor looked last.
#[derive(Default)]
pub struct Reports(AtomicU8);

impl Reports {
    /// Nobody.
    pub const fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    /// This task runs.
    pub fn report(&self, task: Task) {
        self.0.fetch_or(task as u8, Ordering::Relaxed);
    }

    /// Whether every task has reported since the last call.
    pub fn take_all(&self) -> bool {
        self.0.swap(0, Ordering::Relaxed) == ALL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_silent_task_is_noticed() {
        let reports = Reports::new();
        let tasks = [Task::Sample, Task::Odometry, Task::Estimate, Task::Drive, Task::Guard, Task::Telemetry];
        for silent in tasks {
            tasks.iter().filter(|task| **task != silent).for_each(|task| reports.report(*task));
            assert!(!reports.take_all(), "{silent:?}");
        }
        tasks.iter().for_each(|task| reports.report(*task));
        assert!(reports.take_all());
        assert!(!reports.take_all(), "reports count once");
    }
}
