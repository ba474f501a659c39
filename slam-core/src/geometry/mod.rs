//! Angles, poses and lines in the plane. Knows nothing of robots.

pub mod angle;
pub mod line;
pub mod pose;
