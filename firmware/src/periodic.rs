//! A beat that tasks share: periods begin at whole multiples, so that two tasks with the same beat run at the same time.

use embassy_time::{Duration, Instant, Timer};

/// Period of encoders and wheel-speed control, milliseconds.
pub const CONTROL_MS: u64 = 20;
/// Period of range sensors and estimator, milliseconds: about that of a Sharp sensor's own cycle.
pub const SAMPLE_MS: u64 = 40;
/// Period of the supervisor, milliseconds.
pub const SUPERVISE_MS: u64 = 500;

/// A beat.
#[derive(Clone, Copy, Debug)]
pub struct Periodic {
    period: Duration,
}

impl Periodic {
    /// A beat of this many milliseconds.
    pub const fn every_ms(period_ms: u64) -> Self {
        Self { period: Duration::from_millis(period_ms) }
    }

    /// Waits for the next beat and gives its time. Beats that were missed are left out.
    pub async fn next(&mut self) -> Instant {
        let period = self.period.as_ticks();
        let beat = Instant::from_ticks((Instant::now().as_ticks() / period + 1) * period);
        Timer::at(beat).await;
        beat
    }
}
