//! Pilot or floor job, wheel-speed control and motors.

use crate::Job;
use crate::faults::Task;
use crate::periodic::CONTROL_MS;
use crate::shared::{Odometry, Shared, Told, Touch};
use core::cell::Cell;
use core::sync::atomic::Ordering;
use embassy_time::Instant;
use robot::rig::BuiltIn;
use robot::{
    Condition, Debounce, DriveMotors, Duty, FloorState, LastingMemory, PowerSupply, Senses, WheelControl, WheelSpeeds,
};
use wire::{Command, Frame};

/// Longest time that a [`Command::Spin`] turns the wheels, in control periods: half a second.
const SPIN_PERIODS: u32 = 500 / CONTROL_MS as u32;

/// So many control periods the motors brake a robot that is told to stop: half a second.
const BRAKE_PERIODS: u8 = (500 / CONTROL_MS) as u8;

/// Samples between two frames of what becomes of the floor: once a second.
const FLOOR_FRAMES: u32 = 25;

/// A decision stands for this long after the senses that it was made by, microseconds: two samples may be lost.
const DECISION_US: u64 = 100_000;

/// What was commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Stopped,
    Driving,
    Spinning { duty: Duty, periods: u32 },
}

/// What pilot or floor job decided last, as long as it stands.
#[derive(Default)]
struct Decision {
    /// When the senses were taken, microseconds, and the speeds; none where nobody is in charge.
    made: Option<(u64, WheelSpeeds)>,
    /// The motors are held off.
    is_held: bool,
    /// When they were held off last, microseconds: they are told nothing that was decided by senses of before.
    held_us: u64,
}

impl Decision {
    /// The motors are held off now, or not.
    fn hold(&mut self, is_held: bool) {
        // The first beat after a hold counts as held, too: samples that were taken before its end come late.
        if core::mem::replace(&mut self.is_held, is_held) || is_held {
            (self.made, self.held_us) = (None, Instant::now().as_micros());
        }
    }

    /// Takes in what was decided by senses of then, microseconds.
    fn take(&mut self, time_us: u64, speeds: WheelSpeeds) {
        if !self.is_held && time_us > self.held_us {
            self.made = Some((time_us, speeds));
        }
    }

    /// Whether it is too old by now: nobody is in charge any more.
    fn lapses(&mut self, now_us: u64) -> bool {
        self.made.take_if(|(time_us, _)| now_us.saturating_sub(*time_us) > DECISION_US).is_some()
    }

    fn speeds(&self) -> WheelSpeeds {
        self.made.map_or(WheelSpeeds::STOP, |(_, speeds)| speeds)
    }
}

/// Drives the wheels at the odometry's beat, by what the job decided last, once told to start or to clean. Without senses the
/// wheels stop.
///
/// What is to be known of the floor after a reset goes into the memory; the first [`Command::Clean`] that is not for all of the floor goes
/// on with what is there.
///
/// A motor that is driven hard while its wheel stands is not driven on for half a second, and the robot backs off.
pub async fn drive(
    job: &mut Job,
    robot: BuiltIn,
    mut control: WheelControl,
    motors: &mut impl DriveMotors,
    supply: &mut impl PowerSupply,
    memory: &mut impl LastingMemory,
    shared: &Shared,
) -> ! {
    let mut stalls = control.stall_watch();
    let mut duty = Duty::default();
    let mut mode = Mode::Stopped;
    let mut decision = Decision::default();
    let mut last_us = None;
    let mut decided = 0_u32;
    let mut goes_on = false;
    let mut dock = Debounce::OPEN;
    let mut stopped = 0_u8;
    loop {
        let odometry = shared.odometry.wait().await;
        while let Ok(command) = shared.commands.try_receive() {
            goes_on |= command == Command::Clean { anew: false } && job.floor().is_none();
            mode = obey(command, mode, job, robot);
        }
        let period_s = period_s(last_us.replace(odometry.time_us), &odometry);
        decision.hold(shared.hold.load(Ordering::Relaxed));
        let is_stalled = stalls.update(duty, odometry.ticks, period_s);
        if let Some(Told { senses, whereabouts }) = shared.told.try_take() {
            let (battery_v, is_charging) = (supply.battery_v(), dock.step(supply.is_charging()));
            shared.docked.store(is_charging, Ordering::Relaxed);
            let condition = Condition { battery_v, is_charging, is_stalled, ..senses.condition };
            if core::mem::take(&mut goes_on) {
                go_on(job, whereabouts.kept, memory);
            }
            let speeds = job.step(&Senses { condition, ..senses }, &whereabouts);
            job.note(whereabouts.kept, memory);
            decision.take(senses.time_us, speeds);
            decided = decided.wrapping_add(1);
            tell_floor(job, decided, shared);
            if mode == Mode::Driving && job.is_over() {
                mode = Mode::Stopped;
            }
        }
        if decision.lapses(odometry.time_us) {
            shared.faults.count(|faults| &mut faults.dead_man_stops);
        }
        let touch = shared.touch.lock(Cell::get);
        duty = match mode {
            Mode::Stopped => control.update(WheelSpeeds::STOP, odometry.ticks, period_s),
            Mode::Driving => {
                control.update(stalls.guard(touch.contacts.guard(decision.speeds())), odometry.ticks, period_s)
            }
            Mode::Spinning { duty, .. } if touch.contacts.any() => {
                Duty { left: duty.left.min(0.0), right: duty.right.min(0.0) }
            }
            Mode::Spinning { duty, .. } => duty,
        };
        mode = age(mode);
        let is_to_stand = mode == Mode::Stopped || is_at_home(job);
        stopped = tell_stands(is_to_stand && duty == Duty::default(), stopped, shared);
        match motors.set_duty(duty) {
            Ok(()) => tell_guard(touch, shared),
            Err(_) => shared.faults.count(|faults| &mut faults.motors_failed),
        }
        shared.reports.report(Task::Drive);
    }
}

