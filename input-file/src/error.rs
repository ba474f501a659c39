//! What can be wrong with a file or a request, said once and clearly.

use std::fmt;
use std::path::{Path, PathBuf};

/// Something wrong with a file: where it is, what is wrong and what would be right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file.
    pub file: PathBuf,
    /// Line, counted from one, where there is one.
    pub line: Option<usize>,
    /// Key or column, where there is one.
    pub place: Option<String>,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl FileError {
    /// An error about the whole file.
    pub fn new(file: &Path, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line: None, place: None, message: message.into() }
    }

    /// What the system said when the file could not be used for `purpose` ("read", "write", "create").
    pub fn system(file: &Path, purpose: &str, cause: &std::io::Error) -> Self {
        Self::new(file, format!("cannot {purpose}: {cause}"))
    }

    /// The same error at a line.
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// The same error at a key or column.
    pub fn at(mut self, place: impl Into<String>) -> Self {
        self.place = Some(place.into());
        self
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(place) = &self.place {
            write!(f, ": {place}")?;
        }
        write!(f, ": {}", self.message)
    }
}

impl std::error::Error for FileError {}
