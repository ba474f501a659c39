//! The output folder of an experiment: rows are appended as runs end, so that nothing finished is done twice.

use std::collections::HashSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::file::Experiment;
use crate::row::{RunKey, RunRow};
use crate::samples::ErrorSample;
use input_file::FileError;

/// The rows.
pub const RUNS: &str = "runs.csv";
/// The errors over time that the rows are made from, at a few times of each run.
pub const SAMPLES: &str = "samples.csv";
/// The experiment file that the rows are from.
pub const EXPERIMENT: &str = "experiment.toml";
/// The program that made them.
pub const BUILD: &str = "build.txt";

/// An output folder open for appending.
pub struct Store {
    folder: PathBuf,
    runs: File,
    samples: File,
    finished: HashSet<RunKey>,
}

impl Store {
    /// Opens the folder for this experiment: a new one, or one whose rows are of the same experiment and program.
    ///
    /// # Errors
    /// The folder holds something else, or cannot be used.
    pub fn open(folder: &Path, experiment: &Experiment) -> Result<Self, FileError> {
        std::fs::create_dir_all(folder).map_err(|cause| FileError::system(folder, "create", &cause))?;
        keep_same(&folder.join(EXPERIMENT), &experiment.text, "rows of another experiment")?;
        keep_same(&folder.join(BUILD), &build(), "rows that another build of this program made")?;
        let runs = folder.join(RUNS);
        drop_half_line(&runs)?;
        drop_half_line(&folder.join(SAMPLES))?;
        let finished = if runs.exists() { read(&runs)? } else { Vec::new() };
        let rows = append(&runs, &RunRow::header())?;
        match rows.try_lock() {
            // A file system without locks is used without.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => {
                let what = "is being written by another run; wait until it is over, or name another folder with --out";
                return Err(FileError::new(&runs, what));
            }
        }
        Ok(Self {
            runs: rows,
            samples: append(&folder.join(SAMPLES), &ErrorSample::header())?,
            folder: folder.to_owned(),
            finished: finished.into_iter().map(|row| row.key).collect(),
        })
    }

    /// Whether a run is in the folder already.
    pub fn has(&self, key: &RunKey) -> bool {
        self.finished.contains(key)
    }

    /// Appends the results of one unit of work.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, rows: &[RunRow], samples: &[ErrorSample]) -> Result<(), FileError> {
        // The rows come last: a run that is in the rows has all its samples.
        let text: String = samples.iter().map(|sample| sample.line() + "\n").collect();
        write(&mut self.samples, &text, &self.folder.join(SAMPLES))?;
        let text: String = rows.iter().map(|row| row.line() + "\n").collect();
        write(&mut self.runs, &text, &self.folder.join(RUNS))?;
        self.finished.extend(rows.iter().map(|row| row.key.clone()));
        Ok(())
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

/// The rows of a file, in order, each run once.
///
/// # Errors
/// The file cannot be read, or a line is no row.
pub fn read(file: &Path) -> Result<Vec<RunRow>, FileError> {
    let text = input_file::read(file)?;
    let mut lines = text.lines().enumerate();
    match lines.next() {
        Some((_, header)) if header == RunRow::header() => {}
        _ => return Err(FileError::new(file, format!("must begin with the line {}", RunRow::header())).at_line(1)),
    }
    let mut rows = Vec::new();
    for (i, line) in lines {
        let row = RunRow::parse(line).ok_or_else(|| FileError::new(file, "is no row of results").at_line(i + 1))?;
        rows.push(row);
    }
    Ok(unique(rows, |row| row.key.clone()))
}

/// The samples of a file, in order, each once.
///
/// # Errors
/// The file cannot be read, or a line is no sample.
pub fn read_samples(file: &Path) -> Result<Vec<ErrorSample>, FileError> {
    let text = input_file::read(file)?;
    let mut samples = Vec::new();
    for (i, line) in text.lines().enumerate().skip(1) {
        let sample = ErrorSample::parse(line)
            .ok_or_else(|| FileError::new(file, "is no sample of a run's errors").at_line(i + 1))?;
        samples.push(sample);
    }
    Ok(unique(samples, |sample| (sample.key.clone(), sample.t_s.to_bits())))
}

