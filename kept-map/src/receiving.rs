//! A record that comes from outside, word by word: into the slot after the newest one's, under the store's own number, its CRC
//! last.

use embedded_storage::nor_flash::NorFlash;

use crate::record::{CRC, HEAD_SIZES, len_of_head};
use crate::refused::Refused;
use crate::store::{RIG, SaveError, Saved, Saving, Store, continued};

/// The word of a record that is its save's number.
const SEQUENCE: usize = 4;

/// A record on its way in.
#[derive(Debug)]
pub struct Receiving {
    saving: Saving,
    head: [u32; HEAD_SIZES],
    /// CRC of the words as they came.
    theirs: u32,
    /// Words with the CRC, once the head is there.
    len: Option<usize>,
}

/// Why a record was not taken. The slot holds none then, and the newest one is where it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceiveError<E> {
    /// It is no record of a robot like this one.
    Refused(Refused),
    /// It cannot be written.
    Save(SaveError<E>),
}

impl Receiving {
    /// Words that were taken.
    pub fn words(&self) -> usize {
        self.saving.written()
    }

    /// Whether nothing but the CRC is missing.
    pub fn is_unsealed(&self) -> bool {
        self.len.is_some_and(|len| self.words() + 1 == len)
    }

    /// The slot that it goes to.
    pub fn slot(&self) -> u32 {
        self.saving.slot()
    }
}

impl<F: NorFlash> Store<F> {
    /// Begins to receive a record of this [`rig_hash`](crate::rig_hash): erases the slot after the newest one's.
    ///
    /// # Errors
    /// The flash refused.
    pub fn receive(&mut self, rig: u32) -> Result<Receiving, SaveError<F::Error>> {
        let theirs = CRC.digest().finalize();
        Ok(Receiving { saving: self.begin(rig)?, head: [0; HEAD_SIZES], theirs, len: None })
    }

    /// Takes the record's next word but for its CRC.
    ///
    /// # Errors
    /// It is no record of this rig, is longer than a slot, or the flash refused.
    pub fn take(&mut self, receiving: &mut Receiving, word: u32) -> Result<(), ReceiveError<F::Error>> {
        let Receiving { saving, head, theirs, len } = receiving;
        let place = saving.written();
        if let Some(entry) = head.get_mut(place) {
            *entry = word;
        }
        if place + 1 == HEAD_SIZES {
            let words = len_of_head(head).map_err(ReceiveError::Refused)?;
            if head.get(RIG) != Some(&saving.rig()) {
                return Err(ReceiveError::Refused(Refused::OtherRig));
            }
            if !self.fits(words) {
                return Err(ReceiveError::Save(SaveError::TooLong));
            }
            *len = Some(words);
        }
        *theirs = continued(*theirs, word);
        let own = if place == SEQUENCE { saving.sequence() } else { word };
        self.write(saving, own).map_err(|error| ReceiveError::Save(SaveError::Flash(error)))
    }

    /// Takes the record's CRC: the record is the newest one then.
    ///
    /// # Errors
    /// The CRC is not that of the words, or the flash refused.
    pub fn seal(&mut self, mut receiving: Receiving, crc: u32) -> Result<Saved, ReceiveError<F::Error>> {
        if !receiving.is_unsealed() || receiving.theirs != crc {
            return Err(ReceiveError::Refused(Refused::Corrupt));
        }
        self.finish(&mut receiving.saving).map_err(ReceiveError::Save)
    }
}
