//! Bumper and cliff stop the wheels with neither estimator nor drive task alive.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::Wire;
use core::cell::Cell;
use core::future::Future;
use core::pin::pin;
use core::sync::atomic::Ordering;
use core::task::{Context, Waker};
use embassy_time::{Duration, Instant, MockDriver};
use firmware::{Shared, tasks};
use robot::ContactPins;

/// The guard with its inputs, and the drive task's part.
struct Bench<'a> {
    shared: &'a Shared,
    enabled: &'a Cell<bool>,
    poll: &'a mut dyn FnMut(),
}

impl Bench<'_> {
    fn poll(&mut self) {
        (self.poll)();
    }

    /// The drive task has told the motors something.
    fn drive(&self) {
        self.shared.driven.lock(|driven| driven.set(Some(Instant::now())));
    }

    /// The stop that it has to answer.
    fn stop(&self) -> Option<u32> {
        self.shared.touch.lock(Cell::get).stop
    }

    fn contact_stops(&self) -> u32 {
        self.shared.faults.get().contact_stops
    }

    /// A switch bounces: it is released after two looks at it.
    fn release(&mut self) {
        for _ in 0..3 {
            assert!(self.shared.contacts().any(), "not yet");
            self.drive();
            self.poll();
            MockDriver::get().advance(Duration::from_millis(10));
        }
        self.poll();
    }

    /// It is pressed, and let go.
    fn press(&mut self, input: &Cell<bool>, stops: u32) {
        input.set(true);
        self.poll();
        assert!(!self.enabled.get(), "off at once, without any time passing");
        assert!(self.shared.contacts().any());
        assert_eq!((self.contact_stops(), self.stop()), (stops, Some(stops)));
        MockDriver::get().advance(Duration::from_millis(500));
        self.drive();
        self.poll();
        assert!(!self.enabled.get(), "off for as long as the drive task has not answered");
        self.shared.release.signal(stops);
        self.poll();
        assert!(self.enabled.get(), "the drive task has set what the contact allows");
        assert_eq!(self.contact_stops(), stops, "one contact, one stop");
        input.set(false);
        self.release();
        assert!(self.enabled.get() && !self.shared.contacts().any());
        assert_eq!(self.contact_stops(), stops);
    }

    /// One is pressed while the other is.
    fn press_both(&mut self, bumper: &Cell<bool>, cliff: &Cell<bool>) {
        bumper.set(true);
        self.poll();
        let seen = self.stop().expect("the bumper stops the motors");
        cliff.set(true);
        self.poll();
        self.shared.release.signal(seen);
        self.poll();
        assert!(!self.enabled.get(), "the answer to the bumper does not release the cliff's stop");
        bumper.set(false);
        self.release();
        let contacts = self.shared.contacts();
        let is_right = !self.enabled.get() && !contacts.bump_left && contacts.cliff;
        assert!(is_right, "nor does the bumper that is let go");
        assert_eq!(self.contact_stops(), 6, "to let go is no contact");
        self.shared.release.signal(self.stop().expect("the cliff stops the motors"));
        self.poll();
        assert!(self.enabled.get(), "the answer to the cliff does");
        cliff.set(false);
        self.release();
    }

    /// A bumper that bounces while it is let go is one contact.
    fn bounce(&mut self, bumper: &Cell<bool>) {
        for is_pressed in [true, false, true, false, true] {
            bumper.set(is_pressed);
            self.poll();
            assert!(self.shared.contacts().bump_left);
            MockDriver::get().advance(Duration::from_millis(5));
            self.drive();
        }
        assert_eq!(self.contact_stops(), 7);
    }

    /// A robot that stands is not held.
    fn stand(&mut self) {
        self.shared.release.signal(self.stop().expect("the bumper stops the motors"));
        self.poll();
        assert!(self.enabled.get());
        self.shared.is_free.store(true, Ordering::Relaxed);
        self.poll();
        MockDriver::get().advance(Duration::from_millis(10));
        self.poll();
        assert!(!self.enabled.get() && self.shared.faults.get().dead_man_stops == 0);
    }
}

#[test]
fn contact_cuts_the_motors_until_the_drive_task_has_answered_this_contact() {
    let shared = Shared::new();
    let [left, right, cliff, lifted, enabled] = [false; 5].map(Cell::new);
    let inputs =
        ContactPins { bump_left: Wire(&left), bump_right: Wire(&right), cliff: Wire(&cliff), lifted: Wire(&lifted) };
    let mut enable = Wire(&enabled);
    let mut guard = pin!(tasks::guard(inputs, &mut enable, &shared));
    let mut context = Context::from_waker(Waker::noop());
    let mut poll = || assert!(guard.as_mut().poll(&mut context).is_pending());
    let mut bench = Bench { shared: &shared, enabled: &enabled, poll: &mut poll };
    bench.drive();
    bench.poll();
    assert!(enabled.get(), "nothing touched: motors may run");
    for (input, stops) in [(&left, 1), (&right, 2), (&cliff, 3), (&lifted, 4)] {
        bench.press(input, stops);
    }
    bench.press_both(&left, &cliff);
    bench.bounce(&left);
    bench.stand();
}
