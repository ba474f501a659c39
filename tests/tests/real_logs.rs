//! Logs of real robots. They are not part of the project: `cargo xtask test real-logs` runs these tests where they are.

use lab::recording::Figures;
use slam_core::Config;
use tests::real_logs::{CORRIDOR, FREIBURG, HALLWAYS, INTEL, RealLog};
use tests::trial::{LoadedLog, NOISES, Trial};

/// Replays a real log to its end.
fn replay(log: RealLog, rows: usize) -> Figures {
    let replayed = log.replay();
    assert!(replayed.error.is_none() && replayed.notes.is_empty(), "{:?} {:?}", replayed.error, replayed.notes);
    let recording = replayed.recording;
    assert_eq!(recording.steps.len(), rows);
    let finite = |step: &lab::recording::Step| {
        [step.pose.x_m, step.pose.y_m, step.pose.theta_rad].iter().all(|number| number.is_finite())
            && step.covariance.iter().flatten().all(|number| number.is_finite())
    };
    assert!(recording.steps.iter().all(finite));
    assert!(recording.figures.walls > 0 && recording.figures.updates > 1000, "{:?}", recording.figures);
    recording.figures
}

/// Odometry's map entropy less the estimate's.
fn sharper_nats(figures: &Figures) -> f64 {
    let score = figures.consistency.as_ref().expect("there are readings");
    score.odometry_entropy_nats - score.entropy_nats
}

#[test]
#[ignore = "needs the logs of real robots: cargo xtask test real-logs"]
fn freiburg_offices_with_a_laser() {
    let figures = replay(FREIBURG, 2400);
    let (estimate, odometry) = (figures.estimate.expect("a truth"), figures.odometry.expect("a truth"));
    // A property of the log alone: it pins reading, dead reckoning, pairing and alignment.
    assert!((odometry.ate_m - 0.783).abs() < 0.005, "{odometry:?}");
    assert!(estimate.ate_m < odometry.ate_m, "{estimate:?} is worse than {odometry:?}");
}

#[test]
#[ignore = "needs the logs of real robots: cargo xtask test real-logs"]
fn hallways_with_a_drone() {
    let figures = replay(HALLWAYS, 3431);
    assert!(sharper_nats(&figures) > 0.0, "more blurred than odometry: {:?}", figures.consistency);
}

#[test]
#[ignore = "needs the logs of real robots: cargo xtask test real-logs"]
fn a_corridor_in_a_carmen_log() {
    let figures = replay(CORRIDOR, 713);
    assert!((figures.path_m - 41.2).abs() < 0.1, "{figures:?}");
    assert!(sharper_nats(&figures) > 0.2, "hardly sharper than odometry: {:?}", figures.consistency);
}

#[test]
#[ignore = "needs the logs of real robots: cargo xtask test real-logs"]
fn offices_whose_walls_bend() {
    let log = LoadedLog::read(INTEL);
    let of = |noise: f32| log.replay(&Trial { config: Config::real_rooms(), noise, ..Trial::default() });
    let off_m = NOISES.map(|noise| of(noise).figures.estimate.expect("a truth").ate_m);
    println!("{off_m:.2?}");
    // Believed as a straight one, the wall that bends turns every fourth replay by ten degrees: it ends up to five metres off.
    assert!(off_m.iter().all(|m| *m < 2.0), "{off_m:.2?}");
}
