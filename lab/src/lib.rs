//! The workbench: runs the estimator over simulated drives and recorded logs, scores it and writes what it found.
//!
//! The folders are what a user does: what goes in is read by [`input`]; [`run`] feeds it to the estimator, drive or log, and
//! keeps a [`recording`]; [`evaluate`] scores that, places path and map once more when all is known, and compares; [`show`]
//! draws and writes it. Arrows point one way: [`run`] uses all of them, [`show`] uses [`evaluate`], [`evaluate`] uses
//! [`input`], and each may use the [`recording`].
//!
//! One rule: the truth scores an estimate and never reaches it. Here, on a desk, numbers are f64; what goes into the
//! estimator and comes out of it is its own f32, unrounded.

#![forbid(unsafe_code)]

pub mod evaluate;
pub mod input;
pub mod numbers;
pub mod recording;
pub mod run;
pub mod show;

/// What `summary.json` calls this program.
pub const PROGRAM: &str = "wall-slam lab";
