//! `lab compare`: two runs' or replays' scores side by side.

mod scores;
mod summary;
mod table;

use std::path::PathBuf;

use clap::Args;
use serde_json::Value;

use input_file::FileError;
pub use scores::{Better, Row, rows};
pub use summary::Summary;

/// Two output folders to compare.
#[derive(Clone, Debug, Args)]
pub struct Compare {
    /// Output folder of a run or a replay, the one to compare with.
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// Output folder of another.
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Both sides, what is doubtful about comparing them, and their scores.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The first folder.
    pub a: Summary,
    /// The second.
    pub b: Summary,
    /// What a reader should know before believing a difference.
    pub warnings: Vec<String>,
    /// One row for each score that either side has.
    pub rows: Vec<Row>,
}

impl Compare {
    /// Reads both summaries.
    ///
    /// # Errors
    /// A folder that is no output of this program, or holds no figures.
    pub fn run(&self) -> Result<Comparison, FileError> {
        let (a, b) = (Summary::read(&self.a)?, Summary::read(&self.b)?);
        let (warnings, rows) = (a.doubts(&b), rows(&a.value, &b.value));
        Ok(Comparison { a, b, warnings, rows })
    }

    /// The comparison as text, as asked for.
    ///
    /// # Errors
    /// As [`Compare::run`].
    pub fn text(&self) -> Result<String, FileError> {
        let comparison = self.run()?;
        Ok(if self.json { format!("{:#}\n", comparison.json()) } else { table::text(&comparison) })
    }
}

impl Comparison {
    /// The comparison as JSON.
    pub fn json(&self) -> Value {
        let side = |summary: &Summary| serde_json::json!({ "folder": summary.folder, "title": summary.title() });
        serde_json::json!({
            "a": side(&self.a),
            "b": side(&self.b),
            "warnings": self.warnings,
            "scores": self.rows.iter().map(Row::json).collect::<Vec<_>>(),
        })
    }
}
