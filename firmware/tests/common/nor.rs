//! NOR flash in memory whose power can fail.

use embassy_time::{Duration, MockDriver};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use firmware::keeper::{MapFlash, SLOT_BYTES};

/// Three slots.
#[derive(Clone)]
pub struct Nor {
    bytes: Vec<u8>,
    /// Words that are still written before the power fails, once.
    pub words_left: usize,
}

/// The power failed.
#[derive(Debug)]
pub struct PowerCut;

impl Nor {
    /// As it comes from the factory.
    pub fn new() -> Self {
        Self { bytes: vec![0xFF; 3 * SLOT_BYTES as usize], words_left: usize::MAX }
    }
}

impl NorFlashError for PowerCut {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for Nor {
    type Error = PowerCut;
}

impl ReadNorFlash for Nor {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerCut> {
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Nor {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SLOT_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerCut> {
        // As long as the processor stands still for a sector, in whole beats.
        MockDriver::get().advance(Duration::from_millis(240));
        self.bytes[from as usize..to as usize].fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerCut> {
        let Some(left) = self.words_left.checked_sub(1) else {
            self.words_left = usize::MAX;
            return Err(PowerCut);
        };
        self.words_left = left;
        for (cell, byte) in self.bytes[offset as usize..].iter_mut().zip(bytes) {
            assert_eq!(*cell & byte, *byte, "a bit is set only by erasing");
            *cell &= byte;
        }
        Ok(())
    }
}

impl MapFlash for &mut Nor {
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}
