//! The floor job in a memory that lasts over a reset: what was swept and what stands where, where home is, and what the job is
//! about. What it was at is not kept: it looks for the nearest floor from where it is.
//!
//! It is written piece by piece, so that a step writes little, and whatever is cut off in the middle leaves a job that was:
//!
//! ```text
//! two heads      the whole one with the higher number counts
//! rows           of the picture, two cells a byte, and of what lies beyond it, each with a serial: that of its head, or it counts for nothing
//! ```
//!
//! Where cells come to mean another place (another job, other axes, the picture moves), the serial changes; within one serial a cell only
//! comes to be known and swept, so that a row of old cells and new ones is right, too. A head follows its rows.

use slam_core::Pose;

use super::errand::{Errand, Way};
use super::frame::Frame;
use super::overview::OVERVIEW_BYTES;
use super::sheet::Sheet;
use super::swept::CELLS;
use super::{FloorJob, FloorState, Phase};
use crate::in_turn::{InTurn, put};
use crate::pilot::memory::Cell;
use crate::traits::LastingMemory;

const STATES: usize = FloorState::ALL.len();
const HEADS: InTurn = InTurn::new(*b"FLJ\x07", 48 + 2 * STATES);
const SERIAL: usize = 2;
const ROW: usize = SERIAL + CELLS / 2;
/// Rows of the picture and of the overview.
const ROWS: usize = CELLS + OVERVIEW_BYTES.div_ceil(CELLS / 2);

/// Bytes of a memory that a floor job is saved in.
pub const FLOOR_RECORD_BYTES: usize = 2 * HEADS.len + ROWS * ROW;

/// Why a memory has no floor job to go on with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FloorRecordError {
    /// It has none, one of another version, or a damaged one.
    Nothing,
    /// It is the job in another kept map.
    OtherMap,
    /// A value that cannot be.
    Value,
}

impl core::fmt::Display for FloorRecordError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Nothing => "there is no whole saved floor job of this version",
            Self::OtherMap => "the saved floor job is of another kept map",
            Self::Value => "the saved floor job has a value that cannot be",
        })
    }
}

impl core::error::Error for FloorRecordError {}

/// Of the sixteen ways in which the quarters of a free cell are swept or not, the two where only opposite corners are count as none, so
/// that a cell fits in four bits with two more for what is unknown and what stands there. One of the two stands for a cell that is left
/// out: the areas are drawn anew after a reset, and may be elsewhere.
const SWEPT: [u8; 14] = [0, 1, 2, 3, 4, 5, 7, 8, 10, 11, 12, 13, 14, 15];
const UNKNOWN: u8 = 14;
const OBSTACLE: u8 = 15;

impl Sheet {
    fn code(&self, cell: Cell) -> u8 {
        if self.picture.is_obstacle(cell) {
            return OBSTACLE;
        }
        if !self.picture.is_free(cell) {
            return UNKNOWN;
        }
        let swept = self.swept.kept_of(cell);
        SWEPT.iter().position(|kept| *kept == swept).unwrap_or(0) as u8
    }

    fn codes(&self, [first, second]: [Cell; 2]) -> u8 {
        self.code(first) | self.code(second) << 4
    }

    fn decode_pair(&mut self, [first, second]: [Cell; 2], codes: u8) {
        self.decode(first, codes & 0xF);
        self.decode(second, codes >> 4);
    }

    fn decode(&mut self, cell: Cell, code: u8) {
        match SWEPT.get(usize::from(code)) {
            Some(swept) => {
                self.picture.stand_on(cell);
                self.swept.put(cell, *swept);
            }
            None if code == OBSTACLE => (0..3).for_each(|_| self.picture.see_hit(cell)),
            None => {}
        }
    }
}

/// The cells of a row of the picture in pairs.
fn pairs(row: i16) -> impl Iterator<Item = [Cell; 2]> {
    (0..CELLS as i16 / 2).map(move |col| [0, 1].map(|second| Cell { col: 2 * col + second, row }))
}

/// The bytes of the overview that a row after those of the picture holds; none for one of the picture.
fn overview_row(row: i16) -> Option<core::ops::Range<usize>> {
    let from = (row as usize).checked_sub(CELLS)? * (CELLS / 2);
    Some(from..(from + CELLS / 2).min(OVERVIEW_BYTES))
}

/// Where a row is in the memory.
fn row_at(row: i16) -> usize {
    2 * HEADS.len + row as usize * ROW
}

