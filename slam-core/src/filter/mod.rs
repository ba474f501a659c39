//! The extended Kalman filter: a mean, a covariance, which state stands where, and the normal density.

pub mod covariance;
pub mod density;
pub mod ekf;
pub mod jacobian;
pub mod layout;
