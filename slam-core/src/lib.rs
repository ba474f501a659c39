//! EKF-SLAM for robots with a few infrared range sensors.
//!
//! Samples in, estimate out: [`Slam::step`] takes what the robot sensed since the last step (encoder ticks or a
//! dead-reckoned increment, and one reading per range sensor) and keeps a pose, a map of walls, the direction of the
//! home's wall grid and the calibration of the robot's own sensors in one extended Kalman filter.
//!
//! Frames: *map* is the robot's start pose (origin at the wheel axle's centre, x forward, y left, theta
//! counter-clockwise); *robot* is the same, moving with the robot. Units are metres, radians, seconds and volts.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

pub mod angle;
mod association;
mod beam;
mod birth;
mod buffer;
mod cluster;
pub mod config;
pub mod covariance;
pub mod dbscan;
pub mod ekf;
mod extend;
mod grid;
mod layout;
mod line_fit;
mod map;
mod motion;
mod observe;
mod odometry;
pub mod pose;
mod range;
pub mod report;
pub mod rig;
pub mod sample;
mod slam;
#[cfg(test)]
mod tests;
mod view;
mod wall;

pub use config::{Clustering, Config, WallPolicy};
pub use pose::Pose;
pub use report::{Counters, Outcome, ReadingReport, Refusal, StepReport};
pub use rig::{Adc, DriveModel, Mount, RangeModel, RangeSensor, Rig, RigError};
pub use sample::{Increment, Motion, RangeInput, Sample, Ticks};
pub use slam::{HostSlam, RobotSlam, Slam};
pub use view::{Parameter, WallView};
pub use wall::WallKind;