/// Joins the rows of folders that shards wrote into one folder.
///
/// # Errors
/// The parts are of different experiments or programs, or a file cannot be used.
pub fn merge(folder: &Path, parts: &[PathBuf]) -> Result<Experiment, FileError> {
    let Some(first) = parts.first() else {
        return Err(FileError::new(folder, "nothing to merge; name the folders that --shard wrote"));
    };
    let experiment = Experiment::read(&first.join(EXPERIMENT))?;
    let first_build = input_file::read(&first.join(BUILD))?;
    std::fs::create_dir_all(folder).map_err(|cause| FileError::system(folder, "create", &cause))?;
    keep_same(&folder.join(EXPERIMENT), &experiment.text, "rows of another experiment")?;
    keep_same(&folder.join(BUILD), &first_build, "rows that another build of this program made")?;
    let mut store = Store {
        runs: append(&folder.join(RUNS), &RunRow::header())?,
        samples: append(&folder.join(SAMPLES), &ErrorSample::header())?,
        folder: folder.to_owned(),
        finished: read(&folder.join(RUNS))?.into_iter().map(|row| row.key).collect(),
    };
    for part in parts {
        keep_same(&part.join(EXPERIMENT), &experiment.text, "rows of another experiment than the first part")?;
        keep_same(&part.join(BUILD), &first_build, "rows of another build of this program than the first part's")?;
        let rows = read(&part.join(RUNS))?;
        let new: Vec<RunRow> = rows.into_iter().filter(|row| !store.has(&row.key)).collect();
        let keys: HashSet<&RunKey> = new.iter().map(|row| &row.key).collect();
        let samples = read_samples(&part.join(SAMPLES))?;
        let samples: Vec<ErrorSample> = samples.into_iter().filter(|sample| keys.contains(&sample.key)).collect();
        store.push(&new, &samples)?;
    }
    Ok(experiment)
}

fn unique<T, K: std::hash::Hash + Eq>(all: Vec<T>, key: impl Fn(&T) -> K) -> Vec<T> {
    let mut seen = HashSet::new();
    all.into_iter().filter(|one| seen.insert(key(one))).collect()
}

fn write(file: &mut File, text: &str, path: &Path) -> Result<(), FileError> {
    file.write_all(text.as_bytes()).map_err(|cause| FileError::system(path, "write", &cause))
}

/// Writes `text` where there is no file, and otherwise checks that the file holds just that.
fn keep_same(file: &Path, text: &str, otherwise: &str) -> Result<(), FileError> {
    match std::fs::read_to_string(file) {
        Ok(present) if present == text => Ok(()),
        Ok(_) => Err(FileError::new(
            file.parent().unwrap_or(file),
            format!("holds {otherwise}; choose another --out folder or remove this one"),
        )),
        Err(_) => std::fs::write(file, text).map_err(|cause| FileError::system(file, "write", &cause)),
    }
}

/// Opens a file for appending; a new one begins with `header`.
fn append(path: &Path, header: &str) -> Result<File, FileError> {
    let system = |cause: std::io::Error| FileError::system(path, "write", &cause);
    let mut file = OpenOptions::new().create(true).append(true).open(path).map_err(system)?;
    if file.metadata().map_err(system)?.len() == 0 {
        write(&mut file, &format!("{header}\n"), path)?;
    }
    Ok(file)
}

/// A run that was stopped while it wrote leaves half a line.
fn drop_half_line(path: &Path) -> Result<(), FileError> {
    let Ok(text) = std::fs::read_to_string(path) else { return Ok(()) };
    if text.is_empty() || text.ends_with('\n') {
        return Ok(());
    }
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    std::fs::write(path, whole).map_err(|cause| FileError::system(path, "write", &cause))
}

/// The program's version and a hash (FNV-1a) of its binary: rows of two builds must not be mixed.
fn build() -> String {
    let bytes = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
    let hash = bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    format!("lab {} {hash:016x}\n", env!("CARGO_PKG_VERSION"))
}
