//! What the robot says before it waits for its watchdog, to a debug probe.
#![allow(unsafe_code, reason = "handlers of panics and faults touch registers directly")]

use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;
use defmt::Display2Format;

/// Where the program panicked, and why.
pub fn panicked(info: &PanicInfo) -> ! {
    defmt::error!("{}", Display2Format(info));
    wait()
}

/// The instruction that failed, where it is known.
pub fn faulted(place: Option<u32>) -> ! {
    let status = fault_status();
    match place {
        Some(place) => defmt::error!("hard fault at {:#010x}, CFSR {:#010x}", place, status),
        None => defmt::error!("the stack overflowed, CFSR {:#010x}", status),
    }
    wait()
}

/// An interrupt that nobody handles.
pub fn interrupted(number: i16) -> ! {
    defmt::error!("interrupt {} has no handler", number);
    wait()
}

/// The configurable fault status register.
fn fault_status() -> u32 {
    // SAFETY: reading this register changes nothing.
    unsafe { (*SCB::PTR).cfsr.read() }
}

fn wait() -> ! {
    defmt::flush();
    loop {
        cortex_m::asm::nop();
    }
}
