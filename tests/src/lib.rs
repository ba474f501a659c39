//! Cross-crate tests live in `tests/`; here is what several of them share.

pub mod browser;
pub mod sample_recording;
