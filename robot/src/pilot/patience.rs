//! Whether the robot still comes nearer to where it wants to go.

use super::search::Route;

/// Without coming nearer to its target for this long, patience is over, microseconds.
const LIMIT_US: u64 = 6_000_000;

/// Targets this near to each other are one, in cells.
const SAME_TARGET: i16 = 3;

/// A target at most this near that falls out of reach is let go, in steps.
const FLICKER_STEPS: u16 = 6;

/// Changes of the target that count as progress.
const SWITCHES: u8 = 4;

/// Progress towards the target, and its changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patience {
    /// Fewest steps to the target so far, and when that was reached.
    best_steps: u16,
    progress_us: u64,
    /// Changes of the target since the robot last saw something new.
    switches: u8,
}

impl Patience {
    /// Of a pilot that is yet to be prepared.
    pub(super) const ZEROS: Self = Self { best_steps: 0, progress_us: 0, switches: 0 };

    pub(super) const fn new() -> Self {
        Self { best_steps: u16::MAX, progress_us: 0, switches: 0 }
    }

    /// Something was achieved, whatever the target.
    pub(super) fn renew(&mut self, time_us: u64) {
        *self = Self { progress_us: time_us, ..Self::new() };
    }

    /// Takes note of the present route and the one before. A new target counts as progress, but not again and again.
    /// Returns whether the old target is to be let go: a near place that fell out of reach comes back into it as soon
    /// as the robot has turned away.
    pub(super) fn note(&mut self, before: Option<&Route>, now: &Route, time_us: u64) -> bool {
        let mut let_go = false;
        if let Some(before) = before
            && before.target.moves_to(now.target) > SAME_TARGET
        {
            let_go = before.steps <= FLICKER_STEPS && now.steps > 2 * FLICKER_STEPS;
            self.switches = self.switches.saturating_add(1);
            if self.switches <= SWITCHES {
                self.best_steps = u16::MAX;
            }
        }
        if now.steps < self.best_steps {
            self.best_steps = now.steps;
            self.progress_us = time_us;
        }
        let_go
    }

    /// Whether the robot has tried for too long.
    pub(super) fn is_over(&self, time_us: u64) -> bool {
        time_us.saturating_sub(self.progress_us) > LIMIT_US
    }
}
