//! The frame of the floor job: its axes along the walls' grid of the map that it began in. What the job remembers is in this frame, and
//! stays where it is when the robot goes on in another map.

use slam_core::Pose;

/// Where the job's frame lies in the map's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Its origin in the map frame.
    origin: Pose,
    /// Its axes are along the walls' grid.
    is_aligned: bool,
}

impl Frame {
    /// The map's.
    pub(super) const MAP: Self = Self { origin: Pose::ORIGIN, is_aligned: false };

    /// The frame with this origin in the map's; the map's where there is none.
    pub(super) fn at(origin: Option<Pose>) -> Self {
        origin.map_or(Self::MAP, |origin| Self { origin, is_aligned: true })
    }

    /// Its origin in the map frame.
    pub(super) fn origin(&self) -> Pose {
        self.origin
    }

    /// The same; none where it is the map's still.
    pub(super) fn kept(&self) -> Option<Pose> {
        (*self != Self::MAP).then_some(self.origin)
    }

    /// A pose of the map frame.
    pub(super) fn pose(&self, pose: &Pose) -> Pose {
        self.kept().map_or(*pose, |origin| origin.inverse().compose(pose))
    }

    /// Takes up the direction of the walls' grid; how far the frame turned, radians, where it did.
    pub(super) fn align(&mut self, grid_rad: f32) -> Option<f32> {
        if self.is_aligned || !grid_rad.is_finite() {
            return None;
        }
        let quarter = core::f32::consts::FRAC_PI_2;
        let off_rad = grid_rad - self.origin.theta_rad;
        let nearest_rad = off_rad - quarter * libm::roundf(off_rad / quarter);
        let Pose { x_m, y_m, theta_rad } = self.origin;
        *self = Self { origin: Pose::new(x_m, y_m, theta_rad + nearest_rad), is_aligned: true };
        Some(nearest_rad)
    }

    /// The robot goes on in another map: a place of the map so far is this one there.
    pub(super) fn go_on(&mut self, before: &Pose, now: &Pose) {
        let origin = now.compose(&self.pose(before).inverse());
        if origin.x_m.is_finite() && origin.y_m.is_finite() && origin.theta_rad.is_finite() {
            self.origin = origin;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_another_map_everything_stays_where_it_is() {
        let mut frame = Frame::MAP;
        frame.align(0.1);
        let (robot, chair) = (Pose::new(1.0, 2.0, 0.7), Pose::new(-1.0, 0.5, 0.0));
        let remembered = frame.pose(&chair);
        // The other map's origin lies here.
        let other = Pose::new(3.0, -2.0, 1.9);
        let seen_there = |pose: &Pose| other.inverse().compose(pose);
        frame.go_on(&robot, &seen_there(&robot));
        let again = frame.pose(&seen_there(&chair));
        assert!((again.x_m - remembered.x_m).abs() < 1e-5 && (again.y_m - remembered.y_m).abs() < 1e-5, "{again:?}");
        assert!(frame.align(0.4).is_none(), "its axes are what they were");
    }

    #[test]
    fn axes_that_nothing_told_yet_turn_onto_the_grid_of_another_map() {
        let mut frame = Frame::MAP;
        let here = Pose::new(1.0, 2.0, 0.4);
        frame.go_on(&Pose::ORIGIN, &here);
        assert!((frame.align(-1.4).unwrap() + 0.4 - (core::f32::consts::FRAC_PI_2 - 1.4)).abs() < 1e-6);
        assert_eq!([frame.origin().x_m, frame.origin().y_m], [here.x_m, here.y_m], "they turn about their origin");
        assert!(frame.align(0.3).is_none(), "once");
    }
}
