//! Whether a reading is the wall's, by what else it may be.

use crate::measurement::data_association::{noise_m2, odds};

/// Largest innovation that is likelier the wall's than anything's, in standard deviations, over a span of 3 m.
fn gate(sigma_m: f32) -> f32 {
    let sigmas = (0..1000).map(|i| 0.01 * i as f32);
    sigmas.take_while(|d| odds(d * sigma_m, sigma_m * sigma_m, 3.0) >= 1.0).last().unwrap_or(-1.0)
}

#[test]
fn odds_are_the_ratio_of_the_densities() {
    let (innovation, variance, span) = (0.07f64, 0.003f64, 2.5f64);
    let normal = (-0.5 * innovation * innovation / variance).exp() / (core::f64::consts::TAU * variance).sqrt();
    let expected = normal / (1.0 / span);
    assert!((f64::from(odds(0.07, 0.003, 2.5)) / expected - 1.0).abs() < 1e-5);
}

#[test]
fn who_knows_less_must_be_met_better() {
    // As the density falls: 2 ln(span / (sigma sqrt(2 pi))) is the square of the gate.
    for sigma_m in [0.01f32, 0.03, 0.1, 0.3, 1.0] {
        let expected = (2.0 * (3.0 / (sigma_m * core::f32::consts::TAU.sqrt())).ln()).sqrt();
        assert!((gate(sigma_m) - expected).abs() < 0.02, "{sigma_m}: {} not {expected}", gate(sigma_m));
    }
    assert!(gate(0.02) > 2.8 && gate(0.5) < 1.4);
    assert_eq!(gate(1.5), -1.0, "nothing is the wall's for one who could be anywhere");
}

#[test]
fn a_reading_has_as_much_gain_as_its_probability_is_worth() {
    let (known, noise) = (0.04f32, 0.001f32);
    for odds in [1.0f32, 3.0, 100.0] {
        let inflated = noise_m2(noise, known + noise, odds);
        let expected = odds / (1.0 + odds) * known / (known + noise);
        assert!((known / (known + inflated) - expected).abs() < 1e-6);
    }
}
