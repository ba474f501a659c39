//! Where tasks meet. Every channel is bounded; what happens when one is full is said here and counted in the faults.

use crate::SENSORS;
use crate::faults::{FaultCounts, Reports};
use core::cell::Cell;
use core::sync::atomic::AtomicBool;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex as Raw;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_time::Instant;
use robot::{Contacts, Senses, Whereabouts};
use slam_core::{RangeInput, Ticks};
use wire::{Command, Frame, MapRequest};

/// One reading of the range sensors.
#[derive(Clone, Copy, Debug)]
pub struct Ranges {
    /// When, microseconds since the start.
    pub time_us: u64,
    /// The readings, in the rig's order.
    pub ranges: [RangeInput; SENSORS],
}

/// One reading of the encoders.
#[derive(Clone, Copy, Debug, Default)]
pub struct Odometry {
    /// When, microseconds since the start.
    pub time_us: u64,
    /// Cumulative counts.
    pub ticks: Ticks,
}

/// What the estimator makes of one sample.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// Pose, ranges and contacts.
    pub senses: Senses<SENSORS>,
    /// What is known of the map that the pose is in.
    pub whereabouts: Whereabouts,
}

/// What the guard of bumper and cliff sensor knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Touch {
    /// The inputs now.
    pub contacts: Contacts,
    /// The stop by contact, counted from 1, that keeps the motors off until the drive task has answered this one.
    pub stop: Option<u32>,
}

/// Everything that tasks share.
pub struct Shared {
    /// Sample to estimate. Full: the oldest is dropped, `samples_dropped`.
    pub ranges: Channel<Raw, Ranges, 2>,
    /// Odometry to drive: the latest counts.
    pub odometry: Signal<Raw, Odometry>,
    /// The latest counts, for the estimator.
    pub latest_odometry: Mutex<Raw, Cell<Odometry>>,
    /// Estimate to drive: the latest only.
    pub told: Signal<Raw, Told>,
    /// To telemetry. Full: the new one is dropped, `frames_dropped`.
    pub frames: Channel<Raw, Frame, 8>,
    /// Commands to drive. Full: the new one is dropped, `commands_dropped`.
    pub commands: Channel<Raw, Command, 4>,
    /// The estimator shall forget its map.
    pub reset_map: Signal<Raw, ()>,
    /// Somebody wants something with the kept map: the latest request only.
    pub map_request: Signal<Raw, MapRequest>,
    /// Guard to drive and estimate.
    pub touch: Mutex<Raw, Cell<Touch>>,
    /// Drive to guard: the stop with this number is taken into account. It releases no other one.
    pub release: Signal<Raw, u32>,
    /// Drive to guard: when the motors were last given a duty; none before the first time.
    pub driven: Mutex<Raw, Cell<Option<Instant>>>,
    /// Drive to estimate: the robot is told to stand.
    pub stands: AtomicBool,
    /// Drive to guard: the robot has braked and stands; without its motors it can be pushed.
    pub is_free: AtomicBool,
    /// Estimate to guard: the motors have to be off, for the map is saved.
    pub hold: AtomicBool,
    /// Guard to estimate: the motors are off for that.
    pub is_held: AtomicBool,
    /// Drive to estimate: the robot stands in its dock.
    pub docked: AtomicBool,
    /// Fault counters.
    pub faults: FaultCounts,
    /// Signs of life.
    pub reports: Reports,
}

impl Shared {
    /// Nothing sent yet.
    pub const fn new() -> Self {
        let origin = Odometry { time_us: 0, ticks: Ticks { left: 0, right: 0 } };
        let contacts = Contacts { bump_left: false, bump_right: false, cliff: false, lifted: false };
        Self {
            ranges: Channel::new(),
            odometry: Signal::new(),
            latest_odometry: Mutex::new(Cell::new(origin)),
            told: Signal::new(),
            frames: Channel::new(),
            commands: Channel::new(),
            reset_map: Signal::new(),
            map_request: Signal::new(),
            touch: Mutex::new(Cell::new(Touch { contacts, stop: None })),
            release: Signal::new(),
            driven: Mutex::new(Cell::new(None)),
            stands: AtomicBool::new(true),
            is_free: AtomicBool::new(false),
            hold: AtomicBool::new(false),
            is_held: AtomicBool::new(false),
            docked: AtomicBool::new(false),
            faults: FaultCounts::new(),
            reports: Reports::new(),
        }
    }

    /// Hands ranges to the estimator; the oldest make room.
    pub fn push_ranges(&self, ranges: Ranges) {
        if let Err(embassy_sync::channel::TrySendError::Full(ranges)) = self.ranges.try_send(ranges) {
            self.faults.count(|faults| &mut faults.samples_dropped);
            // Nobody else takes or sends between these two: there is room now.
            let _ = self.ranges.try_receive();
            let _ = self.ranges.try_send(ranges);
        }
    }

    /// Hands a command to the drive task, if there is room. A [`Command::Stop`] makes room for itself: of all that wait, it is what counts.
    pub fn push_command(&self, command: Command) {
        if self.commands.try_send(command).is_err() {
            self.faults.count(|faults| &mut faults.commands_dropped);
            if command == Command::Stop {
                self.commands.clear();
                let _ = self.commands.try_send(command);
            }
        }
    }

    /// Hands a frame to the telemetry, if there is room.
    pub fn push_frame(&self, frame: Frame) {
        if self.frames.try_send(frame).is_err() {
            self.faults.count(|faults| &mut faults.frames_dropped);
        }
    }

    /// Bumper and cliff now.
    pub fn contacts(&self) -> Contacts {
        self.touch.lock(Cell::get).contacts
    }
}

impl Default for Shared {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_channels_drop_what_they_say_and_count() {
        let shared = Shared::new();
        for time_us in 1..=5 {
            shared.push_ranges(Ranges { time_us, ranges: [RangeInput::Missing; SENSORS] });
        }
        let kept: Vec<u64> = core::iter::from_fn(|| shared.ranges.try_receive().ok()).map(|r| r.time_us).collect();
        assert_eq!(kept, [4, 5], "the newest ranges are kept");
        assert_eq!(shared.faults.get().samples_dropped, 3);
        for _ in 0..10 {
            shared.push_frame(Frame::Command(Command::Stop));
        }
        assert_eq!(shared.faults.get().frames_dropped, 2);
        for command in [Command::Start; 5].into_iter().chain([Command::Stop]) {
            shared.push_command(command);
        }
        assert_eq!(shared.faults.get().commands_dropped, 2);
        assert_eq!(shared.commands.try_receive(), Ok(Command::Stop), "a stop is never dropped");
        assert!(shared.commands.try_receive().is_err());
    }

    extern crate std;
    use std::vec::Vec;
}
