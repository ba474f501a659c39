//! First-estimates Jacobians (Huang, Mourikis and Roumeliotis 2010, sec. 5.1).
//!
//! A map can be moved and turned as a whole with the robot in it: no reading tells. A filter that differentiates its models
//! at ever newer estimates loses sight of that and comes to know the map's direction better than anything measured it.
//! What counts is where the Jacobians say that this common motion leads: here they say the same in every step, since it
//! starts from the pose as each step *predicted* it, and from each wall's normal as it was born. What cancels in it,
//! range and incidence, is that of the latest estimate, and so are all innovations.
//!
//! A normal that turned out to be another is taken anew, and the covariance with it: the error of the wall's distance is restated so
//! that the common motions are those of before at the new normal, and nothing is learned by that. It is what an invariant filter does
//! in each update (Barrau and Bonnabel 2015).

use crate::filter::ekf::{EkfView, MotionJacobian};
use crate::filter::layout::{THETA, X, Y};
use crate::geometry::pose::Pose;
use crate::measurement::beam::Prediction;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::wall::Wall;

/// At which estimates the models are differentiated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Linearisation {
    /// The latest ones: the plain extended Kalman filter, as in Rousse & Qiu.
    Latest,
    /// The pose as each step predicted it and the walls' normals as they were born (Huang, Mourikis and Roumeliotis 2010).
    #[default]
    FirstEstimates,
}

/// Sine of the angle by which a wall's normal may have turned since readings were differentiated at it: a third of a degree. Ten metres
/// away that is a lever of six centimetres, which errors of millimetres multiply.
const TURNED: f32 = 0.006;

/// What the models are differentiated at.
#[derive(Clone, Copy, Debug)]
pub struct FirstEstimates {
    /// The pose as it was predicted in this step.
    pub pose: Pose,
}

impl FirstEstimates {
    /// At the start.
    pub const START: Self = Self { pose: Pose::ORIGIN };

    /// The motion's Jacobian, from where the step's start was predicted to where its end is.
    pub fn of_motion(&self, at_latest: MotionJacobian, predicted: &Pose) -> MotionJacobian {
        let mut jacobian = at_latest;
        jacobian[X][THETA] = self.pose.y_m - predicted.y_m;
        jacobian[Y][THETA] = predicted.x_m - self.pose.x_m;
        jacobian
    }

    /// The derivatives of a reading, given those at the latest estimate.
    pub fn of_reading(&self, wall: &Wall, latest: &Prediction) -> Prediction {
        let normal = wall.first_normal;
        // A turn of everything about the origin moves the pose by (-y, x) and leaves the reading as it is.
        let Pose { x_m, y_m, .. } = self.pose;
        let along_m = y_m * normal[0] - x_m * normal[1];
        Prediction {
            by_position: normal.map(|n| -n * latest.by_rho),
            by_beta: -latest.by_heading - along_m * latest.by_rho,
            ..*latest
        }
    }

    /// Takes a wall's normal anew where it turned, and restates its distance's error: n . (error of the position, less what a turn of
    /// everything about the origin makes of it), for what the normal changed by.
    pub fn renew(&self, wall: &mut Wall, ekf: &mut EkfView) {
        let normal = wall.line(ekf, &ManhattanFrame::of(ekf)).normal;
        let first = core::mem::replace(&mut wall.first_normal, normal);
        if (first[0] * normal[1] - first[1] * normal[0]).abs() < TURNED {
            wall.first_normal = first;
            return;
        }
        let by = [normal[0] - first[0], normal[1] - first[1]];
        let Pose { x_m, y_m, .. } = self.pose;
        ekf.restate(wall.rho(), [(X, by[0]), (Y, by[1]), (THETA, by[0] * y_m - by[1] * x_m)]);
    }
}
