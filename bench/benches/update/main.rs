//! One scalar update, gain and downdate, of n states on the host: microseconds, and each filter's over ours.
//!
//! Run with `cargo bench --package bench`.

mod others;

use nalgebra::{SMatrix, SVector};
use slam_core::ekf::{Ekf, Jacobian, storage};
use std::hint::black_box;
use std::time::Instant;

/// Timed runs of each filter; the fastest counts, being the least disturbed.
const RUNS: usize = 7;

/// Rows of one state length.
macro_rules! rows {
    ($n:literal, $module:ident) => {
        let ours = microseconds(20_000, slam_core::<$n, { storage($n) }>());
        let repeats = (20_000_000 / ($n * $n * $n)).max(20);
        println!("| {} | slam-core | {ours:.2} | 1 |", $n);
        for (name, us) in [
            ("nalgebra ger", microseconds(20_000, nalgebra_ger::<$n>())),
            ("nalgebra, textbook", microseconds(repeats, nalgebra_textbook::<$n>())),
            ("minikalman", microseconds(repeats, others::$module::minikalman())),
            ("kfilter", microseconds(repeats, others::$module::kfilter())),
            ("adskalman", microseconds(repeats, others::$module::adskalman())),
        ] {
            println!("| {} | {name} | {us:.2} | {:.1} |", $n, us / ours);
        }
    };
}

fn main() {
    println!("| n | filter | us per update | over slam-core |\n|---|---|---|---|");
    rows!(20, n20);
    rows!(36, n36);
    rows!(68, n68);
    rows!(132, n132);
}

/// The fastest run's time for one call.
fn microseconds(calls: usize, mut call: impl FnMut()) -> f64 {
    let run = |_| {
        let start = Instant::now();
        (0..calls).for_each(|_| call());
        start.elapsed().as_secs_f64() * 1e6 / calls as f64
    };
    (0..RUNS).map(run).fold(f64::INFINITY, f64::min)
}

/// The row of a reading of a grid wall: pose, grid direction, the sensor's gain, the wall's distance.
fn reading(n: usize) -> [(usize, f32); 6] {
    [(0, -1.0), (1, 0.1), (2, 0.3), (3, 0.2), (9, 1.0), (n - 1, 1.0)]
}

/// So large that the covariance stays as it is over any number of updates.
const NOISE: f32 = 1e6;

fn slam_core<const N: usize, const ROWS: usize>() -> impl FnMut() {
    let mut ekf = Box::new(Ekf::<ROWS>::EMPTY);
    for i in 0..N {
        let jacobian: Jacobian = (i > 0).then_some((0, 0.1)).into_iter().collect();
        ekf.augment(0.0, &jacobian, 1.0);
    }
    let jacobian: Jacobian = reading(N).into_iter().collect();
    move || ekf.update(black_box(0.01), black_box(&jacobian), black_box(NOISE)).expect("a regular update")
}

/// A covariance like that of `slam_core`, dense.
fn covariance<const N: usize>() -> SMatrix<f32, N, N> {
    SMatrix::from_fn(|i, j| if i == j { 1.0 } else { 0.01 })
}

/// Six columns, then `ger` on the full square matrix.
fn nalgebra_ger<const N: usize>() -> impl FnMut() {
    let (mut x, mut p) = (SVector::<f32, N>::zeros(), Box::new(covariance::<N>()));
    move || {
        let h = black_box(reading(N));
        let mut g = SVector::<f32, N>::zeros();
        h.iter().for_each(|&(i, d)| g.axpy(d, &p.column(i), 1.0));
        let variance = h.iter().fold(black_box(NOISE), |sum, &(i, d)| sum + d * g[i]);
        x.axpy(black_box(0.01) / variance, &g, 1.0);
        p.ger(-1.0 / variance, &g, &g, 1.0);
    }
}

/// P = (I - K H) P with a dense H.
fn nalgebra_textbook<const N: usize>() -> impl FnMut() {
    let (mut x, mut p) = (SVector::<f32, N>::zeros(), Box::new(covariance::<N>()));
    let mut h = SMatrix::<f32, 1, N>::zeros();
    reading(N).iter().for_each(|&(i, d)| h[i] = d);
    move || {
        let pht = *p * h.transpose();
        let variance = (h * pht)[0] + black_box(NOISE);
        let k = pht / variance;
        x += k * black_box(0.01);
        *p = (SMatrix::<f32, N, N>::identity() - k * h) * *p;
    }
}
