//! Everything that one run or replay did, in memory: what the outputs, the scores and the report page are made from.
//!
//! Frames and units: poses, walls and hits are in the map frame (the robot's start pose), metres and radians; times are
//! seconds. The true path and plan are moved so that the first true pose is the map frame's origin.

mod figures;
pub mod health;
mod job;
mod notes;

use hal_sim::floor::FloorScore;
use slam_core::{Counters, Health, NotTaken, Outcome, ReadingReport, WallView};

pub use hal_sim::pose::{Pose2, wrap};

pub use crate::run::Searched;
pub use figures::{Consistency, Figures, LookingBack, MapScore, PathScore, SeenWall, SurfelScore, Visit};
pub use job::Job;

/// One run of the estimator over one log or simulated drive.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// What was run, for people: a floor plan's or a log's name.
    pub title: String,
    /// Seed of a simulated drive.
    pub seed: Option<u64>,
    /// What a simulated robot was to do.
    pub job: Option<Job>,
    /// Since when the pilot of a simulated drive could not get away from where it was, to the end, seconds.
    pub stuck_from_s: Option<f64>,
    /// Whether path and map are as they look from the end, see [`crate::evaluate::smoother`].
    pub looks_back: bool,
    /// The range sensors, in the rig's order.
    pub sensors: Vec<SensorInfo>,
    /// One entry per log row.
    pub steps: Vec<Step>,
    /// What became of each reading: `sensors.len()` entries per step, see [`Recording::readings`].
    pub readings: Vec<ReadingReport>,
    /// The map over time: whenever its structure changed, and about once a second; the last entry is the final map.
    pub maps: Vec<MapSnapshot>,
    /// Every calibration parameter; one that is not estimated stays at 1 with a sigma of 0.
    pub parameters: Vec<ParameterInfo>,
    /// What look backs found while the robot drove, taken over or not.
    pub hand_overs: Vec<HandOver>,
    /// The calibration about once a second; the last entry is the final one.
    pub calibration: Vec<CalibrationSnapshot>,
    /// The true floor plan, where known.
    pub true_walls: Vec<Segment>,
    /// The estimator's own counts at the end.
    pub counters: Counters,
    /// Which frame the truth is in before it is scored.
    pub truth_frame: TruthFrame,
    /// What every search for the place in the kept map found.
    pub searches: Vec<Searched>,
    /// How often a place was given up: lifted, or the claim revoked.
    pub lost: usize,
    /// What a user should know of the run though it is no error.
    pub notes: Vec<String>,
    /// The run's figures, filled in when it is over.
    pub figures: Figures,
}

/// Which frame true poses are in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TruthFrame {
    /// One in which the first of them should be the map's origin.
    #[default]
    FirstPose,
    /// The map's.
    Map,
    /// Not known: that of a kept map is the start of another drive. They are moved so that they fit the estimate best.
    Unknown,
}

/// One range sensor as the rig file describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorInfo {
    /// Its name.
    pub name: String,
    /// Where the beam starts in the robot's frame, metres forward.
    pub x_m: f64,
    /// Where the beam starts in the robot's frame, metres left.
    pub y_m: f64,
    /// Beam direction, radians counter-clockwise from straight ahead.
    pub bearing_rad: f64,
    /// Shortest and longest range that is a reading, metres.
    pub span_m: [f64; 2],
}

/// One log row and the estimate after it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// Time as the log writes it.
    pub t_text: String,
    /// Time since the first row, seconds.
    pub t_s: f64,
    /// Estimated pose.
    pub pose: Pose2,
    /// Where the robot started, in the map frame.
    pub start: Pose2,
    /// Covariance of (x, y, theta) in the map frame: m^2, m rad, rad^2.
    pub covariance: [[f32; 3]; 3],
    /// Direction of the wall grid and its 1-sigma, radians; none before there is a grid.
    pub alpha: Option<(f32, f32)>,
    /// Pose by the motion input alone.
    pub dead_reckoning: Pose2,
    /// The same, the way that the ranges tell, and not moved by wheels that turn while something holds the robot.
    pub sensed: Pose2,
    /// How far off that is of this step, 1-sigma, metres and radians, where its motion was lost.
    pub lost: Option<[f32; 2]>,
    /// True pose, where known at this time and to be had in a frame of the drive's.
    pub truth: Option<Pose2>,
    /// Number of walls in the map.
    pub walls: usize,
    /// Walls born in this step.
    pub births: u8,
    /// Pairs of walls merged in this step.
    pub merges: u8,
    /// Walls removed in this step.
    pub prunes: u8,
    /// Maps that the estimator had begun anew until then.
    pub restarts: u32,
    /// How the estimator was after it.
    pub health: Health,
    /// The pose is in a fresh map's frame, for the robot has not found itself in the kept one, and is not scored. Else it is
    /// claimed in the frame of the kept map, or of this drive's start where there is none.
    pub searching: bool,
    /// The same of a robot that was lifted, or began somewhere in a kept map: no odometry links it to a frame.
    pub carried: bool,
}

impl Step {
    /// Estimated pose in the frame of the start pose.
    pub fn pose_from_start(&self) -> Pose2 {
        self.start.relative(&self.pose)
    }

    /// True pose of a robot that claims to know its own, where known.
    pub fn claimed_truth(&self) -> Option<Pose2> {
        self.truth.filter(|_| !self.searching)
    }

    /// Estimate minus truth in the map frame, where the truth is known and the robot claims a place.
    pub fn error(&self) -> Option<Pose2> {
        let (pose, truth) = (self.pose, self.start.compose(&self.claimed_truth()?));
        Some(Pose2 {
            x_m: pose.x_m - truth.x_m,
            y_m: pose.y_m - truth.y_m,
            theta_rad: wrap(pose.theta_rad - truth.theta_rad),
        })
    }
}

