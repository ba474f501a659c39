//! The system timer as a clock: every 20 ms it turns to the host, before it wakes any task.
#![allow(unsafe_code, reason = "a register of the core is read where its owner is out of reach")]

use crate::link::Link;
use core::cell::{Cell, RefCell};
use core::task::Waker;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use critical_section::{CriticalSection, Mutex};
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;

/// Clock of the core, hertz: the robot's, and the emulator's whatever clocks a program sets up.
const CORE_HZ: u32 = 168_000_000;
/// Period of the timer's interrupt, microseconds.
const TICK_US: u64 = 1000;
/// Period of the exchange with the host, in ticks: 20 ms.
const EXCHANGE: u64 = 20;
/// Counts of the timer in a tick, and in a microsecond.
const COUNTS: u32 = CORE_HZ / 1_000_000 * TICK_US as u32;
const COUNTS_PER_US: u32 = CORE_HZ / 1_000_000;
/// The timer's interrupt waits, in the interrupt control and state register.
const PENDSTSET: u32 = 1 << 26;

struct CoreClock {
    ticks: Mutex<Cell<u64>>,
    queue: Mutex<RefCell<Queue>>,
    link: Mutex<RefCell<Option<Link>>>,
}

embassy_time_driver::time_driver_impl!(static CLOCK: CoreClock = CoreClock {
    ticks: Mutex::new(Cell::new(0)),
    queue: Mutex::new(RefCell::new(Queue::new())),
    link: Mutex::new(RefCell::new(None)),
});

impl CoreClock {
    fn now_us(&self, section: CriticalSection) -> u64 {
        let mut ticks = self.ticks.borrow(section).get();
        let mut left = SYST::get_current();
        // SAFETY: reading this register changes nothing.
        if unsafe { (*SCB::PTR).icsr.read() } & PENDSTSET != 0 {
            ticks += 1;
            left = SYST::get_current();
        }
        ticks * TICK_US + u64::from((COUNTS - 1).saturating_sub(left) / COUNTS_PER_US)
    }
}

impl Driver for CoreClock {
    fn now(&self) -> u64 {
        critical_section::with(|section| self.now_us(section))
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        // The next tick looks at the queue: what is to be woken is so at whole milliseconds.
        critical_section::with(|section| self.queue.borrow(section).borrow_mut().schedule_wake(at, waker));
    }
}

/// Starts the clock, which turns to the host from now on.
pub fn start(mut timer: SYST, link: Link) {
    critical_section::with(|section| CLOCK.link.borrow(section).replace(Some(link)));
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(COUNTS - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

#[cortex_m_rt::exception]
fn SysTick() {
    critical_section::with(|section| {
        let ticks = CLOCK.ticks.borrow(section).get() + 1;
        CLOCK.ticks.borrow(section).set(ticks);
        if ticks.is_multiple_of(EXCHANGE)
            && let Some(link) = CLOCK.link.borrow(section).borrow_mut().as_mut()
        {
            // The host shows what the sensors show now; its time is this one.
            link.exchange();
        }
        CLOCK.queue.borrow(section).borrow_mut().next_expiration(ticks * TICK_US);
    });
}
