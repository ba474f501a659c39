//! A robot whose samples come a few times a second: between two of them its wheels change their speeds, walls are seen
//! seldom, and the heading is known badly for long.

use std::ops::RangeInclusive;

use lab::evaluate::statistics::median;
use lab::recording::PathScore;
use slam_core::Config;
use tests::simulated::{estimated, rows};

const MINUTES: f64 = 4.0;

/// Scores of the drives of these seeds with one row of so many at 25 Hz: the estimate's and dead reckoning's.
fn scores(every: usize, seeds: RangeInclusive<u64>) -> Vec<(String, PathScore, PathScore)> {
    let mut scores = Vec::new();
    for plan in ["flat", "clutter"] {
        for seed in seeds.clone() {
            let rows: Vec<_> = rows(plan, MINUTES, seed).into_iter().step_by(every).collect();
            let figures = estimated(&rows, Config::default());
            let of = |score: Option<PathScore>| score.expect("a simulated drive has its truth");
            scores.push((format!("{plan} {seed}"), of(figures.estimate), of(figures.odometry)));
        }
    }
    scores
}

/// All but so many are twice as near to the truth as dead reckoning, and the error bars are honest.
fn assert_honest(every: usize, seeds: RangeInclusive<u64>, most_far: usize) {
    let scores = scores(every, seeds);
    let is_far = |(_, estimate, odometry): &&(String, PathScore, PathScore)| estimate.ate_m >= 0.5 * odometry.ate_m;
    let told = |(drive, estimate, odometry): &(String, PathScore, PathScore)| {
        format!("{drive}: {:.3} m, dead reckoning {:.3} m", estimate.ate_m, odometry.ate_m)
    };
    let far: Vec<_> = scores.iter().filter(is_far).map(told).collect();
    assert!(far.len() <= most_far, "every {every}th row, of {} drives: {far:?}", scores.len());
    let nees: Vec<f64> = scores.iter().filter_map(|(_, estimate, _)| estimate.nees).collect();
    println!("every {every}th row: {nees:?}");
    // 3 is ideal.
    let nees = median(&nees).expect("there are drives");
    assert!(nees < 6.0, "every {every}th row: median NEES {nees}");
}

#[test]
fn five_samples_a_second_are_enough() {
    // One ends 3.3 cm off in the flat, where dead reckoning is 6.1 by chance.
    assert_honest(5, 19..=66, 1);
}

#[test]
fn three_samples_a_second_are_enough() {
    // One in twenty-four: where dead reckoning is good by chance, or a door is met with the heading badly known.
    assert_honest(8, 19..=42, 2);
}
