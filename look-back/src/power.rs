//! A power for weights, which need not be exact: a third of what `libm`'s logarithm and exponential take.

/// Bits of the square root of a half: from there to its double, the argument is the mantissa.
const LEAST: i32 = 0x3F35_04F3;
/// Bits of the mantissa.
const MANTISSA: u32 = 23;
/// The exponent of one.
const BIAS: i32 = 127;

/// `base` to the `exponent`, to two parts in ten thousand; a positive base, and a power within what f32 holds.
pub fn power(base: f32, exponent: f32) -> f32 {
    let y = exponent * log2(base);
    // To the nearest whole number: the conversion cuts off.
    let whole = (y + if y < 0.0 { -0.5 } else { 0.5 }) as i32;
    let z = core::f32::consts::LN_2 * (y - whole as f32);
    // The exponential's series to the fourth power, for up to half of ln 2.
    let part = 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z * (1.0 / 24.0))));
    part * f32::from_bits(((whole.clamp(1 - BIAS, BIAS) + BIAS) as u32) << MANTISSA)
}

/// ln m = 2 atanh((m - 1) / (m + 1)), the series to the third power, for m within a factor of the square root of two from one.
fn log2(x: f32) -> f32 {
    let bits = x.to_bits().cast_signed();
    let whole = bits.wrapping_sub(LEAST) >> MANTISSA;
    let m = f32::from_bits(bits.wrapping_sub(whole << MANTISSA).cast_unsigned());
    let u = (m - 1.0) / (m + 1.0);
    whole as f32 + core::f32::consts::LOG2_E * u * (2.0 + u * u * (2.0 / 3.0))
}

#[cfg(test)]
mod tests {
    use super::power;

    #[test]
    fn is_near_libm_s() {
        for exponent in [0.7, 0.86, -0.86, 1.3, -2.0] {
            for step in 1..2000 {
                let base = 0.005 * step as f32;
                let (ours, theirs) = (power(base, exponent), libm::powf(base, exponent));
                assert!((ours / theirs - 1.0).abs() < 2e-4, "{base} ^ {exponent}: {ours}, {theirs}");
            }
        }
    }

    #[test]
    fn odd_numbers_do_no_harm() {
        for base in [0.0, -1.0, f32::NAN, f32::INFINITY, f32::MIN_POSITIVE, f32::MAX] {
            for exponent in [-3.0, 0.0, 3.0] {
                // Any number will do; nothing panics.
                let _ = power(base, exponent);
            }
        }
    }
}
