//! Slots of NOR flash, of which the newest whole record counts.
//!
//! A save goes to the slot after the newest one's: it is erased, the record is written, its CRC last. Until then the slot holds
//! no record, and the newest one is where it was. So a power cut leaves the old map or the new one, and all slots wear alike.

use embedded_storage::nor_flash::NorFlash;
use slam_core::kept::Kept;

use crate::areas::Areas;
use crate::record::{CRC, HEAD_SIZES, Writer, areas_of_head, check};

/// The word of a record that is its rig's hash.
pub(crate) const RIG: usize = 5;

/// Longest write unit of a flash, bytes.
const MOST_UNIT: usize = 16;

/// Equal slots of a NOR flash from its beginning on.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    slots: u32,
    slot_bytes: u32,
    /// Saves that were begun since one was whole.
    tries: u32,
}

/// Where the newest record is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Saved {
    /// Its slot, counted from the flash's beginning.
    pub slot: u32,
    /// The number of its save.
    pub sequence: u32,
}

/// Why a map was not saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveError<E> {
    /// The record is longer than a slot.
    TooLong,
    /// The flash refused.
    Flash(E),
    /// What the flash holds is not what was written.
    Damaged,
}

/// A save under way: its slot is erased, and so many words are written.
#[derive(Debug)]
pub struct Saving {
    slot: u32,
    sequence: u32,
    rig: u32,
    /// The record whose areas it takes along.
    before: Option<Saved>,
    written: usize,
    /// Where in the flash the next unit goes.
    at: u32,
    digest: u32,
    unit: [u8; MOST_UNIT],
    filled: usize,
}

impl<F: NorFlash> Store<F> {
    /// The store on a flash: at least two slots of whole erase units.
    ///
    /// # Panics
    /// In the compiler where the flash's units are no words or longer than 16 bytes.
    pub fn new(flash: F, slot_bytes: u32) -> Self {
        const { assert!(F::WRITE_SIZE <= MOST_UNIT && MOST_UNIT.is_multiple_of(F::WRITE_SIZE)) };
        let slots = flash.capacity() as u32 / slot_bytes.max(1);
        Self { flash, slots, slot_bytes, tries: 0 }
    }

    /// The newest whole record; none where there is none.
    pub fn newest(&mut self) -> Option<Saved> {
        let mut newest: Option<Saved> = None;
        for slot in 0..self.slots {
            let Some(sequence) = check(|place| self.word(slot, place)) else { continue };
            // The difference tells also where the numbers have run over.
            if newest.is_none_or(|newest| sequence.wrapping_sub(newest.sequence).cast_signed() > 0) {
                newest = Some(Saved { slot, sequence });
            }
        }
        newest
    }

    fn word(&mut self, slot: u32, place: usize) -> Option<u32> {
        let offset = u32::try_from(4 * place).ok().filter(|offset| offset + 4 <= self.slot_bytes)?;
        let mut bytes = [0; 4];
        self.flash.read(slot * self.slot_bytes + offset, &mut bytes).ok()?;
        Some(u32::from_le_bytes(bytes))
    }

