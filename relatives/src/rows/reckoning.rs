//! Dead reckoning: the motion alone, which every system must beat.

use nalgebra::Matrix3;

use crate::geometry::{Pose, Segment};
use crate::{Input, Output, Relative};

/// The motion alone.
#[derive(Default)]
pub struct Reckoning {
    pose: Pose,
    covariance: Matrix3<f64>,
}

impl Relative for Reckoning {
    fn step(&mut self, input: &Input<'_>) -> Output {
        let (by_pose, by_motion) = self.pose.compose_jacobians(&input.motion);
        self.covariance =
            by_pose * self.covariance * by_pose.transpose() + by_motion * input.motion_cov * by_motion.transpose();
        self.pose = self.pose.compose(&input.motion);
        Output { pose: self.pose, covariance: Some(self.covariance) }
    }

    fn walls(&self) -> Vec<Segment> {
        Vec::new()
    }

    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
}