/// What a look back found, handed over to the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandOver {
    /// Index into [`Recording::steps`] of the first step after it.
    pub step: usize,
    /// Why it was not taken over; none where it was.
    pub refused: Option<NotTaken>,
    /// How it moved the pose, in the robot's frame before.
    pub moved: Pose2,
}

/// The map after one step.
#[derive(Clone, Debug, Default)]
pub struct MapSnapshot {
    /// Index into [`Recording::steps`].
    pub step: usize,
    /// The walls.
    pub walls: Vec<WallView>,
}

/// One calibration parameter: a factor, 1 where exact.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterInfo {
    /// Its name as in `calibration.csv`: `gain_NAME`, `scale_left`, ...
    pub name: String,
    /// Its true value, where known (simulation).
    pub truth: Option<f64>,
}

/// The calibration after one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CalibrationSnapshot {
    /// Index into [`Recording::steps`].
    pub step: usize,
    /// Estimate and 1-sigma of each of [`Recording::parameters`].
    pub values: Vec<(f32, f32)>,
}

/// A straight piece of the true plan, metres in the map frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// One end.
    pub from_m: [f64; 2],
    /// The other end.
    pub to_m: [f64; 2],
}

impl Recording {
    /// The readings of one step, in the rig's order.
    pub fn readings(&self, step: usize) -> &[ReadingReport] {
        let n = self.sensors.len();
        self.readings.get(step * n..(step + 1) * n).unwrap_or(&[])
    }

    /// Share of the rows whose pose is not claimed.
    pub fn lost(&self) -> f64 {
        let lost = self.steps.iter().filter(|step| step.searching).count();
        lost as f64 / self.steps.len().max(1) as f64
    }

    /// Whether the odometry links all poses: the robot was never carried.
    pub fn is_one_frame(&self) -> bool {
        !self.steps.iter().any(|step| step.carried)
    }

    /// The floor, where the job was to sweep it.
    pub fn swept_floor(&self) -> Option<&FloorScore> {
        self.figures.floor.as_ref().filter(|_| self.job == Some(Job::Clean))
    }

    /// What is wrong with the estimate itself, in words; none where every number is one.
    pub fn fault(&self) -> Option<String> {
        let is_number = |step: &Step| {
            let Pose2 { x_m, y_m, theta_rad } = step.pose;
            [x_m, y_m, theta_rad].iter().all(|number| number.is_finite())
                && step.covariance.iter().flatten().all(|number| number.is_finite())
        };
        let step = self.steps.iter().find(|step| !is_number(step))?;
        Some(format!("from {} s on the estimate is not a number; the results are no map of anything", step.t_text))
    }

    /// Where the robot started, in the map frame as it is in the end.
    pub fn start(&self) -> Pose2 {
        self.steps.last().map_or_else(Pose2::default, |step| step.start)
    }

    /// The true walls, in the map frame as it is in the end.
    pub fn true_walls_in_map(&self) -> Vec<Segment> {
        let start = self.start();
        let place = |at_m: [f64; 2]| start.transform(at_m);
        self.true_walls.iter().map(|s| Segment { from_m: place(s.from_m), to_m: place(s.to_m) }).collect()
    }

    /// The final map.
    pub fn walls(&self) -> &[WallView] {
        self.maps.last().map_or(&[], |map| &map.walls)
    }
}

/// Normalised innovation squared of a reading that was used or gated.
pub fn nis(outcome: &Outcome) -> Option<f64> {
    match *outcome {
        Outcome::Updated { innovation_m, variance_m2, .. } | Outcome::Gated { innovation_m, variance_m2, .. } => {
            Some(f64::from(innovation_m) * f64::from(innovation_m) / f64::from(variance_m2))
        }
        Outcome::Missing | Outcome::Refused(_) | Outcome::Unexplained => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn a_heading_error_is_the_short_way_round() {
        let pose = |theta_rad| Pose2 { theta_rad, ..Pose2::default() };
        let step = Step { pose: pose(3.1), truth: Some(pose(-3.1)), ..Step::default() };
        let found = step.error().map(|e| e.theta_rad).unwrap_or_default();
        assert!((found - (6.2 - TAU)).abs() < 1e-12, "{found}");
        assert_eq!(Step { truth: None, ..step }.error(), None);
    }

    #[test]
    fn an_estimate_that_is_no_number_is_a_fault() {
        let steps = vec![Step::default(); 3];
        let mut recording = Recording { steps, ..Recording::default() };
        assert_eq!(recording.fault(), None);
        recording.steps[2].t_text = "1.5".into();
        recording.steps[2].covariance[1][1] = f32::INFINITY;
        assert!(recording.fault().is_some_and(|fault| fault.contains("from 1.5 s on")));
        recording.steps[2].covariance[1][1] = 0.0;
        recording.steps[2].pose.x_m = f64::NAN;
        assert!(recording.fault().is_some());
    }

    #[test]
    fn an_error_is_seen_in_the_map_frame() {
        // The walls turned the start pose by a quarter: what is 1 m ahead of it is 1 m to the left on the map.
        let start = Pose2::new(0.5, 0.0, PI / 2.0);
        let step =
            Step { start, pose: Pose2::new(0.5, 1.0, PI / 2.0), truth: Some(Pose2::default()), ..Step::default() };
        let error = step.error().expect("there is a truth");
        assert!(
            error.x_m.abs() < 1e-12 && (error.y_m - 1.0).abs() < 1e-12 && error.theta_rad.abs() < 1e-12,
            "{error:?}"
        );
    }
}
