//! Angles, poses and lines in the plane. Knows nothing of robots.

pub mod angle;
pub mod line;
pub mod matrix;
pub mod pose;
