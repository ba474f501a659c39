//! The estimator at work: a [`Session`] is fed row by row, by a simulated [`Drive`] or by a log; [`Run`] and [`Replay`] do
//! that from input files to the output folder.

mod drive;
mod floor_drive;
mod kept_files;
mod life;
mod map_file;
mod relative;
mod replay;
mod session;
mod simulate;
mod suits;

use robot::FloorRecordError;

pub use crate::recording::Job;
pub use drive::Drive;
pub use floor_drive::{FloorDrive, clean, clean_by, clean_with};
pub use life::{Place, Searched};
pub use map_file::{MapId, newest as newest_map};
pub use relative::{RelativeReplay, RelativeSession, covariance_of, look_back, to_record, views};
pub use replay::{Replay, Replayed};
pub use session::{Session, begun, parameter_name};
pub use simulate::Run;
pub use suits::unsuitable;

/// How far a run or a replay is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// Share of the drive that is done, 0 to 1: of the time, or of the floor where the job is to sweep it.
    Driven(f64),
    /// Rows of the log that are done.
    Rows(usize),
    /// There is a floor job beside the kept map, which the drive does not go on with.
    Dropped(FloorRecordError),
    /// The rows are done; rounds in which path and map were placed once more.
    LookingBack(usize),
}
