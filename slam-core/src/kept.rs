//! What is kept of a map when a drive ends, and how a later drive takes it up again.
//!
//! A kept map is the filter without the pose: grid, calibration and walls with their covariance. A drive that finds itself in
//! it gives up the map that it made meanwhile, but for where the robot stands beside two walls that both maps have: these say
//! where it stands in the kept one. So no stored wall moves, and nothing is counted twice.

use crate::filter::layout::ALPHA;
use crate::geometry::angle::wrap;
use crate::geometry::pose::Pose;
use crate::slam::Slam;
pub use crate::walls::wall::Direction;
use crate::walls::wall::Wall;
use core::f32::consts::FRAC_PI_2;

/// States of the pose: they lead the filter's states and are not kept.
pub const POSE_STATES: usize = 3;

/// A wall as it is kept; states are named by their indices in the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptWall {
    /// Identifier.
    pub id: u16,
    /// Index of the state that is the distance of its line from the filter's origin.
    pub rho: u16,
    /// Where its direction comes from.
    pub direction: Direction,
    /// Start of its extent along (-sin beta, cos beta), metres.
    pub lo_m: f32,
    /// End of its extent, metres.
    pub hi_m: f32,
    /// Readings that updated it.
    pub updates: u32,
    /// Confidence in its existence.
    pub score: i8,
    /// Its line when it was first drawn, where walls hold the map frame: distance from the origin (metres) and direction of the
    /// normal (radians).
    pub drawn: Option<[f32; 2]>,
}

impl KeptWall {
    pub(crate) fn of(wall: &Wall) -> Self {
        Self {
            id: wall.id,
            rho: wall.rho,
            direction: wall.direction,
            lo_m: wall.lo_m,
            hi_m: wall.hi_m,
            updates: wall.updates,
            score: wall.score,
            drawn: wall.drawn,
        }
    }
}

/// What is kept beside walls and states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptFrame {
    /// States of the filter, with the pose's.
    pub states: u16,
    /// Of these, states that no wall has: pose, grid, calibration.
    pub common: u16,
    /// Walls.
    pub walls: u16,
    /// The next wall's identifier.
    pub next_id: u16,
    /// The grid was founded.
    pub has_grid: bool,
    /// Where the first drive started is the robot's dock.
    pub has_dock: bool,
    /// How likely the home's walls stand on its grid exactly by those that were put onto it: log of the odds, in quarters; the least where they
    /// stand as built walls do.
    pub exactness: i8,
    /// Where the first drive started, in the map frame.
    pub start: Pose,
    /// Where the filter's frame is in that of the start pose, with its covariance; none where they are one.
    pub anchor: Option<(Pose, [[f32; 3]; 3])>,
    /// Number of times that the filter began anew elsewhere since the estimator was made; nought where it is none.
    pub number: u16,
}

/// Where a robot was in a kept map when its power went, as far as it knew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastPose {
    /// The pose in the map frame.
    pub pose: Pose,
    /// Variance of its place along each axis, m^2.
    pub place_m2: f32,
    /// Variance of its heading, rad^2.
    pub heading_rad2: f32,
}

/// A map that is kept, wherever it is.
pub trait Kept {
    /// What there is beside walls and states.
    fn frame(&self) -> KeptFrame;

    /// The wall at a place of the list.
    fn wall(&self, index: usize) -> Option<KeptWall>;

    /// Path of the robot since the wall at a place of the list was met, metres; none where that is not known.
    fn unseen_m(&self, _index: usize) -> Option<f32> {
        None
    }

    /// Estimate of state `i`.
    fn mean(&self, i: usize) -> f32;

    /// Covariance of the states `i` and `j`.
    fn covariance(&self, i: usize, j: usize) -> f32;

    /// Distance of a wall's line from the filter's origin along its normal, metres, and the direction of that normal, radians.
    fn line(&self, wall: &KeptWall) -> [f32; 2] {
        let alpha_rad = self.mean(ALPHA);
        let on_grid = |quarter: u8| wrap(alpha_rad + f32::from(quarter) * FRAC_PI_2);
        let beta_rad = match wall.direction {
            Direction::Grid(quarter) => on_grid(quarter),
            Direction::Snapped(theta) => {
                let quarters = libm::roundf((self.mean(usize::from(theta)) - alpha_rad) * (1.0 / FRAC_PI_2));
                wrap(alpha_rad + quarters * FRAC_PI_2)
            }
            Direction::Free(theta) | Direction::NearGrid(theta, _) | Direction::Built(theta, _) => {
                self.mean(usize::from(theta))
            }
        };
        [self.mean(usize::from(wall.rho)), beta_rad]
    }
}

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Kept for Slam<S, W, B, ROWS> {
    fn frame(&self) -> KeptFrame {
        KeptFrame {
            states: self.ekf.len() as u16,
            common: self.map.first_state(&self.ekf) as u16,
            walls: self.map.walls().len() as u16,
            next_id: self.map.next_id(),
            has_grid: self.map.has_grid,
            has_dock: self.map.has_dock,
            exactness: self.map.exactness.quarters(self.map.tolerance),
            start: self.map.start,
            anchor: self.map.anchor.map(|anchor| (anchor.pose, anchor.whole_covariance(&self.ekf, &self.drive.states))),
            number: self.map.frames,
        }
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        self.map.walls().get(index).map(KeptWall::of)
    }

    fn unseen_m(&self, index: usize) -> Option<f32> {
        Some(self.drive.dead_reckoning.path_m - self.map.walls().get(index)?.seen_at_m)
    }

    fn mean(&self, i: usize) -> f32 {
        self.ekf.mean(i)
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        self.ekf.covariance(i, j)
    }
}
