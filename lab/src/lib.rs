//! The workbench: runs the estimator over simulated drives and recorded logs, scores it and writes what it found.
//!
//! Rows of a [`log`] (or of a simulated drive) go through a [`session`], which keeps a [`recording`]; [`score`] compares
//! it with what is true and [`output`] writes it.
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod cli;
pub mod doctor;
pub mod drive;
pub mod error;
pub mod experiment;
pub mod hil;
pub mod log;
pub mod monitor;
pub mod output;
pub mod port;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rig_file;
pub mod run;
pub mod score;
pub mod session;
pub mod toml_table;
pub mod variant;
