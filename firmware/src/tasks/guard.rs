//! Bumper and cliff: the motors are off at the first sign, before the estimator or the pilot hear of it.
//!
//! This task runs at interrupt level. It owns the motor driver's standby input, which cuts both motors; the drive task
//! releases it once the wheels are told something that the contact allows.

use crate::faults::Task;
use crate::shared::{Shared, Touch};
use embassy_futures::select::{select, select4};
use embassy_time::{Duration, Timer};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal_async::digital::Wait;
use robot::ContactPins;

/// The inputs are looked at this often even without an edge.
const LOOK: Duration = Duration::from_millis(10);

/// Watches bumper and cliff; `enable` is high while the motors may run.
pub async fn guard<L, R, C>(mut inputs: ContactPins<L, R, C>, enable: &mut impl OutputPin, shared: &Shared) -> !
where
    L: InputPin + Wait,
    R: InputPin + Wait,
    C: InputPin + Wait,
{
    let mut before = Touch::default();
    loop {
        let contacts = inputs.read();
        let released = shared.release.try_take().is_some();
        let struck = contacts.any() && contacts != before.contacts;
        let held = struck || (before.held && !released);
        if struck {
            shared.faults.count(|faults| &mut faults.contact_stops);
        }
        let done = if held { enable.set_low() } else { enable.set_high() };
        if done.is_err() {
            shared.faults.count(|faults| &mut faults.motors_failed);
        }
        before = Touch { contacts, held };
        shared.touch.lock(|touch| touch.set(before));
        shared.reports.report(Task::Guard);
        let edges = select4(
            inputs.bump_left.wait_for_any_edge(),
            inputs.bump_right.wait_for_any_edge(),
            inputs.cliff.wait_for_any_edge(),
            Timer::after(LOOK),
        );
        select(edges, wait_release(shared)).await;
    }
}

/// Waits until the drive task has answered, and leaves the answer there.
async fn wait_release(shared: &Shared) {
    shared.release.wait().await;
    shared.release.signal(());
}
