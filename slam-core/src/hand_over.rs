//! What a look back hands over to the filter: where the robot, its odometry's calibration, the grid and the walls are, with
//! their joint covariance, as one Gaussian.

use crate::geometry::pose::Pose;

/// Place of the scale of distance among the unknowns of a hand-over.
pub const DISTANCE: usize = 0;
/// Of the scale of turning.
pub const TURN: usize = 1;
/// Of the veer, radians per metre.
pub const VEER: usize = 2;
/// Of the grid's direction, radians.
pub const ALPHA: usize = 3;
/// Of the robot's x, metres; y and theta follow.
pub const POSE: usize = 4;
/// Of the first sensor's gain; the others follow.
pub const GAINS: usize = 7;
/// Sensors whose gains are unknowns; those of others are known.
pub const MOST_GAINS: usize = 8;
/// Of the first wall's offset at its anchor, metres; its direction, radians, and the other walls follow.
pub const WALLS: usize = GAINS + MOST_GAINS;

/// Scales of distance and turning, and the veer: the odometry senses the motion over its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Scale of distance.
    pub distance: f32,
    /// Scale of turning.
    pub turn: f32,
    /// Turn per metre that the odometry does not sense, radians.
    pub veer_rad_per_m: f32,
}

impl Calibration {
    /// That of an odometry without errors.
    pub const EXACT: Self = Self { distance: 1.0, turn: 1.0, veer_rad_per_m: 0.0 };
}

/// A wall as a look back placed it: the points p with p . (cos beta, sin beta) = rho, from lo to hi along (-sin beta, cos beta).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedWall {
    /// An identifier that the filter gave it, the latest.
    pub id: u16,
    /// Signed distance of its line from the origin along the normal, metres.
    pub rho_m: f32,
    /// Direction of the normal, radians.
    pub beta_rad: f32,
    /// Place along it about which its line is turned, metres.
    pub anchor_m: f32,
    /// Start of its extent, metres.
    pub lo_m: f32,
    /// End of it, metres.
    pub hi_m: f32,
    /// Hits that are on it.
    pub hits: u32,
    /// Whether it stands on the grid.
    pub on_grid: bool,
}

/// A joint estimate of the present, in the filter's frame, which is known exactly: the start pose's, or another one's that was
/// taken for it since.
#[derive(Clone, Copy, Debug)]
pub struct HandOver<'a> {
    /// [`Slam::epoch`](crate::Slam::epoch) at which its record of the drive began, or the last one was taken over.
    pub epoch: u32,
    /// Where the robot is after the last sample.
    pub pose: Pose,
    /// Direction of the grid, radians; none where there is none.
    pub alpha_rad: Option<f32>,
    /// The odometry's calibration.
    pub calibration: Calibration,
    /// The sensors' gains: reported = gain x true range.
    pub gains: [f32; MOST_GAINS],
    /// The walls.
    pub walls: &'a [PlacedWall],
    /// Every identifier under which the filter has had one of them, and its place in `walls`.
    pub names: &'a [(u16, u8)],
    /// The lower triangle of the covariance, row by row: [`DISTANCE`], [`TURN`], [`VEER`], [`ALPHA`], [`POSE`], [`GAINS`],
    /// [`WALLS`].
    pub covariance: &'a [f32],
    /// Whether it found that something moved the robot of which the filter does not know: then that is surer than it may be.
    pub is_displaced: bool,
}

/// What one number is a sum of: unknowns and its derivatives by them. Those of nought count for nothing.
pub(crate) type Terms<const N: usize> = [(usize, f32); N];

impl HandOver<'_> {
    /// Unknowns.
    pub fn unknowns(&self) -> usize {
        WALLS + 2 * self.walls.len()
    }

    /// Covariance of two unknowns; not a number where there is none.
    pub fn covariance(&self, i: usize, j: usize) -> f32 {
        let (row, column) = if i < j { (j, i) } else { (i, j) };
        self.covariance.get(row * (row + 1) / 2 + column).copied().unwrap_or(f32::NAN)
    }

    /// Covariance of two sums of unknowns.
    pub(crate) fn of_sums<const N: usize>(&self, a: &Terms<N>, b: &Terms<N>) -> f32 {
        let mut sum = 0.0;
        for &(i, u) in a.iter().filter(|(_, u)| *u != 0.0) {
            for &(j, v) in b.iter().filter(|(_, v)| *v != 0.0) {
                sum += u * v * self.covariance(i, j);
            }
        }
        sum
    }

    /// Which of the walls the filter calls so.
    pub fn wall_named(&self, id: u16) -> Option<usize> {
        self.names.iter().find(|(name, _)| *name == id).map(|(_, wall)| usize::from(*wall))
    }

    /// Whether every number is one, and every variance positive.
    pub(crate) fn is_sound(&self) -> bool {
        let Pose { x_m, y_m, theta_rad } = self.pose;
        let Calibration { distance, turn, veer_rad_per_m } = self.calibration;
        let lines = self.walls.iter().flat_map(|wall| [wall.rho_m, wall.beta_rad, wall.anchor_m, wall.lo_m, wall.hi_m]);
        let means = [x_m, y_m, theta_rad, self.alpha_rad.unwrap_or(0.0), distance, turn, veer_rad_per_m];
        let all = means.into_iter().chain(self.gains).chain(lines).chain(self.covariance.iter().copied());
        let n = self.unknowns();
        self.covariance.len() == n * (n + 1) / 2
            && all.fold(true, |sound, value| sound & value.is_finite())
            && (0..n).all(|i| self.covariance(i, i) > 0.0)
            && distance > 0.0
            && turn > 0.0
            && self.gains.iter().all(|gain| *gain > 0.0)
    }
}
