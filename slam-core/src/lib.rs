//! EKF-SLAM for robots with a few infrared range sensors.
//!
//! Samples in, estimate out: [`Slam::step`] takes what the robot sensed since the last step (encoder ticks or a
//! dead-reckoned increment, and one reading per range sensor) and keeps a pose, a map of walls, the direction of the
//! home's wall grid and the calibration of the robot's own sensors in one extended Kalman filter.
//!
//! Layers, in the order in which the data flow; none reaches back:
//!
//! | layer | what it makes |
//! |---|---|
//! | [`sample`], [`rig`] | what was sensed, and what by |
//! | motion, pace, range | checked travel and readings, with their noise; what cannot be is refused here and counted |
//! | beam, association, clutter, repeats, noise level, latency, linearise, observe | which wall a reading came from, and what it should have been |
//! | [`ekf`], [`covariance`] | the state: predict, update, add, remove; knows nothing of robots and walls |
//! | buffer, cluster, line fit, verdict, birth | new walls from the readings that fit none |
//! | grid, map | the home's directions; walls merged and removed |
//! | [`report`], [`WallView`] | what became of each reading, and what is known |
//!
//! One rule: the crate is pure. Time and samples are arguments; there is no clock, no randomness, no hardware, no heap and
//! no panic.
//!
//! "The report" in the comments is P. Rousse and J. Qiu, *Simultaneous Localization And Mapping in a domestic
//! environment*; `docs/estimator.md` says where this estimator goes beyond it.
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
mod clutter;
pub mod config;
pub mod covariance;
pub mod dbscan;
pub mod ekf;
mod extend;
mod frame;
mod grid;
mod jacobian;
mod latency;
mod layout;
mod line_fit;
mod linearise;
mod map;
mod motion;
mod noise_level;
mod observe;
mod odometry;
mod pace;
pub mod pose;
mod range;
mod repeats;
pub mod report;
pub mod rig;
pub mod sample;
mod slam;
#[cfg(test)]
mod tests;
mod verdict;
mod view;
mod wall;

pub use config::{BUILT_RELIEF_M, Clustering, Config, Linearisation, MapFrame, WallPolicy};
pub use grid::BUILT_TOLERANCE;
pub use motion::{SLIP_M2_PER_RAD, SLIP_RUNS};
pub use pose::Pose;
pub use range::SURFACE_M;
pub use report::{Counters, Outcome, ReadingReport, Refusal, StepReport};
pub use rig::{Adc, DriveModel, Mount, RangeModel, RangeSensor, Rig, RigError};
pub use sample::{Increment, Motion, RangeInput, Sample, Ticks};
pub use slam::{HostSlam, RobotSlam, Slam};
pub use view::{Parameter, WallView};
pub use wall::WallKind;