/// How far a memory is written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Notes {
    /// Number and serial of the last head; none before the memory was looked at.
    last: Option<(u32, u16)>,
    /// There is a whole head.
    is_there: bool,
    /// The row that comes next.
    row: i16,
}

impl Notes {
    /// Of a memory not looked at yet.
    pub(crate) const NEW: Self = Self { last: None, is_there: false, row: 0 };

    /// Number and serial of the last head. A memory that has none may hold anything: rows begin with no serial.
    fn open(&mut self, memory: &mut impl LastingMemory) -> (u32, u16) {
        *self.last.get_or_insert_with(|| {
            let found = HEADS.newest(memory);
            self.is_there = found.is_some();
            if found.is_none() {
                (0..ROWS as i16).for_each(|row| put(memory, row_at(row), [0; SERIAL]));
            }
            found.map_or((0, 0), |number| (number, serial_in(HEADS.said(number, memory))))
        })
    }

    /// There is no job to go on with.
    pub(crate) fn wipe(&mut self, memory: &mut impl LastingMemory) {
        let (number, _) = self.open(memory);
        if core::mem::take(&mut self.is_there) {
            HEADS.wipe(number, memory);
        }
    }
}

fn serial_of(memory: &impl LastingMemory, row: i16) -> u16 {
    u16::from_le_bytes([0, 1].map(|place| memory.read(row_at(row) + place)))
}

/// The serial that a head begins with.
fn serial_in(mut said: impl Iterator<Item = u8>) -> u16 {
    u16::from_le_bytes([0; SERIAL].map(|_| said.next().unwrap_or(0)))
}

/// Whether a head with this serial is that of another kept map.
fn is_of_other_map(mut said: impl Iterator<Item = u8>, serial: u16, map: u32) -> bool {
    let mut word = || [0_u8; 4].map(|_| said.next().unwrap_or(0));
    let [low, high, ..] = word();
    u16::from_le_bytes([low, high]) == serial && word() != map.to_le_bytes()
}

impl<const S: usize> FloorJob<S> {
    /// Writes a piece of what is to be known after a reset, in the kept map of this number; true where that was the last one.
    pub(crate) fn note(&mut self, map: u32, notes: &mut Notes, memory: &mut impl LastingMemory) -> bool {
        let (number, serial) = notes.open(memory);
        if !core::mem::replace(&mut self.is_noted, true) {
            (notes.last, notes.row) = (Some((number, serial.wrapping_add(1).max(1))), 0);
            return false;
        }
        // Where the map was saved since, the floor as it is written down is that in the new one, too.
        let is_saved_anew = notes.is_there && is_of_other_map(HEADS.said(number, memory), serial, map);
        if !is_saved_anew && usize::try_from(notes.row).is_ok_and(|row| row < ROWS) {
            self.note_row(notes.row, serial, memory);
            notes.row += 1;
            return false;
        }
        self.note_head(map, number.wrapping_add(1), serial, memory);
        let row = if is_saved_anew { notes.row } else { 0 };
        *notes = Notes { last: Some((number.wrapping_add(1), serial)), is_there: true, row };
        !is_saved_anew
    }

    /// Writes all of it into a memory of its own.
    pub(crate) fn save(&mut self, map: u32, memory: &mut impl LastingMemory) {
        let mut notes = Notes::NEW;
        self.is_noted = false;
        while !self.note(map, &mut notes, memory) {}
        // What else is written down of it begins anew.
        self.is_noted = false;
    }

    fn note_row(&mut self, row: i16, serial: u16, memory: &mut impl LastingMemory) {
        let is_other = serial_of(memory, row) != serial;
        if is_other {
            put(memory, row_at(row), [0; SERIAL]);
        }
        let at = row_at(row) + SERIAL;
        match overview_row(row) {
            Some(bytes) => put(memory, at, self.sheet.overview.bytes().get(bytes).into_iter().flatten().copied()),
            None => put(memory, at, pairs(row).map(|pair| self.sheet.codes(pair))),
        }
        if is_other {
            put(memory, row_at(row), serial.to_le_bytes());
        }
    }