fn obey(command: Command, mode: Mode, job: &mut Job, robot: BuiltIn) -> Mode {
    match command {
        Command::Start => {
            job.explore(&robot.rig());
            Mode::Driving
        }
        Command::Clean { anew } => {
            job.clean(&robot.rig(), anew);
            Mode::Driving
        }
        Command::Stop => {
            job.pause();
            Mode::Stopped
        }
        Command::Spin { left, right } if mode != Mode::Driving => {
            Mode::Spinning { duty: Duty { left, right }, periods: SPIN_PERIODS }
        }
        Command::Spin { .. } | Command::ResetMap => mode,
    }
}

/// Goes on with the floor that was left before the reset, if there was some in this kept map.
fn go_on(job: &mut Job, kept: Option<u32>, memory: &impl LastingMemory) {
    if let Some(map) = kept {
        // Where there is none in this map, all of the floor is left.
        let _ = job.restore(map, memory);
    }
}

/// Whether the robot stands at home with floor left to sweep, where there is time to save the map.
fn is_at_home(job: &Job) -> bool {
    job.floor().is_some_and(|floor| matches!(floor.state, FloorState::Charging | FloorState::Waiting))
}

/// Tells whether the robot stands, after so many periods in which it did; how many these are now. It brakes first.
fn tell_stands(stands: bool, stopped: u8, shared: &Shared) -> u8 {
    shared.stands.store(stands, Ordering::Relaxed);
    let stopped = if stands { stopped.saturating_add(1) } else { 0 };
    shared.is_free.store(stopped > BRAKE_PERIODS, Ordering::Relaxed);
    stopped
}

/// Tells what became of the floor: not in the step in which the estimator has much to tell.
fn tell_floor(job: &Job, decided: u32, shared: &Shared) {
    if decided % FLOOR_FRAMES == FLOOR_FRAMES / 2
        && let Some(progress) = job.floor()
    {
        shared.push_frame(Frame::Floor(progress.into()));
    }
}

fn age(mode: Mode) -> Mode {
    match mode {
        Mode::Spinning { periods: 0, .. } => Mode::Stopped,
        Mode::Spinning { duty, periods } => Mode::Spinning { duty, periods: periods - 1 },
        other => other,
    }
}

fn period_s(last_us: Option<u64>, odometry: &Odometry) -> f32 {
    let elapsed_us = last_us.map_or(0, |last_us| odometry.time_us.saturating_sub(last_us));
    elapsed_us as f32 * 1e-6
}

/// The motors have a duty that takes the contact seen into account: the guard may let them go on.
fn tell_guard(seen: Touch, shared: &Shared) {
    shared.driven.lock(|driven| driven.set(Some(Instant::now())));
    if let Some(stop) = seen.stop {
        shared.release.signal(stop);
    }
}
