//! Tests that need what is private to this crate: each formula against an independent derivation.
#![allow(clippy::needless_range_loop, reason = "a matrix is written with its indices")]

mod anchors;
mod angles;
mod beams;
mod births;
mod buffers;
mod clusters;
mod clutter;
mod covariances;
mod exactness;
mod filter;
mod frames;
mod grids;
mod healths;
mod jacobians;
mod lines;
mod motions;
mod noise_levels;
mod numeric;
mod odometries;
mod oracle;
mod outliers;
mod output_noises;
mod paces;
mod random;
mod ranges;
mod repeats;
mod rigs;
mod runs;
mod signs;
mod slippages;
mod stillness;
mod strides;
mod take_overs;
mod verdicts;
mod walls;
