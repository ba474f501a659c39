//! The small sectors of the emulator's flash, whose bytes the host keeps in a file.
//!
//! A program cannot write this flash, but what the host reads into it for a program stays. So each word goes to the file, and from
//! there into the flash, where it is read as on the robot. The emulator's command line may say after how many words the power
//! fails: `power=1000`.
#![allow(unsafe_code, reason = "the flash is read as memory")]

use crate::transport::{self, HostFile};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use firmware::keeper::{MapFlash, SLOT_BYTES};

/// Where the sectors lie in memory: behind the one with the vectors.
const START: usize = 0x0800_0000 + SLOT_BYTES as usize;
/// All three of them, bytes.
const CAPACITY: usize = 3 * SLOT_BYTES as usize;

/// The sectors.
pub struct Flash {
    file: HostFile,
    /// Words that are written before the power fails; none where it does not.
    power_words: Option<u32>,
}

impl Flash {
    /// With what the host's file has.
    pub fn open() -> Self {
        let flash = Self { file: HostFile::open(b"flash\0"), power_words: power_words() };
        flash.show(0, CAPACITY);
        flash
    }

    /// Lets the processor see what the file has now.
    fn show(&self, offset: usize, len: usize) {
        // SAFETY: the sectors are memory, and nobody has a reference to them while this one is written to.
        unsafe { self.file.read(offset, (START + offset) as *mut u8, len) }
    }

    fn put(&self, offset: u32, bytes: &[u8]) {
        self.file.write(offset as usize, bytes);
        self.show(offset as usize, bytes.len());
    }
}

/// What the command line says of the power.
fn power_words() -> Option<u32> {
    let mut text = [0; 256];
    let mut words = transport::command_line(&mut text).split(|byte| *byte == b' ');
    let number = words.find_map(|word| word.strip_prefix(b"power="))?;
    core::str::from_utf8(number).ok()?.parse().ok()
}

fn within(offset: u32, len: usize) -> Result<(), NorFlashErrorKind> {
    if offset as usize + len <= CAPACITY { Ok(()) } else { Err(NorFlashErrorKind::OutOfBounds) }
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let from = self.bytes().get(offset as usize..).and_then(|from| from.get(..bytes.len()));
        bytes.copy_from_slice(from.ok_or(NorFlashErrorKind::OutOfBounds)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        CAPACITY
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SLOT_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        within(to, 0)?;
        for offset in (from..to).step_by(64) {
            // A power cut comes in the middle of an erase.
            if self.power_words == Some(0) && offset - from >= (to - from) / 2 {
                transport::end();
            }
            self.put(offset, &[0xFF; 64]);
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        within(offset, bytes.len())?;
        for (at, word) in (offset..).step_by(4).zip(bytes.chunks(4)) {
            match &mut self.power_words {
                Some(0) => transport::end(),
                Some(words) => *words -= 1,
                None => {}
            }
            self.put(at, word);
        }
        Ok(())
    }
}

impl MapFlash for Flash {
    fn bytes(&self) -> &[u8] {
        // SAFETY: the sectors are memory that is always there; they are written through a mutable reference to this only.
        unsafe { core::slice::from_raw_parts(START as *const u8, CAPACITY) }
    }
}
