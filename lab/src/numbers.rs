//! Numbers as text: the shortest that reads back as the same value.

use std::fmt::{Display, LowerExp};

/// A number in its shortest form; `nan` for what is none.
pub fn shortest<T: Display + LowerExp + Into<f64> + Copy>(number: T) -> String {
    let wide: f64 = number.into();
    let magnitude = wide.abs();
    if wide.is_nan() {
        "nan".to_owned()
    } else if magnitude != 0.0 && !(1e-4..1e15).contains(&magnitude) {
        format!("{number:e}")
    } else {
        format!("{number}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_as_the_same_bits() {
        assert_eq!(shortest(0.1f32), "0.1");
        assert_eq!(shortest(-0.0f32), "-0");
        assert_eq!(shortest(1.5e-9f32), "1.5e-9");
        assert_eq!(shortest(f32::NAN), "nan");
        for bits in (0..u32::MAX).step_by(999_983) {
            let number = f32::from_bits(bits);
            let read: f32 = shortest(number).parse().expect("a number");
            assert!(read.to_bits() == bits || (read.is_nan() && number.is_nan()), "{number} {read}");
        }
    }
}
