//! The tests on logs of real robots, which are not part of the project.

use crate::run::{ACROSS, Result, cargo, root, run};
use std::path::PathBuf;

/// Names the folder of the logs.
pub const VARIABLE: &str = "SLAM_DATA";

/// The folder of the logs: what the variable names, or `shared/data` beside the repository, where the tests look, too.
pub fn folder() -> PathBuf {
    std::env::var_os(VARIABLE).map_or_else(|| root().join("../shared/data"), PathBuf::from)
}

/// Why the tests cannot run here; none where there are logs. That one of the logs is missing is a failure of its test.
pub fn missing() -> Option<String> {
    let folder = folder();
    let has_logs = std::fs::read_dir(&folder).is_ok_and(|mut entries| entries.any(|entry| entry.is_ok()));
    let set = if std::env::var_os(VARIABLE).is_some() { "is set to that" } else { "is not set" };
    (!has_logs)
        .then(|| format!("no logs of real robots in {}; {VARIABLE} names their folder and {set}", folder.display()))
}

/// Runs by name the tests that are ignored elsewhere.
pub fn test() -> Result {
    run(cargo(&ACROSS).args(["--ignored", "real_logs::", "run_page::"]).env(VARIABLE, folder()))
}
