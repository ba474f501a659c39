//! From a range sensor's input to a reading, and what is known of the errors of readings.

pub mod correlation;
pub mod latency;
pub mod noise_level;
pub mod range;
