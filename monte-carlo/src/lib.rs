//! `lab experiment`: Monte Carlo over seeds, plans, settings and estimator variants.
//!
//! A [`file`](mod@file) says which [`plan`]s are driven under which [`setting`]s by which [`variant`]s. A [`unit`](mod@unit) of work is one
//! drive: it is simulated once, steered by the default estimator, and every variant gets its samples. The [`store`]
//! keeps a [`row`] of metrics for each variant of each drive, so that a run can be resumed and its parts merged;
//! [`table`]s, [`bar`]s, [`figures`] and the [`page`] are made from the rows alone.

#![forbid(unsafe_code)]

pub mod bar;
mod clock;
pub mod command;
pub mod figures;
pub mod file;
pub mod floor;
pub mod key;
mod keys;
pub mod page;
pub mod plan;
mod relative;
pub mod row;
pub mod runner;
pub mod samples;
pub mod senses;
pub mod sensor;
pub mod setting;
pub mod store;
pub mod table;
pub mod track;
pub mod unit;
pub mod variant;
