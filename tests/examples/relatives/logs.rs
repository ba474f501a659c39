//! The logs of real robots, replayed by each system.

use std::fmt::Write as _;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::Path;

use lab::evaluate::score;
use lab::input::log;
use lab::input::log::truth;
use lab::input::rig_file::Robot;
use lab::recording::Recording;
use lab::run::{RelativeSession, look_back};
use relatives::{Kind, Setup};
use slam_core::RangeModel;
use tests::real_logs::{CORRIDOR, DRONE_8, DRONE_12, FREIBURG, FREIBURG_WHEELS, HALLWAYS, INTEL, RealLog};
use tests::trial::{LoadedLog, NOISES, Trial};

/// The file of what was found.
pub const FILE: &str = "logs.csv";

/// The logs.
pub const LOGS: [RealLog; 7] = [FREIBURG, HALLWAYS, CORRIDOR, FREIBURG_WHEELS, INTEL, DRONE_8, DRONE_12];

/// The estimator's name beside the systems'.
pub const OURS: &str = "ours";

/// Figures of one replay, in the order of the file.
pub const FIGURES: [&str; 8] = [
    "ate_m",
    "odometry_ate_m",
    "sharper_nats",
    "apart_m",
    "back_ate_m",
    "back_sharper_nats",
    "back_apart_m",
    "step_us",
];

/// One replay; a figure that there is not is not a number.
pub struct Found {
    /// The log's name.
    pub log: String,
    /// The system's.
    pub system: String,
    /// Index of the noise.
    pub replay: usize,
    /// The figures.
    pub figures: [f64; FIGURES.len()],
    /// Why it cannot run; empty where it can.
    pub cannot: String,
}

impl Found {
    fn line(&self) -> String {
        let mut line = format!("{},{},{}", self.log, self.system, self.replay);
        for figure in self.figures {
            let _ = write!(line, ",{figure}");
        }
        format!("{line},{}", self.cannot)
    }

    fn parse(line: &str) -> Option<Self> {
        let mut cells = line.splitn(4 + FIGURES.len(), ',');
        let (log, system) = (cells.next()?.to_owned(), cells.next()?.to_owned());
        let replay = cells.next()?.parse().ok()?;
        let mut figures = [f64::NAN; FIGURES.len()];
        for figure in &mut figures {
            *figure = cells.next()?.parse().ok()?;
        }
        Some(Self { log, system, replay, figures, cannot: cells.next()?.to_owned() })
    }
}

/// What is in the file; a line that was not finished is left out.
pub fn read(file: &Path) -> Vec<Found> {
    fs::read_to_string(file).unwrap_or_default().lines().filter_map(Found::parse).collect()
}

/// Replays what is not in the file yet.
///
/// # Errors
/// The file cannot be written.
pub fn run(file: &Path, replays: usize) -> Result<(), String> {
    let done = read(file);
    let said = |error: std::io::Error| format!("{}: {error}", file.display());
    let mut out = OpenOptions::new().create(true).append(true).open(file).map_err(said)?;
    let systems: Vec<Option<Kind>> = std::iter::once(None).chain(Kind::ALL.map(Some)).collect();
    for replay in 0..replays {
        for log in LOGS {
            if std::panic::catch_unwind(|| log.folder()).is_err() {
                eprintln!("{} is not at hand and is left out", log.name);
                continue;
            }
            for system in &systems {
                let name = system.map_or(OURS, Kind::name);
                if done.iter().any(|found| found.log == log.name && found.system == name && found.replay == replay) {
                    continue;
                }
                eprintln!("{}: {name}, replay {}", log.name, replay + 1);
                let found = system.map_or_else(|| ours(log, replay), |kind| theirs(log, kind, replay));
                writeln!(out, "{}", found.line()).map_err(said)?;
            }
        }
    }
    Ok(())
}

fn ours(log: RealLog, replay: usize) -> Found {
    let recording = LoadedLog::read(log).replay(&Trial { noise: NOISES[replay], ..Trial::default() });
    found(log, OURS, replay, &recording)
}

fn theirs(log: RealLog, kind: Kind, replay: usize) -> Found {
    let folder = log.folder();
    let good = "the log was read before";
    let mut robot = Robot::read(&folder.join(log.rig)).expect(good);
    let mut rows = log::open(&folder.join(log.file), &mut robot).expect(good);
    for sensor in &mut robot.rig.sensors {
        if let RangeModel::Metric { noise_m, noise_rel } = &mut sensor.model {
            *noise_m *= NOISES[replay];
            *noise_rel *= NOISES[replay];
        }
    }
    let setup = Setup { seed: replay as u64, has_scans: rows.has_scans(), ..Setup::default() };
    let mut session = match RelativeSession::new(&robot, kind, &setup, String::new()) {
        Ok(session) => session,
        Err(why) => {
            let (log, system, cannot) = (log.name.to_owned(), kind.name().to_owned(), why.to_owned());
            return Found { log, system, replay, figures: [f64::NAN; FIGURES.len()], cannot };
        }
    };
    let mut times_s = Vec::new();
    while let Some(Ok(row)) = rows.next() {
        session.push(&row, rows.whole_scan());
        times_s.push(row.t_s);
    }
    let (mut recording, path) = session.finish();
    let truth = folder.join("truth.csv");
    let truth = truth.is_file().then(|| truth::read(&truth).expect(good));
    score::score(&mut recording, &times_s, truth.as_ref());
    if let Some(path) = path {
        look_back(&mut recording, &path);
    }
    found(log, kind.name(), replay, &recording)
}

fn found(log: RealLog, system: &str, replay: usize, recording: &Recording) -> Found {
    let figures = &recording.figures;
    let consistency = figures.consistency.as_ref();
    let back = figures.looking_back.as_ref();
    let back_consistency = back.and_then(|back| back.consistency.as_ref());
    let values = [
        figures.estimate.map(|score| score.ate_m),
        figures.odometry.map(|score| score.ate_m),
        consistency.map(|score| score.odometry_entropy_nats - score.entropy_nats),
        consistency.and_then(|score| Some(score.surfels?.median_m)),
        back.and_then(|back| Some(back.estimate?.ate_m)),
        back_consistency.map(|score| score.odometry_entropy_nats - score.entropy_nats),
        back_consistency.and_then(|score| Some(score.surfels?.median_m)),
        Some(1e6 * figures.estimator_s / recording.steps.len().max(1) as f64),
    ];
    let (log, system) = (log.name.to_owned(), system.to_owned());
    Found { log, system, replay, figures: values.map(|v| v.unwrap_or(f64::NAN)), cannot: String::new() }
}
