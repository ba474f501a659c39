//! The ways to fail.
#![allow(unsafe_code, reason = "brings about faults on purpose")]

use core::hint::black_box;
use cortex_m_semihosting::{debug, syscall};
use stm32_metapac::Interrupt;

/// A way to fail.
#[derive(Clone, Copy, Debug)]
pub enum Way {
    Panic,
    Fault,
    Overflow,
    Interrupt,
}

/// What the last word of the command line names.
pub fn wanted() -> Way {
    let mut text = [0_u8; 64];
    // SAFETY: the host writes at most as many bytes as there are, the last one a zero.
    let failed = unsafe { syscall!(GET_CMDLINE, text.as_mut_ptr(), text.len()) } != 0;
    let line = text.split(|byte| *byte == 0).next().unwrap_or_default();
    match line.rsplit(|byte| *byte == b' ').next() {
        Some(b"panic") if !failed => Way::Panic,
        Some(b"fault") => Way::Fault,
        Some(b"overflow") => Way::Overflow,
        Some(b"interrupt") => Way::Interrupt,
        _ => loop {
            debug::exit(debug::EXIT_FAILURE);
        },
    }
}

/// Fails.
pub fn fail(way: Way) -> ! {
    match way {
        Way::Panic => panic!("as wanted"),
        Way::Fault => cortex_m::asm::udf(),
        Way::Overflow => panic!("{}", deeper(black_box(0))),
        Way::Interrupt => {
            cortex_m::peripheral::NVIC::pend(Interrupt::UART4);
            // SAFETY: that it has no handler is what is wanted.
            unsafe { cortex_m::peripheral::NVIC::unmask(Interrupt::UART4) };
            panic!("the interrupt did not come");
        }
    }
}

/// Has no end that the stack could hold.
#[inline(never)]
fn deeper(depth: u32) -> u32 {
    let room = black_box([depth; 64]);
    if depth == u32::MAX { 0 } else { deeper(depth + 1) + room[1] }
}
