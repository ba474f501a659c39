//! Everything that one run or replay did, in memory: what the outputs, the scores and the report page are made from.
//!
//! Frames and units: poses, walls and hits are in the map frame (the robot's start pose), metres and radians; times are
//! seconds. The true path and plan are moved so that the first true pose is the map frame's origin.

use std::f64::consts::{PI, TAU};

use slam_core::{Counters, Outcome, ReadingReport, WallView};

/// A planar pose: metres, radians in (-pi, pi].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose2 {
    /// x in the map frame, metres.
    pub x_m: f64,
    /// y in the map frame, metres.
    pub y_m: f64,
    /// Heading, radians counter-clockwise.
    pub theta_rad: f64,
}

impl Pose2 {
    /// A pose; the heading is wrapped.
    pub fn new(x_m: f64, y_m: f64, theta_rad: f64) -> Self {
        Self { x_m, y_m, theta_rad: wrap(theta_rad) }
    }

    /// `other`, given in the same frame as this pose, in this pose's own frame.
    pub fn relative(&self, other: &Pose2) -> Pose2 {
        let (s, c) = self.theta_rad.sin_cos();
        let (dx, dy) = (other.x_m - self.x_m, other.y_m - self.y_m);
        Pose2::new(c * dx + s * dy, c * dy - s * dx, other.theta_rad - self.theta_rad)
    }

    /// `inner`, which is in this pose's frame, in the frame that this pose is in.
    pub fn compose(&self, inner: &Pose2) -> Pose2 {
        let [x_m, y_m] = self.transform([inner.x_m, inner.y_m]);
        Pose2::new(x_m, y_m, self.theta_rad + inner.theta_rad)
    }

    /// A point in this pose's frame, in the frame that this pose is in (metres).
    pub fn transform(&self, point_m: [f64; 2]) -> [f64; 2] {
        let (s, c) = self.theta_rad.sin_cos();
        [self.x_m + c * point_m[0] - s * point_m[1], self.y_m + s * point_m[0] + c * point_m[1]]
    }
}

impl From<slam_core::Pose> for Pose2 {
    fn from(pose: slam_core::Pose) -> Self {
        Self { x_m: pose.x_m.into(), y_m: pose.y_m.into(), theta_rad: pose.theta_rad.into() }
    }
}

/// The angle in (-pi, pi] that equals `angle_rad` modulo a full turn.
pub fn wrap(angle_rad: f64) -> f64 {
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// One run of the estimator over one log or simulated drive.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// What was run, for people: a floor plan's or a log's name.
    pub title: String,
    /// Seed of a simulated drive.
    pub seed: Option<u64>,
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
    /// The calibration about once a second; the last entry is the final one.
    pub calibration: Vec<CalibrationSnapshot>,
    /// The true floor plan, where known.
    pub true_walls: Vec<Segment>,
    /// The estimator's own counts at the end.
    pub counters: Counters,
    /// The run's figures, filled in when it is over.
    pub figures: Figures,
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
    /// Covariance of (x, y, theta) in the frame of the start pose: m^2, m rad, rad^2.
    pub covariance: [[f32; 3]; 3],
    /// Direction of the wall grid and its 1-sigma, radians; none before there is a grid.
    pub alpha: Option<(f32, f32)>,
    /// Pose by the motion input alone.
    pub dead_reckoning: Pose2,
    /// True pose, where known at this time.
    pub truth: Option<Pose2>,
    /// Number of walls in the map.
    pub walls: usize,
    /// Walls born in this step.
    pub births: u8,
    /// Pairs of walls merged in this step.
    pub merges: u8,
    /// Walls removed in this step.
    pub prunes: u8,
}

impl Step {
    /// Estimated pose in the frame of the start pose.
    pub fn pose_from_start(&self) -> Pose2 {
        self.start.relative(&self.pose)
    }

    /// Estimate minus truth in the frame of the start pose, where the truth is known.
    pub fn error(&self) -> Option<Pose2> {
        let (pose, truth) = (self.pose_from_start(), self.truth?);
        Some(Pose2 {
            x_m: pose.x_m - truth.x_m,
            y_m: pose.y_m - truth.y_m,
            theta_rad: wrap(pose.theta_rad - truth.theta_rad),
        })
    }
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

/// Figures of a whole run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    /// Length of the path by dead reckoning, metres.
    pub path_m: f64,
    /// Time from first to last row, seconds.
    pub duration_s: f64,
    /// Time that the estimator took, seconds of this machine.
    pub estimator_s: f64,
    /// Walls in the final map.
    pub walls: usize,
    /// Readings used in updates.
    pub updates: u64,
    /// Readings that no wall explained: outside the gate, or meeting none.
    pub outliers: u64,
    /// Mean normalised innovation squared of the updates (1 is ideal).
    pub mean_nis: Option<f64>,
    /// The same of all readings that met a wall, before the gate (1 is ideal).
    pub nis_before_gate: Option<f64>,
    /// Median of these (0.45 is ideal): what the few that are far off do not move.
    pub median_nis_before_gate: Option<f64>,
    /// The same of those that came from their wall, see [`crate::evaluate::score::nis`].
    pub nis_associated: Option<f64>,
    /// How late the readings that come in metres are, and its 1-sigma, seconds; none where it is not estimated.
    pub latency_s: Option<(f64, f64)>,
    /// Share of the readings that met a wall and fell outside its gate.
    pub outside_gate: Option<f64>,
    /// The estimate against the truth.
    pub estimate: Option<PathScore>,
    /// Dead reckoning against the truth.
    pub odometry: Option<PathScore>,
    /// The map against the true plan.
    pub map: Option<MapScore>,
    /// The map against itself.
    pub consistency: Option<Consistency>,
    /// The same scores of the path and the map as they look from the end, see [`crate::evaluate::smoother`].
    pub looking_back: Option<LookingBack>,
}

