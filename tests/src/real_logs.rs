//! Where real logs are, on machines that have them.

use std::path::PathBuf;

use lab::input::settings::Settings;
use lab::run::{Replay, Replayed};
use slam_core::Config;

/// A log of a real robot.
#[derive(Clone, Copy, Debug)]
pub struct RealLog {
    /// Its folder.
    pub name: &'static str,
    /// The log within the folder.
    pub file: &'static str,
    /// The robot's rig file within the folder.
    pub rig: &'static str,
    /// Where it is from.
    pub about: &'static str,
}

/// Seven beams of a real laser in offices, with a truth.
pub const FREIBURG: RealLog = RealLog {
    name: "fr079-first",
    file: "log.csv",
    rig: "rig.toml",
    about: "seven beams of a real laser in offices, up to 3 m; odometry with synthetic errors",
};

/// Four time-of-flight beams of a drone in hallways.
pub const HALLWAYS: RealLog = RealLog {
    name: "olsson-demo",
    file: "log.csv",
    rig: "rig.toml",
    about: "four time-of-flight beams of a drone in hallways, up to 2 m",
};

/// A CARMEN log of a corridor.
pub const CORRIDOR: RealLog = RealLog {
    name: "wean-1",
    file: "wean.log.gz",
    rig: "rig.toml",
    about: "seven beams of a real laser in a corridor, up to 5 m; real wheel odometry",
};

/// Another log of it.
pub const CORRIDOR_5: RealLog = RealLog { name: "wean-5", about: "another drive through that corridor", ..CORRIDOR };

/// The offices with the odometry that the robot's wheels made.
pub const FREIBURG_WHEELS: RealLog = RealLog {
    name: "fr079-first-realodo",
    file: "log.csv",
    rig: "rig.toml",
    about: "the same offices with the odometry of the robot's wheels",
};

/// Three laps of office corridors, at one row a second.
pub const INTEL: RealLog = RealLog {
    name: "intel-loops",
    file: "log.csv",
    rig: "rig.toml",
    about: "seven beams of a real laser in office corridors, one row a second, with the odometry of the robot's wheels",
};

/// A drone with eight beams of its time-of-flight sensors in an office.
pub const DRONE_8: RealLog = RealLog {
    name: "smcl-S8",
    file: "log.csv",
    rig: "rig.toml",
    about: "eight time-of-flight beams of a drone in an office, up to 2.5 m",
};

/// Another flight of it.
pub const DRONE_12: RealLog = RealLog { name: "smcl-S12", about: "another flight of that drone", ..DRONE_8 };

impl RealLog {
    /// The same log as a robot of two wheels has it: ticks instead of a pose.
    pub const fn with_wheels(self) -> Self {
        Self { rig: "rig-wheels.toml", ..self }
    }

    /// The log's folder, in `SLAM_DATA` or in `shared/data` beside the repository.
    ///
    /// # Panics
    /// It is not there: the logs are not this project's to publish.
    pub fn folder(&self) -> PathBuf {
        let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
        let root = std::env::var_os("SLAM_DATA").map_or_else(beside, PathBuf::from);
        let folder = root.join(self.name);
        let name = self.name;
        assert!(folder.is_dir(), "no real log {name} in {}; set SLAM_DATA to the folder that holds it", root.display());
        folder
    }

    /// Replays it with the estimator's defaults, as the program does.
    ///
    /// # Panics
    /// It is not at hand, or cannot be replayed.
    pub fn replay(&self) -> Replayed {
        let folder = self.folder();
        let out = tempfile::TempDir::new().expect("a temporary folder");
        let replay = Replay {
            log: folder.join(self.file),
            rig: folder.join(self.rig),
            out: out.path().to_owned(),
            truth: None,
            map: None,
            settings: Settings::Exactly(Config::real_rooms()),
            trace: false,
        };
        replay.run(|_| ()).unwrap_or_else(|error| panic!("{error}"))
    }
}
