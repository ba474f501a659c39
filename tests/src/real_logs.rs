//! Where real logs are, on machines that have them.

use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use lab::replay::{Replay, Replayed};
use slam_core::Config;

/// A log of a real robot.
#[derive(Clone, Copy, Debug)]
pub struct RealLog {
    /// Its folder.
    pub name: &'static str,
    /// The log within the folder.
    pub file: &'static str,
    /// Where it is from.
    pub about: &'static str,
}

/// Seven beams of a real laser in offices, with a truth.
pub const FREIBURG: RealLog = RealLog {
    name: "fr079-first",
    file: "log.csv",
    about: "seven beams of a real laser in offices, up to 3 m; odometry with synthetic errors",
};

/// Four time-of-flight beams of a drone in hallways.
pub const HALLWAYS: RealLog = RealLog {
    name: "olsson-demo",
    file: "log.csv",
    about: "four time-of-flight beams of a drone in hallways, up to 2 m",
};

/// A CARMEN log of a corridor.
pub const CORRIDOR: RealLog = RealLog {
    name: "wean-1",
    file: "wean.log.gz",
    about: "seven beams of a real laser in a corridor, up to 5 m; real wheel odometry",
};

impl RealLog {
    /// The log's folder, in `SLAM_DATA` or in `shared/data` beside the repository. None, said loudly, where it is not
    /// there: the logs are not this project's to publish.
    pub fn folder(&self) -> Option<PathBuf> {
        let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
        let root = std::env::var_os("SLAM_DATA").map_or_else(beside, PathBuf::from);
        let folder = root.join(self.name);
        if folder.is_dir() {
            return Some(folder);
        }
        // Straight to the stream: the test harness would swallow what a passing test prints.
        let _ = writeln!(
            io::stderr(),
            "\nSKIPPED: no real log {} in {}; set SLAM_DATA to the folder that holds it\n",
            self.name,
            root.display()
        );
        None
    }

    /// Replays it with the estimator's defaults; none where it is not at hand.
    ///
    /// # Panics
    /// It cannot be replayed.
    pub fn replay(&self) -> Option<Replayed> {
        self.replay_as(&Trial::default())
    }

    /// Replays it otherwise; none where it is not at hand.
    ///
    /// # Panics
    /// It cannot be replayed.
    pub fn replay_as(&self, trial: &Trial) -> Option<Replayed> {
        let folder = self.folder()?;
        let place = tempfile::TempDir::new().expect("a temporary folder");
        let rig_toml = fs::read_to_string(folder.join("rig.toml")).expect("the log's rig file");
        let rig = place.path().join("rig.toml");
        fs::write(&rig, trial.rig(&rig_toml)).expect("a rig file");
        let replay = Replay {
            log: folder.join(self.file),
            rig,
            out: place.path().join("out"),
            truth: None,
            config: trial.config,
            trace: false,
        };
        Some(replay.run(|_| ()).unwrap_or_else(|error| panic!("{error}")))
    }
}

/// What a replay of a real log differs in from the log's own rig file and the estimator's defaults.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// The estimator's settings.
    pub config: Config,
    /// Longest range that is a reading, metres, where the rig file allows more.
    pub cap_m: f64,
    /// Factor of the range sensors' noise.
    pub noise: f64,
}

impl Default for Trial {
    fn default() -> Self {
        Self { config: Config::default(), cap_m: f64::INFINITY, noise: 1.0 }
    }
}

impl Trial {
    /// A rig file with this trial's caps and noise.
    fn rig(&self, rig_toml: &str) -> String {
        let changed = |line: &str| {
            let (key, value) = line.split_once('=')?;
            let value: f64 = value.split('#').next()?.trim().parse().ok()?;
            let value = match key.trim() {
                "max_m" => value.min(self.cap_m),
                "noise_m" | "noise_rel" | "noise_v" => value * self.noise,
                _ => return None,
            };
            Some(format!("{key}= {value}"))
        };
        rig_toml.lines().map(|line| changed(line).unwrap_or_else(|| line.to_owned()) + "\n").collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_changes_caps_and_noise_alone() {
        let rig_toml = "[[range_sensor]]\nname = \"a\"\nmax_m = 3.0 # far\nnoise_m = 0.02\nmin_m = 0.1\n";
        assert_eq!(Trial::default().rig(rig_toml), rig_toml.replace("3.0 # far", "3"));
        let trial = Trial { cap_m: 1.5, noise: 0.5, ..Trial::default() };
        assert_eq!(trial.rig(rig_toml), rig_toml.replace("3.0 # far", "1.5").replace("0.02", "0.01"));
    }
}
