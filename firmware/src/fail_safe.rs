//! What runs when the program cannot go on, be it a panic, a hard fault or an interrupt that nobody handles: first the motor
//! driver's enable line goes low, then the binary says what happened (`last_words.rs`). The watchdog restarts the robot.
#![allow(unsafe_code, reason = "writes the port of the enable line directly")]

use crate::last_words;
use core::panic::PanicInfo;

/// Set and reset register of GPIO port C.
const GPIOC_BSRR: u32 = 0x4002_0818;
/// What resets PC8, the enable line of `board.rs`.
const ENABLE_LOW: u32 = 1 << (16 + 8);

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Takes the enable line low, whoever owns it.
fn motors_off() {
    // SAFETY: the register exists, takes whole words, and changes the named pin only.
    unsafe { (GPIOC_BSRR as *mut u32).write_volatile(ENABLE_LOW) };
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    // An interrupt that came in between would let the motors go on.
    cortex_m::interrupt::disable();
    motors_off();
    last_words::panicked(info)
}

#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    cortex_m::interrupt::disable();
    motors_off();
    last_words::interrupted(number)
}

/// The motors are off before the stack is used, for it may be the stack that failed; what follows gets a fresh one.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        "movw r1, #{register_lo}",
        "movt r1, #{register_hi}",
        "mov r2, #{low}",
        "str r2, [r1]",
        "mrs r0, MSP",
        "movw r1, #:lower16:_stack_start",
        "movt r1, #:upper16:_stack_start",
        "msr MSP, r1",
        "b {fault}",
        register_lo = const GPIOC_BSRR & 0xffff,
        register_hi = const GPIOC_BSRR >> 16,
        low = const ENABLE_LOW,
        fault = sym fault,
    )
}

/// `frame` is where the processor put its registers; after an overflow that is no memory.
extern "C" fn fault(frame: usize) -> ! {
    let (end, start) = (&raw const _stack_end as usize, &raw const _stack_start as usize);
    let whole = (end..=start - 32).contains(&frame) && frame.is_multiple_of(4);
    // SAFETY: the eight words of the frame lie in the stack; the program counter is the seventh.
    let place = whole.then(|| unsafe { ((frame + 24) as *const u32).read_volatile() });
    last_words::faulted(place)
}
