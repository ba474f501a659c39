//! Sine, cosine and wrapping: the same bits on every machine.

use core::f32::consts::PI;

use crate::geometry::angle::{sin_cos, wrap};

/// FNV-1a over the bits of every value.
fn hash(values: impl Iterator<Item = f32>) -> u64 {
    values
        .flat_map(|value| value.to_bits().to_le_bytes())
        .fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3))
}

fn angles() -> impl Iterator<Item = f32> {
    (-30_000..30_000).map(|i| i as f32 * 4.1e-4)
}

/// Nothing but additions, multiplications and roundings of IEEE 754: a machine that gives other bits fuses or reorders
/// them. A change of the polynomials changes these numbers on purpose, and every replay with them.
#[test]
fn the_bits_are_the_same_on_every_machine() {
    assert_eq!(hash(angles().flat_map(|a| <[f32; 2]>::from(sin_cos(a)))), 14_177_608_508_297_669_710);
    assert_eq!(hash(angles().map(wrap)), 7_872_814_161_312_822_356);
}

#[test]
fn sine_and_cosine_stay_on_the_unit_circle() {
    for angle in angles() {
        let (s, c) = sin_cos(angle);
        assert!((f64::from(s).hypot(f64::from(c)) - 1.0).abs() < 3e-7, "{angle}");
    }
    assert_eq!(sin_cos(0.0), (0.0, 1.0));
}

#[test]
fn wrapping_moves_by_whole_turns_only() {
    for i in -500i32..500 {
        let angle = i as f32 * 0.37;
        let turns = f64::from(angle - wrap(angle)) / (2.0 * core::f64::consts::PI);
        assert!((turns - turns.round()).abs() < 1e-5, "{angle}");
        assert!(wrap(angle).abs() <= PI);
        assert_eq!(wrap(wrap(angle)), wrap(angle));
    }
}
