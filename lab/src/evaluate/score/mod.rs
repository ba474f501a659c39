//! Scores of a run against what is true.

pub mod consistency;
mod entropy;
mod hits;
pub mod map;
pub mod nis;
mod passes;
pub mod path;
mod surfels;

use crate::input::log::truth::{Truth, pair};
use crate::recording::{PathScore, Pose2, Recording, Step, TruthFrame};

/// Puts the truth into the record, moved into the frame that the estimate should be in, and scores both paths against it.
///
/// `truth` replaces what the rows themselves carried; `times_s` are the rows' times on its clock.
pub fn score(recording: &mut Recording, times_s: &[f64], truth: Option<&Truth>) {
    recording.figures.consistency = consistency::score(recording);
    if let Some(truth) = truth {
        for (step, pose) in recording.steps.iter_mut().zip(pair(times_s, truth)) {
            step.truth = pose.filter(|_| !step.carried);
        }
    }
    let Some(first) = recording.steps.iter().find_map(|step| step.truth) else { return };
    let origin = match recording.truth_frame {
        TruthFrame::FirstPose => first,
        TruthFrame::Map => Pose2::default(),
        TruthFrame::Unknown => {
            let pairs: Vec<_> =
                recording.steps.iter().filter_map(|step| Some((step.pose, step.claimed_truth()?))).collect();
            path::align(&pairs)
        }
    };
    for truth in recording.steps.iter_mut().filter_map(|step| step.truth.as_mut()) {
        *truth = origin.relative(truth);
    }
    (recording.figures.estimate, recording.figures.odometry) = against_truth(recording);
}

/// The scores of both paths, the estimate's first, against true poses in the frame that the estimate should be in; none where
/// none is known. The estimate's is without steps at which the robot claims no place; dead reckoning claims one always.
pub fn against_truth(recording: &Recording) -> (Option<PathScore>, Option<PathScore>) {
    let pairs = |step: &Step| Some((step.dead_reckoning, step.truth?));
    let odometry: Vec<(Pose2, Pose2)> = recording.steps.iter().filter_map(pairs).collect();
    (path::of_estimate(&recording.steps), path::score(&odometry))
}
