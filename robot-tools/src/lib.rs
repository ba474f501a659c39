//! Tools that talk to a robot, or to its firmware: [`hil`] drives the firmware in the loop with the simulated home,
//! [`monitor`] shows and records what a robot says, [`relay`] lets the studio take part in its line, [`doctor`] checks it part by
//! part, [`stop`] has it stand, [`kept_map`] fetches its map, stores and forgets it. Without the feature `desk` there is what needs no port, file or
//! socket: the studio has that, too.

#![forbid(unsafe_code)]

pub mod doctor;
#[cfg(feature = "desk")]
pub mod hil;
pub mod kept_map;
#[cfg(feature = "desk")]
pub mod monitor;
#[cfg(feature = "desk")]
pub mod port;
#[cfg(feature = "desk")]
pub mod relay;
#[cfg(feature = "desk")]
pub mod stop;
