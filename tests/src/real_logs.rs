//! Where real logs are, on machines that have them.

use std::path::PathBuf;

/// The folder of a real log: in `SLAM_DATA`, or in `shared/data` beside the repository. None, said loudly, where it is not
/// there: the logs are not this project's to publish.
pub fn folder(name: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let root = std::env::var_os("SLAM_DATA").map_or_else(beside, PathBuf::from);
    let folder = root.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: no real log {name} in {}; set SLAM_DATA to the folder that holds it", root.display());
    None
}
