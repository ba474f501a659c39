//! The robot's tasks at work in a simulated home.

use core::cell::{Cell, RefCell};
use core::future::{Future, pending, poll_fn};
use core::pin::{Pin, pin};
use core::task::{Context, Poll, Waker};
use embassy_futures::join::{join, join4};
use embassy_time::{Duration, MockDriver};
use embedded_hal::digital::{ErrorType, InputPin};
use embedded_hal_async::digital::Wait;
use embedded_io_async::{ErrorKind, ErrorType as IoErrorType, Read, Write};
use firmware::keeper::{MapFlash, SLOT_BYTES};
use firmware::tasks::{self, Platform};
use firmware::{Job, Keeper, LookBacks, SENSORS, Shared};
use hal_sim::{Board, Plan, Pose2, SimOptions, Simulation, plan_file};
use kept_map::{Record, Store};
use look_back::RobotBackEnd;
use robot::rig::BuiltIn;
use robot::{
    ContactPins, FLOOR_RECORD_BYTES, POSE_RECORD_BYTES, PowerSupply, RangeSensorBank, WheelControl, WheelControlConfig,
};
use slam_core::kept::Kept;
use slam_core::{Config, RobotSlam};
use std::collections::VecDeque;
use wire::{Command, Decoder, Estimate, Floor, Frame, Place, encode};

use super::Wire;
use super::nor::Nor;

/// A simulated input without edges: the guard's own look finds the level.
pub struct Input<P>(pub P);

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

/// One end of a serial line.
pub struct Line<'a>(pub &'a RefCell<VecDeque<u8>>);

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
pub struct Fed<'a>(pub &'a Cell<u32>);

impl Platform for Fed<'_> {
    fn feed_watchdog(&mut self) {
        self.0.set(self.0.get() + 1);
    }

    fn stack_used_bytes(&mut self) -> u32 {
        0
    }
}

/// Battery and charging contact of the simulated robot.
struct Supply<'a>(&'a Board);

impl PowerSupply for Supply<'_> {
    fn battery_v(&mut self) -> Option<f32> {
        self.0.with_simulation(|simulation| simulation.condition().battery_v)
    }

    fn is_charging(&mut self) -> bool {
        self.0.with_simulation(|simulation| simulation.condition().is_charging)
    }
}

/// What was said on a line, all of it whole.
pub fn frames(line: &RefCell<VecDeque<u8>>) -> Vec<Frame> {
    let mut decoder = Decoder::new();
    line.borrow_mut().drain(..).filter_map(|byte| decoder.push(byte)).map(|frame| frame.expect("undamaged")).collect()
}

/// The estimates among these frames.
pub fn estimates(said: &[Frame]) -> impl DoubleEndedIterator<Item = &Estimate> {
    said.iter().filter_map(|frame| if let Frame::Estimate(estimate) = frame { Some(estimate) } else { None })
}

/// The last estimate of the pose among these frames.
pub fn estimate(said: &[Frame]) -> Pose2 {
    let [x_m, y_m, theta_rad] = estimates(said).next_back().expect("estimates are told").pose.map(f64::from);
    Pose2::new(x_m, y_m, theta_rad)
}

/// What these frames say last of the robot's place.
pub fn place(said: &[Frame]) -> Option<Place> {
    said.iter().rev().find_map(|frame| if let Frame::Place(place) = frame { Some(*place) } else { None })
}

/// What they say last of its floor.
pub fn floor(said: &[Frame]) -> Option<Floor> {
    said.iter().rev().find_map(|frame| if let Frame::Floor(floor) = frame { Some(*floor) } else { None })
}

/// Steps of the clock, milliseconds.
const STEP_MS: u64 = 2;

/// A robot in a home, and the lines to it.
pub struct Home {
    pub board: Board,
    pub shared: Shared,
    pub look_backs: LookBacks,
    /// The flash that the map is kept in.
    pub flash: RefCell<Nor>,
    /// Its backup RAM: the floor, and the last pose.
    pub backup: RefCell<[u8; FLOOR_RECORD_BYTES]>,
    pub pose_backup: RefCell<[u8; POSE_RECORD_BYTES]>,
    /// The motor driver's enable input, which the simulated board does not have.
    pub enabled: Cell<bool>,
    /// How often the watchdog was fed.
    pub fed: Cell<u32>,
    up: RefCell<VecDeque<u8>>,
    down: RefCell<VecDeque<u8>>,
}

impl Home {
    /// A built-in robot in a built-in home.
    pub fn new(plan: &str, robot: BuiltIn) -> Self {
        Self::of(&plan_file::load(plan).unwrap(), robot, SimOptions::default())
    }

    /// A built-in robot in a home.
    pub fn of(plan: &Plan, robot: BuiltIn, options: SimOptions) -> Self {
        let simulation = Simulation::new(plan, &robot.rig(), options, 3).unwrap();
        Self {
            board: Board::new(simulation),
            shared: Shared::new(),
            look_backs: LookBacks::new(),
            flash: RefCell::new(Nor::new()),
            backup: RefCell::new([0; FLOOR_RECORD_BYTES]),
            pose_backup: RefCell::new([0; POSE_RECORD_BYTES]),
            enabled: Cell::new(false),
            fed: Cell::new(0),
            up: RefCell::default(),
            down: RefCell::default(),
        }
    }

