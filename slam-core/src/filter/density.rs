//! The normal density.

/// 1 / sqrt(2 pi).
pub const INVERSE_SQRT_TAU: f32 = 0.398_942_3;

/// Normal density at so far from the mean.
pub fn density(off: f32, variance: f32) -> f32 {
    let square = off * off / variance;
    INVERSE_SQRT_TAU / float::sqrtf(variance) * libm::expf(-0.5 * square)
}
