//! The floor job as bytes, for a memory that lasts over a reset: what was swept and what stands where, where home is, and what the
//! job is about. What it was at is not kept: it looks for the nearest floor from where it is.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use slam_core::Pose;

use super::errand::Errand;
use super::frame::Frame;
use super::sheet::Sheet;
use super::swept::CELLS;
use super::{FloorJob, FloorState, Phase};
use crate::pilot::memory::Cell;

/// What the bytes begin with; the last one is the format's version.
const MAGIC: [u8; 4] = *b"FLJ\x02";
const HEAD: usize = 44;
const STATES: usize = FloorState::ALL.len();
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Length of a saved floor job, bytes.
pub const FLOOR_RECORD_BYTES: usize = HEAD + 2 * STATES + CELLS * CELLS / 2 + 4;

/// Why bytes are no floor job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FloorRecordError {
    /// Fewer or more bytes than [`FLOOR_RECORD_BYTES`].
    Length,
    /// Something else, or of another version.
    Magic,
    /// The check sum says that bytes changed.
    Sum,
    /// A value that cannot be.
    Value,
}

impl core::fmt::Display for FloorRecordError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Length => "a saved floor job has another length",
            Self::Magic => "this is no saved floor job of this version",
            Self::Sum => "the saved floor job is damaged: its check sum is another",
            Self::Value => "the saved floor job has a value that cannot be",
        })
    }
}

impl core::error::Error for FloorRecordError {}

/// Of the sixteen ways in which the quarters of a free cell are swept or not, the two where only opposite corners are lose one, so
/// that a cell fits in four bits with two more for what is unknown and what stands there.
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
        let swept = match self.swept.of(cell) {
            6 => 2,
            9 => 1,
            swept => swept,
        };
        SWEPT.iter().position(|kept| *kept == swept).unwrap_or(0) as u8
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

/// The cells of the picture in pairs, row by row.
fn pairs() -> impl Iterator<Item = [Cell; 2]> {
    (0..CELLS as i16)
        .flat_map(|row| (0..CELLS as i16 / 2).map(move |col| [0, 1].map(|second| Cell { col: 2 * col + second, row })))
}

impl<const S: usize> FloorJob<S> {
    /// Writes down what is to be known after a reset.
    pub fn save(&self, into: &mut [u8; FLOOR_RECORD_BYTES]) {
        let errand = match self.errand {
            Errand::Sweep => 0,
            Errand::Recharge => 1,
            Errand::Finish => 2,
        };
        let origin = Some(self.frame.origin()).filter(|_| self.frame.is_aligned());
        let [col, row] = self.sheet.picture.corner();
        let poses = [origin, self.home].into_iter().flat_map(pose_words);
        let head = [MAGIC, [errand, u8::from(self.has_dock), self.retries, 0]].into_iter().chain(poses);
        let head = head.chain([col.to_le_bytes(), row.to_le_bytes(), self.tally.swept().to_le_bytes()]);
        let seconds = self.progress().seconds_in.into_iter().flat_map(u16::to_le_bytes);
        let cells = pairs().map(|[first, second]| self.sheet.code(first) | self.sheet.code(second) << 4);
        let mut sum = CRC.digest();
        let mut places = into.iter_mut();
        for (byte, place) in head.flatten().chain(seconds).chain(cells).zip(places.by_ref()) {
            *place = byte;
            sum.update(&[byte]);
        }
        places.zip(sum.finalize().to_le_bytes()).for_each(|(place, byte)| *place = byte);
    }

    /// A job that knows nothing yet becomes the one that was saved, about to go on where the robot is.
    ///
    /// # Errors
    /// The bytes are not those of a saved floor job: it still knows nothing.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), FloorRecordError> {
        let bytes: &[u8; FLOOR_RECORD_BYTES] = bytes.try_into().map_err(|_| FloorRecordError::Length)?;
        let mut words = bytes.iter().copied();
        let mut word = || [0_u8; 4].map(|_| words.next().unwrap_or(0));
        if word() != MAGIC {
            return Err(FloorRecordError::Magic);
        }
        let (body, sum) = bytes.split_last_chunk::<4>().ok_or(FloorRecordError::Length)?;
        if CRC.checksum(body) != u32::from_le_bytes(*sum) {
            return Err(FloorRecordError::Sum);
        }
        let [errand, has_dock, retries, _] = word();
        self.errand = match errand {
            0 => Errand::Sweep,
            1 => Errand::Recharge,
            2 => Errand::Finish,
            _ => return Err(FloorRecordError::Value),
        };
        self.frame = Frame::at(pose_of([(); 3].map(|()| word())));
        self.home = pose_of([(); 3].map(|()| word()));
        (self.has_dock, self.retries) = (has_dock != 0, retries);
        self.sheet.picture.put_corner([(); 2].map(|()| i32::from_le_bytes(word())));
        let swept = u32::from_le_bytes(word());
        let mut seconds_in = [0; STATES];
        let mut rest = words;
        for seconds in &mut seconds_in {
            *seconds = u16::from_le_bytes([(); 2].map(|()| rest.next().unwrap_or(0)));
        }
        self.tally.take_up(swept, seconds_in);
        for ([first, second], code) in pairs().zip(rest) {
            self.sheet.decode(first, code & 0xF);
            self.sheet.decode(second, code >> 4);
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
    use super::*;
    use crate::rig::default_rig;

    #[test]
    fn what_was_swept_and_what_stands_there_is_known_after_a_reset() {
        let rig = default_rig::<8>();
        let mut job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &rig);
        job.align(0.2);
        job.go_on_in(&Pose::ORIGIN, &Pose::new(0.3, 0.4, 0.5));
        job.home = Some(Pose::new(0.5, -0.25, 1.0));
        job.errand = Errand::Recharge;
        let mut bits = 1_u32;
        for cell in pairs().flatten() {
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
        let mut bytes = [0; FLOOR_RECORD_BYTES];
        job.save(&mut bytes);
        let mut again: FloorJob<8> = FloorJob::new(FloorConfig::default(), &rig);
        again.restore(&bytes).unwrap();
        assert_eq!((again.home, again.errand, again.frame), (job.home, job.errand, job.frame));
        for cell in pairs().flatten() {
            assert_eq!(again.sheet.code(cell), job.sheet.code(cell), "{cell:?}");
            assert_eq!(again.sheet.picture.centre_m(cell), job.sheet.picture.centre_m(cell));
        }
        let mut twice = [0; FLOOR_RECORD_BYTES];
        again.save(&mut twice);
        assert_eq!(bytes, twice);
    }

    #[test]
    fn damaged_bytes_are_refused_with_the_reason() {
        let rig = default_rig::<8>();
        let job: FloorJob<8> = FloorJob::new(FloorConfig::default(), &rig);
        let mut bytes = [0; FLOOR_RECORD_BYTES];
        job.save(&mut bytes);
        let restored = |bytes: &[u8]| job.clone().restore(bytes).err();
        assert_eq!(restored(&bytes), None);
        assert_eq!(restored(&bytes[1..]), Some(FloorRecordError::Length));
        for place in 0..FLOOR_RECORD_BYTES {
            let mut damaged = bytes;
            damaged[place] ^= 0x10;
            let expected = if place < MAGIC.len() { FloorRecordError::Magic } else { FloorRecordError::Sum };
            assert_eq!(restored(&damaged), Some(expected), "byte {place}");
        }
    }
}
