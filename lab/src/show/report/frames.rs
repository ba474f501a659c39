//! Where fresh maps of a robot that looked for its place lie in its kept map.

use crate::recording::{Pose2, Recording};

/// The frames of a run's poses, one after the other: each begins where the robot lost or found its place.
pub struct Frames {
    /// First step of each frame, and where the frame lies in that of the kept map.
    frames: Vec<(usize, Pose2)>,
}

impl Frames {
    /// Those of a run. A fresh map whose robot never found itself stays where it is.
    pub fn of(recording: &Recording) -> Self {
        let steps = &recording.steps;
        let is_begin = |step: &usize| *step == 0 || steps[*step].searching != steps[step - 1].searching;
        let begins: Vec<usize> = (0..steps.len()).filter(is_begin).collect();
        let place = |(index, begin): (usize, &usize)| {
            let found = begins.get(index + 1).filter(|_| steps[*begin].searching);
            (*begin, found.map_or_else(Pose2::default, |found| found_at(recording, *found)))
        };
        Self { frames: begins.iter().enumerate().map(place).collect() }
    }

    /// Number of the frame that the poses of a step are in.
    pub fn of_step(&self, step: usize) -> usize {
        self.frames.partition_point(|(begin, _)| *begin <= step).saturating_sub(1)
    }

    /// Where the frame of a step lies in that of the kept map.
    pub fn place(&self, step: usize) -> Pose2 {
        self.frames.get(self.of_step(step)).map_or_else(Pose2::default, |(_, place)| *place)
    }
}

/// Where the fresh frame lay, by the last pose in it and the first in the kept one, the drive between them left out.
fn found_at(recording: &Recording, found: usize) -> Pose2 {
    let (before, after) = (&recording.steps[found - 1], &recording.steps[found]);
    let driven = before.sensed.relative(&after.sensed);
    let fresh = before.pose.compose(&driven);
    after.pose.compose(&fresh.relative(&Pose2::default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Step;

    #[test]
    fn a_fresh_map_lies_where_its_last_pose_was_found() {
        let pose = |x_m, y_m, theta_rad| Pose2::new(x_m, y_m, theta_rad);
        let step = |searching, pose: Pose2, driven_m| Step {
            searching,
            pose,
            sensed: Pose2::new(driven_m, 0.0, 0.0),
            ..Step::default()
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let recording = Recording {
            steps: vec![
                step(true, pose(0.0, 0.0, 0.0), 0.0),
                step(true, pose(1.0, 0.0, 0.0), 1.0),
                step(false, pose(5.0, 3.1, quarter), 1.1),
            ],
            ..Recording::default()
        };
        let frames = Frames::of(&recording);
        let placed = frames.place(1).compose(&recording.steps[1].pose);
        let expected = [5.0, 3.0, quarter];
        for (found, expected) in [placed.x_m, placed.y_m, placed.theta_rad].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{placed:?}");
        }
        assert_eq!(frames.place(2), Pose2::default());
        assert_ne!(frames.of_step(1), frames.of_step(2));
        assert_eq!(Frames::of(&Recording::default()).of_step(0), 0);
    }
}
