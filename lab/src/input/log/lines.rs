//! Lines of a text file, gzipped or not, with their numbers.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;

use input_file::FileError;

/// Longest line, bytes: a row of ten thousand beams has fewer.
const LONGEST: u64 = 1 << 20;

/// The lines of a file.
pub struct Lines {
    file: PathBuf,
    input: Box<dyn BufRead>,
    number: usize,
    peeked: Option<(usize, String)>,
}

impl Lines {
    /// Opens a file.
    pub fn open(file: &Path) -> Result<Self, FileError> {
        let content = File::open(file).map_err(|cause| FileError::system(file, "read", &cause))?;
        Self::of(file, BufReader::new(content))
    }

    /// The lines of a file's content; gzip is recognised by its first two bytes.
    pub fn of(file: &Path, mut plain: impl BufRead + 'static) -> Result<Self, FileError> {
        let system = |cause| FileError::system(file, "read", &cause);
        let gzipped = plain.fill_buf().map_err(system)?.starts_with(&[0x1f, 0x8b]);
        let input: Box<dyn BufRead> =
            if gzipped { Box::new(BufReader::new(MultiGzDecoder::new(plain))) } else { Box::new(plain) };
        Ok(Self { file: file.to_owned(), input, number: 0, peeked: None })
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// An error at a line.
    pub fn error(&self, line: usize, message: impl Into<String>) -> FileError {
        FileError::new(&self.file, message).at_line(line)
    }

    /// The next line that is neither blank nor a `#` comment, without taking it.
    pub fn peek_content(&mut self) -> Result<Option<String>, FileError> {
        if self.peeked.is_none() {
            self.peeked = self.next_content()?;
        }
        Ok(self.peeked.as_ref().map(|(_, line)| line.clone()))
    }

    /// The next line that is neither blank nor a `#` comment, with its number.
    pub fn next_content(&mut self) -> Result<Option<(usize, String)>, FileError> {
        if let Some(peeked) = self.peeked.take() {
            return Ok(Some(peeked));
        }
        while let Some(line) = self.read_line()? {
            let content = line.trim();
            if !content.is_empty() && !content.starts_with('#') {
                return Ok(Some((self.number, content.to_owned())));
            }
        }
        Ok(None)
    }

    fn read_line(&mut self) -> Result<Option<String>, FileError> {
        let mut bytes = Vec::new();
        let length = (&mut self.input)
            .take(LONGEST + 1)
            .read_until(b'\n', &mut bytes)
            .map_err(|cause| self.error(self.number + 1, format!("cannot read on: {cause}")))?;
        if length == 0 {
            return Ok(None);
        }
        self.number += 1;
        if length as u64 > LONGEST {
            return Err(self.error(self.number, format!("is longer than {LONGEST} bytes; a log has one sample a line")));
        }
        // Spreadsheets put a byte order mark before the header.
        let bytes = if self.number == 1 { bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes) } else { &bytes };
        match std::str::from_utf8(bytes) {
            Ok(text) => Ok(Some(text.to_owned())),
            Err(_) => Err(self.error(self.number, "is not text; a log is a text file in UTF-8, gzipped or not")),
        }
    }
}
