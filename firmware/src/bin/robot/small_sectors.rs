//! The three small sectors of the processor's flash between its vectors and its program (memory.x): one map each.
//!
//! While a sector is erased the processor stands still, for 0.25 s typically and 0.8 s at most.
#![allow(unsafe_code, reason = "the flash is read as memory")]

use embassy_stm32::Peri;
use embassy_stm32::flash::{Bank1Region1, Blocking, Error, Flash};
use embassy_stm32::peripherals::FLASH;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use firmware::keeper::{MapFlash, SLOT_BYTES};
use stm32_metapac::FLASH as FLASH_REGISTERS;
use stm32_metapac::flash::vals::Psize;

/// Bytes before the first of them: the sector with the vectors.
const FROM: u32 = SLOT_BYTES;
/// How many there are.
const SECTORS: u32 = 3;
/// What unlocks the flash's control register, one after the other.
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
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
        erase_by_words();
        let done = self.0.erase(FROM + from, FROM + to);
        forget_what_was_read();
        done
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        let done = self.0.write(FROM + offset, bytes);
        forget_what_was_read();
        done
    }
}

/// Erases 32 bits at a time, which takes 0.25 s where bytes take 0.4 s; the supply of 3.3 V is enough for it. What is unlocked here is locked
/// after the erasure.
fn erase_by_words() {
    if FLASH_REGISTERS.cr().read().lock() {
        KEYS.into_iter().for_each(|key| FLASH_REGISTERS.keyr().write_value(key));
    }
    FLASH_REGISTERS.cr().modify(|control| control.set_psize(Psize::PSIZE32));
}

/// What was read before is another now: the data cache begins anew.
fn forget_what_was_read() {
    let access = FLASH_REGISTERS.acr();
    access.modify(|access| access.set_dcen(false));
    access.modify(|access| access.set_dcrst(true));
    access.modify(|access| access.set_dcrst(false));
    access.modify(|access| access.set_dcen(true));
}

impl MapFlash for SmallSectors {
    fn bytes(&self) -> &[u8] {
        let first = (FLASH_START + FROM as usize) as *const u8;
        // SAFETY: the flash is memory that is always there; it is written through a mutable reference to this only.
        unsafe { core::slice::from_raw_parts(first, self.capacity()) }
    }
}
