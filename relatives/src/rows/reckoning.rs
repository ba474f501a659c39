//! Dead reckoning: the motion alone, which every system must beat.

use crate::geometry::{Chain, Segment};
use crate::{Input, Output, Relative};

/// The motion alone.
#[derive(Default)]
pub struct Reckoning(Chain);

impl Relative for Reckoning {
    fn step(&mut self, input: &Input<'_>) -> Output {
        self.0 = self.0.then(&input.motion, &input.motion_cov);
        Output { pose: self.0.pose, covariance: Some(self.0.covariance) }
    }

    fn walls(&self) -> Vec<Segment> {
        Vec::new()
    }

    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
}
