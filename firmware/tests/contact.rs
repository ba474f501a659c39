//! Bumper and cliff stop the wheels with neither estimator nor drive task alive.
//!
//! One test only: the clock is one for the whole process.

use core::cell::Cell;
use core::convert::Infallible;
use core::future::{Future, poll_fn};
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embassy_time::{Duration, MockDriver};
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::digital::Wait;
use firmware::{Shared, tasks};
use robot::ContactPins;

/// A wire between test and task.
struct Wire<'a>(&'a Cell<bool>);

impl ErrorType for Wire<'_> {
    type Error = Infallible;
}

impl InputPin for Wire<'_> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.get())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.get())
    }
}

impl OutputPin for Wire<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

impl Wire<'_> {
    async fn wait_for(&mut self, high: bool) -> Result<(), Infallible> {
        poll_fn(|_| if self.0.get() == high { Poll::Ready(Ok(())) } else { Poll::Pending }).await
    }
}

impl Wait for Wire<'_> {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        self.wait_for(true).await
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        self.wait_for(false).await
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for(false).await?;
        self.wait_for(true).await
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for(true).await?;
        self.wait_for(false).await
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        let before = self.0.get();
        self.wait_for(!before).await
    }
}

#[test]
fn contact_cuts_the_motors_until_the_drive_task_has_answered() {
    let shared = Shared::new();
    let [left, right, cliff, enabled] = [false; 4].map(Cell::new);
    let inputs = ContactPins { bump_left: Wire(&left), bump_right: Wire(&right), cliff: Wire(&cliff) };
    let mut enable = Wire(&enabled);
    let mut guard = pin!(tasks::guard(inputs, &mut enable, &shared));
    let mut context = Context::from_waker(Waker::noop());
    let mut poll = || assert!(guard.as_mut().poll(&mut context).is_pending());

    poll();
    assert!(enabled.get(), "nothing touched: motors may run");
    for (input, stops) in [(&left, 1), (&right, 2), (&cliff, 3)] {
        input.set(true);
        poll();
        assert!(!enabled.get(), "off at once, without any time passing");
        assert!(shared.contacts().any());
        assert_eq!(shared.faults.get().contact_stops, stops);
        MockDriver::get().advance(Duration::from_millis(500));
        poll();
        assert!(!enabled.get(), "off for as long as the drive task has not answered");
        shared.release.signal(());
        poll();
        assert!(enabled.get(), "the drive task has set what the contact allows");
        assert_eq!(shared.faults.get().contact_stops, stops, "one contact, one stop");
        input.set(false);
        poll();
        assert!(enabled.get() && !shared.contacts().any());
    }
}
