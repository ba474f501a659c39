//! The robot's kept map as a file, and back: [`errand`] says what is to be sent and what the answers mean, `lab map` does it
//! at a serial port.

#[cfg(feature = "desk")]
mod command;
pub mod errand;

#[cfg(feature = "desk")]
pub use command::MapArgs;
