//! Another system at work on a robot's log: a [`Relative`] is fed row by row and leaves the record that the estimator's
//! [`Session`](super::Session) leaves, so that every score and page is made of it in the same way.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use relatives::front::Front;
use relatives::geometry::{Pose, Segment, perp};
use relatives::{Dense, Kind, Relative, Setup};
use serde_json::json;
use slam_core::{Config, ReadingReport, WallKind, WallView};

use super::Progress;
use super::replay::{Replayed, notes, title_of, truth_of, without_rows};
use super::session::sensor_info;
use crate::evaluate::score::{self, path};
use crate::evaluate::smoother;
use crate::input::log::{self, Row, Scan};
use crate::input::rig_file::{MAX_SENSORS, Robot};
use crate::recording::{Figures, LookingBack, MapSnapshot, Pose2, Recording, Step};
use crate::show::output::folder::Folder;
use crate::show::output::streams::Streams;
use crate::show::output::summary::Origin;
use crate::show::output::{self, NAMES};
use input_file::FileError;

/// How often the map is recorded, steps.
const SNAPSHOT_EVERY: usize = 100;

/// Longest range of a whole scan that is a reading, metres: what scan matchers take of a laser of the kind that logs have.
const SCAN_REACH_M: f64 = 10.0;

/// A system and the record of what it did.
pub struct RelativeSession {
    front: Front<MAX_SENSORS>,
    relative: Box<dyn Relative>,
    recording: Recording,
    dead_reckoning: Pose,
    first_s: Option<f64>,
    time: Duration,
}

/// A pose as records have it.
pub fn to_record(pose: &Pose) -> Pose2 {
    Pose2::new(pose.at.x, pose.at.y, pose.theta)
}

/// A covariance as records have it; not a number where there is none.
pub fn covariance_of(covariance: Option<nalgebra::Matrix3<f64>>) -> [[f32; 3]; 3] {
    let entry = |i: usize, j: usize| covariance.map_or(f32::NAN, |covariance| covariance[(i, j)] as f32);
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

/// Walls as records have them.
pub fn views(walls: &[Segment]) -> Vec<WallView> {
    let view = |(id, wall): (usize, &Segment)| {
        let along = (wall.to - wall.from).normalize();
        let n = -perp(along);
        let (n, along) = if n.dot(&wall.from) < 0.0 { (-n, -along) } else { (n, along) };
        let ends = [wall.from.dot(&along), wall.to.dot(&along)];
        WallView {
            id: id as u16,
            kind: WallKind::Free,
            rho_m: n.dot(&wall.from) as f32,
            beta_rad: n.y.atan2(n.x) as f32,
            lo_m: ends[0].min(ends[1]) as f32,
            hi_m: ends[0].max(ends[1]) as f32,
            sigma_rho_m: 0.0,
            updates: 0,
        }
    };
    walls.iter().filter(|wall| wall.length() > 0.0).enumerate().map(view).collect()
}

impl RelativeSession {
    /// The system at the start pose.
    ///
    /// # Errors
    /// Why it cannot run on this robot.
    pub fn new(robot: &Robot, kind: Kind, setup: &Setup, title: String) -> Result<Self, &'static str> {
        let sensors = robot.rig.sensors.iter().zip(&robot.names).map(sensor_info).collect();
        Ok(Self {
            front: Front::new(robot.rig.clone()),
            relative: kind.build(setup)?,
            recording: Recording { title: format!("{title}, {}", kind.name()), sensors, ..Recording::default() },
            dead_reckoning: Pose::default(),
            first_s: None,
            time: Duration::ZERO,
        })
    }

    /// Takes in one row, and the whole scan that came with it.
    pub fn push(&mut self, row: &Row, scan: Option<Scan<'_>>) -> &Step {
        let origin = self.recording.sensors.first().map_or_else(Default::default, |s| [s.x_m, s.y_m]);
        let dense = scan.map(|scan| Dense {
            origin: origin.into(),
            first: scan.first_rad,
            step: scan.step_rad,
            ranges: scan.ranges_m,
            reach: SCAN_REACH_M,
        });
        let before = Instant::now();
        let sample = if row.lifted { row.sample.without_ranges() } else { row.sample };
        let input = self.front.read(&sample, dense.filter(|_| !row.lifted));
        let motion = input.motion;
        let output = self.relative.step(&input);
        self.time += before.elapsed();
        self.dead_reckoning = self.dead_reckoning.compose(&motion);
        let readings = self.front.beams().iter().map(|beam| match beam {
            Some(beam) => {
                let hit = output.pose.transform(beam.end());
                let hit_m = Some([hit.x as f32, hit.y as f32]);
                ReadingReport { range_m: Some(beam.range as f32), hit_m, ..ReadingReport::default() }
            }
            None => ReadingReport::default(),
        });
        self.recording.readings.extend(readings);
        let index = self.recording.steps.len();
        if index.is_multiple_of(SNAPSHOT_EVERY) {
            self.recording.maps.push(MapSnapshot { step: index, walls: views(&self.relative.walls()) });
        }
        self.recording.steps.push(Step {
            t_text: row.t_text.clone(),
            t_s: row.t_s - *self.first_s.get_or_insert(row.t_s),
            pose: to_record(&output.pose),
            covariance: covariance_of(output.covariance),
            dead_reckoning: to_record(&self.dead_reckoning),
            sensed: to_record(&self.dead_reckoning),
            truth: row.truth,
            walls: self.recording.maps.last().map_or(0, |map| map.walls.len()),
            ..Step::default()
        });
        &self.recording.steps[index]
    }

    /// Ends the session: the record with the figures that need no truth, and the path as the system knows it in the end.
    pub fn finish(mut self) -> (Recording, Option<Vec<Pose2>>) {
        let walls = views(&self.relative.walls());
        let recording = &mut self.recording;
        let figures = &mut recording.figures;
        figures.estimator_s = self.time.as_secs_f64();
        figures.duration_s = recording.steps.last().map_or(0.0, |step| step.t_s);
        figures.path_m = path::length_m(recording.steps.iter().map(|step| step.dead_reckoning));
        figures.walls = walls.len();
        recording.maps.push(MapSnapshot { step: recording.steps.len().saturating_sub(1), walls });
        let back = self.relative.path().map(|path| path.iter().map(to_record).collect());
        (self.recording, back)
    }

    /// Memory that the system's state takes now, bytes.
    pub fn bytes(&self) -> usize {
        self.relative.bytes()
    }
}

