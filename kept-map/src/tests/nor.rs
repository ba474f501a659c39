//! NOR flash in memory whose power can fail at any time.

use std::vec;
use std::vec::Vec;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

pub const PAGE: usize = 512;

#[derive(Clone, Debug)]
pub struct Nor {
    pub bytes: Vec<u8>,
    /// Words and pages that are still written and erased before the power fails.
    pub power: usize,
    /// What a cell is left with when the power fails.
    pub noise: u32,
    pub erased: Vec<usize>,
    /// A byte that reads as nothing, whatever is written there.
    pub dead: Option<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    PowerCut,
    /// A bit was to be set, or something is not aligned.
    Misuse,
}

impl Nor {
    pub fn new(pages: usize) -> Self {
        Self { bytes: vec![0xA5; pages * PAGE], power: usize::MAX, noise: 1, erased: vec![0; pages], dead: None }
    }

    fn random(&mut self) -> u8 {
        self.noise ^= self.noise << 13;
        self.noise ^= self.noise >> 17;
        self.noise ^= self.noise << 5;
        (self.noise >> 8) as u8
    }

    fn spend(&mut self) -> bool {
        let is_on = self.power > 0;
        self.power = self.power.saturating_sub(1);
        is_on
    }
}

impl NorFlashError for Fault {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for Nor {
    type Error = Fault;
}

impl ReadNorFlash for Nor {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        let from = offset as usize;
        bytes.copy_from_slice(self.bytes.get(from..from + bytes.len()).ok_or(Fault::Misuse)?);
        if let Some(byte) = self.dead.and_then(|dead| bytes.get_mut(dead.checked_sub(from)?)) {
            *byte = 0;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Nor {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        let (from, to) = (from as usize, to as usize);
        if !from.is_multiple_of(PAGE) || !to.is_multiple_of(PAGE) || to > self.bytes.len() {
            return Err(Fault::Misuse);
        }
        for page in from / PAGE..to / PAGE {
            let is_whole = self.spend();
            for place in page * PAGE..(page + 1) * PAGE {
                // Bits rise in no order: some are still as they were.
                let noise = self.random();
                self.bytes[place] = if is_whole { 0xFF } else { self.bytes[place] | noise };
            }
            if !is_whole {
                return Err(Fault::PowerCut);
            }
            self.erased[page] += 1;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        if !offset.is_multiple_of(4) || !bytes.len().is_multiple_of(4) {
            return Err(Fault::Misuse);
        }
        for (place, word) in (offset as usize..).step_by(4).zip(bytes.chunks(4)) {
            let is_whole = self.spend();
            for (place, &byte) in (place..).zip(word) {
                if self.bytes[place] & byte != byte {
                    return Err(Fault::Misuse);
                }
                let noise = self.random();
                self.bytes[place] &= if is_whole { byte } else { byte | noise };
            }
            if !is_whole {
                return Err(Fault::PowerCut);
            }
        }
        Ok(())
    }
}
