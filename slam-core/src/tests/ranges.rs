//! The analogue sensor's curve: innovation and noise against the curve itself in f64.

use super::random::Random;
use crate::sensing::range::{Noise, Reading};

const SCALE_M: f64 = 0.60374;
const EXPONENT: f64 = -1.16;
const NOISE_V: f64 = 0.012;

fn volts(range_m: f64) -> f64 {
    (range_m / SCALE_M).powf(1.0 / EXPONENT)
}

fn reading(range_m: f64) -> Reading {
    let noise = Noise::Volts {
        variance_v2: (NOISE_V * NOISE_V) as f32,
        volts: volts(range_m) as f32,
        scale_m: SCALE_M as f32,
        exponent: EXPONENT as f32,
    };
    Reading { range_m: range_m as f32, before_v: 0.0, noise }
}

/// dr/dV of the curve.
fn metres_per_volt(range_m: f64) -> f64 {
    EXPONENT * range_m / volts(range_m)
}

#[test]
fn the_innovation_is_the_voltage_s_scaled_to_metres_at_the_prediction() {
    let mut random = Random::new(1);
    for _ in 0..1000 {
        let read_m = random.uniform(0.15, 1.5);
        // What passes a gate: a few sigma of a reading.
        let predicted_m = read_m * random.uniform(0.85, 1.15);
        let got = reading(read_m).innovation(predicted_m as f32);
        let expected = (volts(read_m) - volts(predicted_m)) * metres_per_volt(predicted_m);
        let difference = predicted_m / read_m - 1.0;
        // The first term of the expansion that is left out.
        let tolerance = 5.0 * read_m * difference.powi(4) + 2e-6;
        assert!(
            (f64::from(got.value_m) - expected).abs() < tolerance,
            "{read_m} {predicted_m}: {} {expected}",
            got.value_m
        );
        let sigma_m = NOISE_V * metres_per_volt(predicted_m).abs();
        let ratio = f64::from(got.noise_m2).sqrt() / sigma_m;
        assert!((ratio - 1.0).abs() < 8.0 * difference.abs().powi(3) + 2e-4, "{read_m} {predicted_m}: {ratio}");
    }
}

#[test]
fn noise_of_an_analogue_reading_grows_with_range_to_the_power_of_the_curve() {
    for range_m in [0.2, 0.5, 1.0, 1.5] {
        let expected = NOISE_V * metres_per_volt(range_m).abs();
        assert!((f64::from(reading(range_m).sigma_m()) / expected - 1.0).abs() < 1e-4);
    }
    // About r^1.86 with this exponent: at 1.5 m forty times as much as at 0.2 m.
    assert!((reading(1.5).sigma_m() / reading(0.2).sigma_m() - 42.6).abs() < 1.0);
}

/// The variance belongs to the prediction: a short reading must not be trusted more than a long one.
#[test]
fn short_and_long_readings_of_one_wall_weigh_the_same() {
    let at_m = 1.0;
    let sigma_m = NOISE_V * metres_per_volt(at_m).abs();
    let [short, long] = [-2.0, 2.0].map(|n| reading(at_m + n * sigma_m).innovation(at_m as f32).noise_m2);
    assert!((short / long - 1.0).abs() < 0.02, "{short} {long}");
    let metric = |range_m| Reading { range_m, before_v: 0.0, noise: Noise::Metres { noise_m: 0.01, noise_rel: 0.02 } };
    assert_eq!(metric(0.9).innovation(1.0).noise_m2, metric(1.1).innovation(1.0).noise_m2);
    assert!((metric(1.1).innovation(1.0).noise_m2 - 5e-4).abs() < 1e-9);
    assert!((metric(1.1).innovation(1.0).value_m - 0.1).abs() < 1e-6);
}

/// Readings of one wall with Gaussian volts: the innovations have mean zero, as a filter must have it.
#[test]
fn innovations_have_no_bias() {
    let mut random = Random::new(2);
    for at_m in [0.3, 0.8, 1.4] {
        let sigma_m = NOISE_V * metres_per_volt(at_m).abs();
        let rounds = 20_000;
        let mut sum = 0.0;
        for _ in 0..rounds {
            let read_v = volts(at_m) + NOISE_V * random.gaussian();
            let read_m = SCALE_M * read_v.powf(EXPONENT);
            sum += f64::from(reading(read_m).innovation(at_m as f32).value_m);
        }
        let bias = sum / f64::from(rounds) / sigma_m;
        // Four sigma of the mean are 0.03; ranges themselves would be off by 0.1 at 1.4 m.
        assert!(bias.abs() < 0.03, "{at_m} m: {bias} sigma");
    }
}

/// Points of a new wall, weighed as a line fit weighs them, have no bias with four times the usual noise. Weighed by their own noise
/// they would be 2 % short, for the short ones would weigh most.
#[test]
fn points_of_a_new_wall_have_no_bias() {
    let mut random = Random::new(3);
    let noise_v = 0.045;
    for at_m in [0.4, 0.8, 1.1] {
        let mut output = || SCALE_M * (volts(at_m) + noise_v * random.gaussian()).powf(EXPONENT);
        let (mut weights, mut sum, mut own_weights, mut own_sum) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..40_000 {
            let range_m = output();
            let variance_v2 = (noise_v * noise_v) as f32;
            let noise = Noise::Volts {
                variance_v2,
                volts: volts(range_m) as f32,
                scale_m: SCALE_M as f32,
                exponent: EXPONENT as f32,
            };
            let of = |about_m: f64| Reading { range_m: range_m as f32, before_v: volts(about_m) as f32, noise };
            let (read, own) = (of(output()), of(range_m));
            let weigh = |reading: &Reading| f64::from(1.0 / (reading.sigma_about_m() * reading.sigma_about_m()));
            weights += weigh(&read);
            sum += weigh(&read) * f64::from(read.mean_m());
            own_weights += weigh(&own);
            own_sum += weigh(&own) * f64::from(own.range_m);
        }
        let [bias, own_bias] = [sum / weights, own_sum / own_weights].map(|mean_m| mean_m / at_m - 1.0);
        assert!(bias.abs() < 0.004, "{at_m} m: {bias}");
        assert!(at_m < 0.8 || own_bias < -0.01, "{at_m} m: {own_bias}");
    }
}

/// Where half of a surface's readings are beyond the largest range, the other half are short ones.
#[test]
fn a_surface_at_the_largest_range_is_cut_off() {
    assert!(reading(1.45).is_cut_off(1.5));
    assert!(!reading(1.2).is_cut_off(1.5));
    let metric = Reading { range_m: 1.45, before_v: 0.0, noise: Noise::Metres { noise_m: 0.1, noise_rel: 0.0 } };
    assert!(!metric.is_cut_off(1.5));
}
