//! The three small sectors of the processor's flash between its vectors and its program (memory.x): one map each.
//!
//! While a sector is erased the processor stands still, for 0.25 s typically and 0.8 s at most.
#![allow(unsafe_code, reason = "the flash is read as memory")]

use embassy_stm32::Peri;
use embassy_stm32::flash::{Bank1Region1, Blocking, Error, Flash};
use embassy_stm32::peripherals::FLASH;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use firmware::keeper::{MapFlash, SLOT_BYTES};

/// Bytes before the first of them: the sector with the vectors.
const FROM: u32 = SLOT_BYTES;
/// How many there are.
const SECTORS: u32 = 3;
/// Where the flash lies in memory.
const FLASH_START: usize = 0x0800_0000;

/// The sectors.
pub struct SmallSectors(Bank1Region1<'static, Blocking>);

impl SmallSectors {
    /// Of this flash.
    pub fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(Flash::new_blocking(flash).into_blocking_regions().bank1_region1)
    }
}

impl ErrorType for SmallSectors {
    type Error = Error;
}

impl ReadNorFlash for SmallSectors {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        self.0.read(FROM + offset, bytes)
    }

    fn capacity(&self) -> usize {
        (SECTORS * SLOT_BYTES) as usize
    }
}

impl NorFlash for SmallSectors {
    const WRITE_SIZE: usize = <Bank1Region1<'static, Blocking> as NorFlash>::WRITE_SIZE;
    const ERASE_SIZE: usize = SLOT_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        self.0.erase(FROM + from, FROM + to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        self.0.write(FROM + offset, bytes)
    }
}

impl MapFlash for SmallSectors {
    fn bytes(&self) -> &[u8] {
        let first = (FLASH_START + FROM as usize) as *const u8;
        // SAFETY: the flash is memory that is always there; it is written through a mutable reference to this only.
        unsafe { core::slice::from_raw_parts(first, self.capacity()) }
    }
}
