//! Text files, and texts in TOML files.

use std::path::Path;

use serde::{Deserialize, Deserializer};

use crate::FileError;
use crate::number::Given;

/// A text file's content.
///
/// # Errors
/// What the system says.
pub fn read(file: &Path) -> Result<String, FileError> {
    std::fs::read_to_string(file).map_err(|cause| FileError::system(file, "read", &cause))
}

/// A text of a TOML file that is not blank.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text(String);

impl Text {
    /// What must be given.
    pub const ALLOWED: &str = "a text in quotes that is not empty";

    /// The text.
    pub fn get(self) -> String {
        self.0
    }
}

impl AsRef<str> for Text {
    fn as_ref(&self) -> &str {
        &self.0
    }
}

impl<'de> Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = Given::deserialize(deserializer, Self::ALLOWED)?;
        match given {
            Given::Text(text) if !text.trim().is_empty() => Ok(Self(text)),
            wrong => Err(wrong.refused(Self::ALLOWED)),
        }
    }
}
