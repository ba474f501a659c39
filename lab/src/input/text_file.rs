//! Text files, which are read whole.

use std::path::Path;

use crate::error::FileError;

/// A text file's content.
///
/// # Errors
/// What the system says.
pub fn read(file: &Path) -> Result<String, FileError> {
    std::fs::read_to_string(file).map_err(|cause| FileError::system(file, "read", &cause))
}
