//! What a run or a replay leaves in its output folder.

mod floor;
pub mod folder;
pub mod streams;
pub mod summary;
pub mod tables;
pub mod trace;

use crate::recording::Recording;
use crate::show::report;
use folder::Folder;
use input_file::FileError;
use summary::Origin;

/// What every run and replay writes, apart from what it adds of its own.
pub const NAMES: [&str; 14] = [
    "map.bin",
    "pose.bin",
    "trajectory.tum",
    "truth.tum",
    "estimate.csv",
    "walls.csv",
    "calibration.csv",
    "summary.json",
    "report.html",
    "readings.csv",
    "looking-back.tum",
    "looking-back.html",
    "floor.csv",
    "floor.pgm",
];

/// Writes everything that is written when a run is over, of the record and of how it looks from the end; what grew with the
/// rows is there already.
///
/// # Errors
/// What the system says about the first file that cannot be written.
pub fn finish(
    folder: &mut Folder,
    recording: &Recording,
    looking_back: Option<&Recording>,
    origin: &Origin,
) -> Result<(), FileError> {
    folder.write("walls.csv", tables::walls(recording))?;
    folder.write("calibration.csv", tables::calibration(recording))?;
    if origin.trace {
        trace::write(folder, recording)?;
    }
    if let Some(truth) = tables::truth(recording) {
        folder.write("truth.tum", &truth)?;
    }
    if let Some(score) = recording.swept_floor() {
        folder.write("floor.csv", floor::progress(score))?;
        folder.write("floor.pgm", floor::picture(&score.picture))?;
    }
    write_page(folder, recording, "report.html")?;
    if let Some(back) = looking_back {
        folder.write("looking-back.tum", tables::path(back))?;
        write_page(folder, back, "looking-back.html")?;
    }
    folder.write_summary(&summary::summary(recording, origin))
}

fn write_page(folder: &Folder, recording: &Recording, name: &str) -> Result<(), FileError> {
    let page = folder.file(name);
    report::write(recording, &page).map_err(|cause| FileError::system(&page, "write", &cause))
}
