//! The output folder of an experiment: rows are appended as runs end, so that nothing finished is done twice.

use std::collections::HashSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};

use crate::figures;
use crate::file::Experiment;
use crate::page;
use crate::row::{RunKey, RunRow};
use crate::runner::units;
use crate::samples::ErrorSample;
use input_file::FileError;

/// The rows.
pub const RUNS: &str = "runs.csv";
/// The errors over time that the rows are made from, at a few times of each run.
pub const SAMPLES: &str = "samples.csv";
/// The experiment file that the rows are from.
pub const EXPERIMENT: &str = "experiment.toml";
/// The program, and the rig and plan files, that made them.
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
        Self::open_of(folder, experiment, &build(experiment)?)
    }

    /// The same for rows of the program that says `build` of itself.
    fn open_of(folder: &Path, experiment: &Experiment, build: &str) -> Result<Self, FileError> {
        std::fs::create_dir_all(folder).map_err(|cause| FileError::system(folder, "create", &cause))?;
        refuse_foreign(folder)?;
        let (runs, samples) = (folder.join(RUNS), folder.join(SAMPLES));
        let mut rows = open(&runs)?;
        // Before anything is read or written: what another run writes just now is not to be judged.
        match rows.try_lock() {
            // A file system without locks is used without.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => {
                let what = "is being written by another run; wait until it is over, or name another folder with --out";
                return Err(FileError::new(&runs, what));
            }
        }
        let finished = parse(&runs, &begin(&runs, &mut rows, &RunRow::header())?)?;
        keep_same(&folder.join(EXPERIMENT), &experiment.text, "rows of another experiment")?;
        let other = "rows of another build of this program, or of other rig or plan files";
        keep_same(&folder.join(BUILD), build, other)?;
        let mut errors = open(&samples)?;
        begin(&samples, &mut errors, &ErrorSample::header())?;
        Ok(Self {
            runs: rows,
            samples: errors,
            folder: folder.to_owned(),
            finished: finished.into_iter().map(|row| row.key).collect(),
        })
    }

    /// Whether a run is in the folder already.
    pub fn has(&self, key: &RunKey) -> bool {
        self.finished.contains(key)
    }

    /// Whether every run of the experiment is in the folder.
    ///
    /// # Errors
    /// It names the first one that is not.
    fn is_whole(&self, experiment: &Experiment) -> Result<(), FileError> {
        let units = units(experiment);
        let runs = units.iter().flat_map(|unit| experiment.variants.iter().map(|variant| unit.key(variant)));
        let missing: Vec<RunKey> = runs.filter(|key| !self.has(key)).collect();
        let Some(RunKey { plan, case, seed, variant }) = missing.first() else { return Ok(()) };
        let what = format!(
            "lacks {} runs, the first of plan {plan}, case {case}, seed {seed}, variant {variant}; merge it with the parts that have them",
            missing.len()
        );
        Err(FileError::new(&self.folder, what))
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
    parse(file, &input_file::read(file)?)
}

fn parse(file: &Path, text: &str) -> Result<Vec<RunRow>, FileError> {
    let mut lines = text.lines().enumerate();
    match lines.next() {
        Some((_, header)) if header == RunRow::header() => {}
        _ => return Err(foreign(file, &RunRow::header())),
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
/// The parts are of different experiments or programs, they are not all there, or a file cannot be used.
pub fn merge(folder: &Path, parts: &[PathBuf]) -> Result<Experiment, FileError> {
    let Some(first) = parts.first() else {
        return Err(FileError::new(folder, "nothing to merge; name the folders that --shard wrote"));
    };
    if let Some(missing) = parts.iter().find(|part| !part.is_dir()) {
        return Err(FileError::new(missing, "is no folder; name the folders that --shard wrote"));
    }
    let experiment = Experiment::read(&first.join(EXPERIMENT))?;
    let first_build = input_file::read(&first.join(BUILD))?;
    for part in &parts[1..] {
        is_same(&part.join(EXPERIMENT), &experiment.text, "rows of another experiment than the first part")?;
        let other = "rows of another build of this program, or of other rig or plan files, than the first part's";
        is_same(&part.join(BUILD), &first_build, other)?;
    }
    let mut store = Store::open_of(folder, &experiment, &first_build)?;
    for part in parts {
        let rows = read(&part.join(RUNS))?;
        let new: Vec<RunRow> = rows.into_iter().filter(|row| !store.has(&row.key)).collect();
        let keys: HashSet<&RunKey> = new.iter().map(|row| &row.key).collect();
        let samples = read_samples(&part.join(SAMPLES))?;
        let samples: Vec<ErrorSample> = samples.into_iter().filter(|sample| keys.contains(&sample.key)).collect();
        store.push(&new, &samples)?;
        figures::copy_series(part, folder)?;
    }
    store.is_whole(&experiment)?;
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
    if std::fs::metadata(file).is_err_and(|cause| cause.kind() == ErrorKind::NotFound) {
        return std::fs::write(file, text).map_err(|cause| FileError::system(file, "write", &cause));
    }
    is_same(file, text, &format!("{otherwise}; choose another --out folder or remove this one"))
}

/// Checks that a file holds just `text`.
fn is_same(file: &Path, text: &str, otherwise: &str) -> Result<(), FileError> {
    if input_file::read(file)? == text {
        return Ok(());
    }
    Err(FileError::new(file.parent().unwrap_or(file), format!("holds {otherwise}")))
}

/// Refuses a folder in which no experiment ran before and where its results would take the place of somebody's files.
fn refuse_foreign(folder: &Path) -> Result<(), FileError> {
    if folder.join(BUILD).exists() {
        return Ok(());
    }
    match page::FILES.into_iter().chain([SAMPLES]).find(|name| folder.join(name).exists()) {
        None => Ok(()),
        Some(name) => Err(FileError::new(
            &folder.join(name),
            "was not written by an experiment and would be lost; choose another --out folder or remove it",
        )),
    }
}

/// Opens a file for reading and appending.
fn open(path: &Path) -> Result<File, FileError> {
    let options = OpenOptions::new().create(true).read(true).append(true).open(path);
    options.map_err(|cause| FileError::system(path, "write", &cause))
}

/// What a file of lines holds; a new one begins with `header`, and the half line that a run left that was stopped while it
/// wrote is dropped.
fn begin(path: &Path, file: &mut File, header: &str) -> Result<String, FileError> {
    let mut text = String::new();
    file.read_to_string(&mut text).map_err(|cause| FileError::system(path, "read", &cause))?;
    let first = format!("{header}\n");
    if !text.starts_with(&first) && !first.starts_with(&text) {
        return Err(foreign(path, header));
    }
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    if whole < text.len() {
        file.set_len(whole as u64).map_err(|cause| FileError::system(path, "write", &cause))?;
        text.truncate(whole);
    }
    if text.is_empty() {
        write(file, &first, path)?;
        text = first;
    }
    Ok(text)
}

fn foreign(file: &Path, header: &str) -> FileError {
    FileError::new(file, format!("must begin with the line {header}")).at_line(1)
}

/// The program's version and hashes of its binary and of the rig and plan files: rows of two of a kind must not be mixed.
fn build(experiment: &Experiment) -> Result<String, FileError> {
    let program = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
    let mut text = format!("lab {} {:016x}\n", env!("CARGO_PKG_VERSION"), hash(&program));
    for file in experiment.files() {
        text += &format!("{file} {:016x}\n", hash(input_file::read(Path::new(file))?.as_bytes()));
    }
    Ok(text)
}

/// FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}
