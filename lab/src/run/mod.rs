//! The estimator at work: a [`Session`] is fed row by row, by a simulated [`Drive`] or by a log; [`Run`] and [`Replay`] do
//! that from input files to the output folder.

mod drive;
mod replay;
mod session;
mod simulate;

pub use drive::{Drive, pose2};
pub use replay::{Replay, Replayed};
pub use session::Session;
pub use simulate::Run;
