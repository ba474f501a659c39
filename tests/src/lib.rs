//! Cross-crate tests live in `tests/`; here is what several of them share.

#![forbid(unsafe_code)]

pub mod browser;
pub mod carries;
pub mod crowds;
pub mod devtools;
pub mod drawn_robots;
pub mod frames;
pub mod fuzzing;
pub mod long_drive;
pub mod mishaps;
pub mod positivity;
pub mod real_logs;
pub mod report;
pub mod sample_recording;
pub mod sanity;
pub mod simulated;
pub mod snapshot;
pub mod trial;
