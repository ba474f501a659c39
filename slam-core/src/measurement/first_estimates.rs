//! First-estimates Jacobians (Huang, Mourikis and Roumeliotis 2010, sec. 5.1).
//!
//! A map can be moved and turned as a whole with the robot in it: no reading tells. A filter that differentiates its models
//! at ever newer estimates loses sight of that and comes to know the map's direction better than anything measured it.
//! What counts is where the Jacobians say that this common motion leads: here they say the same in every step, since it
//! starts from the pose as each step *predicted* it, and from the grid's direction as it was founded. What cancels in it,
//! range and incidence, is that of the latest estimate, and so are all innovations: a far first estimate cannot make a bad
//! lever.

use crate::config::Linearisation;
use crate::filter::ekf::MotionJacobian;
use crate::filter::layout::{ALPHA, THETA, X, Y};
use crate::geometry::line::Line;
use crate::geometry::pose::Pose;
use crate::measurement::beam::Prediction;
use crate::slam::Slam;
use crate::walls::manhattan::GridDirection;
use crate::walls::wall::{Direction, Wall};

/// A first direction of the grid that turned out farther off than this is taken anew, radians: one degree. Its error in
/// each Jacobian costs more than what is gained by keeping it.
const GRID_OFF_RAD: f32 = 0.02;

/// What the models are differentiated at.
#[derive(Clone, Copy, Debug)]
pub struct First {
    /// The pose as it was predicted in this step.
    pub pose: Pose,
    /// The grid's direction as it was founded.
    pub grid: Option<GridDirection>,
}

impl First {
    /// At the start.
    pub const START: Self = Self { pose: Pose::ORIGIN, grid: None };
}

impl<const S: usize, const W: usize, const B: usize, const NB: usize, const BLOCKS: usize> Slam<S, W, B, NB, BLOCKS> {
    /// The motion's Jacobian, from where the step's start was predicted to where its end is.
    pub(crate) fn linearise_motion(&mut self, jacobian: &mut MotionJacobian, predicted: Pose) {
        if self.config.linearisation == Linearisation::FirstEstimates {
            jacobian[X][THETA] = self.first.pose.y_m - predicted.y_m;
            jacobian[Y][THETA] = predicted.x_m - self.first.pose.x_m;
        }
        self.first.pose = predicted;
        let alpha_rad = self.ekf.mean(ALPHA);
        let is_off = |grid: GridDirection| (alpha_rad - grid.alpha_rad).abs() > GRID_OFF_RAD;
        if self.has_grid && self.first.grid.is_none_or(is_off) {
            self.first.grid = Some(GridDirection::of(&self.ekf));
        }
    }

    /// The derivatives of a reading, given those at the latest estimate.
    pub(crate) fn linearise(&self, wall: &Wall, line: &Line, latest: &Prediction) -> Prediction {
        if self.config.linearisation == Linearisation::Latest {
            return *latest;
        }
        let normal = match (wall.direction, self.first.grid) {
            (Direction::Grid(quarter), Some(grid)) => grid.normal(quarter),
            _ => line.normal,
        };
        // A turn of everything about the origin moves the pose by (-y, x) and leaves the reading as it is.
        let Pose { x_m, y_m, .. } = self.first.pose;
        let along_m = y_m * normal[0] - x_m * normal[1];
        Prediction {
            by_position: normal.map(|n| -n * latest.by_rho),
            by_beta: -latest.by_heading - along_m * latest.by_rho,
            ..*latest
        }
    }
}
