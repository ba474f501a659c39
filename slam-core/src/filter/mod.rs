//! The extended Kalman filter: a mean, a covariance, and which state stands where.

pub mod covariance;
pub mod ekf;
pub mod jacobian;
pub mod layout;
