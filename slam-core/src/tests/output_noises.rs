//! How noisy analogue outputs are, from the outputs alone.

use std::vec::Vec;

use super::random::Random;
use crate::sensing::output_noise::{OutputNoise, Outputs};

/// The factor that is found for outputs of this noise, volts, where 12 mV are stated, of a robot that drives towards
/// one wall after another, for a second each.
fn found(noise_v: f64, seconds: usize) -> f32 {
    let mut random = Random::new(3);
    let (mut noise, mut outputs) = (OutputNoise::UNKNOWN, Outputs::NONE);
    for step in 0..25 * seconds {
        let range_m = 1.2 - 0.5 * (step % 25) as f64 * 0.04;
        let volts = (range_m / 0.6).powf(-0.86) + noise_v * random.gaussian();
        if step % 25 == 0 {
            outputs = Outputs::starting_at(volts as f32);
        } else if let Some(bend_v) = outputs.push(volts as f32) {
            noise.note(bend_v, 0.012 * 0.012);
            noise.settle();
        }
    }
    noise.factor()
}

#[test]
fn the_noise_is_found_whatever_the_rig_states() {
    for noise_v in [0.02, 0.045, 0.06] {
        let expected = (noise_v / 0.012_f64).powi(2);
        let ratio = f64::from(found(noise_v, 60)) / expected;
        assert!((0.75..1.35).contains(&ratio), "{noise_v} V: {ratio}");
    }
}

#[test]
fn a_second_s_readings_of_eight_sensors_tell_most_of_it() {
    // As many as eight sensors make in two seconds.
    let factor = found(0.045, 16);
    assert!(factor > 8.0, "{factor}");
}

#[test]
fn less_noise_than_stated_is_not_believed() {
    let factor = found(0.003, 60);
    assert!((1.0..1.001).contains(&factor), "{factor}");
}

/// What was read before the noise is known has the noise that is found, from then on.
#[test]
fn the_first_readings_wait_until_their_noise_is_known() {
    let (mut random, mut noise) = (Random::new(3), OutputNoise::UNKNOWN);
    assert!(!noise.is_settling(), "a robot without analogue sensors waits for nothing");
    let mut settled = Vec::new();
    for _ in 0..100 {
        let before = noise.factor();
        let bend_v = 6.0f64.sqrt() * 0.036 * random.gaussian();
        noise.note(bend_v as f32, 0.012 * 0.012);
        if let Some(times) = noise.settle() {
            settled.push(f64::from(before * times * times));
        }
        assert_eq!(noise.is_settling(), settled.is_empty());
    }
    // Three times the stated sigma.
    assert!(settled.len() == 1 && (settled[0] / 9.0).ln().abs() < 0.7, "{settled:?}");
}
