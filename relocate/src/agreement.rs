//! Whether readings agree with the map: of the last that met a wall, the share that fitted it.

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