/// Scores of a path and a map that were placed with the whole log at hand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LookingBack {
    /// The path against the truth.
    pub estimate: Option<PathScore>,
    /// The map against itself.
    pub consistency: Option<Consistency>,
}

/// How well a map agrees with itself: scores that need no truth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Consistency {
    /// Mean map entropy of the readings' end points by the estimate (radius 0.4 m), nats: less is sharper.
    pub entropy_nats: f64,
    /// The same by dead reckoning.
    pub odometry_entropy_nats: f64,
    /// Walls of which two visits or more saw the same stretch, visits more than 30 s apart.
    pub revisited: usize,
    /// Largest distance between two visits' places of one wall, along its normal, metres.
    pub widest_gap_m: Option<f64>,
    /// Mean over the revisited walls of the distance between their two farthest visits, metres.
    pub mean_gap_m: Option<f64>,
    /// RMS thickness of the revisited walls, metres.
    pub thickness_m: Option<f64>,
    /// RMS over the revisited walls of the distance between their first and their last visit, metres.
    pub closure_m: Option<f64>,
    /// The same had dead reckoning led from the first visit to the last.
    pub odometry_closure_m: Option<f64>,
    /// How far visits are apart, by pieces of surface and without the map's walls.
    pub surfels: Option<SurfelScore>,
    /// The same by dead reckoning.
    pub odometry_surfels: Option<SurfelScore>,
    /// Every wall of the final map that readings met.
    pub walls: Vec<SeenWall>,
}

/// How far visits of one place, more than 30 s apart, see its surface apart: by surfels, flat pieces of surface half a metre
/// wide as one visit saw them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfelScore {
    /// Surfels found.
    pub found: usize,
    /// Of which other visits saw the surface as well.
    pub compared: usize,
    /// Median over these of the distance to the visit that differs most, metres.
    pub median_m: f64,
    /// The distance that nine in ten do not exceed, metres.
    pub p90_m: f64,
    /// Share that is more than 15 cm apart.
    pub wide_share: f64,
}

/// A wall of the final map as its visits saw it. Places are distances behind its line, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenWall {
    /// Identifier of the wall.
    pub wall: u16,
    /// Readings that ended on it.
    pub readings: usize,
    /// RMS distance of these from their mean, metres.
    pub thickness_m: f64,
    /// Distance between the two farthest visits, metres; none where no two visits saw the same stretch.
    pub gap_m: Option<f64>,
    /// How far behind the first visit's place the last one sees it, metres.
    pub closure_m: Option<f64>,
    /// The same had dead reckoning led from the first visit to the last.
    pub odometry_closure_m: Option<f64>,
    /// The visits, in order.
    pub visits: Vec<Visit>,
}

/// One visit of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Visit {
    /// Time of the first reading, seconds since the log's first row.
    pub begin_s: f64,
    /// Time of the last, seconds.
    pub end_s: f64,
    /// Readings in front of and behind the wall that faced it.
    pub readings: usize,
    /// Mean place of those on it, metres behind the wall's line.
    pub mean_m: f64,
}

/// Errors of a path against the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathScore {
    /// Number of poses compared.
    pub poses: usize,
    /// RMSE of position after the best rigid alignment (rotation and translation, no scale), metres.
    pub ate_m: f64,
    /// RMSE of position in the start frame, metres.
    pub start_m: f64,
    /// RMSE of heading after removing the alignment's rotation, degrees.
    pub heading_deg: f64,
    /// Mean normalised pose error squared in the start frame (3 is ideal); of the estimate only.
    pub nees: Option<f64>,
    /// The alignment: true position = R(`alignment.theta_rad`) estimated position + translation.
    pub alignment: Pose2,
}

/// The map against the true plan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapScore {
    /// RMS of the mapped walls' offsets from the true walls that they match, metres.
    pub offset_m: f64,
    /// Mapped walls that match a true wall.
    pub matched: usize,
    /// True walls longer than 1 m that the robot passed within range and that the map lacks.
    pub missed: usize,
    /// Mapped walls that match no true wall.
    pub invented: usize,
}

impl Recording {
    /// The readings of one step, in the rig's order.
    pub fn readings(&self, step: usize) -> &[ReadingReport] {
        let n = self.sensors.len();
        self.readings.get(step * n..(step + 1) * n).unwrap_or(&[])
    }

    /// Where the robot started, in the map frame as it is in the end.
    pub fn start(&self) -> Pose2 {
        self.steps.last().map_or_else(Pose2::default, |step| step.start)
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

    #[test]
    fn a_heading_error_is_the_short_way_round() {
        let pose = |theta_rad| Pose2 { theta_rad, ..Pose2::default() };
        let step = Step { pose: pose(3.1), truth: Some(pose(-3.1)), ..Step::default() };
        let found = step.error().map(|e| e.theta_rad).unwrap_or_default();
        assert!((found - (6.2 - TAU)).abs() < 1e-12, "{found}");
        assert_eq!(Step { truth: None, ..step }.error(), None);
    }

    #[test]
    fn an_error_is_seen_from_the_start_pose() {
        // The walls turned the start pose by a quarter: what is 1 m to the left on the map is 1 m ahead of it.
        let start = Pose2::new(0.5, 0.0, PI / 2.0);
        let step =
            Step { start, pose: Pose2::new(0.5, 1.0, PI / 2.0), truth: Some(Pose2::default()), ..Step::default() };
        let error = step.error().expect("there is a truth");
        assert!(
            (error.x_m - 1.0).abs() < 1e-12 && error.y_m.abs() < 1e-12 && error.theta_rad.abs() < 1e-12,
            "{error:?}"
        );
    }
}
