//! The processor's backup RAM: it lasts over every reset, and over loss of power where VBAT has a cell.
#![allow(unsafe_code, reason = "the memory lies at an address of the processor's")]

use core::ptr;
use robot::{FLOOR_RECORD_BYTES, LastingMemory, POSE_RECORD_BYTES};
use stm32_metapac::{PWR, RCC};

const START: usize = 0x4002_4000;
const BYTES: usize = 4096;
/// Where the part for the last pose begins: behind that for the floor, which lies where it always did.
const POSE_AT: usize = FLOOR_RECORD_BYTES.next_multiple_of(4);
const _: () = assert!(POSE_AT + POSE_RECORD_BYTES <= BYTES);

/// The part of it that begins at this place and has so many bytes.
pub struct BackupRam<const AT: usize, const LEN: usize>(());

/// The part for the floor.
pub type FloorBackup = BackupRam<0, FLOOR_RECORD_BYTES>;
/// The part for the last pose.
pub type PoseBackup = BackupRam<POSE_AT, POSE_RECORD_BYTES>;

/// Switches on its clock, its write access and the regulator that keeps it on VBAT. There is one part for each.
pub fn parts() -> (FloorBackup, PoseBackup) {
    RCC.apb1enr().modify(|clocks| clocks.set_pwren(true));
    PWR.cr1().modify(|power| power.set_dbp(true));
    RCC.ahb1enr().modify(|clocks| clocks.set_bkpsramen(true));
    PWR.csr1().modify(|power| power.set_bre(true));
    (BackupRam(()), BackupRam(()))
}

impl<const AT: usize, const LEN: usize> LastingMemory for BackupRam<AT, LEN> {
    fn read(&self, place: usize) -> u8 {
        if place >= LEN {
            return 0;
        }
        // SAFETY: the address is in this part of the memory, which is nobody else's.
        unsafe { ptr::read_volatile((START + AT + place) as *const u8) }
    }

    fn write(&mut self, place: usize, byte: u8) {
        if place < LEN {
            // SAFETY: as above.
            unsafe { ptr::write_volatile((START + AT + place) as *mut u8, byte) }
        }
    }
}
