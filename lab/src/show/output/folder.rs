//! The output folder: made where absent, and never a place where a file of somebody else is lost.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::PROGRAM;
use input_file::FileError;

/// An output folder. It is locked as long as this lives: two programs must not write one result.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// `summary.json`, which carries the lock.
    summary: File,
    /// Names of every file there that this program wrote, now or earlier.
    files: Vec<String>,
}

impl Folder {
    /// Makes the folder ready for the files named: those of an earlier run are removed.
    ///
    /// # Errors
    /// The folder cannot be made, or holds a file of one of these names that this program did not write.
    pub fn prepare(path: &Path, names: &[&str]) -> Result<Self, FileError> {
        fs::create_dir_all(path).map_err(|cause| FileError::system(path, "make this folder", &cause))?;
        let summary_file = path.join("summary.json");
        let mut files = files_of_summary(&summary_file);
        for name in names {
            let file = path.join(name);
            let listed = files.iter().any(|own| own == name);
            if !listed && fs::symlink_metadata(&file).is_ok() {
                let what =
                    format!("is not a result of {PROGRAM}, and would be overwritten; name another folder with --out");
                return Err(FileError::new(&file, what));
            }
        }
        let summary = lock(&summary_file)?;
        for name in names.iter().filter(|name| **name != "summary.json") {
            let file = path.join(name);
            if file.exists() {
                fs::remove_file(&file).map_err(|cause| FileError::system(&file, "replace", &cause))?;
            }
            if !files.iter().any(|own| own == name) {
                files.push((*name).to_owned());
            }
        }
        if !files.iter().any(|own| own == "summary.json") {
            files.push("summary.json".to_owned());
        }
        let mut folder = Self { path: path.to_owned(), summary, files };
        // From here on the folder says whose it is, even when the run is interrupted.
        folder.write_summary(&json!({ "finished": false }))?;
        Ok(folder)
    }

    /// A file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a whole file.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) -> Result<(), FileError> {
        let file = self.file(name);
        fs::write(&file, text.as_ref()).map_err(|cause| FileError::system(&file, "write", &cause))
    }

    /// Removes a file, if it is there.
    ///
    /// # Errors
    /// What the system says.
    pub fn remove(&self, name: &str) -> Result<(), FileError> {
        let file = self.file(name);
        match fs::remove_file(&file) {
            Err(cause) if cause.kind() != ErrorKind::NotFound => Err(FileError::system(&file, "remove", &cause)),
            _ => Ok(()),
        }
    }

    /// Writes `summary.json`: who wrote it, the figures given, and which files of the folder are this program's.
    ///
    /// # Errors
    /// What the system says.
    pub fn write_summary(&mut self, figures: &Value) -> Result<(), FileError> {
        let mut summary = json!({ "program": PROGRAM, "version": env!("CARGO_PKG_VERSION") });
        if let (Some(summary), Some(figures)) = (summary.as_object_mut(), figures.as_object()) {
            summary.extend(figures.clone());
            summary.insert("files".to_owned(), json!(self.files));
        }
        // Through the handle that has the lock: on some systems no other one may write.
        let text = format!("{summary:#}\n");
        let file = &mut self.summary;
        let written = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(text.as_bytes()));
        written.map_err(|cause| FileError::system(&self.path.join("summary.json"), "write", &cause))
    }
}

/// Opens a folder's `summary.json` for this program alone.
fn lock(file: &Path) -> Result<File, FileError> {
    let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(file);
    let opened = opened.map_err(|cause| FileError::system(file, "write", &cause))?;
    match opened.try_lock() {
        // A file system without locks is used without.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(opened),
        Err(TryLockError::WouldBlock) => {
            let what = "is being written by another run; wait until it is over, or name another folder with --out";
            Err(FileError::new(file, what))
        }
    }
}

/// The files that an earlier run lists as its own; none where there was none.
fn files_of_summary(file: &Path) -> Vec<String> {
    let Ok(text) = fs::read_to_string(file) else { return Vec::new() };
    let Ok(summary) = serde_json::from_str::<Value>(&text) else { return Vec::new() };
    if summary["program"] != PROGRAM {
        return Vec::new();
    }
    let files = summary["files"].as_array().cloned().unwrap_or_default();
    files.iter().filter_map(Value::as_str).map(str::to_owned).collect()
}
