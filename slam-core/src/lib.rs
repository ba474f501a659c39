#![doc = include_str!("../README.md")]
//!
//! # How it works
//!
//! [`Slam::step`] takes what the robot sensed since the last step (encoder ticks or a dead-reckoned increment, and one reading
//! per range sensor) and keeps a pose, a map of walls, the direction of the home's wall grid and the calibration of the robot's
//! own sensors in one extended Kalman filter.
//!
//! Layers, in the order in which the data flow; none reaches back:
//!
//! | layer | what it makes |
//! |---|---|
//! | [`sample`], [`rig`] | what was sensed, and what by |
//! | `geometry` | angles, poses, lines |
//! | `filter` | the state: predict, update, add, remove ([`ekf`], [`covariance`]); which state stands where |
//! | `motion` | checked travel, and the step that it makes, with its noise (Rousse & Qiu 3.1) |
//! | `sensing` | checked readings, and what is known of their errors; what cannot be is refused here and counted |
//! | `walls` | the walls, the grid that they stand on, the map frame that they hold (Rousse & Qiu 3.2) |
//! | `measurement` | which wall a reading came from, and what it should have been (Rousse & Qiu eqs. 1, 3, 5) |
//! | `births` | new walls from the readings that fit none (Rousse & Qiu 3.3) |
//! | `holds` | robots that stay where they are while their wheels turn, from their readings |
//! | `jolts` | displacements of the robot that its wheels do not tell, from its readings |
//! | [`report`], [`WallView`] | what became of each reading, and what is known |
//! | [`hand_over`] | what a look back found, taken over ([`Slam::take_over`]) |
//!
//! One rule: the crate is pure. Time and samples are arguments; there is no clock, no randomness, no hardware, no heap and
//! no panic.
//!
//! Rousse & Qiu is P. Rousse and J. Qiu, *Simultaneous Localization And Mapping in a domestic environment*;
//! `docs/explanation/estimator.md` says where this estimator goes beyond it.
//!
//! Frames: *map* is the robot's start pose (origin at the wheel axle's centre, x forward, y left, theta
//! counter-clockwise), until walls hold it ([`MapFrame`]); *robot* is the same, moving with the robot. Units are metres, radians, seconds and volts.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod births;
mod clock;
pub mod config;
mod counted;
mod displacement;
mod dock;
mod extended;
mod filter;
mod frozen_sensors;
mod geometry;
pub mod hand_over;
mod health;
mod holds;
mod jolts;
pub mod kept;
mod measurement;
mod motion;
pub mod report;
mod restart;

pub mod rig;
pub mod sample;
mod second_copy;
mod sensing;
mod slam;
mod take_over;
mod take_up;
#[cfg(test)]
mod tests;
mod view;
mod walls;

/// What every estimator on these rigs begins with, for those that are compared with this one: checked readings, and motion by
/// the rig's nominal calibration.
pub mod front_end {
    pub use crate::motion::step::{Factor, Factors, Step, step};
    pub use crate::motion::travel::{Encoders, Travel};
    pub use crate::sensing::output_noise::OutputNoise;
    pub use crate::sensing::range::{FrontEnd, Innovation, Noise, Reading, SHARP_HOLD_S};
}

pub use births::BirthSettings;
pub use births::cluster::Clustering;
pub use births::dbscan;
pub use config::Config;
pub use filter::{covariance, ekf};
pub use geometry::pose::Pose;
pub use geometry::{angle, pose};
pub use hand_over::{Calibration, HandOver, PlacedWall};
pub use health::{CONTRADICTED_M, Elsewhere};
pub use jolts::search::{JOLT, are_apart};
pub use measurement::MeasurementSettings;
pub use measurement::first_estimates::Linearisation;
pub use motion::step::{SLIP_M2_PER_RAD, SLIP_RUNS};
pub use motion::{MotionSettings, Slip};
pub use report::{Counters, Health, NotTaken, Outcome, ReadingReport, Refusal, StepReport};
pub use rig::{Adc, DriveModel, Mount, RangeModel, RangeSensor, Rig, RigError, VEER_SIGMA};
pub use sample::{Increment, Motion, RangeInput, Sample, Ticks};
pub use second_copy::SecondCopy;
pub use sensing::SensingSettings;
pub use sensing::range::SURFACE_M;
pub use slam::{HostSlam, RobotSlam, Slam, states};
pub use take_up::{Match, Unfit};
pub use view::{Estimate, Parameter, Standing, WallView};
pub use walls::decision::{BUILT_TOLERANCE, DECISION, GRID_SHARE, LOOSE_RAD};
pub use walls::map::{Displaced, MapFrame};
pub use walls::wall::{WallKind, WallPolicy};
pub use walls::{BUILT_RELIEF_M, WallSettings};
