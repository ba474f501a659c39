//! A kept map in a file: two slots as in a robot's flash, of which the newest whole record counts.
//!
//! A save leaves the record before it as it is until its own CRC is written, which comes last. A file of one record alone, as a first save
//! leaves it, is the same as that record.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use input_file::FileError;
use kept_map::{ReceiveError, Record, Refused, SaveError, Saved, Store};

/// Bytes of a slot: more than the record of the largest map on the desk.
const SLOT_BYTES: u32 = 512 * 1024;
const SLOTS: u32 = 2;
/// Where a record has the number of its save, bytes.
const SEQUENCE_AT: usize = 16;
/// What erased cells hold.
const ERASED: u8 = 0xFF;

/// What tells a kept map from every other one: its check sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapId(pub(super) u32);

impl MapId {
    /// Of a whole record; none of anything else.
    pub fn of(map: &[u8]) -> Option<Self> {
        Record::check_sum(map).map(Self)
    }
}

/// The newest whole record among the bytes of such a file; all of them where there is none, for whoever reads them to say why.
pub fn newest(bytes: &[u8]) -> &[u8] {
    let slots = bytes.chunks(SLOT_BYTES as usize).take(SLOTS as usize);
    let whole = slots.filter_map(|slot| Some((Record::parse(slot).ok()?.sequence(), slot)));
    let newer = |(number, slot): (u32, _), other: (u32, _)| {
        // The difference tells also where the numbers have run over.
        if other.0.wrapping_sub(number).cast_signed() > 0 { other } else { (number, slot) }
    };
    whole.reduce(newer).map_or(bytes, |(_, slot)| slot)
}

/// The newest whole record of a file.
///
/// # Errors
/// The file cannot be read, or has none: why the first one is not.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    let bytes = fs::read(path).map_err(|cause| FileError::system(path, "read", &cause))?;
    let newest = newest(&bytes);
    Record::parse(newest).map_err(|refused| FileError::new(path, refused.to_string()))?;
    Ok(newest.to_vec())
}

/// Saves a map, the bytes of a record of the robot with this [`rig_hash`](kept_map::rig_hash), into a file, which is made where it is
/// not there. The record gets a number of the file's own. The map that the file's newest record holds is not saved again: what is kept of a
/// place in it stays good.
///
/// # Errors
/// What the system says. What was saved before is as it was then.
pub fn save(path: &Path, map: &[u8], rig: u32) -> Result<(), FileError> {
    let failed = |cause: &io::Error| FileError::system(path, "write", cause);
    if fs::read(path).is_ok_and(|bytes| is_same_map(newest(&bytes), map)) {
        return Ok(());
    }
    let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
    let mut store = Store::new(MapFile(file.map_err(|cause| failed(&cause))?), SLOT_BYTES);
    let saved = put(&mut store, map, rig).map_err(|error| match error {
        ReceiveError::Refused(refused) => FileError::new(path, format!("cannot have this map, which {refused}")),
        ReceiveError::Save(SaveError::TooLong) => {
            FileError::new(path, format!("has room for a map of {SLOT_BYTES} bytes; this one is larger"))
        }
        ReceiveError::Save(SaveError::Damaged) => FileError::new(path, "does not hold what was written"),
        ReceiveError::Save(SaveError::Flash(Failed(cause))) => failed(&cause),
    });
    saved.and_then(|_| store.flash().0.sync_all().map_err(|cause| failed(&cause)))
}

/// Whether two records are one map, whatever the numbers of their saves.
fn is_same_map(a: &[u8], b: &[u8]) -> bool {
    let content = |record: &[u8]| {
        let words = 4 * Record::parse(record).ok()?.words();
        Some([record.get(..SEQUENCE_AT)?.to_vec(), record.get(SEQUENCE_AT + 4..words - 4)?.to_vec()])
    };
    content(a).is_some_and(|a| content(b).is_some_and(|b| a == b))
}

fn put(store: &mut Store<MapFile>, map: &[u8], rig: u32) -> Result<Saved, ReceiveError<Failed>> {
    let (words, _) = map.as_chunks::<4>();
    let mut words = words.iter().map(|word| u32::from_le_bytes(*word));
    let crc = words.next_back().ok_or(ReceiveError::Refused(Refused::Corrupt))?;
    let mut receiving = store.receive(rig).map_err(ReceiveError::Save)?;
    words.try_for_each(|word| store.take(&mut receiving, word))?;
    store.seal(receiving, crc)
}

/// A file as NOR flash: cells past its end are erased ones.
struct MapFile(File);

/// What the system said.
#[derive(Debug)]
struct Failed(io::Error);

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for MapFile {
    type Error = Failed;
}

impl ReadNorFlash for MapFile {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        bytes.fill(ERASED);
        self.0.seek(SeekFrom::Start(offset.into())).map_err(Failed)?;
        let mut rest = bytes;
        while !rest.is_empty() {
            match self.0.read(rest).map_err(Failed)? {
                0 => break,
                count => rest = rest.split_at_mut(count).1,
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        (SLOTS * SLOT_BYTES) as usize
    }
}

impl NorFlash for MapFile {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SLOT_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        let end = self.0.metadata().map_err(Failed)?.len();
        if u64::from(to) >= end {
            return self.0.set_len(end.min(from.into())).map_err(Failed);
        }
        self.write(from, &vec![ERASED; (to - from) as usize])
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        self.0.seek(SeekFrom::Start(offset.into())).map_err(Failed)?;
        self.0.write_all(bytes).map_err(Failed)
    }
}
