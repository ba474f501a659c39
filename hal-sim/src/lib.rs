//! A simulated robot board and home.
//!
//! [`Plan`] is the home, [`Simulation`] the robot in it: wheel speeds in, [`Sample`](slam_core::Sample)s out, and the
//! truth beside them. Everything random follows from one seed, bit for bit and on every machine: own random streams,
//! `libm` for every transcendental function.
//!
//! ```
//! use hal_sim::{ClosedLoop, Estimate, SimOptions, Simulation, default_rig, plan_file};
//! use slam_core::{Config, HostSlam};
//!
//! let plan = plan_file::load("flat")?;
//! let rig = default_rig();
//! let simulation = Simulation::new(&plan, &rig, SimOptions::default(), 1)?;
//! let mut slam = HostSlam::with_config(rig.clone(), Config::default()).expect("a rig that can be");
//! let mut robot = ClosedLoop::new(simulation, &rig, robot::PilotConfig::default());
//! // Record once; feed the samples to as many estimators as you like.
//! let frames = robot.record(5.0, &mut |sample| {
//!     let report = slam.step(sample);
//!     Estimate::new(slam.pose(), &report)
//! });
//! assert_eq!(frames.len(), 126);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

pub mod board;
mod body;
mod closed_loop;
pub mod coverage;
pub mod fault;
pub mod floor;
mod history;
mod inside;
pub mod mishap;
mod odometer;
pub mod options;
pub mod plan;
pub mod plan_file;
pub mod pose;
pub mod random_home;
pub mod rig;
pub mod rng;
pub mod scanner;
mod sensor;
pub mod sharp;
mod sim_error;
mod simulation;
mod supply;
pub mod world;

pub use board::Board;
pub use body::TrueDrive;
pub use closed_loop::{ClosedLoop, Estimate, Frame, nominal_ranges};
pub use coverage::{Coverage, SeenWall};
pub use mishap::Mishaps;
pub use options::{Age, DriveOptions, SharpOptions, SimOptions};
pub use plan::{Face, Plan};
pub use pose::Pose2;
pub use rig::{default_rig, default_rig_with, measured_rig, odometry_rig, short_rig};
pub use sim_error::SimError;
pub use simulation::{MAX_SENSORS, Simulation, TrueCalibration};
