//! Density-based clustering of a full outlier buffer, for three kinds of contents.

use core::hint::black_box;
use instruction_count::Bench;
use slam_core::dbscan::dbscan;

/// Points in a full buffer.
const POINTS: usize = 128;
/// Neighbourhood of points that eight sensors left on walls, metres.
const EPSILON_M: f32 = 0.15;
/// Fewest points of a core point's neighbourhood.
const MIN_POINTS: usize = 4;

/// Clutter over a room's width, two walls at a corner, and everything in one heap.
pub fn run(bench: &Bench) {
    let scattered = |i: u32, side_m: f32| side_m * (i.wrapping_mul(2_654_435_761) >> 16) as f32 * (1.0 / 65_536.0);
    case(bench, "dbscan_clutter", |i| [scattered(i, 2.0), scattered(i + 1_000, 2.0)]);
    case(bench, "dbscan_corner", |i| {
        let along_m = (i / 2) as f32 * 0.03;
        let off_m = scattered(i, 0.04);
        if i % 2 == 0 { [along_m, off_m] } else { [off_m, along_m] }
    });
    case(bench, "dbscan_heap", |i| [scattered(i, 0.1), scattered(i + 1_000, 0.1)]);
}

fn case(bench: &Bench, name: &str, point: impl Fn(u32) -> [f32; 2]) {
    let mut points = [[0.0; 2]; POINTS];
    for (i, p) in (0..).zip(&mut points) {
        *p = point(i);
    }
    bench.case(name, || dbscan::<POINTS>(black_box(&points), black_box(EPSILON_M), black_box(MIN_POINTS)));
}
