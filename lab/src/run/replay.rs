//! `lab replay`: the estimator over a recorded log.

use std::path::{Path, PathBuf};

use serde_json::json;
use slam_core::Config;

use super::Progress;
use super::kept_files::{begin_in, keep, renewed};
use super::session::Session;
use crate::evaluate::score;
use crate::evaluate::smoother;
use crate::input::log::truth::{self, Truth};
use crate::input::log::{self, Rows};
use crate::input::rig_file::{Robot, rig_error};
use crate::input::settings::Settings;
use crate::recording::{Recording, TruthFrame};
use crate::show::output::folder::Folder;
use crate::show::output::streams::Streams;
use crate::show::output::summary::Origin;
use crate::show::output::{self, NAMES};
use input_file::FileError;

/// What to replay.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The log: `log.csv` or CARMEN, plain or gzipped.
    pub log: PathBuf,
    /// The rig file.
    pub rig: PathBuf,
    /// The output folder.
    pub out: PathBuf,
    /// True poses; `truth.csv` beside the log when not given.
    pub truth: Option<PathBuf>,
    /// The kept map that the drive begins in, not knowing where.
    pub map: Option<PathBuf>,
    /// The estimator's settings.
    pub settings: Settings,
    /// Whether to write what became of every reading.
    pub trace: bool,
}

/// What a replay ended with.
#[derive(Debug)]
pub struct Replayed {
    /// Everything that was processed.
    pub recording: Recording,
    /// What a user should know about the log and its truth though it is no error; the record has more, which the run found out.
    pub notes: Vec<String>,
    /// The bad line that the log ended with, where it did not end well. Everything before it is processed and written.
    pub error: Option<FileError>,
}

impl Replay {
    /// Replays the log and writes the output folder; `progress` is told how far it is.
    ///
    /// # Errors
    /// What keeps the replay from starting, or an output from being written.
    pub fn run(&self, mut progress: impl FnMut(Progress)) -> Result<Replayed, FileError> {
        let rig_toml = input_file::read(&self.rig)?;
        let mut robot = Robot::parse(&self.rig, &rig_toml)?;
        let mut rows = log::open(&self.log, &mut robot)?;
        let truth = truth_of(&self.log, self.truth.as_deref())?;
        let config = self.settings.config(&robot);
        let mut session = Session::new(&robot, config, title_of(&self.log)).map_err(|e| rig_error(&self.rig, &e))?;
        begin_in(&mut session, self.map.as_deref())?;
        let mut folder = Folder::prepare(&self.out, &renewed(&NAMES, &self.out, self.map.as_deref()))?;
        let mut streams = Streams::create(&folder)?;
        let mut times_s = Vec::new();
        let error = feed(&mut *rows, &mut session, &mut streams, &mut times_s, &mut progress)?;
        let error = error.or_else(|| without_rows(&self.log, &times_s));
        streams.close()?;
        keep(&folder, &session)?;
        let mut recording = session.finish();
        recording.truth_frame = if self.map.is_some() { TruthFrame::Unknown } else { TruthFrame::FirstPose };
        score::score(&mut recording, &times_s, truth.as_ref());
        let notes = notes(&*rows, &times_s, truth.as_ref());
        recording.notes = notes.iter().cloned().chain(recording.findings()).collect();
        let origin = Origin {
            arguments: vec![
                ("command", json!("replay")),
                ("log", json!(self.log)),
                ("rig", json!(self.rig)),
                ("truth", json!(self.truth)),
                ("map", json!(self.map)),
            ],
            rig_toml,
            config,
            suits: Config::for_rig(&robot.rig),
            trace: self.trace,
            error: error.as_ref().map(ToString::to_string).or_else(|| recording.fault()),
        };
        let looking_back =
            smoother::add(&mut recording, &robot.rig, &mut |rounds| progress(Progress::LookingBack(rounds)));
        output::finish(&mut folder, &recording, looking_back.as_ref(), &origin)?;
        Ok(Replayed { recording, notes, error })
    }
}

/// That a log has no rows, if it has none.
pub(super) fn without_rows(log: &Path, times_s: &[f64]) -> Option<FileError> {
    times_s.is_empty().then(|| FileError::new(log, "has a header but no rows"))
}

/// What a user should know about a log and its truth though it is no error.
pub(super) fn notes(rows: &dyn Rows, times_s: &[f64], truth: Option<&Truth>) -> Vec<String> {
    rows.notes().into_iter().chain(truth.and_then(|truth| truth::without_pairs(times_s, truth))).collect()
}

/// The true poses of a log: of a file, or of `truth.csv` beside it.
pub(super) fn truth_of(log: &Path, file: Option<&Path>) -> Result<Option<Truth>, FileError> {
    let beside = log.with_file_name("truth.csv");
    match file {
        Some(file) => truth::read(file).map(Some),
        None if beside.is_file() => truth::read(&beside).map(Some),
        None => Ok(None),
    }
}

/// Feeds every row to the estimator; the inner error is the bad line that ended the log.
fn feed(
    rows: &mut dyn Rows,
    session: &mut Session,
    streams: &mut Streams,
    times_s: &mut Vec<f64>,
    progress: &mut impl FnMut(Progress),
) -> Result<Option<FileError>, FileError> {
    for row in rows {
        match row {
            Ok(row) => {
                streams.push(session.push(&row))?;
                times_s.push(row.t_s);
                progress(Progress::Rows(times_s.len()));
            }
            Err(error) => return Ok(Some(error)),
        }
    }
    Ok(None)
}

/// A log's name for people: its folder's and its own.
pub(super) fn title_of(log: &Path) -> String {
    let own = log.file_name().unwrap_or(log.as_os_str()).to_string_lossy();
    match log.parent().and_then(Path::file_name) {
        Some(folder) => format!("{}/{own}", folder.to_string_lossy()),
        None => own.into_owned(),
    }
}
