//! Tools that talk to a robot, or to its firmware: [`hil`] drives the firmware in the loop with the simulated home,
//! [`monitor`] shows and records what a robot says, [`relay`] lets the studio take part in its line, [`doctor`] checks it part by
//! part.

pub mod doctor;
pub mod hil;
pub mod monitor;
pub mod port;
pub mod relay;
