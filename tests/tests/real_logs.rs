//! Logs of real robots, where they are at hand.

use lab::recording::Figures;
use lab::replay::Replay;
use slam_core::Config;
use tests::real_logs::folder;

/// Replays a real log to its end; none where it is not at hand.
fn replay(name: &str, log: &str, rows: usize) -> Option<Figures> {
    let folder = folder(name)?;
    let out = tempfile::TempDir::new().expect("a temporary folder");
    let replay = Replay {
        log: folder.join(log),
        rig: folder.join("rig.toml"),
        out: out.path().to_owned(),
        truth: None,
        config: Config::default(),
        trace: false,
    };
    let replayed = replay.run(|_| ()).unwrap_or_else(|error| panic!("{error}"));
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

#[test]
fn freiburg_offices_with_a_laser() {
    let Some(figures) = replay("fr079-first", "log.csv", 2400) else { return };
    let (estimate, odometry) = (figures.estimate.expect("a truth"), figures.odometry.expect("a truth"));
    // A property of the log alone: it pins reading, dead reckoning, pairing and alignment.
    assert!((odometry.ate_m - 0.783).abs() < 0.005, "{odometry:?}");
    assert!(estimate.ate_m < odometry.ate_m, "{estimate:?} is worse than {odometry:?}");
}

#[test]
fn hallways_with_a_drone() {
    replay("olsson-demo", "log.csv", 3431);
}

#[test]
fn a_corridor_in_a_carmen_log() {
    let Some(figures) = replay("wean-1", "wean.log.gz", 713) else { return };
    assert!((figures.path_m - 41.2).abs() < 0.1, "{figures:?}");
}
