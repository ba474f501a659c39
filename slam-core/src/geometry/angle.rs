//! Angles in f32, with the same bits on every machine.

use core::f32::consts::{FRAC_PI_2, PI};

/// The angle in (-pi, pi] that equals `angle_rad` modulo a full turn. Zero for what is no angle: not finite, or so large
/// (a million radians) that f32 no longer resolves a turn.
pub fn wrap(angle_rad: f32) -> f32 {
    if angle_rad.is_nan() || angle_rad.abs() > 1e6 {
        return 0.0;
    }
    let turns = libm::roundf(angle_rad * (0.5 / PI));
    let wrapped = angle_rad - turns * (2.0 * PI);
    if wrapped > PI {
        PI
    } else if wrapped <= -PI {
        -wrapped
    } else {
        wrapped
    }
}

/// Angle between two directions modulo a quarter turn, in [-pi/4, pi/4].
pub fn off_quarter(a_rad: f32, b_rad: f32) -> f32 {
    let difference = a_rad - b_rad;
    difference - libm::roundf(difference * (1.0 / FRAC_PI_2)) * FRAC_PI_2
}

/// Sine and cosine of an angle of at most a few turns, radians.
///
/// The quarter turn is removed in two parts (Cody and Waite 1980), the rest goes through minimax polynomials on
/// [-pi/4, pi/4]; the error is below 2e-7. `libm::sinf` computes in f64, which the Cortex-M4F has only in software, and
/// takes forty times as long.
pub fn sin_cos(angle_rad: f32) -> (f32, f32) {
    const HIGH: f32 = 1.570_312_5;
    const LOW: f32 = 4.838_268e-4;
    let quarter = libm::roundf(angle_rad * (1.0 / FRAC_PI_2));
    let r = (angle_rad - quarter * HIGH) - quarter * LOW;
    let r2 = r * r;
    let s = r + r * r2 * (-1.666_665_5e-1 + r2 * (8.332_161e-3 + r2 * -1.951_529_6e-4));
    let c = 1.0 - 0.5 * r2 + r2 * r2 * (4.166_664_6e-2 + r2 * (-1.388_731_6e-3 + r2 * 2.443_315_7e-5));
    match (quarter as i32) & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Unit vector in a direction, which is the normal of a line with it as beta.
#[inline(never)]
pub fn normal(beta_rad: f32) -> [f32; 2] {
    let (s, c) = sin_cos(beta_rad);
    [c, s]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sin_cos_is_exact_to_2e_7() {
        for i in -200_000..200_000 {
            let angle = i as f32 * 5e-5;
            let (s, c) = sin_cos(angle);
            assert!((f64::from(s) - libm::sin(f64::from(angle))).abs() < 2e-7, "sin {angle}");
            assert!((f64::from(c) - libm::cos(f64::from(angle))).abs() < 2e-7, "cos {angle}");
        }
    }

    #[test]
    fn wrap_lands_in_the_half_open_turn() {
        for i in -1000..1000 {
            let wrapped = wrap(i as f32 * 0.1);
            assert!(wrapped > -PI && wrapped <= PI);
            assert!((libm::sinf(wrapped) - libm::sinf(i as f32 * 0.1)).abs() < 2e-5);
        }
        assert_eq!(wrap(f32::NAN), 0.0);
        assert_eq!(wrap(-PI), PI);
    }
}
