//! From ticks or dead-reckoned increments to the predicted pose (report 3.1).

pub mod dead_reckoning;
pub mod drive;
pub mod mean_motion;
pub mod step;
pub mod travel;
