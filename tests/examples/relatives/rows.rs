//! A file of figures by name and seed, which a run that was stopped goes on with.

use std::fmt::Write as _;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::Path;

/// The first seed of every evaluation.
pub const FIRST_SEED: u64 = 51;

/// Figures of one name and seed; a figure that there is not is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The home, or the home and the system.
    pub name: String,
    /// The seed.
    pub seed: u64,
    /// The figures.
    pub figures: Vec<f64>,
}

impl Row {
    fn parse(line: &str) -> Option<Self> {
        let mut cells = line.strip_suffix(';')?.split(',');
        let (name, seed) = (cells.next()?.to_owned(), cells.next()?.parse().ok()?);
        let figures = cells.map(|cell| cell.parse().ok()).collect::<Option<_>>()?;
        Some(Self { name, seed, figures })
    }
}

/// What is in the file; a line that was not finished is left out.
pub fn read(file: &Path) -> Vec<Row> {
    fs::read_to_string(file).unwrap_or_default().lines().filter_map(Row::parse).collect()
}

/// Measures the seeds that the file does not have under this name.
///
/// # Errors
/// The file cannot be written.
pub fn missing(file: &Path, name: &str, seeds: u64, mut measure: impl FnMut(u64) -> Vec<f64>) -> Result<(), String> {
    let done = read(file);
    let said = |error: std::io::Error| format!("{}: {error}", file.display());
    let mut out = OpenOptions::new().create(true).append(true).open(file).map_err(said)?;
    for seed in
        (FIRST_SEED..FIRST_SEED + seeds).filter(|seed| !done.iter().any(|row| row.name == name && row.seed == *seed))
    {
        let mut line = format!("{name},{seed}");
        for figure in measure(seed) {
            let _ = write!(line, ",{figure}");
        }
        writeln!(out, "{line};").map_err(said)?;
    }
    Ok(())
}
