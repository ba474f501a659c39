//! The workbench: runs the estimator over simulated drives and recorded logs, scores it and writes what it found.
//!
//! Rows of a [`log`] (or of a simulated drive) go through a [`session`], which keeps a [`recording`]; [`score`] compares
//! it with what is true, [`hindsight`] places path and map once more when all is known, [`report`] draws it and [`output`]
//! writes it. [`run`], [`replay`], [`compare`], [`hil`], [`monitor`], [`doctor`]
//! and [`experiment`] are the commands of [`cli`], each its own use of these parts.
//!
//! One rule: the truth scores an estimate and never reaches it. Here, on a desk, numbers are f64; what goes into the
//! estimator and comes out of it is its own f32, unrounded.
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod cli;
pub mod compare;
pub mod doctor;
pub mod drive;
pub mod error;
pub mod experiment;
pub mod hil;
pub mod hindsight;
pub mod log;
pub mod monitor;
pub mod output;
pub mod part;
pub mod port;
pub mod recording;
pub mod replay;
pub mod report;
pub mod rig_file;
pub mod run;
pub mod score;
pub mod session;
pub mod text_file;
pub mod toml_table;
pub mod variant;
