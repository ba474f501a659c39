//! Readings that repeat one another: what is learned of them, and what one of them counts.

use super::random::Random;
use crate::sensing::correlation::{Hit, SurfaceCorrelation};

const WALL: u16 = 3;
const SPACING_M: f32 = 0.05;

/// Innovations along a wall, a share of whose variance is the surface's, with a correlation length of a quarter metre.
fn along_a_wall(share: f64, sensors: usize) -> SurfaceCorrelation<2> {
    let mut random = Random::new(7);
    let mut repeats = SurfaceCorrelation::NEW;
    let keep = (-f64::from(SPACING_M) / 0.25).exp();
    let mut surface = [0.0, 0.0];
    for step in 1..4000 {
        for (sensor, surface) in surface.iter_mut().enumerate().take(sensors) {
            *surface = keep * *surface + (1.0 - keep * keep).sqrt() * random.gaussian();
            let normalised = share.sqrt() * *surface + (1.0 - share).sqrt() * random.gaussian();
            let along_m = SPACING_M * step as f32;
            repeats.note(sensor, Hit { wall: WALL, along_m, step, normalised: normalised as f32 });
        }
    }
    repeats
}

#[test]
fn the_surfaces_share_is_learned() {
    for share in [0.0, 0.25, 0.4] {
        let found = f64::from(along_a_wall(share, 1).share());
        assert!((found - share).abs() < 0.15, "{found} for {share}");
    }
    assert_eq!(along_a_wall(1.0, 1).share(), 0.5, "half of it is the sensor's own");
}

#[test]
fn before_any_reading_half_of_it_is_the_surfaces() {
    assert_eq!(SurfaceCorrelation::<1>::NEW.share(), 0.5);
    assert!(SurfaceCorrelation::<1>::NEW.count(0, WALL, 0.0, 1) > 1.0);
}

#[test]
fn independent_readings_count_as_one_each_and_repeated_ones_as_their_number() {
    let last = 3999;
    let next_m = SPACING_M * (last + 1) as f32;
    let independent = along_a_wall(0.0, 1).count(0, WALL, next_m, last + 1);
    assert!(independent < 1.6, "{independent}");
    // A quarter metre of wall holds five readings of one sensor, ten of two; half of their error is their own.
    let (one, two) = (along_a_wall(1.0, 1), along_a_wall(1.0, 2));
    let (of_one, of_two) = (one.count(0, WALL, next_m, last + 1), two.count(0, WALL, next_m, last + 1));
    assert!((3.0..4.0).contains(&of_one), "{of_one}");
    assert!((5.0..7.0).contains(&of_two), "{of_two}");
    // Of another wall it is the first.
    assert!(one.count(0, WALL + 1, next_m, last + 1) < 2.1);
}

#[test]
fn a_robot_that_stands_learns_next_to_nothing() {
    let repeats = along_a_wall(1.0, 1);
    let standing = repeats.count(0, WALL, SPACING_M * 3999.0, 4000);
    assert!(standing > 50.0 && standing.is_finite(), "{standing}");
}
