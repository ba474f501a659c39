//! A unit of work: one drive, simulated once, and every variant over its samples.

use std::fmt;

use hal_sim::{ClosedLoop, Frame, Plan, SimError, Simulation, TrueCalibration, nominal_ranges};
use slam_core::{Config, RigError};

use crate::clock::processor_time;
use crate::file::{Case, Experiment};
use crate::floor;
use crate::key::Key;
use crate::plan::changed;
use crate::relative;
use crate::row::{Metric, RunKey, RunRow};
use crate::senses::{Scanned, Senses};
use crate::track::{Track, Tracker, replay, whole_robot};
use crate::variant::{Buffer, Method, Variant};
use input_file::FileError;
use lab::evaluate::score::map::{LONG_M, PASSED_M, PassedWall};
use lab::evaluate::score::path::length_m;
use lab::evaluate::score::{map, path};
use lab::evaluate::statistics::mean;
use lab::input::rig_file::Robot;
use lab::recording::{Pose2, Segment, Step};

/// Length of a drive where the experiment file does not say, minutes.
const MINUTES: f64 = 10.0;

/// One plan, case and seed.
#[derive(Clone, Debug)]
pub struct Unit<'a> {
    /// The plan's name.
    pub plan: &'a str,
    /// The condition.
    pub case: &'a Case,
    /// The seed.
    pub seed: u64,
}

/// Why a unit cannot be driven.
#[derive(Clone, Debug)]
pub struct UnitError(String);

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for UnitError {}

impl From<FileError> for UnitError {
    fn from(error: FileError) -> Self {
        Self(error.to_string())
    }
}

impl From<SimError> for UnitError {
    fn from(error: SimError) -> Self {
        Self(error.to_string())
    }
}

impl From<RigError> for UnitError {
    fn from(error: RigError) -> Self {
        Self(format!("rig: {} must be {}", error.key, error.allowed))
    }
}

/// A drive that was simulated: what every variant gets, and what is true.
pub struct Driven {
    /// The home.
    pub plan: Plan,
    /// The robot as its rig says it is.
    pub robot: Robot,
    /// The samples and the true poses.
    pub frames: Vec<Frame>,
    /// What the robot's calibration really was.
    pub calibration: TrueCalibration,
    /// The path by the encoders alone.
    dead_reckoning: Vec<Pose2>,
    /// The true walls in the start frame.
    walls: Vec<Segment>,
    /// Those that were passed within range.
    passed: Vec<PassedWall>,
}

/// What one variant made of a drive.
pub struct Outcome {
    /// Its figures.
    pub row: RunRow,
    /// Its track.
    pub track: Track,
}

impl Unit<'_> {
    /// Which run this is for a variant.
    pub fn key(&self, variant: &Variant) -> RunKey {
        RunKey {
            plan: self.plan.to_owned(),
            case: self.case.name.clone(),
            seed: self.seed,
            variant: variant.name.clone(),
        }
    }

    /// Drives once and gives the samples to each of these variants of the experiment.
    ///
    /// # Errors
    /// The robot or the home cannot be simulated.
    pub fn run(&self, experiment: &Experiment, variants: &[&Variant]) -> Result<Vec<Outcome>, UnitError> {
        let driven = self.drive(experiment)?;
        let mut outcomes = Vec::new();
        for variant in variants {
            let track = driven.track(variant, self.seed)?;
            outcomes.push(Outcome { row: driven.score(self.key(variant), variant, &track), track });
        }
        Ok(outcomes)
    }

    /// The drive, steered by the default estimator.
    ///
    /// # Errors
    /// The robot or the home cannot be simulated.
    pub fn drive(&self, experiment: &Experiment) -> Result<Driven, UnitError> {
        let setting = &self.case.setting.drawn(self.seed);
        let original = hal_sim::plan_file::load(self.plan).map_err(|error| UnitError(error.to_string()))?;
        let plan = changed(&original, self.plan, &experiment.doors, setting, self.seed);
        let robot = setting.robot()?;
        let simulation = Simulation::new(&plan, &robot.rig, setting.options(), self.seed)?;
        let mut closed_loop = ClosedLoop::new(simulation, &robot.rig, setting.pilot());
        let robot = setting.told(&robot);
        let mut tracker = Tracker::<128>::new(&robot, Config::default())?;
        let minutes = setting.get(Key::Minutes).unwrap_or(MINUTES);
        let frames = closed_loop.record(60.0 * minutes, &mut |sample| tracker.estimate(sample));
        let track = tracker.finish(&frames);
        let faces = plan.faces_in_start_frame();
        let walls: Vec<Segment> = faces.iter().map(|face| Segment { from_m: face.from_m, to_m: face.to_m }).collect();
        let seen = closed_loop.simulation.coverage().walls(LONG_M, PASSED_M);
        let passed =
            seen.into_iter().map(|seen| PassedWall { wall: walls[seen.face], stretches_m: seen.stretches_m }).collect();
        let calibration = closed_loop.simulation.calibration().clone();
        let dead_reckoning = track.steps.iter().map(|step| step.dead_reckoning).collect();
        Ok(Driven { plan, robot, frames, calibration, dead_reckoning, walls, passed })
    }
}

impl Driven {
    /// The true walls in the start frame.
    pub fn walls(&self) -> &[Segment] {
        &self.walls
    }

