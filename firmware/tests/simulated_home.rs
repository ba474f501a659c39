//! The robot's tasks, as they are, on this machine: peripherals of the simulated board, a clock that the test moves.
//!
//! One test only: the clock is one for the whole process.

use core::cell::Cell;
use core::convert::Infallible;
use core::future::{Future, pending, poll_fn};
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embassy_futures::join::{join, join4};
use embassy_time::{Duration, MockDriver};
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::digital::Wait;
use embedded_io_async::{ErrorKind, ErrorType as IoErrorType, Read, Write};
use firmware::tasks::{self, Platform};
use firmware::{Pilot, SENSORS, Shared};
use hal_sim::{Board, SimOptions, Simulation, TruePose, default_rig, plan_file};
use robot::{ContactPins, PilotConfig, RangeSensorBank, WheelControl, WheelControlConfig};
use slam_core::{Config, RangeInput, RobotSlam};
use std::cell::RefCell;
use std::collections::VecDeque;
use wire::{Command, Decoder, Estimate, Frame, encode};

/// The simulated bank with the robot's number of sensors.
struct Ranges(hal_sim::board::SimRanges);

impl RangeSensorBank<SENSORS> for Ranges {
    type Error = Infallible;

    fn read(&mut self) -> Result<[RangeInput; SENSORS], Infallible> {
        let wide = self.0.read()?;
        Ok(core::array::from_fn(|i| wide[i]))
    }
}

/// A simulated input without edges: the guard's own look finds the level.
struct Input<P>(P);

impl<P: ErrorType> ErrorType for Input<P> {
    type Error = P::Error;
}

impl<P: InputPin> InputPin for Input<P> {
    fn is_high(&mut self) -> Result<bool, P::Error> {
        self.0.is_high()
    }

    fn is_low(&mut self) -> Result<bool, P::Error> {
        self.0.is_low()
    }
}

impl<P: InputPin> Wait for Input<P> {
    async fn wait_for_high(&mut self) -> Result<(), P::Error> {
        pending().await
    }

    async fn wait_for_low(&mut self) -> Result<(), P::Error> {
        pending().await
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), P::Error> {
        pending().await
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), P::Error> {
        pending().await
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), P::Error> {
        pending().await
    }
}

/// The motor driver's enable input, which the simulated board does not have: the test looks at it.
struct Enable<'a>(&'a Cell<bool>);

impl ErrorType for Enable<'_> {
    type Error = Infallible;
}

impl OutputPin for Enable<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

/// One end of a serial line.
struct Line<'a>(&'a RefCell<VecDeque<u8>>);

impl IoErrorType for Line<'_> {
    type Error = ErrorKind;
}

impl Write for Line<'_> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        self.0.borrow_mut().extend(bytes);
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

impl Read for Line<'_> {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, ErrorKind> {
        poll_fn(|_| if self.0.borrow().is_empty() { Poll::Pending } else { Poll::Ready(()) }).await;
        let mut queue = self.0.borrow_mut();
        let count = bytes.len().min(queue.len());
        bytes.iter_mut().zip(queue.drain(..count)).for_each(|(to, from)| *to = from);
        Ok(count)
    }
}

/// Counts how often the watchdog was fed.
struct Fed<'a>(&'a Cell<u32>);

impl Platform for Fed<'_> {
    fn feed_watchdog(&mut self) {
        self.0.set(self.0.get() + 1);
    }

    fn stack_used_bytes(&mut self) -> u32 {
        0
    }
}

/// Lets simulated time pass with the tasks at work. They are polled until they can have nothing left to do.
fn drive(all: &mut core::pin::Pin<&mut impl Future>, board: &Board, seconds: f64) {
    let mut context = Context::from_waker(Waker::noop());
    for _ in 0..(seconds * 100.0) as u32 {
        board.advance(0.01);
        MockDriver::get().advance(Duration::from_millis(10));
        for _ in 0..12 {
            assert!(all.as_mut().poll(&mut context).is_pending(), "no task ends");
        }
    }
}

fn frames(line: &RefCell<VecDeque<u8>>) -> Vec<Frame> {
    let mut decoder = Decoder::new();
    line.borrow_mut().drain(..).filter_map(|byte| decoder.push(byte)).map(|frame| frame.expect("undamaged")).collect()
}

