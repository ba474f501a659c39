//! What a robot keeps over power loss, in files beside each other: its map, the floor that is left, and where it was.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use input_file::FileError;
use kept_map::{Record, rig_hash};

use super::map_file::{self, MapId};
use super::session::Session;
use crate::show::output::folder::Folder;

/// The file of the kept map.
const MAP: &str = "map.bin";
/// The file of a floor job that is not over, in the kept map beside it.
pub(super) const JOB: &str = "job.bin";
/// The file of where the robot was at the end, in the kept map beside it.
const POSE: &str = "pose.bin";

/// Begins in the kept map of a file, if there is one, where the robot was, if that is beside it: which map it is.
///
/// # Errors
/// A file cannot be read, or is no map of this robot.
pub(super) fn begin_in(session: &mut Session, map: Option<&Path>) -> Result<Option<MapId>, FileError> {
    let Some(file) = map else { return Ok(None) };
    let map = map_file::read(file)?;
    let id = MapId::of(&map);
    session.begin_in(map).map_err(|what| FileError::new(file, what))?;
    if let Some((id, pose)) = id.zip(beside(file, POSE)?) {
        session.recall(id, &pose);
    }
    Ok(id)
}

/// The file of this name beside a kept map; none where there is none.
///
/// # Errors
/// What the system says.
pub(super) fn beside(map: &Path, name: &str) -> Result<Option<Vec<u8>>, FileError> {
    let file = map.with_file_name(name);
    match fs::read(&file) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(cause) if cause.kind() == ErrorKind::NotFound => Ok(None),
        Err(cause) => Err(FileError::system(&file, "read", &cause)),
    }
}

/// Of the files that a run writes those that it begins anew: the map in which it began, and job and pose in that, are kept beside the new
/// ones, for a run that does not end has none.
pub(super) fn renewed<'n>(names: &[&'n str], out: &Path, map: Option<&Path>) -> Vec<&'n str> {
    let whole = |path: &Path| path.canonicalize().ok();
    let is_kept = |name: &str| {
        [MAP, JOB, POSE].contains(&name)
            && map.is_some_and(|map| whole(map).is_some_and(|map| whole(&out.join(MAP)) == Some(map)))
    };
    names.iter().copied().filter(|name| !is_kept(name)).collect()
}

/// Saves `map.bin`, if there is a map, and `pose.bin`, if the robot knows where it is in that: which map it is.
///
/// # Errors
/// What the system says.
pub(super) fn keep(folder: &Folder, session: &Session) -> Result<Option<MapId>, FileError> {
    let kept = keep_map(folder, session)?;
    write_or_remove(folder, POSE, kept.and_then(|map| session.pose_in(map)))?;
    Ok(kept)
}

/// Writes a file, or removes it where there is nothing to write.
///
/// # Errors
/// What the system says.
pub(super) fn write_or_remove(folder: &Folder, name: &str, bytes: Option<impl AsRef<[u8]>>) -> Result<(), FileError> {
    bytes.map_or_else(|| folder.remove(name), |bytes| folder.write(name, bytes))
}

fn keep_map(folder: &Folder, session: &Session) -> Result<Option<MapId>, FileError> {
    let Some(map) = session.map() else { return Ok(None) };
    let Ok(record) = Record::whole(&map) else { return Ok(None) };
    let map = map.get(..4 * record.words()).unwrap_or_default();
    let file = folder.file(MAP);
    map_file::save(&file, map, rig_hash(session.slam().rig()))?;
    Ok(MapId::of(&map_file::read(&file)?))
}
