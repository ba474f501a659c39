//! The figures of a run: its scores against the truth and against itself.

use super::Pose2;
use hal_sim::floor::FloorScore;

/// Figures of a whole run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    /// Length of the path by dead reckoning, metres.
    pub path_m: f64,
    /// Time from first to last row, seconds.
    pub duration_s: f64,
    /// Share of the rows whose pose is not claimed, 0 to 1: the scores against the truth and of the live map are without these.
    pub lost: f64,
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
    /// The floor that a simulated drive swept.
    pub floor: Option<FloorScore>,
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
    /// RMSE of position in the start frame, metres; none where the truth does not tell where the robot started.
    pub start_m: Option<f64>,
    /// RMSE of heading after removing the alignment's rotation, degrees.
    pub heading_deg: f64,
    /// Mean normalised pose error squared in the map frame (3 is ideal); of the estimate only.
    pub nees: Option<f64>,
    /// The alignment: true position = R(`alignment.theta_rad`) estimated position + translation.
    pub alignment: Pose2,
}

/// The map against the true plan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapScore {
    /// RMS of the mapped walls' offsets from the true walls that they match, metres; none where none matches.
    pub offset_m: Option<f64>,
    /// Mapped walls that match a true wall.
    pub matched: usize,
    /// True walls longer than 1 m that the robot passed within range and that the map lacks.
    pub missed: usize,
    /// Mapped walls that match no true wall.
    pub invented: usize,
}