    fn track(&self, variant: &Variant, seed: u64) -> Result<Track, UnitError> {
        let scanned = match variant.senses {
            Senses::Rig => None,
            Senses::Scanner(kind) => Some(Scanned::of(self, kind, seed)),
        };
        let cannot = |why: &str| UnitError(format!("{}: {why}", variant.name));
        let (robot, frames) = (&self.robot, &self.frames[..]);
        let own = match (&scanned, variant.method) {
            (Some(scanned), Method::Slam(..)) => {
                Some(scanned.as_rig(robot, frames).ok_or_else(|| cannot("a sample has room for 16 readings"))?)
            }
            _ => None,
        };
        let before = processor_time();
        let mut track = match (variant.method, &own) {
            // Such a robot's settings are those of any rig that reports metres.
            (Method::Slam(..), Some((robot, frames))) => replay::<128>(robot, Config::for_rig(&robot.rig), frames)?,
            (Method::Relative(kind), _) => relative::track(self, kind, scanned.as_ref(), seed).map_err(cannot)?,
            (Method::DeadReckoning, _) => {
                let step = |pose: &Pose2| Step { pose: *pose, ..Step::default() };
                let mut track = Track { steps: self.dead_reckoning.iter().map(step).collect(), ..Track::default() };
                track.reveal(frames);
                track
            }
            (Method::Slam(config, Buffer::B32), _) => replay::<32>(robot, config, frames)?,
            (Method::Slam(config, Buffer::B64), _) => replay::<64>(robot, config, frames)?,
            (Method::Slam(config, Buffer::B128), _) => replay::<128>(robot, config, frames)?,
            (Method::Slam(config, Buffer::B255), _) => replay::<255>(robot, config, frames)?,
            (Method::Robot, _) => whole_robot(robot, frames)?,
            (Method::Floor, _) => floor::localise(&self.plan, robot, &self.calibration, frames),
        };
        track.time = processor_time().saturating_sub(before);
        Ok(track)
    }

    fn score(&self, key: RunKey, variant: &Variant, track: &Track) -> RunRow {
        let mut row = RunRow::new(key);
        row.set(Metric::Path, length_m(track.steps.iter().filter_map(|step| step.truth)));
        let visited = self.rooms_visited();
        row.set(Metric::RoomsVisited, visited as f64);
        row.set(Metric::RoomsMissed, (self.plan.rooms.len() - visited) as f64);
        if variant.method == Method::Robot {
            let lost = track.steps.iter().filter(|step| step.searching).count();
            row.set(Metric::Lost, lost as f64 / track.steps.len().max(1) as f64);
        }
        let Some(score) = path::of_estimate(&track.steps) else { return row };
        row.set(Metric::Ate, score.ate_m);
        row.set(Metric::Start, score.start_m.unwrap_or(f64::NAN));
        row.set(Metric::Heading, score.heading_deg);
        row.set(Metric::EndPoints, self.end_points_m(track, &score.alignment).unwrap_or(f64::NAN));
        if variant.method == Method::DeadReckoning {
            return row;
        }
        row.set(Metric::Nees, score.nees.unwrap_or(f64::NAN));
        row.set(Metric::Nis, track.mean_nis.unwrap_or(f64::NAN));
        row.set(Metric::Updates, track.innovations.len() as f64);
        row.set(Metric::StepCost, 1e6 * track.time.as_secs_f64() / track.steps.len().max(1) as f64);
        row.set(Metric::Back, track.back_m.unwrap_or(f64::NAN));
        row.set(Metric::Memory, track.bytes as f64 / 1024.0);
        if variant.method != Method::Floor {
            let map = map::score(&track.walls, &self.walls, &self.passed, &score.alignment);
            row.set(Metric::Offset, map.offset_m.unwrap_or(f64::NAN));
            row.set(Metric::Matched, map.matched as f64);
            row.set(Metric::Missed, map.missed as f64);
            row.set(Metric::Invented, map.invented as f64);
        }
        row
    }

    /// RMS distance of the rig's end points, placed by the aligned path, from the true walls; each counts up to 0.3 m.
    fn end_points_m(&self, track: &Track, alignment: &Pose2) -> Option<f64> {
        let mut squares = Vec::new();
        for (step, frame) in track.steps.iter().zip(&self.frames).step_by(END_POINTS_EVERY) {
            let pose = alignment.compose(&step.pose);
            let ranges = nominal_ranges(&self.robot.rig, &frame.sample);
            for (sensor, range_m) in self.robot.rig.sensors.iter().zip(ranges) {
                let Some(range_m) = range_m else { continue };
                let mount =
                    Pose2::new(sensor.mount.x_m.into(), sensor.mount.y_m.into(), sensor.mount.bearing_rad.into());
                let end = pose.compose(&mount).transform([range_m.into(), 0.0]);
                let off_m = self.walls.iter().map(|wall| distance_m(wall, end)).fold(END_POINT_M, f64::min);
                squares.push(off_m * off_m);
            }
        }
        mean(&squares).map(f64::sqrt)
    }

    fn rooms_visited(&self) -> usize {
        let in_plan: Vec<[f64; 2]> =
            self.frames.iter().map(|frame| self.plan.start.transform([frame.truth.x_m, frame.truth.y_m])).collect();
        self.plan.rooms.iter().filter(|room| in_plan.iter().any(|[x_m, y_m]| room.contains(*x_m, *y_m))).count()
    }
}

/// Of so many samples one gives its end points to the score.
const END_POINTS_EVERY: usize = 10;

/// An end point counts with this distance from a wall at most, metres.
const END_POINT_M: f64 = 0.3;

/// Distance of a point from a wall, metres.
fn distance_m(wall: &Segment, point: [f64; 2]) -> f64 {
    let [ax, ay] = [wall.to_m[0] - wall.from_m[0], wall.to_m[1] - wall.from_m[1]];
    let [px, py] = [point[0] - wall.from_m[0], point[1] - wall.from_m[1]];
    let share = ((px * ax + py * ay) / (ax * ax + ay * ay).max(1e-18)).clamp(0.0, 1.0);
    (px - share * ax).hypot(py - share * ay)
}