    fn note_head(&self, map: u32, number: u32, serial: u16, memory: &mut impl LastingMemory) {
        let errand = match self.errand {
            Errand::Sweep { .. } => 0,
            Errand::Recharge { .. } => 1,
            Errand::Finish(_) => 2,
        };
        let errand = [errand, u8::from(self.has_dock), self.retries, 0];
        let [low, high] = serial.to_le_bytes();
        let poses = [self.frame.kept(), self.home].into_iter().flat_map(pose_words);
        let [col, row] = self.sheet.picture.corner().map(i32::to_le_bytes);
        let words = [[low, high, 0, 0], map.to_le_bytes(), errand].into_iter();
        let words = words.chain(poses).chain([col, row, self.tally.swept().to_le_bytes()]).flatten();
        let seconds_in = self.progress().seconds_in.into_iter().flat_map(u16::to_le_bytes);
        HEADS.write(number, words.chain(seconds_in), memory);
    }

    /// A job that knows nothing yet becomes the one that was saved in the kept map of this number, about to go on where the robot is.
    ///
    /// # Errors
    /// The memory has no floor job in that map: it still knows nothing.
    pub(crate) fn restore(&mut self, map: u32, memory: &impl LastingMemory) -> Result<(), FloorRecordError> {
        let number = HEADS.newest(memory).ok_or(FloorRecordError::Nothing)?;
        let mut bytes = HEADS.said(number, memory);
        let mut word = || [0_u8; 4].map(|_| bytes.next().unwrap_or(0));
        let [low, high, ..] = word();
        let serial = u16::from_le_bytes([low, high]);
        if word() != map.to_le_bytes() {
            return Err(FloorRecordError::OtherMap);
        }
        let [errand, has_dock, retries, _] = word();
        self.errand = match errand {
            0 => Errand::FIRST,
            1 => Errand::Recharge { then: Way::Open },
            2 => Errand::Finish(Way::Open),
            _ => return Err(FloorRecordError::Value),
        };
        self.frame = Frame::at(pose_of([(); 3].map(|()| word())));
        self.home = pose_of([(); 3].map(|()| word()));
        (self.has_dock, self.retries) = (has_dock != 0, retries);
        self.sheet.picture.put_corner([(); 2].map(|()| i32::from_le_bytes(word())));
        let swept = u32::from_le_bytes(word());
        let seconds_in = [0_u16; STATES].map(|_| u16::from_le_bytes([(); 2].map(|()| bytes.next().unwrap_or(0))));
        self.tally.take_up(swept, seconds_in);
        for row in (0..ROWS as i16).filter(|row| serial_of(memory, *row) == serial) {
            let bytes = (row_at(row) + SERIAL..).map(|place| memory.read(place));
            match overview_row(row) {
                Some(places) => {
                    let known = self.sheet.overview.bytes().get_mut(places).into_iter().flatten();
                    known.zip(bytes).for_each(|(known, byte)| *known = byte);
                }
                None => pairs(row).zip(bytes).for_each(|(pair, codes)| self.sheet.decode_pair(pair, codes)),
            }
        }
        self.phase = Phase::Plan { aim: self.aim(), escape: 5, begun: false };
        Ok(())
    }
}

/// A pose as bytes; one that is not known is no number.
fn pose_words(pose: Option<Pose>) -> [[u8; 4]; 3] {
    pose.map_or([f32::NAN; 3], |Pose { x_m, y_m, theta_rad }| [x_m, y_m, theta_rad]).map(f32::to_le_bytes)
}

fn pose_of(words: [[u8; 4]; 3]) -> Option<Pose> {
    let [x_m, y_m, theta_rad] = words.map(f32::from_le_bytes);
    let is_known = x_m.is_finite() && y_m.is_finite() && theta_rad.is_finite();
    is_known.then_some(Pose { x_m, y_m, theta_rad })
}

#[cfg(test)]
mod tests {
    use super::super::FloorConfig;
    use super::super::overview::Known;
    use super::*;
    use crate::in_turn::Failing;
    use crate::rig::default_rig;

    fn blank() -> FloorJob<8> {
        FloorJob::new(FloorConfig::default(), &default_rig())
    }

    /// A job that knows something of each cell, and another one by another seed.
    fn job(seed: u32) -> FloorJob<8> {
        let mut job = blank();
        job.align(0.2);
        job.go_on_in(&Pose::ORIGIN, &Pose::new(0.3, 0.4, 0.5));
        job.home = Some(Pose::new(0.5, -0.25, seed as f32));
        job.errand = Errand::Recharge { then: Way::Open };
        job.sheet.overview.put([-20, 5], Known::Left);
        job.sheet.overview.put([3, -7], Known::Swept);
        let mut bits = seed;
        for cell in (0..CELLS as i16).flat_map(pairs).flatten() {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match bits >> 30 {
                0 => {}
                1 => (0..2).for_each(|_| job.sheet.picture.see_hit(cell)),
                _ => {
                    job.sheet.picture.see_free(cell);
                    job.sheet.swept.put(cell, (bits >> 24) as u8 & 0xF);
                }
            }
        }
        job
    }

