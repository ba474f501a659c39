//! The systems.

pub mod line_ekf;
pub mod ortho;
pub mod particles;
pub mod psm_slam;
pub mod range_hough;
pub mod reckoning;
pub mod sonar_ekf;
pub mod sparse_gslam;
