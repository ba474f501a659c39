//! Another system over a drive of an experiment.

use hal_sim::scanner::ScannerKind;
use relatives::front::Front;
use relatives::geometry::{Point, Segment};
use relatives::{Dense, Input, Kind, Setup};

use crate::senses::{Scanned, beams_of};
use crate::track::Track;
use crate::unit::Driven;
use lab::evaluate::score::path;
use lab::recording::{Pose2, Step};
use lab::run::{covariance_of, to_record, views};

/// Follows the drive; an error is why the system cannot run on it.
///
/// # Errors
/// Why the system cannot run with such sensors.
pub fn track(driven: &Driven, kind: Kind, scanned: Option<&Scanned>, seed: u64) -> Result<Track, &'static str> {
    let has_scans = scanned.is_some_and(|scanned| matches!(scanned.kind, ScannerKind::Laser(_)));
    let known = driven.walls().iter().map(|wall| Segment { from: wall.from_m.into(), to: wall.to_m.into() }).collect();
    let cones = scanned.is_some_and(|scanned| scanned.kind == ScannerKind::Sonar);
    let mut relative = kind.build(&Setup { seed, has_scans, cones, known })?;
    let mut front = Front::new(driven.robot.rig.clone());
    let mut track = Track::default();
    for (i, frame) in driven.frames.iter().enumerate() {
        let scan = scanned.and_then(|scanned| Some((scanned.kind, scanned.scans.get(i)?.as_deref()?)));
        let read = front.read(&frame.sample, None);
        let beams = scan.map_or(Vec::new(), |(kind, ranges)| beams_of(kind, ranges));
        let dense = scan.filter(|_| has_scans).map(|(kind, ranges)| dense_of(kind, ranges));
        let input = if scanned.is_some() { Input { beams: &beams, dense, ..read } } else { read };
        let output = relative.step(&input);
        track.steps.push(Step {
            t_s: frame.sample.time_us as f64 * 1e-6,
            pose: to_record(&output.pose),
            covariance: covariance_of(output.covariance),
            ..Step::default()
        });
    }
    track.reveal(&driven.frames);
    track.walls = views(&relative.walls());
    track.bytes = relative.bytes();
    track.back_m = relative.path().and_then(|path| {
        let pairs: Vec<(Pose2, Pose2)> =
            path.iter().zip(&driven.frames).map(|(pose, frame)| (to_record(pose), frame.truth)).collect();
        path::score(&pairs).map(|score| score.ate_m)
    });
    Ok(track)
}

fn dense_of(kind: ScannerKind, ranges: &[f32]) -> Dense<'_> {
    Dense { origin: Point::zeros(), first: kind.bearing_rad(0), step: kind.step_rad(), ranges, reach: kind.reach_m() }
}
