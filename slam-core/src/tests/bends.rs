//! Walls that bend: what their readings are worth.

use std::vec::Vec;

use super::random::Random;
use crate::sensing::bend::Bends;

const WALL: u16 = 3;
/// Variance that one correction of the heading takes away, rad^2.
const TAKEN_RAD2: f32 = 1e-4;

/// Corrections of two readings every 0.28 m, of which each is `bias` sigma too large: what the wall's readings are believed to be off by,
/// row by row.
fn excesses(bias: f64, rows: usize, seed: u64) -> Vec<f32> {
    let (mut random, mut bends) = (Random::new(seed), Bends::NONE);
    (0..rows)
        .map(|row| {
            for _ in 0..2 {
                let turned_rad = TAKEN_RAD2.sqrt() * (bias + random.gaussian()) as f32;
                bends.note(WALL, 0.28 * row as f32, turned_rad, TAKEN_RAD2);
            }
            bends.excess(WALL)
        })
        .collect()
}

#[test]
fn a_straight_wall_is_believed() {
    let mean = (1..=50).map(|seed| excesses(0.0, 200, seed).iter().sum::<f32>() / 200.0).sum::<f32>() / 50.0;
    // The square is a chi-square variable with one degree of freedom: the larger of one and the mean of one and that is 1.24 on average.
    assert!((1.15..1.35).contains(&mean), "{mean}");
}

#[test]
fn a_wall_whose_corrections_go_one_way_counts_for_less() {
    let mut last: Vec<f32> = (1..=50).map(|seed| *excesses(0.5, 60, seed).last().unwrap()).collect();
    last.sort_by(f32::total_cmp);
    assert!(last[25] > 3.0, "{}", last[25]);
    let mut bends = Bends::NONE;
    bends.note(WALL, 0.0, 0.1, TAKEN_RAD2);
    assert_eq!(bends.excess(WALL).round(), 51.0, "the square is a hundred times what is expected");
    assert_eq!(bends.excess(WALL + 1), 1.0, "another wall is none of it");
    // Ten metres on, what is new counts most.
    let mut later = bends;
    later.note(WALL, 10.0, 0.0, TAKEN_RAD2);
    assert!(later.excess(WALL) < 1.5, "{}", later.excess(WALL));
    // As many other walls leave no room for it.
    for other in 0..6 {
        bends.note(10 + other, 10.0, 0.0, TAKEN_RAD2);
    }
    assert_eq!(bends.excess(WALL), 1.0);
    assert_eq!(Bends::NONE.excess(0), 1.0, "nothing was met");
}