    /// Runs every task with these range sensors while `story` tells what happens.
    pub fn run(&self, robot: BuiltIn, mut bank: impl RangeSensorBank<SENSORS>, story: impl FnOnce(&mut Tasks<'_>)) {
        let shared = &self.shared;
        let config = Config::for_rig::<SENSORS>(&robot.rig()).with_hand_overs();
        self.look_backs.give_back(Box::leak(Box::new(RobotBackEnd::IDLE)));
        let mut slam = RobotSlam::with_config(robot.rig(), config).unwrap();
        let mut flash = self.flash.borrow_mut();
        let mut backup = self.backup.borrow_mut();
        let mut pose_backup = self.pose_backup.borrow_mut();
        let mut keeper = Keeper::start(&mut *flash, &slam);
        let mut job = Job::idle();
        job.explore(&robot.rig());
        job.pause();
        let (mut encoders, mut motors, pins) = (self.board.encoders(), self.board.motors(), self.board.contacts());
        let inputs = ContactPins {
            bump_left: Input(pins.bump_left),
            bump_right: Input(pins.bump_right),
            cliff: Input(pins.cliff),
            lifted: Input(pins.lifted),
        };
        let (mut enable, mut platform) = (Wire(&self.enabled), Fed(&self.fed));
        let (mut transmitter, mut receiver) = (Line(&self.up), Line(&self.down));
        let control = WheelControl::new(WheelControlConfig::default());
        let mut supply = Supply(&self.board);
        let sensing = join(tasks::odometry(&mut encoders, shared), tasks::sample(&mut bank, shared));
        let all = join4(
            sensing,
            join(
                tasks::estimate(&mut slam, &mut keeper, config, shared, &self.look_backs, &mut *pose_backup),
                tasks::drive(&mut job, robot, control, &mut motors, &mut supply, &mut *backup, shared),
            ),
            tasks::look_back(&self.look_backs),
            join4(
                tasks::guard(inputs, &mut enable, shared),
                tasks::telemetry(&mut transmitter, shared),
                tasks::commands(&mut receiver, shared),
                tasks::supervise(&mut platform, shared),
            ),
        );
        story(&mut Tasks { all: pin!(async { _ = all.await }), home: self });
    }

    /// Whether the newest map that is kept has a dock where its first drive started.
    pub fn kept_map_has_dock(&self) -> bool {
        let mut flash = self.flash.borrow_mut();
        let newest = Store::new(&mut *flash, SLOT_BYTES).newest().expect("a map is kept");
        let flash = &mut *flash;
        let record = &flash.bytes()[(newest.slot * SLOT_BYTES) as usize..];
        Record::whole(record).expect("a whole record").frame().has_dock
    }

    /// The same home, robot and flash after the power was off. What becomes of one is nothing to another.
    pub fn restarted(&self) -> Self {
        let Self { board, flash, backup, pose_backup, .. } = self;
        Self {
            board: Board::new(board.with_simulation(Simulation::clone)),
            flash: flash.clone(),
            backup: backup.clone(),
            pose_backup: pose_backup.clone(),
            shared: Shared::new(),
            look_backs: LookBacks::new(),
            enabled: Cell::new(false),
            fed: Cell::new(0),
            up: RefCell::default(),
            down: RefCell::default(),
        }
    }

    /// The true pose.
    pub fn truth(&self) -> Pose2 {
        self.board.with_simulation(|simulation| simulation.pose())
    }

    /// How far the last of the estimates among these frames is from the true position, metres.
    pub fn error_m(&self, said: &[Frame]) -> f64 {
        let (estimate, truth) = (estimate(said), self.truth());
        (estimate.x_m - truth.x_m).hypot(estimate.y_m - truth.y_m)
    }

    /// Puts bytes onto the line to the robot.
    pub fn say(&self, bytes: &[u8]) {
        self.down.borrow_mut().extend(bytes);
    }

    /// Tells the robot what to do.
    pub fn command(&self, command: Command) {
        self.say(&encode(&Frame::Command(command)).unwrap());
    }

    /// What the robot said since the last call.
    pub fn heard(&self) -> Vec<Frame> {
        frames(&self.up)
    }
}

/// The tasks at work.
pub struct Tasks<'a> {
    all: Pin<&'a mut dyn Future<Output = ()>>,
    home: &'a Home,
}

impl Tasks<'_> {
    /// Lets simulated time pass. The tasks are polled until they can have nothing left to do.
    pub fn drive(&mut self, seconds: f64) {
        let mut context = Context::from_waker(Waker::noop());
        for _ in 0..(seconds * 1000.0) as u64 / STEP_MS {
            self.home.board.advance(STEP_MS as f64 * 1e-3);
            MockDriver::get().advance(Duration::from_millis(STEP_MS));
            for _ in 0..12 {
                assert!(self.all.as_mut().poll(&mut context).is_pending(), "no task ends");
            }
        }
    }
}
