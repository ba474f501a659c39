//! First-estimates Jacobians (Huang, Mourikis and Roumeliotis 2010, sec. 5.1).
//!
//! A map can be moved and turned as a whole with the robot in it: no reading tells. A filter that differentiates its models
//! at ever newer estimates loses sight of that and comes to know the map's direction better than anything measured it.
//! What counts is where the Jacobians say that this common motion leads: here they say the same in every step, since it
//! starts from the pose as each step *predicted* it, and from the grid's direction as it was founded. What cancels in it,
//! range and incidence, is that of the latest estimate, and so are all innovations: a far first estimate cannot make a bad
//! lever.

use crate::filter::ekf::MotionJacobian;
use crate::filter::layout::{THETA, X, Y};
use crate::geometry::line::Line;
use crate::geometry::pose::Pose;
use crate::measurement::beam::Prediction;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::wall::{Direction, Wall};

/// At which estimates the models are differentiated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Linearisation {
    /// The latest ones: the plain extended Kalman filter, as in Rousse & Qiu.
    Latest,
    /// The pose as each step predicted it and the grid's direction as it was founded (Huang, Mourikis and Roumeliotis
    /// 2010).
    #[default]
    FirstEstimates,
}

/// A first direction of the grid that turned out farther off than this is taken anew, radians: one degree. Its error in
/// each Jacobian costs more than what is gained by keeping it.
const GRID_OFF_RAD: f32 = 0.02;

/// What the models are differentiated at.
#[derive(Clone, Copy, Debug)]
pub struct FirstEstimates {
    /// The pose as it was predicted in this step.
    pub pose: Pose,
    /// The grid's direction as it was founded.
    pub grid: Option<ManhattanFrame>,
}

impl FirstEstimates {
    /// At the start.
    pub const START: Self = Self { pose: Pose::ORIGIN, grid: None };

    /// The motion's Jacobian, from where the step's start was predicted to where its end is.
    pub fn of_motion(&self, at_latest: MotionJacobian, predicted: &Pose) -> MotionJacobian {
        let mut jacobian = at_latest;
        jacobian[X][THETA] = self.pose.y_m - predicted.y_m;
        jacobian[Y][THETA] = predicted.x_m - self.pose.x_m;
        jacobian
    }

    /// Takes in the pose as this step predicted it, and the grid where it was founded since or turned out far off.
    pub fn follow(&mut self, predicted: Pose, grid: Option<ManhattanFrame>) {
        self.pose = predicted;
        let is_off =
            |first: ManhattanFrame, now: ManhattanFrame| (now.alpha_rad - first.alpha_rad).abs() > GRID_OFF_RAD;
        if let Some(now) = grid
            && self.grid.is_none_or(|first| is_off(first, now))
        {
            self.grid = Some(now);
        }
    }

    /// The estimate was replaced as a whole: its first ones are those of now.
    pub fn begin_anew(&mut self, pose: Pose, grid: Option<ManhattanFrame>) {
        *self = Self { pose, grid };
    }

    /// The derivatives of a reading, given those at the latest estimate.
    pub fn of_reading(&self, wall: &Wall, line: &Line, latest: &Prediction) -> Prediction {
        let normal = match (wall.direction, self.grid) {
            (Direction::Grid(quarter), Some(grid)) => grid.normal(quarter),
            _ => line.normal,
        };
        // A turn of everything about the origin moves the pose by (-y, x) and leaves the reading as it is.
        let Pose { x_m, y_m, .. } = self.pose;
        let along_m = y_m * normal[0] - x_m * normal[1];
        Prediction {
            by_position: normal.map(|n| -n * latest.by_rho),
            by_beta: -latest.by_heading - along_m * latest.by_rho,
            ..*latest
        }
    }
}
