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
    let Some((first, truth)) = recording.steps.iter().find_map(|step| Some((step, step.truth?))) else { return };
    let begins_late = recording.truth_begins_late();
    let origin = match recording.truth_frame {
        // What little the robot moved until then, its odometry knows.
        TruthFrame::FirstPose if !begins_late => truth.compose(&first.dead_reckoning.relative(&Pose2::default())),
        TruthFrame::Map => Pose2::default(),
        TruthFrame::FirstPose | TruthFrame::Unknown => {
            let pairs: Vec<_> =
                recording.steps.iter().filter_map(|step| Some((step.pose, step.claimed_truth()?))).collect();
            path::align(&pairs)
        }
    };
    for truth in recording.steps.iter_mut().filter_map(|step| step.truth.as_mut()) {
        *truth = origin.relative(truth);
    }
    (recording.figures.estimate, recording.figures.odometry) = against_truth(recording);
    if begins_late {
        for score in [&mut recording.figures.estimate, &mut recording.figures.odometry].into_iter().flatten() {
            (score.start_m, score.nees) = (None, None);
        }
    }
}

/// The scores of both paths, the estimate's first, against true poses in the frame that the estimate should be in; none where
/// none is known. The estimate's is without steps at which the robot claims no place; dead reckoning claims one always.
pub fn against_truth(recording: &Recording) -> (Option<PathScore>, Option<PathScore>) {
    let pairs = |step: &Step| Some((step.dead_reckoning, step.truth?));
    let odometry: Vec<(Pose2, Pose2)> = recording.steps.iter().filter_map(pairs).collect();
    (path::of_estimate(&recording.steps), path::score(&odometry))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten metres straight ahead, estimated without an error, and the truth in a frame of its own.
    fn scored(first: usize) -> Recording {
        let frame = Pose2::new(3.0, -2.0, 0.5);
        let at = |i: usize| Pose2::new(0.02 * i as f64, 0.0, 0.0);
        let step = |i: usize| Step { t_s: 0.1 * i as f64, pose: at(i), dead_reckoning: at(i), ..Step::default() };
        let mut recording = Recording { steps: (0..500).map(step).collect(), ..Recording::default() };
        for step in &mut recording.steps {
            step.covariance = [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]];
        }
        let times_s: Vec<f64> = recording.steps.iter().map(|step| step.t_s).collect();
        let truth: Truth = (first..500).map(|i| (times_s[i], frame.compose(&at(i)))).collect();
        score(&mut recording, &times_s, Some(&truth));
        recording
    }

    #[test]
    fn a_truth_that_begins_late_gives_no_start_frame() {
        let estimate = |first| scored(first).figures.estimate.expect("a truth");
        for at_once in [0, 4] {
            let score = estimate(at_once);
            assert!(score.start_m.expect("it begins at the start") < 1e-9 && score.ate_m < 1e-9, "{score:?}");
            assert!(score.nees.expect("a covariance") < 1e-9, "{score:?}");
        }
        let late = estimate(100);
        assert_eq!((late.start_m, late.nees), (None, None));
        assert!(late.ate_m < 1e-9, "{late:?}");
        assert!(scored(4).findings().is_empty());
        assert!(scored(100).findings()[0].contains("the first true pose is of"), "{:?}", scored(100).findings());
    }
}
