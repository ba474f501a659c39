//! What goes in: logs, rig files, settings of the estimator.

mod built_in;
pub mod log;
pub mod part;
pub mod rig_file;
pub mod settings;

pub use built_in::{built_in, built_in_robot, robot};