fn estimates(said: &[Frame]) -> impl DoubleEndedIterator<Item = &Estimate> {
    said.iter().filter_map(|frame| if let Frame::Estimate(estimate) = frame { Some(estimate) } else { None })
}

/// A minute's frames: where the robot is, the room's walls, and every kind of frame beside.
fn assert_mapped(said: &[Frame], truth: TruePose) {
    let last = estimates(said).next_back().expect("estimates are told");
    let error_m = (f64::from(last.pose[0]) - truth.x_m).hypot(f64::from(last.pose[1]) - truth.y_m);
    assert!(error_m < 0.1, "estimate {:?}, truth {truth:?}", last.pose);
    assert!(last.walls >= 4, "{} walls", last.walls);
    assert!((1500..=1560).contains(&estimates(said).count()), "25 estimates a second");
    for kind in ["Sample", "Wall", "Calibration", "Faults"] {
        assert!(said.iter().any(|frame| format!("{frame:?}").starts_with(kind)), "no {kind} frame");
    }
}

#[test]
fn the_tasks_map_a_simulated_room() {
    let plan = plan_file::load("room").unwrap();
    let simulation = Simulation::new(&plan, &default_rig(), SimOptions::default(), 3).unwrap();
    let board = Board::new(simulation);
    let shared = Shared::new();
    let (enabled, fed) = (Cell::new(false), Cell::new(0));
    let (up, down) = (RefCell::new(VecDeque::new()), RefCell::new(VecDeque::new()));
    let mut slam = RobotSlam::new(robot::rig::default_rig(), Config::default()).unwrap();
    let mut pilot = Pilot::new(PilotConfig::default(), &robot::rig::default_rig());
    let (mut encoders, mut ranges, mut motors) = (board.encoders(), Ranges(board.range_sensors()), board.motors());
    let pins = board.contacts();
    let inputs =
        ContactPins { bump_left: Input(pins.bump_left), bump_right: Input(pins.bump_right), cliff: Input(pins.cliff) };
    let (mut enable, mut platform) = (Enable(&enabled), Fed(&fed));
    let (mut transmitter, mut receiver) = (Line(&up), Line(&down));
    let control = WheelControl::new(WheelControlConfig::default());
    let all = join(
        join4(
            tasks::odometry(&mut encoders, &shared),
            tasks::sample(&mut ranges, &shared),
            tasks::estimate(&mut slam, Config::default(), &shared),
            tasks::drive(&mut pilot, control, &mut motors, &shared),
        ),
        join4(
            tasks::guard(inputs, &mut enable, &shared),
            tasks::telemetry(&mut transmitter, &shared),
            tasks::commands(&mut receiver, &shared),
            tasks::supervise(&mut platform, &shared),
        ),
    );
    let mut all = pin!(all);

    drive(&mut all, &board, 2.0);
    let still = board.with_simulation(|simulation| simulation.pose());
    assert!(still.x_m.hypot(still.y_m) < 1e-6, "the robot waits to be told: {still:?}");
    assert!(enabled.get() && fed.get() >= 3, "motors enabled, watchdog fed: {}", fed.get());

    down.borrow_mut().extend(encode(&Frame::Command(Command::Start)).unwrap());
    drive(&mut all, &board, 60.0);
    assert_mapped(&frames(&up), board.with_simulation(|simulation| simulation.pose()));
    let faults = shared.faults.get();
    assert_eq!((faults.samples_dropped, faults.frames_dropped, faults.late_tasks), (0, 0, 0));

    down.borrow_mut().extend(encode(&Frame::Command(Command::Stop)).unwrap());
    down.borrow_mut().extend(encode(&Frame::Command(Command::ResetMap)).unwrap());
    drive(&mut all, &board, 2.0);
    let said = frames(&up);
    let last = estimates(&said).next_back().expect("estimates are told");
    assert!(last.pose[0].hypot(last.pose[1]) < 0.05, "where it stands is the new origin: {:?}", last.pose);

    down.borrow_mut().extend([7; 300]);
    down.borrow_mut().extend([0]);
    drive(&mut all, &board, 0.5);
    assert_eq!(shared.faults.get().bytes_lost, 1, "noise on the line is counted");
}