    fn codes(job: &FloorJob<8>) -> impl Iterator<Item = u8> {
        (0..CELLS as i16).flat_map(pairs).flatten().map(|cell| job.sheet.code(cell))
    }

    fn save(job: &mut FloorJob<8>, notes: &mut Notes, memory: &mut impl LastingMemory) {
        while !job.note(7, notes, memory) {}
    }

    #[test]
    fn what_was_swept_and_what_stands_there_is_known_after_a_reset() {
        let (mut memory, mut job) = ([0xA5; FLOOR_RECORD_BYTES], job(1));
        save(&mut job, &mut Notes::default(), &mut memory);
        let mut again = blank();
        assert_eq!(again.restore(8, &memory), Err(FloorRecordError::OtherMap));
        again.restore(7, &memory).unwrap();
        assert_eq!((again.home, again.errand, again.frame), (job.home, job.errand, job.frame));
        assert!(codes(&again).eq(codes(&job)));
        let corner = Cell { col: 3, row: 70 };
        assert_eq!(again.sheet.picture.centre_m(corner), job.sheet.picture.centre_m(corner));
        assert_eq!(again.progress().swept_m2, job.progress().swept_m2);
        assert_eq!(again.sheet.overview.bytes(), job.sheet.overview.bytes());
        assert_eq!(again.sheet.overview.of([-20, 5]), Known::Left);
    }

    #[test]
    fn a_cell_that_was_left_out_is_not_swept_after_a_reset() {
        let (mut memory, mut job) = ([0; FLOOR_RECORD_BYTES], blank());
        let cell = Cell { col: 30, row: 40 };
        job.sheet.picture.see_free(cell);
        job.sheet.swept.leave_out(cell);
        save(&mut job, &mut Notes::default(), &mut memory);
        let mut again = blank();
        again.restore(7, &memory).unwrap();
        assert!(again.sheet.picture.is_free(cell) && again.sheet.swept.left_in(cell) == 4);
    }

    #[test]
    fn a_damaged_head_does_not_count_and_the_one_before_does() {
        let (mut memory, mut notes, mut job) = ([0; FLOOR_RECORD_BYTES], Notes::NEW, job(1));
        assert_eq!(blank().restore(7, &memory), Err(FloorRecordError::Nothing));
        save(&mut job, &mut notes, &mut memory);
        let first = HEADS.newest(&memory).unwrap();
        job.home = Some(Pose::new(9.0, 9.0, 0.0));
        save(&mut job, &mut notes, &mut memory);
        let at = HEADS.at(HEADS.newest(&memory).unwrap());
        for place in at..at + HEADS.len {
            let mut damaged = memory;
            damaged[place] ^= 0x10;
            assert_eq!(HEADS.newest(&damaged).unwrap(), first, "byte {place}");
        }
        notes.wipe(&mut memory);
        assert_eq!(blank().restore(7, &memory), Err(FloorRecordError::Nothing));
    }

    #[test]
    fn a_cut_anywhere_leaves_the_job_before_or_the_new_one_and_never_cells_of_both() {
        let (mut memory, mut notes, mut old) = ([0; FLOOR_RECORD_BYTES], Notes::NEW, job(1));
        save(&mut old, &mut notes, &mut memory);
        let (old_codes, new_codes): (Vec<u8>, Vec<u8>) = (codes(&old).collect(), codes(&job(2)).collect());
        let mut homes = Vec::new();
        for left in (0..FLOOR_RECORD_BYTES + 400).step_by(13) {
            let mut failing = Failing { memory, left };
            save(&mut job(2), &mut notes.clone(), &mut failing);
            let mut again = blank();
            again.restore(7, &failing.memory).unwrap();
            let is_new = again.home == job(2).home;
            let whole = if is_new { &new_codes } else { &old_codes };
            assert!(is_new || again.home == old.home);
            let mut cells = codes(&again).zip(whole);
            assert!(cells.all(|(code, whole)| code == *whole || code == UNKNOWN), "cut after {left} bytes");
            homes.push(is_new);
        }
        assert!(!homes[0] && homes[homes.len() - 1] && homes.is_sorted());
    }

    extern crate std;
    use std::vec::Vec;
}
