//! What is measured. A case's name appears in docs/results/timing.csv.

mod clusters;
mod drive;
mod filter;
mod home;

use core::hint::black_box;
use instruction_count::Bench;
use slam_core::angle;

/// Runs every case.
pub fn run(bench: &Bench) {
    bench.worst("sin_cos", 64, |call| angle::sin_cos(black_box(call as f32 * 0.1 - 3.2)));
    filter::run(bench);
    clusters::run(bench);
    drive::run(bench);
}
