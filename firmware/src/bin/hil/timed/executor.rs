//! The executors of the loop, one a level: two in interrupts that the processor's timer can interrupt, and one below them in thread
//! mode, which sleeps when it has nothing to do.
#![allow(unsafe_code, reason = "the executor wants its wake-up function under a fixed name, and one caller of poll")]

use super::clock;
use crate::Levels;
use crate::link::Link;
use core::sync::atomic::{AtomicBool, AtomicPtr, Ordering};
use cortex_m::Peripherals;
use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::{NVIC, SCB};
use critical_section::with;
use embassy_executor::raw;
use static_cell::StaticCell;

/// Contexts of the executors.
const STEP: usize = 0;
const DRIVE: usize = 1;
const BELOW: usize = 2;
/// Priorities of the interrupts: the lowest two, below the clock's.
const PRIORITIES: [u8; 2] = [0xE0, 0xF0];

static LEVELS: StaticCell<[raw::Executor; 3]> = StaticCell::new();
/// The executors that interrupts poll; none before they are there.
static IN_INTERRUPTS: [AtomicPtr<raw::Executor>; 2] = [const { AtomicPtr::new(core::ptr::null_mut()) }; 2];
static BELOW_PENDING: AtomicBool = AtomicBool::new(false);

/// The interrupt of a peripheral that the loop does not use.
#[derive(Clone, Copy)]
struct Spare;

// SAFETY: the processor has an interrupt of this number.
unsafe impl InterruptNumber for Spare {
    fn number(self) -> u16 {
        0
    }
}

#[unsafe(export_name = "__pender")]
fn pend(executor: *mut ()) {
    match executor as usize {
        STEP => NVIC::pend(Spare),
        DRIVE => SCB::set_pendsv(),
        _ => BELOW_PENDING.store(true, Ordering::Release),
    }
}

fn poll(number: usize) {
    // SAFETY: none, or a pointer from a reference that is valid for ever.
    if let Some(level) = unsafe { IN_INTERRUPTS[number].load(Ordering::Acquire).as_ref() } {
        // SAFETY: each is polled by one interrupt, and not from within a task.
        unsafe { level.poll() };
    }
}

/// The spare interrupt: no other is enabled.
#[cortex_m_rt::exception]
unsafe fn DefaultHandler(_number: i16) {
    poll(STEP);
}

#[cortex_m_rt::exception]
fn PendSV() {
    poll(DRIVE);
}

/// Runs the tasks that `spawn` spawns for ever.
pub fn run(spawn: impl FnOnce(Levels), link: Link) -> ! {
    let level = |number: usize| raw::Executor::new(core::ptr::without_provenance_mut(number));
    let [step, drive, below] = &*LEVELS.init([level(STEP), level(DRIVE), level(BELOW)]);
    spawn(Levels { step: step.spawner(), drive: drive.spawner(), below: below.spawner() });
    let Some(mut core) = Peripherals::take() else { panic!("the program starts once") };
    for (place, level) in IN_INTERRUPTS.iter().zip([step, drive]) {
        place.store(core::ptr::from_ref(level).cast_mut(), Ordering::Release);
    }
    // SAFETY: nothing relied on these priorities before, and the executors are there.
    unsafe {
        core.NVIC.set_priority(Spare, PRIORITIES[STEP]);
        core.SCB.set_priority(SystemHandler::PendSV, PRIORITIES[DRIVE]);
        NVIC::unmask(Spare);
    }
    // What was spawned before there was anything to poll.
    SCB::set_pendsv();
    clock::start(core.SYST, link);
    loop {
        if BELOW_PENDING.swap(false, Ordering::Acquire) {
            // SAFETY: the only call, on an executor that lives for ever, and not from within a task.
            unsafe { below.poll() };
        } else {
            // An interrupt that comes after the look wakes the core from its sleep, and is served after the section.
            with(|_| {
                if !BELOW_PENDING.load(Ordering::Acquire) {
                    cortex_m::asm::wfi();
                }
            });
        }
    }
}
