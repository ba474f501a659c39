//! The workbench: runs the estimator over simulated drives and recorded logs, scores it and writes what it found.
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod recording;
