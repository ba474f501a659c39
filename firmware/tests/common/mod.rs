//! Wires between tests and tasks.
#![allow(dead_code, reason = "each test uses its part")]

pub mod home;
pub mod nor;
pub mod ranges;

use core::cell::Cell;
use core::convert::Infallible;
use core::future::poll_fn;
use core::task::Poll;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::digital::Wait;

/// A wire between test and task.
pub struct Wire<'a>(pub &'a Cell<bool>);

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
