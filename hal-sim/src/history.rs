//! Where the robot was in the last while: what a late reading shows.

use std::collections::VecDeque;

use crate::pose::Pose2;

/// Poses are kept for the oldest reading that there can be, seconds.
const KEPT_S: f64 = 0.3;

/// Times and poses of the last while, oldest first.
#[derive(Clone, Debug)]
pub(crate) struct History(VecDeque<(f64, Pose2)>);

impl History {
    /// Standing here at time 0.
    pub(crate) fn starting_at(pose: Pose2) -> Self {
        Self(VecDeque::from([(0.0, pose)]))
    }

    /// Takes in where the robot is now.
    pub(crate) fn push(&mut self, now_s: f64, pose: Pose2) {
        self.0.push_back((now_s, pose));
        while self.0.get(1).is_some_and(|(time_s, _)| *time_s < now_s - KEPT_S) {
            self.0.pop_front();
        }
    }

    /// Where it was at a time (seconds), or at the nearest one that is kept.
    pub(crate) fn at(&self, then_s: f64) -> Pose2 {
        let after = self.0.partition_point(|(time_s, _)| *time_s <= then_s);
        match (after.checked_sub(1).and_then(|i| self.0.get(i)), self.0.get(after)) {
            (Some((from_s, from)), Some((to_s, to))) => from.interpolate(to, (then_s - from_s) / (to_s - from_s)),
            (Some((_, pose)), None) | (None, Some((_, pose))) => *pose,
            (None, None) => Pose2::default(),
        }
    }
}
