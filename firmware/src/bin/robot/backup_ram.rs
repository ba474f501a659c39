//! The processor's backup RAM: it lasts over every reset, and over loss of power where VBAT has a cell.
#![allow(unsafe_code, reason = "the memory lies at an address of the processor's")]

use core::ptr;
use robot::{FLOOR_RECORD_BYTES, LastingMemory};
use stm32_metapac::{PWR, RCC};

const START: usize = 0x4002_4000;
const BYTES: usize = 4096;
const _: () = assert!(FLOOR_RECORD_BYTES <= BYTES);

/// All of it.
pub struct BackupRam(());

impl BackupRam {
    /// Switches on its clock, its write access and the regulator that keeps it on VBAT. There is one.
    pub fn new() -> Self {
        RCC.apb1enr().modify(|clocks| clocks.set_pwren(true));
        PWR.cr1().modify(|power| power.set_dbp(true));
        RCC.ahb1enr().modify(|clocks| clocks.set_bkpsramen(true));
        PWR.csr1().modify(|power| power.set_bre(true));
        Self(())
    }
}

impl LastingMemory for BackupRam {
    fn read(&self, place: usize) -> u8 {
        if place >= BYTES {
            return 0;
        }
        // SAFETY: the address is in the memory, which is nobody else's.
        unsafe { ptr::read_volatile((START + place) as *const u8) }
    }

    fn write(&mut self, place: usize, byte: u8) {
        if place < BYTES {
            // SAFETY: as above.
            unsafe { ptr::write_volatile((START + place) as *mut u8, byte) }
        }
    }
}
