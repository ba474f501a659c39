//! Functions of an `f32` that are faster or smaller on a microcontroller than those of `libm`, with the same bits on every target.
//!
//! One instruction has no safe name in stable Rust: this crate is there so that the others need no unsafe code.

#![no_std]

/// The square root; not a number below zero. `libm` computes it in software, some fifty instructions of a Cortex-M4F whose floating-point
/// unit has one for it. Both round correctly (IEEE 754).
#[cfg(not(all(target_arch = "arm", target_os = "none", target_abi = "eabihf")))]
#[inline(always)]
pub fn sqrtf(x: f32) -> f32 {
    libm::sqrtf(x)
}

/// The square root; not a number below zero.
#[cfg(all(target_arch = "arm", target_os = "none", target_abi = "eabihf"))]
#[inline(never)]
#[allow(unsafe_code, reason = "stable Rust has no name for the instruction in core")]
pub fn sqrtf(x: f32) -> f32 {
    let mut bits = x.to_bits();
    // SAFETY: nothing is changed but two registers that the compiler gives; s0 has what it had.
    unsafe {
        // Where the unit is of single precision, rustc has no registers of it for the operands of an assembly block.
        core::arch::asm!(
            "vmov {kept}, s0",
            "vmov s0, {bits}",
            "vsqrt.f32 s0, s0",
            "vmov {bits}, s0",
            "vmov s0, {kept}",
            bits = inout(reg) bits,
            kept = out(reg) _,
            options(pure, nomem, nostack, preserves_flags),
        );
    }
    f32::from_bits(bits)
}

/// `base` to the `exponent`, for a positive base: to some parts in a million, as curves of sensors are known to some in a hundred. `libm`'s,
/// which is right to the last bit, is a kilobyte and a half.
#[inline(never)]
pub fn powf(base: f32, exponent: f32) -> f32 {
    libm::expf(exponent * libm::logf(base))
}
