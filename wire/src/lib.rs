//! What robot and workbench say to each other over a serial line.
//!
//! A [`Frame`] goes out as COBS(version byte, postcard, CRC-32) and a zero byte. [`encode`] makes those bytes;
//! a [`Decoder`] finds frames in a stream that may start anywhere and may be damaged: a frame arrives whole or is
//! counted as an error, and the next zero byte starts afresh.
//!
//! | direction | frames |
//! |---|---|
//! | robot to host | [`Frame::Sample`], [`Frame::Estimate`], [`Frame::Wall`], [`Frame::Calibration`], [`Frame::Faults`], [`Frame::LookBack`], [`Frame::Place`], [`Frame::MapAnswer`], [`Frame::Floor`], [`Frame::Frozen`] |
//! | host to robot | [`Frame::Command`], [`Frame::MapRequest`] |
//! | with the robot's hardware simulated | [`Frame::Sample`] to the robot, [`Frame::Motors`] back |
#![no_std]
#![forbid(unsafe_code)]

mod codec;
mod convert;
mod frames;
mod map;

pub use codec::{DecodeError, Decoder, EncodeError, FRAME_CAPACITY, ToRobot, VERSION, encode};
pub use frames::{
    BoardFaults, Calibration, Command, Contacts, Estimate, Factor, Faults, Floor, Frame, Frozen, Health, LookBack,
    Motors, Parameter, Place, PlaceState, Range, SENSORS, Sample, SlamFaults, Wall, WallKind,
};
pub use map::{MapAnswer, MapRefusal, MapRequest, PIECE_BYTES, Piece};

/// The examples of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
