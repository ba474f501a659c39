//! The wheels stop within 100 ms when the estimator goes silent, and when the drive task does.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::Wire;
use core::cell::Cell;
use core::convert::Infallible;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Waker};
use embassy_time::{Duration, Instant, MockDriver};
use firmware::shared::{Odometry, Told};
use firmware::{Job, SENSORS, Shared, tasks};
use robot::rig::BuiltIn;
use robot::{
    ContactPins, Contacts, DriveMotors, Duty, NoSupply, Senses, WheelControl, WheelControlConfig, Whereabouts,
};
use slam_core::{Pose, Ticks};
use wire::Command;

/// Motors that remember what they were given last.
struct Motors<'a>(&'a Cell<Duty>);

impl DriveMotors for Motors<'_> {
    type Error = Infallible;

    fn set_duty(&mut self, duty: Duty) -> Result<(), Infallible> {
        self.0.set(duty);
        Ok(())
    }
}

/// Lets 20 ms pass and hands the drive task the counts of then, from wheels that turn at a fifth of a metre a second as they are driven.
fn odometry(shared: &Shared, ticks: &Cell<Ticks>, duty: Duty) {
    MockDriver::get().advance(Duration::from_millis(20));
    let time_us = Instant::now().as_micros();
    let turned = |before: i32, duty: f32| before + 9 * duty.signum() as i32;
    let Ticks { left, right } = ticks.get();
    ticks.set(Ticks { left: turned(left, duty.left), right: turned(right, duty.right) });
    shared.odometry.signal(Odometry { time_us, ticks: ticks.get() });
}

/// The estimator's word of now: all is clear.
fn told() -> Told {
    let time_us = Instant::now().as_micros();
    let senses = Senses {
        time_us,
        pose: Pose::default(),
        ranges_m: [Some(1.0); SENSORS],
        contacts: Contacts::default(),
        condition: robot::Condition::default(),
    };
    Told { senses, whereabouts: Whereabouts::START }
}

#[test]
fn silence_stops_the_wheels() {
    let shared = Shared::new();
    let [left, right, cliff, lifted, enabled] = [false; 5].map(Cell::new);
    let inputs =
        ContactPins { bump_left: Wire(&left), bump_right: Wire(&right), cliff: Wire(&cliff), lifted: Wire(&lifted) };
    let (mut enable, duty) = (Wire(&enabled), Cell::new(Duty::default()));
    let ticks = Cell::new(Ticks { left: 0, right: 0 });
    let mut job = Job::idle();
    job.explore(&BuiltIn::Sharp.rig());
    let mut motors = Motors(&duty);
    let control = WheelControl::new(WheelControlConfig::default());
    let mut guard = pin!(tasks::guard(inputs, &mut enable, &shared));
    let (supply, flash) = (&mut NoSupply, &mut [0; 0]);
    let mut drive = pin!(tasks::drive(&mut job, BuiltIn::Sharp, control, &mut motors, supply, flash, &shared));
    let mut context = Context::from_waker(Waker::noop());
    let mut context_of_guard = Context::from_waker(Waker::noop());
    let mut poll_drive = || assert!(drive.as_mut().poll(&mut context).is_pending());
    let mut poll_guard = || assert!(guard.as_mut().poll(&mut context_of_guard).is_pending());
    let runs = || duty.get() != Duty::default();

    poll_guard();
    assert!(!enabled.get(), "nobody drives yet");
    shared.commands.try_send(Command::Start).unwrap();
    for _ in 0..100 {
        shared.told.signal(told());
        odometry(&shared, &ticks, duty.get());
        poll_drive();
        poll_guard();
    }
    assert!(runs() && enabled.get());

    // The estimator is silent, the drive task lives.
    for _ in 0..3 {
        odometry(&shared, &ticks, duty.get());
        poll_drive();
    }
    assert!(runs(), "80 ms after the last senses");
    for _ in 0..2 {
        odometry(&shared, &ticks, duty.get());
        poll_drive();
        poll_guard();
    }
    assert!(!runs(), "more than 100 ms after the last senses");
    assert!(enabled.get(), "the drive task itself stops the wheels");
    assert_eq!(shared.faults.get().dead_man_stops, 1);

    // The estimator speaks again; then the drive task is silent.
    shared.told.signal(told());
    odometry(&shared, &ticks, duty.get());
    poll_drive();
    poll_guard();
    assert!(runs() && enabled.get());
    let last = Instant::now();
    while enabled.get() {
        MockDriver::get().advance(Duration::from_millis(5));
        poll_guard();
    }
    let elapsed_ms = (Instant::now() - last).as_millis();
    assert!((80..=100).contains(&elapsed_ms), "{elapsed_ms} ms");
    assert_eq!(shared.faults.get().dead_man_stops, 2);
    for _ in 0..50 {
        MockDriver::get().advance(Duration::from_millis(10));
        poll_guard();
        assert!(!enabled.get());
    }
    assert_eq!(shared.faults.get().dead_man_stops, 2, "one silence, one stop");
}
