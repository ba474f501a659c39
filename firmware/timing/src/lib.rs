//! Counts instructions in the emulator and cycles on a board, and ends the program that does so.
#![no_std]
#![forbid(unsafe_code)]

use core::panic::PanicInfo;
use cortex_m::peripheral::{DWT, Peripherals};
use cortex_m_semihosting::{debug, hprintln};
use stm32_metapac::TIM2;

/// The emulator's Cortex-M4 calls itself r0p0; every STM32F405 is an r0p1.
const EMULATED_CPUID: u32 = 0x410f_c240;

/// What a case is measured with.
#[derive(Clone, Copy)]
enum Counter {
    /// The emulator's TIM2 advances by one per instruction when the emulator counts instructions.
    Instructions,
    /// The core's own cycle counter.
    Cycles,
}

/// Runs cases and prints one line for each: `timing NAME COUNT UNIT`.
pub struct Bench {
    counter: Counter,
    /// Cost of measuring nothing, taken off every count.
    overhead: u32,
}

impl Bench {
    /// Finds out where it runs and starts the counter.
    pub fn start() -> Self {
        let mut core = Peripherals::take().expect("the program starts once");
        let mut counter = Counter::Instructions;
        if core.CPUID.base.read() != EMULATED_CPUID {
            core.DCB.enable_trace();
            core.DWT.enable_cycle_counter();
            counter = Counter::Cycles;
        }
        let idle = Self { counter, overhead: 0 };
        Self { overhead: idle.count(|| ()), counter }
    }

    /// What a call returned, and its cost.
    pub fn measure<R>(&self, body: impl FnOnce() -> R) -> (R, u32) {
        let start = self.now();
        let result = core::hint::black_box(body());
        (result, self.now().wrapping_sub(start).saturating_sub(self.overhead))
    }

    /// Measures one call and prints it.
    pub fn case<R>(&self, name: &str, body: impl FnOnce() -> R) {
        self.print(name, self.count(body));
    }

    /// Measures `calls` calls, told their number, and prints the costliest.
    pub fn worst<R>(&self, name: &str, calls: u32, mut body: impl FnMut(u32) -> R) {
        let costs = (0..calls).map(|call| self.count(|| body(call)));
        self.print(name, costs.max().unwrap_or(0));
    }

    fn count<R>(&self, body: impl FnOnce() -> R) -> u32 {
        self.measure(body).1
    }

    fn now(&self) -> u32 {
        match self.counter {
            Counter::Instructions => TIM2.cnt().read(),
            Counter::Cycles => DWT::cycle_count(),
        }
    }

    /// Prints a cost that was measured.
    pub fn print(&self, name: &str, count: u32) {
        let unit = match self.counter {
            Counter::Instructions => "instructions",
            Counter::Cycles => "cycles",
        };
        hprintln!("timing {} {} {}", name, count, unit);
    }
}

/// Ends the program, which has printed all of its counts.
pub fn finish() -> ! {
    exit(debug::EXIT_SUCCESS)
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    hprintln!("{}", info);
    exit(debug::EXIT_FAILURE)
}

fn exit(status: debug::ExitStatus) -> ! {
    loop {
        debug::exit(status);
    }
}
