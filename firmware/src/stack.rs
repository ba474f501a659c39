//! How much stack was ever in use: start-up fills it with a pattern.
#![allow(unsafe_code, reason = "reads the memory between the linker's two symbols")]

unsafe extern "C" {
    static mut _stack_start: u32;
    static mut _stack_end: u32;
}

/// The most stack that was ever in use, bytes.
pub fn used_bytes() -> u32 {
    let (low, high) = (&raw const _stack_end, &raw const _stack_start);
    let mut at = low;
    // SAFETY: both ends are the linker's, and all words between are memory.
    while at < high && unsafe { at.read_volatile() } == cortex_m_rt::STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    (high as usize - at as usize) as u32
}