/// The record with the path that the system knows in the end, scored; its scores are put among the record's figures, too.
pub fn look_back(recording: &mut Recording, path: &[Pose2]) -> Recording {
    let mut back = smoother::moved(recording, path, recording.walls().to_vec());
    back.figures = Figures { estimate: None, map: None, ..back.figures };
    score::score(&mut back, &[], None);
    let Figures { estimate, consistency, .. } = &back.figures;
    recording.figures.looking_back = Some(LookingBack { estimate: *estimate, consistency: consistency.clone() });
    back
}

/// A replay of a log by another system.
#[derive(Clone, Debug)]
pub struct RelativeReplay {
    /// The log: `log.csv` or CARMEN, plain or gzipped.
    pub log: PathBuf,
    /// The rig file.
    pub rig: PathBuf,
    /// The output folder.
    pub out: PathBuf,
    /// True poses; `truth.csv` beside the log when not given.
    pub truth: Option<PathBuf>,
    /// The system.
    pub with: Kind,
}

impl RelativeReplay {
    /// Replays the log and writes the output folder; `progress` is told how far it is.
    ///
    /// # Errors
    /// What keeps the replay from starting, or an output from being written.
    pub fn run(&self, mut progress: impl FnMut(Progress)) -> Result<Replayed, FileError> {
        let rig_toml = input_file::read(&self.rig)?;
        let mut robot = Robot::parse(&self.rig, &rig_toml)?;
        let mut rows = log::open(&self.log, &mut robot)?;
        let truth = truth_of(&self.log, self.truth.as_deref())?;
        let setup = Setup { seed: 1, has_scans: rows.has_scans(), ..Setup::default() };
        let cannot = |why| FileError::new(&self.log, format!("{} cannot run on it: {why}", self.with.name()));
        let mut session = RelativeSession::new(&robot, self.with, &setup, title_of(&self.log)).map_err(cannot)?;
        let mut folder = Folder::prepare(&self.out, &NAMES)?;
        let mut streams = Streams::create(&folder)?;
        let mut times_s = Vec::new();
        let mut error = None;
        while let Some(row) = rows.next() {
            match row {
                Ok(row) => {
                    streams.push(session.push(&row, rows.whole_scan()))?;
                    times_s.push(row.t_s);
                    progress(Progress::Rows(times_s.len()));
                }
                Err(bad) => error = Some(bad),
            }
        }
        let error = error.or_else(|| without_rows(&self.log, &times_s));
        streams.close()?;
        let (mut recording, path) = session.finish();
        score::score(&mut recording, &times_s, truth.as_ref());
        let notes = notes(&*rows, &times_s, truth.as_ref());
        recording.notes = notes.iter().cloned().chain(recording.findings()).collect();
        let back = path.map(|path| look_back(&mut recording, &path));
        let arguments = vec![
            ("command", json!("replay")),
            ("log", json!(self.log)),
            ("rig", json!(self.rig)),
            ("truth", json!(self.truth)),
            ("with", json!(self.with.name())),
        ];
        let said = error.as_ref().map(ToString::to_string);
        let origin = Origin {
            arguments,
            rig_toml,
            config: Config::default(),
            suits: Config::default(),
            trace: false,
            error: said,
        };
        output::finish(&mut folder, &recording, back.as_ref(), &origin)?;
        Ok(Replayed { recording, notes, error })
    }
}
