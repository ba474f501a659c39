//! What is learned of wheels that slip, and what the covariance then says.

use crate::filter::ekf::{Ekf, Jacobian, storage};
use crate::filter::layout::{ALPHA, THETA};
use crate::measurement::slippage::{Direction, Slippage};
use crate::tests::random::Random;

type Filter = Ekf<{ storage(16) }>;

/// Variance that a metre adds to the heading as the rig states it, rad^2.
const STATED_RAD2: f32 = 1e-4;

/// A robot's direction, of such a variance.
fn direction(rad: f32, variance: f32) -> Direction {
    let mut ekf = Filter::EMPTY;
    for i in 0..=ALPHA {
        let (mean, variance) = if i == THETA { (rad, variance) } else { (0.0, 0.0) };
        ekf.augment(mean, &Jacobian::new(), variance);
    }
    Direction::of(&ekf)
}

/// So many metres with wheels whose noise is `actual` times what is stated, and by how much errors were restated in all.
fn drive(slippage: &mut Slippage, metres: usize, actual: f64) -> f32 {
    let mut random = Random::new(3);
    let mut restated = 1.0;
    for _ in 0..metres {
        let noise_rad2 = slippage.factor() * STATED_RAD2;
        let error_rad = ((actual * f64::from(STATED_RAD2)).sqrt() * random.gaussian()) as f32;
        slippage.moved(1.01, noise_rad2);
        // The readings tell all of it.
        slippage.corrected(direction(0.0, noise_rad2), direction(error_rad, 0.0));
        restated *= slippage.restated().unwrap_or(1.0);
    }
    restated
}

#[test]
fn the_factor_of_wheels_that_slip_is_found_and_errors_of_before_are_as_much_larger() {
    for actual in [1.5, 6.0, 30.0] {
        let mut slippage = Slippage::BELIEVED;
        let before = slippage.factor();
        let restated = drive(&mut slippage, 400, actual);
        let factor = slippage.factor();
        // A hundred metres count at most, each of them with the square of a normal variable: a seventh, 1-sigma.
        assert!((f64::from(factor) / actual).ln().abs() < 0.42, "{factor} for {actual}");
        // To 5 % of what it has changed since errors were last restated.
        let expected = (factor / before).powf(0.375);
        assert!((restated / expected).ln().abs() < 0.02, "{restated}, not {expected}");
    }
}

#[test]
fn the_errors_of_a_map_of_another_drive_stay() {
    let mut slippage = Slippage::BELIEVED;
    slippage.keep();
    assert_eq!(drive(&mut slippage, 400, 30.0), 1.0);
    assert!(slippage.factor() > 15.0, "what is learned of the wheels counts all the same: {}", slippage.factor());
    slippage.begin_map();
    assert_eq!(slippage.restated(), None, "a new map begins with what is known");
    assert!(drive(&mut slippage, 400, 2.0) < 0.8);
}

#[test]
fn what_is_widened_keeps_its_correlations_and_calibration_its_errors() {
    let mut ekf = Filter::EMPTY;
    for i in 0..6 {
        let mut jacobian = Jacobian::new();
        if i > 0 {
            jacobian.push((i - 1, 0.5)).unwrap();
        }
        ekf.augment(0.0, &jacobian, 1.0);
    }
    let before: [[f32; 6]; 6] = core::array::from_fn(|i| core::array::from_fn(|j| ekf.covariance(i, j)));
    ekf.widen(3.0, 4..5);
    for (i, row) in before.iter().enumerate() {
        for (j, covariance) in row.iter().enumerate() {
            let times = [i, j].map(|k| if k == 4 { 1.0 } else { 3.0 });
            assert_eq!(ekf.covariance(i, j), times[0] * times[1] * covariance);
        }
    }
}
