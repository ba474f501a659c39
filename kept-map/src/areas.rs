//! Areas that a user drew into the map, in its frame: words behind the covariance, as the record has them.
//!
//! | words | what they are |
//! |---|---|
//! | 1 an area | kind, number of corners (8 bits each) |
//! | 2 a corner of it | x, y, metres |
//!
//! What the kinds mean is not the record's business.

/// Most areas, and most corners of all of them: as many as a robot remembers.
const AREAS: usize = 8;
const CORNERS: usize = 48;
/// Most words.
pub(crate) const MOST: usize = AREAS + 2 * CORNERS;

/// Areas on their way into a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Areas {
    words: [u32; MOST],
    len: usize,
}

/// There are more areas or corners than a robot remembers, or an area has less than three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadArea;

/// A corner of an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The area's kind.
    pub kind: u8,
    /// It is the area's first one.
    pub is_first: bool,
    /// Where it is, metres.
    pub at_m: [f32; 2],
}

impl Areas {
    /// No areas.
    pub const NONE: Self = Self { words: [0; MOST], len: 0 };

    /// Adds an area of a kind: its corners in order, metres.
    ///
    /// # Errors
    /// It has less than three corners, or there is no room for it.
    pub fn add(&mut self, kind: u8, corners: &[[f32; 2]]) -> Result<(), BadArea> {
        let count = u8::try_from(corners.len()).ok().filter(|count| *count >= 3).ok_or(BadArea)?;
        if self.corners().filter(|corner| corner.is_first).count() == AREAS {
            return Err(BadArea);
        }
        let room = self.words.get_mut(self.len..self.len + 1 + 2 * corners.len()).ok_or(BadArea)?;
        let head = u32::from_le_bytes([kind, count, 0, 0]);
        let words = core::iter::once(head).chain(corners.iter().flatten().map(|value_m| value_m.to_bits()));
        room.iter_mut().zip(words).for_each(|(entry, word)| *entry = word);
        self.len += room.len();
        Ok(())
    }

    /// As many of these words as there is room for.
    pub(crate) fn of_words(words: impl Iterator<Item = u32>) -> Self {
        let mut areas = Self::NONE;
        for (entry, word) in areas.words.iter_mut().zip(words) {
            *entry = word;
            areas.len += 1;
        }
        areas
    }

    /// The words.
    pub(crate) fn words(&self) -> &[u32] {
        self.words.get(..self.len).unwrap_or_default()
    }

    /// The corners of one area after those of the other.
    pub fn corners(&self) -> impl Iterator<Item = Corner> + '_ {
        corners(|place| self.words().get(place).copied())
    }
}

/// The corners that words tell of, of as many areas as there may be.
pub(crate) fn corners(word: impl Fn(usize) -> Option<u32>) -> impl Iterator<Item = Corner> {
    let (mut place, mut kind, mut left, mut is_first, mut areas) = (0, 0, 0_u8, false, 0);
    core::iter::from_fn(move || {
        if left == 0 {
            areas += 1;
            if areas > AREAS {
                return None;
            }
            [kind, left, ..] = word(place)?.to_le_bytes();
            is_first = true;
            place += 1;
        }
        let at_m = [f32::from_bits(word(place)?), f32::from_bits(word(place + 1)?)];
        place += 2;
        left = left.checked_sub(1)?;
        Some(Corner { kind, is_first: core::mem::take(&mut is_first), at_m })
    })
}
