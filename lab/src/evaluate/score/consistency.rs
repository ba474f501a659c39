//! How well a map agrees with itself: scores that need no truth.
//!
//! Every reading's end point is taken as the estimator reports it, and as dead reckoning places it. Where the path is
//! right, points of one wall fall on one line, however often the robot came by.

use super::hits;
use super::{entropy, passes, surfels};
use crate::recording::{Consistency, Recording, SeenWall};

/// Scores the record's map against itself; none where there are no readings.
pub fn score(recording: &Recording) -> Option<Consistency> {
    let (estimate, odometry) = (hits::by_estimate(recording), hits::by_dead_reckoning(recording));
    let (entropy_nats, odometry_entropy_nats) = (entropy::mean_nats(&estimate)?, entropy::mean_nats(&odometry)?);
    let walls = passes::walls_seen(recording);
    let seen_again = || walls.iter().filter(|wall| wall.gap_m.is_some());
    let gaps_m: Vec<f64> = seen_again().filter_map(|wall| wall.gap_m).collect();
    let rms = |values: &dyn Fn(&SeenWall) -> Option<f64>| root_mean_square(seen_again().filter_map(values));
    Some(Consistency {
        entropy_nats,
        odometry_entropy_nats,
        revisited: gaps_m.len(),
        widest_gap_m: gaps_m.iter().copied().max_by(f64::total_cmp),
        mean_gap_m: (!gaps_m.is_empty()).then(|| gaps_m.iter().sum::<f64>() / gaps_m.len() as f64),
        thickness_m: rms(&|wall| Some(wall.thickness_m)),
        closure_m: rms(&|wall| wall.closure_m),
        odometry_closure_m: rms(&|wall| wall.odometry_closure_m),
        surfels: surfels::score(recording, &estimate),
        odometry_surfels: surfels::score(recording, &odometry),
        walls,
    })
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0), |(sum, n), value| (sum + value * value, n + 1));
    (n > 0).then(|| (sum / f64::from(n)).sqrt())
}
