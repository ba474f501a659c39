//! The frame of the floor job: the map frame turned so that lanes run along the walls.

use slam_core::Pose;

/// Which way the job's frame is turned against the map's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Direction of the job's x axis in the map frame, radians; none until the walls' grid is known.
    grid_rad: Option<f32>,
}

impl Frame {
    /// Its origin in the map frame.
    pub(super) fn origin(&self) -> Pose {
        Pose::new(0.0, 0.0, self.grid_rad.unwrap_or(0.0))
    }

    /// The frame turned like this against the map's.
    pub(super) const fn with_grid(grid_rad: Option<f32>) -> Self {
        Self { grid_rad }
    }

    /// How it is turned, radians; none until the walls' grid is known.
    pub(super) fn grid_rad(&self) -> Option<f32> {
        self.grid_rad
    }

    /// A pose of the map frame.
    pub(super) fn pose(&self, pose: &Pose) -> Pose {
        match self.grid_rad {
            Some(_) => self.origin().inverse().compose(pose),
            None => *pose,
        }
    }

    /// Takes up the direction of the walls' grid; how far the frame turned, radians, where it did.
    pub(super) fn align(&mut self, grid_rad: f32) -> Option<f32> {
        if self.grid_rad.is_some() || !grid_rad.is_finite() {
            return None;
        }
        let quarter = core::f32::consts::FRAC_PI_2;
        let nearest_rad = grid_rad - quarter * libm::roundf(grid_rad / quarter);
        self.grid_rad = Some(nearest_rad);
        Some(nearest_rad)
    }
}
