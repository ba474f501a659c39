//! The clock is the processor's own and runs on while tasks work: what is late here is late on a robot, too.
//!
//! Priorities are the robot's: the beat of the clock, with the exchange with the host, above all; below it the tasks, in an
//! interrupt; below them, in thread mode, the back end.

mod clock;
mod executor;

pub use executor::run;
