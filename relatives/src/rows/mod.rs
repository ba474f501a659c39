//! The systems.

pub mod line_ekf;
pub mod reckoning;