    /// Reads the newest record into a buffer of a slot's length; none where there is none.
    ///
    /// # Errors
    /// The flash refused.
    pub fn read<'b>(&mut self, buffer: &'b mut [u8]) -> Result<Option<&'b [u8]>, F::Error> {
        let Some(Saved { slot, .. }) = self.newest() else { return Ok(None) };
        let len = buffer.len().min(self.slot_bytes as usize);
        let Some(buffer) = buffer.get_mut(..len) else { return Ok(None) };
        self.flash.read(slot * self.slot_bytes, buffer)?;
        Ok(Some(buffer))
    }

    /// Begins a save: erases the slot after the newest one's, or, where that did not hold the last save, another one. The map may change until the first [`Store::go_on`] and must
    /// not from then on.
    ///
    /// # Errors
    /// The flash refused.
    pub fn begin(&mut self, rig: u32) -> Result<Saving, SaveError<F::Error>> {
        let newest = self.newest();
        let others = self.slots.saturating_sub(1).max(1);
        let slot = newest.map_or(self.tries, |newest| newest.slot + 1 + self.tries % others) % self.slots.max(1);
        self.tries = self.tries.wrapping_add(1);
        let sequence = newest.map_or(1, |newest| newest.sequence.wrapping_add(1));
        let from = slot * self.slot_bytes;
        self.flash.erase(from, from + self.slot_bytes).map_err(SaveError::Flash)?;
        let digest = CRC.digest().finalize();
        let before = newest;
        Ok(Saving { slot, sequence, rig, before, written: 0, at: from, digest, unit: [0; MOST_UNIT], filled: 0 })
    }

    /// Writes at most so many words more; true when the record is whole.
    ///
    /// # Errors
    /// The record is longer than a slot, or the flash refused. The slot holds no record then.
    pub fn go_on(&mut self, saving: &mut Saving, kept: &impl Kept, words: usize) -> Result<bool, SaveError<F::Error>> {
        let areas = self.areas(saving);
        let writer = Writer::new(kept, saving.sequence, saving.rig).with_areas(&areas);
        if !self.fits(writer.len() + 1) {
            return Err(SaveError::TooLong);
        }
        for _ in 0..words {
            if saving.written == writer.len() {
                self.finish(saving)?;
                return Ok(true);
            }
            let word = writer.word(saving.written);
            self.write(saving, word).map_err(SaveError::Flash)?;
        }
        Ok(false)
    }

    /// The areas that are kept with the map, whatever becomes of its walls.
    fn areas(&mut self, saving: &Saving) -> Areas {
        let Some(Saved { slot, .. }) = saving.before else { return Areas::NONE };
        let mut head = [0; HEAD_SIZES];
        for (place, entry) in head.iter_mut().enumerate() {
            *entry = self.word(slot, place).unwrap_or_default();
        }
        let is_own = head.get(RIG) == Some(&saving.rig);
        let (from, count) = areas_of_head(&head).ok().filter(|_| is_own).unwrap_or_default();
        Areas::of_words((from..from + count).map_while(|place| self.word(slot, place)))
    }

    /// Whether a record of so many words has room in a slot.
    pub(crate) fn fits(&self, words: usize) -> bool {
        4 * words <= self.slot_bytes as usize
    }

    /// Writes the next word of a record but for its CRC.
    pub(crate) fn write(&mut self, saving: &mut Saving, word: u32) -> Result<(), F::Error> {
        saving.digest = continued(saving.digest, word);
        saving.push(&mut self.flash, word, false)
    }

    /// Writes the CRC: the record is whole, if the flash holds what was written.
    pub(crate) fn finish(&mut self, saving: &mut Saving) -> Result<Saved, SaveError<F::Error>> {
        saving.push(&mut self.flash, saving.digest, true).map_err(SaveError::Flash)?;
        if check(|place| self.word(saving.slot, place)) != Some(saving.sequence) {
            return Err(SaveError::Damaged);
        }
        self.tries = 0;
        Ok(Saved { slot: saving.slot, sequence: saving.sequence })
    }

    /// Saves in one go.
    ///
    /// # Errors
    /// As [`Store::begin`] and [`Store::go_on`].
    pub fn save(&mut self, kept: &impl Kept, rig: u32) -> Result<Saved, SaveError<F::Error>> {
        let mut saving = self.begin(rig)?;
        while !self.go_on(&mut saving, kept, usize::MAX)? {}
        Ok(Saved { slot: saving.slot, sequence: saving.sequence })
    }

    /// Erases every slot: there is no map any more.
    ///
    /// # Errors
    /// The flash refused.
    pub fn forget(&mut self) -> Result<(), F::Error> {
        self.flash.erase(0, self.slots * self.slot_bytes)
    }

    /// Erases the oldest whole record; false where there is none. Until the last one is erased, the newest is where it was.
    ///
    /// # Errors
    /// The flash refused.
    pub fn forget_oldest(&mut self) -> Result<bool, F::Error> {
        let Some(newest) = self.newest() else { return Ok(false) };
        let mut oldest = newest.slot;
        for after in (1..self.slots).rev() {
            // Saves go round: the slot after the newest one's is the oldest.
            let slot = (newest.slot + after) % self.slots.max(1);
            if check(|place| self.word(slot, place)).is_some() {
                oldest = slot;
            }
        }
        self.flash.erase(oldest * self.slot_bytes, (oldest + 1) * self.slot_bytes)?;
        Ok(true)
    }

    /// The flash.
    pub fn flash(&mut self) -> &mut F {
        &mut self.flash
    }
}

/// The CRC of what was before, and of one word more.
pub(crate) fn continued(crc: u32, word: u32) -> u32 {
    // The algorithm inverts its register at both ends and is reflected: the register before is the inverse of the CRC, whose
    // bits an initial value has in reverse.
    let mut digest = CRC.digest_with_initial((!crc).reverse_bits());
    digest.update(&word.to_le_bytes());
    digest.finalize()
}

impl Saving {
    /// Its slot.
    pub(crate) fn slot(&self) -> u32 {
        self.slot
    }

    /// The number of the save.
    pub(crate) fn sequence(&self) -> u32 {
        self.sequence
    }

    /// The rig's hash.
    pub(crate) fn rig(&self) -> u32 {
        self.rig
    }

    /// Words that are written.
    pub(crate) fn written(&self) -> usize {
        self.written
    }

    fn push<F: NorFlash>(&mut self, flash: &mut F, word: u32, is_last: bool) -> Result<(), F::Error> {
        for byte in word.to_le_bytes() {
            if let Some(entry) = self.unit.get_mut(self.filled) {
                *entry = byte;
            }
            self.filled += 1;
            if self.filled == F::WRITE_SIZE.max(1) {
                self.flush(flash)?;
            }
        }
        self.written += 1;
        if is_last && self.filled > 0 {
            self.unit.iter_mut().skip(self.filled).for_each(|byte| *byte = 0xFF);
            self.flush(flash)?;
        }
        Ok(())
    }

    /// Writes the unit that is full.
    fn flush<F: NorFlash>(&mut self, flash: &mut F) -> Result<(), F::Error> {
        let unit = self.unit.get(..F::WRITE_SIZE.max(1)).unwrap_or_default();
        flash.write(self.at, unit)?;
        self.at += unit.len() as u32;
        self.filled = 0;
        Ok(())
    }
}
