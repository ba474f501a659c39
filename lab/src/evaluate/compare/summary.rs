//! A `summary.json` that has figures, and whether two of them can be compared.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use crate::PROGRAM;
use input_file::FileError;

/// What a run or a replay left in its folder.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The folder.
    pub folder: PathBuf,
    /// Its `summary.json`.
    pub value: Value,
}

impl Summary {
    /// Reads a folder's summary.
    ///
    /// # Errors
    /// There is no such folder, no summary in it, or none with figures.
    pub fn read(folder: &Path) -> Result<Self, FileError> {
        let error =
            |what: &str| FileError::new(folder, format!("{what}; name an output folder of lab run or lab replay"));
        if !folder.is_dir() {
            return Err(error(if folder.exists() { "is not a folder" } else { "is not there" }));
        }
        let file = folder.join("summary.json");
        if !file.is_file() {
            return Err(error("holds no summary.json"));
        }
        let text = input_file::read(&file)?;
        let what = format!("; it must be the summary.json of {PROGRAM}");
        let value: Value = serde_json::from_str(&text)
            .map_err(|cause| FileError::new(&file, format!("is not JSON ({cause}){what}")).at_line(cause.line()))?;
        if value["program"] != PROGRAM {
            return Err(FileError::new(&file, format!("names no program of this kind{what}")).at("program"));
        }
        if !value["rows"].is_number() {
            return Err(FileError::new(&file, "is missing: the run did not end, or was none; run it again").at("rows"));
        }
        Ok(Self { folder: folder.to_owned(), value })
    }

    /// What was run.
    pub fn title(&self) -> &str {
        self.value["title"].as_str().unwrap_or("")
    }

    /// Why a difference to `other` may mean less than it seems.
    pub fn doubts(&self, other: &Self) -> Vec<String> {
        let mut doubts = Vec::new();
        let same = |key: &str| self.value[key] == other.value[key];
        // Dead reckoning and time are the log's own: no estimator changes them.
        if !(same("rows") && same("path_m") && same("duration_s")) {
            let side = |summary: &Self| {
                let number = |key: &str| summary.value[key].as_f64().unwrap_or(f64::NAN);
                format!("{} ({:.1} m, {:.0} s)", summary.title(), number("path_m"), number("duration_s"))
            };
            doubts.push(format!("different logs: {} and {}", side(self), side(other)));
        }
        let lost = |summary: &Self| 100.0 * summary.value["lost"].as_f64().unwrap_or(0.0);
        if lost(self) != lost(other) {
            doubts.push(format!(
                "scores against the truth are of other rows: A claims no place in {:.1} %, B in {:.1} %",
                lost(self),
                lost(other)
            ));
        }
        for (name, summary) in [("A", self), ("B", other)] {
            if summary.value["finished"] != true {
                let why = summary.value["error"].as_str().unwrap_or("not finished");
                doubts.push(format!("{name} ended early: {why}"));
            }
        }
        if self.value["configuration"]["rig_toml"] != other.value["configuration"]["rig_toml"] {
            doubts.push("the rig files differ".to_owned());
        }
        if !same("version") {
            doubts.push("two versions of the program wrote them".to_owned());
        }
        doubts
    }

    /// Settings of the estimator that differ: name, own value, the other's.
    pub fn settings_changed<'a>(&'a self, other: &'a Self) -> Vec<(&'a str, &'a Value, &'a Value)> {
        let none = Map::new();
        let settings = |summary: &'a Self| summary.value["configuration"]["estimator"].as_object();
        let (Some(own), others) = (settings(self), settings(other)) else { return Vec::new() };
        let others = others.unwrap_or(&none);
        let changed = own.iter().filter(|(name, value)| others.get(*name).is_some_and(|other| other != *value));
        changed.map(|(name, value)| (name.as_str(), value, &other.value["configuration"]["estimator"][name])).collect()
    }
}
