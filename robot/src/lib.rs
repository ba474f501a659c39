//! What a small robot is, for firmware and simulator alike.
//!
//! [`traits`] says what a board offers: a bank of range sensors, two wheel encoders, two motors, a bumper and a cliff
//! sensor. [`h_bridge`] drives motors through `embedded-hal` outputs, [`wheel_control`] holds a wheel speed, [`contact`]
//! stops the wheels without waiting for anyone, [`condition`] knows battery, charger and stalled wheels, [`pilot`] and [`floor`] decide where to go, one of them at a time ([`job`]). [`rig`] is the robot as built.
//!
//! One rule: nothing here knows the true pose or the true walls. Lengths are metres, angles radians, times seconds
//! unless a name says otherwise; the robot's frame has its origin at the wheel axle's centre, x forward, y left.
#![no_std]
#![forbid(unsafe_code)]

mod bearings;
pub mod condition;
pub mod contact;
pub mod floor;
pub mod h_bridge;
mod in_turn;
pub mod job;
mod last_pose;
pub mod pilot;
pub mod rig;
pub mod traits;
pub mod wheel_control;
#[cfg(test)]
mod wild;

pub use condition::{Condition, NoSupply, PowerSupply, StallWatch};
pub use contact::{ContactPins, Contacts, Debounce, Lift};
pub use floor::{
    AreaKind, Bounds, FLOOR_RECORD_BYTES, FloorConfig, FloorJob, FloorProgress, FloorRecordError, FloorState,
};
pub use h_bridge::{HBridge, HBridgeError, MotorPair};
pub use job::{AreaCorner, Job, Whereabouts};
pub use last_pose::{COASTS_M, COASTS_RAD, POSE_RECORD_BYTES, PoseNotes, last_pose, read_last_pose};
pub use pilot::{Activity, Pilot, PilotConfig, Senses};
pub use traits::{
    DriveMotors, Duty, LastingMemory, MetricSensor, RangeSensorBank, WheelCounter, WheelEncoders, WheelSpeeds,
};
pub use wheel_control::{WheelControl, WheelControlConfig};

/// The examples of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
