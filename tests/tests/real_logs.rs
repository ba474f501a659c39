//! Logs of real robots, where they are at hand.

use lab::recording::Figures;
use tests::real_logs::{CORRIDOR, FREIBURG, HALLWAYS, RealLog};

/// Replays a real log to its end; none where it is not at hand.
fn replay(log: RealLog, rows: usize) -> Option<Figures> {
    let replayed = log.replay()?;
    assert!(replayed.error.is_none() && replayed.notes.is_empty(), "{:?} {:?}", replayed.error, replayed.notes);
    let recording = replayed.recording;
    assert_eq!(recording.steps.len(), rows);
    let finite = |step: &lab::recording::Step| {
        [step.pose.x_m, step.pose.y_m, step.pose.theta_rad].iter().all(|number| number.is_finite())
            && step.covariance.iter().flatten().all(|number| number.is_finite())
    };
    assert!(recording.steps.iter().all(finite));
    assert!(recording.figures.walls > 0 && recording.figures.updates > 1000, "{:?}", recording.figures);
    Some(recording.figures)
}

/// Odometry's map entropy less the estimate's.
fn sharper_nats(figures: &Figures) -> f64 {
    let score = figures.consistency.as_ref().expect("there are readings");
    score.odometry_entropy_nats - score.entropy_nats
}

#[test]
fn freiburg_offices_with_a_laser() {
    let Some(figures) = replay(FREIBURG, 2400) else { return };
    let (estimate, odometry) = (figures.estimate.expect("a truth"), figures.odometry.expect("a truth"));
    // A property of the log alone: it pins reading, dead reckoning, pairing and alignment.
    assert!((odometry.ate_m - 0.783).abs() < 0.005, "{odometry:?}");
    assert!(estimate.ate_m < odometry.ate_m, "{estimate:?} is worse than {odometry:?}");
}

#[test]
fn hallways_with_a_drone() {
    let Some(figures) = replay(HALLWAYS, 3431) else { return };
    assert!(sharper_nats(&figures) > 0.0, "more blurred than odometry: {:?}", figures.consistency);
}

#[test]
fn a_corridor_in_a_carmen_log() {
    let Some(figures) = replay(CORRIDOR, 713) else { return };
    assert!((figures.path_m - 41.2).abs() < 0.1, "{figures:?}");
    assert!(sharper_nats(&figures) > 0.2, "hardly sharper than odometry: {:?}", figures.consistency);
}
