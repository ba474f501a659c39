//! What a robot senses as `log.csv`, for `lab replay`: one file for each time that it was switched on.

use std::path::Path;

use lab::input::log::writer;
use lab::input::rig_file::Robot;
use lab::show::output::folder::Folder;
use lab::show::output::streams::LineFile;
use wire::Sample;

use crate::port;

/// Files that it may write: a robot that is reset more often is in no state to be recorded.
const MOST: usize = 20;

/// The log that is being written.
pub struct Recorder {
    folder: Folder,
    log: LineFile,
    /// Time of the last sample, microseconds.
    last_us: Option<u64>,
    files: usize,
}

impl Recorder {
    /// Begins; what was recorded in the folder before makes room.
    pub fn begin(out: &Path, robot: &Robot, rig_toml: &str) -> Result<Self, String> {
        let names: Vec<String> = (1..=MOST).map(name).chain(["rig.toml".to_owned()]).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let folder = Folder::prepare(out, &names).map_err(|error| error.to_string())?;
        folder.write("rig.toml", rig_toml).map_err(|error| error.to_string())?;
        let log = create(&folder, 1, robot)?;
        Ok(Self { folder, log, last_us: None, files: 1 })
    }

    /// Writes a sample down; in a file of its own, and so on, of a robot whose time begins anew.
    pub fn take(&mut self, sample: &Sample, robot: &Robot) -> Result<(), String> {
        if self.last_us.is_some_and(|last_us| sample.time_us <= last_us) {
            if self.files == MOST {
                return Err(format!("the robot was reset {MOST} times; what was recorded is complete"));
            }
            self.files += 1;
            eprintln!("note: the robot was reset; what it senses from now on is in {}", name(self.files));
            let log = create(&self.folder, self.files, robot)?;
            std::mem::replace(&mut self.log, log).close().map_err(|error| error.to_string())?;
        }
        self.last_us = Some(sample.time_us);
        let row = port::row(sample, robot, None)?;
        self.log.line(&writer::line(robot, &row)).map_err(|error| error.to_string())
    }

    /// Hands what is written to the system.
    pub fn flush(&mut self) -> Result<(), String> {
        self.log.flush().map_err(|error| error.to_string())
    }

    /// Ends the log.
    pub fn close(self) -> Result<(), String> {
        self.log.close().map_err(|error| error.to_string())
    }
}

/// The file of a robot that was reset so often, less one.
fn name(file: usize) -> String {
    if file == 1 { "log.csv".to_owned() } else { format!("log-{file}.csv") }
}

fn create(folder: &Folder, file: usize, robot: &Robot) -> Result<LineFile, String> {
    let mut log = LineFile::create(folder.file(&name(file))).map_err(|error| error.to_string())?;
    log.line(&writer::header(robot)).map_err(|error| error.to_string())?;
    Ok(log)
}
