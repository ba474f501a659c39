//! The poses that are placed: one for each stretch of path, with the odometry between them.

use crate::recording::{Pose2, Recording, wrap};

/// A new keyframe after so much path, metres: over that, odometry errs by a centimetre.
const SPACING_M: f64 = 0.25;

/// Or so much turning, radians.
const SPACING_RAD: f64 = 0.2;

/// What the odometry sensed from one keyframe to the next.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stretch {
    /// In the frame of the first.
    pub motion: Pose2,
    /// Length of the path, metres.
    pub path_m: f64,
    /// All turning, radians, either way.
    pub turning_rad: f64,
    /// How far off its end is, 1-sigma, metres and radians, where the motion was lost.
    pub lost: [f64; 2],
}

/// Which steps are keyframes.
#[derive(Clone, Debug)]
pub struct Keyframes {
    steps: Vec<usize>,
    /// From each to the next; one less than keyframes.
    pub stretches: Vec<Stretch>,
}

impl Keyframes {
    /// Of a record; the first step and the last are among them.
    pub fn of(recording: &Recording) -> Self {
        let (mut steps, mut stretches) = (Vec::new(), Vec::new());
        let mut so_far = Stretch::default();
        for (index, step) in recording.steps.iter().enumerate() {
            let Some(&begin) = steps.last() else {
                steps.push(index);
                continue;
            };
            let moved = recording.steps[index - 1].sensed.relative(&step.sensed);
            let mut close = |begin: usize, end: usize, stretch: Stretch| {
                let motion = recording.steps[begin].sensed.relative(&recording.steps[end].sensed);
                stretches.push(Stretch { motion, ..stretch });
                steps.push(end);
            };
            if let Some(lost) = step.lost {
                // Neither what came before nor what comes after is off by what was lost.
                if begin + 1 < index {
                    close(begin, index - 1, so_far);
                }
                close(index - 1, index, Stretch { lost: lost.map(f64::from), ..Stretch::default() });
                so_far = Stretch::default();
                continue;
            }
            so_far.path_m += moved.x_m.hypot(moved.y_m);
            so_far.turning_rad += moved.theta_rad.abs();
            let is_last = index + 1 == recording.steps.len();
            if so_far.path_m >= SPACING_M || so_far.turning_rad >= SPACING_RAD || is_last {
                close(begin, index, so_far);
                so_far = Stretch::default();
            }
        }
        Self { steps, stretches }
    }

    /// The steps that are keyframes.
    pub fn steps(&self) -> &[usize] {
        &self.steps
    }

    /// The keyframe at a step or the last before it.
    pub fn before(&self, step: usize) -> usize {
        self.steps.partition_point(|key| *key <= step).saturating_sub(1)
    }

    /// The pose of a step in the frame of its keyframe, by the odometry.
    pub fn local(&self, recording: &Recording, step: usize) -> Pose2 {
        let key = self.steps[self.before(step)];
        recording.steps[key].sensed.relative(&recording.steps[step].sensed)
    }

    /// Every step's pose, given those of the keyframes: between two of them, what the odometry misses is spread evenly.
    pub fn path(&self, recording: &Recording, poses: &[Pose2]) -> Vec<Pose2> {
        let place = |step: usize| {
            let key = self.before(step);
            let local = self.local(recording, step);
            let pose = poses[key].compose(&local);
            let Some((stretch, next)) = self.stretches.get(key).zip(poses.get(key + 1)) else { return pose };
            let share = (step - self.steps[key]) as f64 / (self.steps[key + 1] - self.steps[key]) as f64;
            let arrived = poses[key].compose(&stretch.motion);
            Pose2::new(
                pose.x_m + share * (next.x_m - arrived.x_m),
                pose.y_m + share * (next.y_m - arrived.y_m),
                pose.theta_rad + share * wrap(next.theta_rad - arrived.theta_rad),
            )
        };
        (0..recording.steps.len()).map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Step;

    #[test]
    fn the_odometry_s_own_keyframes_give_its_path_back() {
        let at = |i: i32| Pose2::new(0.03 * f64::from(i), (0.05 * f64::from(i)).sin(), 0.04 * f64::from(i));
        let steps = (0..200).map(|i| Step { sensed: at(i), ..Step::default() }).collect();
        let recording = Recording { steps, ..Recording::default() };
        let keyframes = Keyframes::of(&recording);
        assert!(keyframes.steps().len() > 20 && keyframes.steps().len() < 100);
        assert_eq!((keyframes.steps()[0], keyframes.steps().last()), (0, Some(&199)));
        let poses: Vec<Pose2> = keyframes.steps().iter().map(|step| recording.steps[*step].sensed).collect();
        for (step, pose) in recording.steps.iter().zip(keyframes.path(&recording, &poses)) {
            let off = step.sensed.relative(&pose);
            assert!(off.x_m.abs() < 1e-9 && off.y_m.abs() < 1e-9 && off.theta_rad.abs() < 1e-9, "{off:?}");
        }
    }
}
