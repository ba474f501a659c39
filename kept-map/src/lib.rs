//! The map that a robot keeps: what the filter knows, but for the pose, over power loss.
//!
//! | part | what it is |
//! |---|---|
//! | [`Writer`], [`Record`] | the record as words to write, and as bytes that were read and checked |
//! | [`Areas`] | what a user drew into it |
//! | [`Store`] | slots of NOR flash: the newest whole record counts, and a power cut leaves the old one or the new one |
//! | [`is_outgrown`] | when a robot that drives makes a stop to save |
//! | [`rig_hash`] | what says that a record was made by a robot like this one |
//!
//! One rule: a record exists whole or not at all. Its CRC is written last.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod areas;
mod growth;
mod receiving;
mod record;
mod refused;
mod rig_hash;
mod store;
#[cfg(test)]
mod tests;

pub use areas::{Areas, BadArea, Corner};
pub use growth::{WORTH_M, is_outgrown};
pub use receiving::{ReceiveError, Receiving};
pub use record::{Record, VERSION, Writer};
pub use refused::Refused;
pub use rig_hash::rig_hash;
pub use store::{SaveError, Saved, Saving, Store};
