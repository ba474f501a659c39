//! Records that are written in turn into two places of a memory that lasts: the whole one with the higher number counts, and the other one is
//! written next. So whatever is cut off in the middle leaves the record before or the new one.
//!
//! | bytes | what they are |
//! |---|---|
//! | 4 | magic, the last byte of which is the format's version |
//! | 4 | number of the record |
//! | | what is said |
//! | 4 | CRC-32 (ISO-HDLC) of all bytes before |

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

use crate::traits::LastingMemory;

const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Bytes before what is said, and of the check sum after it.
const BEFORE: usize = 8;
const AFTER: usize = 4;

/// Two records of a kind, at the beginning of a memory.
pub(crate) struct InTurn {
    magic: [u8; 4],
    /// Bytes of one.
    pub len: usize,
}

impl InTurn {
    /// Of records that begin with this and say so many bytes.
    pub(crate) const fn new(magic: [u8; 4], said: usize) -> Self {
        Self { magic, len: BEFORE + said + AFTER }
    }

    /// Where the record of this number is.
    pub(crate) fn at(&self, number: u32) -> usize {
        self.len * (number % 2) as usize
    }

    /// What the record of this number says.
    pub(crate) fn said<'m>(&self, number: u32, memory: &'m impl LastingMemory) -> impl Iterator<Item = u8> + 'm {
        let at = self.at(number);
        (at + BEFORE..at + self.len - AFTER).map(|place| memory.read(place))
    }

    /// Number of the newest whole record.
    pub(crate) fn newest(&self, memory: &impl LastingMemory) -> Option<u32> {
        let number_of = |half: u32| {
            let (at, mut sum) = (self.at(half), CRC.digest());
            (at..at + self.len - AFTER).for_each(|place| sum.update(&[memory.read(place)]));
            let word = |place: usize| [0, 1, 2, 3].map(|byte| memory.read(at + place + byte));
            let is_whole = word(0) == self.magic && word(self.len - AFTER) == sum.finalize().to_le_bytes();
            is_whole.then_some(u32::from_le_bytes(word(4)))
        };
        [0, 1].into_iter().filter_map(number_of).max()
    }

    /// Writes the record of this number.
    pub(crate) fn write(&self, number: u32, said: impl IntoIterator<Item = u8>, memory: &mut impl LastingMemory) {
        let (at, mut sum) = (self.at(number), CRC.digest());
        let bytes = self.magic.into_iter().chain(number.to_le_bytes()).chain(said);
        put(memory, at, bytes.inspect(|byte| sum.update(&[*byte])));
        put(memory, at + self.len - AFTER, sum.finalize().to_le_bytes());
    }

    /// There is none any more, of which the newest had this number. The one before goes first: it must not count where the newest is gone.
    pub(crate) fn wipe(&self, number: u32, memory: &mut impl LastingMemory) {
        [number.wrapping_add(1), number].into_iter().for_each(|number| put(memory, self.at(number), [0; 4]));
    }
}

/// Writes bytes from this place on.
pub(crate) fn put(memory: &mut impl LastingMemory, at: usize, bytes: impl IntoIterator<Item = u8>) {
    bytes.into_iter().zip(at..).for_each(|(byte, place)| memory.write(place, byte));
}

/// A memory whose power fails after so many bytes.
#[cfg(test)]
pub(crate) struct Failing<const N: usize> {
    pub memory: [u8; N],
    pub left: usize,
}

#[cfg(test)]
impl<const N: usize> LastingMemory for Failing<N> {
    fn read(&self, place: usize) -> u8 {
        self.memory.read(place)
    }

    fn write(&mut self, place: usize, byte: u8) {
        if self.left > 0 {
            self.left -= 1;
            self.memory.write(place, byte);
        }
    }
}
