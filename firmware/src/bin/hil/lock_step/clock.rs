//! The clock of the loop: it stands still until the host says how late it is.

use core::cell::{Cell, RefCell};
use core::task::Waker;
use critical_section::Mutex;
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;

struct LinkClock {
    now_us: Mutex<Cell<u64>>,
    queue: Mutex<RefCell<Queue>>,
}

embassy_time_driver::time_driver_impl!(static CLOCK: LinkClock = LinkClock {
    now_us: Mutex::new(Cell::new(0)),
    queue: Mutex::new(RefCell::new(Queue::new())),
});

impl Driver for LinkClock {
    fn now(&self) -> u64 {
        critical_section::with(|cs| self.now_us.borrow(cs).get())
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|cs| self.queue.borrow(cs).borrow_mut().schedule_wake(at, waker));
    }
}

/// It is this late now: wakes every task whose time has come. The clock never goes back.
pub fn advance(to_us: u64) {
    critical_section::with(|cs| {
        let now_us = CLOCK.now_us.borrow(cs);
        now_us.set(now_us.get().max(to_us));
        CLOCK.queue.borrow(cs).borrow_mut().next_expiration(now_us.get());
    });
}
