//! The robot's program, apart from the peripherals: tasks that are generic over what a board offers.
//!
//! | task | waits for | does |
//! |---|---|---|
//! | [`tasks::odometry`] | 50 Hz | reads the encoders |
//! | [`tasks::sample`] | 25 Hz | reads the range sensors: counts ([`burst`]) or metres ([`metric`]) |
//! | [`tasks::estimate`] | ranges | one step of slam-core; tells the job and the telemetry; writes the diary, takes over what was found; keeps the map and the last pose, or finds itself in it ([`keeper`]) |
//! | [`tasks::look_back`] | the step | looks back on the drive, below every other task |
//! | [`tasks::drive`] | odometry | pilot or floor job, wheel-speed control, motors |
//! | [`tasks::guard`] | bumper and cliff inputs | stops the wheels at once, at interrupt level, waiting for nobody; and when drive is silent |
//! | [`tasks::telemetry`], [`tasks::commands`] | frames, bytes | the serial line |
//! | [`tasks::supervise`] | 2 Hz | feeds the watchdog when every task has reported |
//!
//! The binaries bind the tasks to peripherals (`robot`) or to a simulation at the other end of a link (`hil`); the host
//! runs the same bodies in tests. Tasks meet in [`Shared`] only.
#![no_std]
#![forbid(unsafe_code)]

pub mod burst;
pub mod faults;
pub mod look_backs;
pub mod metric;
pub mod periodic;
pub mod shared;
pub mod tasks;

pub use keeper::{self, Keeper};
pub use look_backs::LookBacks;
pub use shared::Shared;

/// Range sensors of the robot.
pub const SENSORS: usize = wire::SENSORS;
/// What the robot is at: it explores, or it cleans.
pub type Job = robot::Job<SENSORS>;
