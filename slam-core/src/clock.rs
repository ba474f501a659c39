//! Time between samples.

/// Nothing samples a robot more often: two rows of a log that are a microsecond apart say nothing of its speed, seconds.
const SHORTEST_S: f32 = 1e-3;

/// After a minute without samples nothing is left that a longer pause would change, seconds.
const LONGEST_S: f32 = 60.0;

/// Steps in a second for which a step's work is allotted.
const STEPS_PER_S: f32 = 25.0;

/// The time of the last sample, microseconds; none before the first.
#[derive(Clone, Copy, Debug)]
pub struct Clock(Option<u64>);

/// The time that passed from one sample to the next.
#[derive(Clone, Copy, Debug)]
pub struct Tick {
    /// Seconds; zero for the first sample.
    pub dt_s: f32,
    /// There was no sample before.
    pub is_first: bool,
}

impl Tick {
    /// What is spread over several steps takes so many turns in this one: one at 25 Hz, more where there is more time.
    pub fn turns(&self) -> usize {
        (libm::ceilf(self.dt_s * STEPS_PER_S) as usize).max(1)
    }
}

impl Clock {
    /// Before the first sample.
    pub const NEW: Self = Self(None);

    /// Takes the time of a sample. None, and nothing changed, where it is not later than the last one's.
    pub fn tick(&mut self, time_us: u64) -> Option<Tick> {
        let Some(last_us) = self.0 else {
            self.0 = Some(time_us);
            return Some(Tick { dt_s: 0.0, is_first: true });
        };
        let elapsed_us = time_us.checked_sub(last_us).filter(|elapsed| *elapsed > 0)?;
        self.0 = Some(time_us);
        let dt_s = (elapsed_us as f32 * 1e-6).clamp(SHORTEST_S, LONGEST_S);
        Some(Tick { dt_s, is_first: false })
    }
}
