//! An outlier to start from.

use crate::births::buffer::Outlier;

/// Seen by sensor 0 from 1 m, straight along x, 1 cm of noise, no error of the odometry.
pub const OUTLIER: Outlier = Outlier {
    sensor: 0,
    hit_m: [0.0; 2],
    direction: [1.0, 0.0],
    by_factor: [[0.0; 2]; 3],
    by_latency: [0.0; 2],
    range_m: 1.0,
    sigma_m: 0.01,
    step: 0,
    sweep_m: 0.0,
    position_variance: 0.0,
    heading_variance: 0.0,
};
