//! Whether readings agree with the map: of the last that met a wall, the share that fitted it.

use slam_core::{Outcome, StepReport};

/// A reading that is off by less than this says nothing against the robot's place, metres: an end of a wall, a thing before it.
const GROSS_M: f32 = 0.08;

/// Readings that agreed with a wall of the kept map, and that are grossly off. Walls that were drawn since, of this identifier or a later
/// one, say nothing: a robot that is elsewhere draws the home a second time, askew, and everything agrees with that.
pub(crate) fn agreement<const S: usize>(report: &StepReport<S>, since: u16) -> [u8; 2] {
    let is_kept = |wall: u16| since.wrapping_sub(wall) as i16 > 0;
    let outcomes = || report.readings.iter().map(|reading| reading.outcome);
    let agrees = |outcome: &Outcome| matches!(*outcome, Outcome::Updated { wall, .. } if is_kept(wall));
    let is_off = |outcome: &Outcome| matches!(*outcome, Outcome::Gated { wall, innovation_m, .. } if is_kept(wall) && innovation_m.abs() > GROSS_M);
    [outcomes().filter(agrees).count() as u8, outcomes().filter(is_off).count() as u8]
}

/// The last readings that met a wall, a bit each: set where it fitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Agreement {
    last: u64,
    count: u8,
}

/// Shares of agreement at which a map is doubted and trusted again, of 64: 40 % and 60 %.
const POOR: u32 = 26;
const GOOD: u32 = 38;

impl Agreement {
    pub(crate) const NEW: Self = Self { last: 0, count: 0 };

    /// Takes in so many readings that fitted, and so many that did not.
    pub(crate) fn take(&mut self, [agreed, refused]: [u8; 2]) {
        for (bit, count) in [(1, agreed), (0, refused)] {
            for _ in 0..count {
                self.last = self.last << 1 | bit;
                self.count = (self.count + 1).min(64);
            }
        }
    }

    /// Few of the last 64 fitted.
    pub(crate) fn is_poor(&self) -> bool {
        self.count == 64 && self.last.count_ones() < POOR
    }

    /// Most of them did.
    pub(crate) fn is_good(&self) -> bool {
        self.last.count_ones() > GOOD
    }
}
