//! Bumper, cliff, wheel drop and the drive task's silence: the motors are off at the first sign, whatever the estimator and the pilot do.
//!
//! This task runs at interrupt level. It owns the motor driver's standby input, which cuts both motors. They run while no
//! stop by contact is unanswered (the drive task answers once the wheels are told something that the contact allows) and
//! while the drive task goes on telling them something: it is the dead man's handle. A robot that stands for a while has them off, too, so
//! that it can be pushed.

use crate::faults::Task;
use crate::shared::{Shared, Touch};
use core::cell::Cell;
use core::sync::atomic::Ordering;
use embassy_futures::select::{Either3, select3, select4};
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal_async::digital::Wait;
use robot::ContactPins;

/// The inputs are looked at this often even without an edge.
const LOOK: Duration = Duration::from_millis(10);
/// A contact is released when it was found so at this many looks in a row: a switch bounces for some milliseconds.
const RELEASED: u8 = 2;
/// The motors are off at the latest this long after the drive task told them something.
const DEAD_MAN: Duration = Duration::from_millis(100);

/// Watches bumper, cliff, wheel drop and drive task; `enable` is high while the motors may run.
pub async fn guard<L, R, C, D>(mut inputs: ContactPins<L, R, C, D>, enable: &mut impl OutputPin, shared: &Shared) -> !
where
    L: InputPin + Wait,
    R: InputPin + Wait,
    C: InputPin + Wait,
    D: InputPin + Wait,
{
    // What is touched at the start stops nothing that runs.
    let mut before = Touch { contacts: inputs.read(), stop: None };
    let mut released_looks = 0_u8;
    let mut stops = 0_u32;
    let (mut driven, mut is_held) = (false, false);
    let mut released = None;
    loop {
        let seen = inputs.read();
        let held = seen.or(before.contacts);
        if held == seen {
            released_looks = 0;
        }
        let contacts = if released_looks >= RELEASED { seen } else { held };
        let struck = contacts.struck_since(before.contacts);
        if struck {
            stops = stops.wrapping_add(1);
            shared.faults.count(|faults| &mut faults.contact_stops);
        }
        let stop = if struck { Some(stops) } else { before.stop.filter(|stop| released != Some(*stop)) };
        before = Touch { contacts, stop };
        shared.touch.lock(|touch| touch.set(before));
        let was_driven = core::mem::replace(&mut driven, is_driven(shared));
        let was_held = core::mem::replace(&mut is_held, shared.hold.load(Ordering::Relaxed));
        // Motors that were held off are not stopped: a save stops the processor meanwhile.
        if was_driven && !driven && !was_held {
            shared.faults.count(|faults| &mut faults.dead_man_stops);
        }
        let is_free = shared.is_free.load(Ordering::Relaxed);
        let runs = stop.is_none() && driven && !is_held && !is_free;
        let done = if runs { enable.set_high() } else { enable.set_low() };
        shared.is_held.store(is_held && done.is_ok(), Ordering::Relaxed);
        if done.is_err() {
            shared.faults.count(|faults| &mut faults.motors_failed);
        }
        shared.reports.report(Task::Guard);
        let edges = select4(
            inputs.bump_left.wait_for_any_edge(),
            inputs.bump_right.wait_for_any_edge(),
            inputs.cliff.wait_for_any_edge(),
            inputs.lifted.wait_for_any_edge(),
        );
        (released, released_looks) = match select3(edges, Timer::after(LOOK), shared.release.wait()).await {
            Either3::First(_) => (None, 0),
            Either3::Second(()) => (None, released_looks.saturating_add(1)),
            Either3::Third(stop) => (Some(stop), released_looks),
        };
    }
}

/// Whether the drive task told the motors something so lately that the next look comes in time.
fn is_driven(shared: &Shared) -> bool {
    shared.driven.lock(Cell::get).is_some_and(|last| Instant::now() + LOOK <= last + DEAD_MAN)
}
