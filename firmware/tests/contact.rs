//! Bumper and cliff stop the wheels with neither estimator nor drive task alive.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::Wire;
use core::cell::Cell;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Waker};
use embassy_time::{Duration, Instant, MockDriver};
use firmware::{Shared, tasks};
use robot::ContactPins;

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
    // The drive task's part: it has told the motors something, and answers a stop.
    let drive = || shared.driven.lock(|driven| driven.set(Some(Instant::now())));
    let stop = || shared.touch.lock(Cell::get).stop;

    drive();
    poll();
    assert!(enabled.get(), "nothing touched: motors may run");
    for (input, stops) in [(&left, 1), (&right, 2), (&cliff, 3), (&lifted, 4)] {
        input.set(true);
        poll();
        assert!(!enabled.get(), "off at once, without any time passing");
        assert!(shared.contacts().any());
        assert_eq!((shared.faults.get().contact_stops, stop()), (stops, Some(stops)));
        MockDriver::get().advance(Duration::from_millis(500));
        drive();
        poll();
        assert!(!enabled.get(), "off for as long as the drive task has not answered");
        shared.release.signal(stops);
        poll();
        assert!(enabled.get(), "the drive task has set what the contact allows");
        assert_eq!(shared.faults.get().contact_stops, stops, "one contact, one stop");
        input.set(false);
        poll();
        assert!(enabled.get() && !shared.contacts().any());
    }

    left.set(true);
    poll();
    let seen = stop().expect("the bumper stops the motors");
    cliff.set(true);
    poll();
    shared.release.signal(seen);
    poll();
    assert!(!enabled.get(), "the answer to the bumper does not release the cliff's stop");
    left.set(false);
    poll();
    assert!(!enabled.get() && shared.contacts().cliff, "nor does the bumper that is let go");
    assert_eq!(shared.faults.get().contact_stops, 6, "to let go is no contact");
    shared.release.signal(stop().expect("the cliff stops the motors"));
    poll();
    assert!(enabled.get(), "the answer to the cliff does");
}
