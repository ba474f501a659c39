//! Prints `docs/results/kept-pairs.md`: real robots that begin in the map of an earlier drive, not knowing where.
//! `cargo run --release --package tests --example kept_pairs`.

use lab::evaluate::score::path;
use lab::evaluate::statistics::{max, median};
use lab::recording::{Pose2, Recording};
use slam_core::Config;
use tests::real_logs::{CORRIDOR, CORRIDOR_5, DRONE_8, DRONE_12, FREIBURG, FREIBURG_WHEELS, HALLWAYS, INTEL, RealLog};
use tests::trial::{Driven, LoadedLog, NOISES, Trial};

/// A claim that is farther off than this is wrong, metres: half the width of a narrow passage.
const WRONG_M: f64 = 0.5;

/// Part of a log, seconds after its first row.
#[derive(Clone, Copy)]
struct Part {
    log: RealLog,
    from_s: f64,
    to_s: f64,
}

impl Part {
    const fn all(log: RealLog) -> Self {
        Self { log, from_s: 0.0, to_s: f64::INFINITY }
    }

    const fn until(log: RealLog, to_s: f64) -> Self {
        Self { log, from_s: 0.0, to_s }
    }

    const fn from(log: RealLog, from_s: f64) -> Self {
        Self { log, from_s, to_s: f64::INFINITY }
    }

    fn rows(&self) -> LoadedLog {
        LoadedLog::read(self.log).between(self.from_s, self.to_s)
    }

    fn name(&self) -> String {
        match (self.from_s > 0.0, self.to_s.is_finite()) {
            (false, false) => self.log.name.to_owned(),
            (false, true) => format!("{}, first {:.0} s", self.log.name, self.to_s),
            _ => format!("{}, from {:.0} s", self.log.name, self.from_s),
        }
    }
}

/// Earlier drives, and later ones in the same place.
const PAIRS: [[Part; 2]; 8] = [
    [Part::all(DRONE_8), Part::all(DRONE_12)],
    [Part::all(DRONE_12), Part::all(DRONE_8)],
    [Part::until(FREIBURG, 240.0), Part::from(FREIBURG, 240.0)],
    [Part::until(FREIBURG_WHEELS, 240.0), Part::from(FREIBURG_WHEELS, 240.0)],
    [Part::until(INTEL, 300.0), Part::from(INTEL, 300.0)],
    [Part::until(HALLWAYS, 170.0), Part::from(HALLWAYS, 170.0)],
    [Part::all(CORRIDOR), Part::all(CORRIDOR_5)],
    [Part::all(CORRIDOR_5), Part::all(CORRIDOR)],
];

const HEAD: &str = "\
# Later drives in kept maps, real logs

Printed by `cargo run --release --package tests --example kept_pairs`. The robot drives through the earlier part of a
[real log](real-logs.md) with hand-overs, keeps its map, and is switched on in the later part, not knowing where. Nine replays each, with the
range noise that the rig file states up to 4 % larger or smaller. A claim is *wrong* where the robot is more than 50 cm away. Errors are those
of positions after the claim, in the frame that lays the earlier drive's path onto its truth best, so that the error of the earlier map is
in them.

| map of | later drive | found | wrong claims | after | path | error: median / worst replay | best odds while not found |
|---|---|---|---|---|---|---|---|
";

const TAIL: &str = "
Without a grid in either map there is no search. Where nothing is found, nothing wrong is claimed either, and a claim needs odds of e^6.9. What keeps the odds down is not that the walls are others.
Laid on one another by the truth, those of the later drive stand where kept ones do; but maps of large places are bent. Over the 28 m
of intel-loops walls are off by 0.2 m near the start and by 1.15 m at the far side, there all alike to 3 cm; in fr079-first by up to 0.2 m. A
wall's sigma against its map's start says so, 0.1 to 0.6 m, and the search takes each wall alone, so that none says much. Maps that are bent have the
path cross kept walls, too, which counts against a place. The drone's maps have four to seven walls on the grid: five of five are matched, and that is
worth e^4.8.

The two flights of the drone (smcl-S8, smcl-S12) are of the data of Zimmerman, Mueller, Magno and Benini (arXiv 2310.12536), who find the
drone in nine of ten runs, 32 cm off, with 32 beams, a camera and 4,096 particles in a floor plan that is given. Here the map is what the
drone made itself with eight of the beams on its one other flight through that passage, and theirs is the better result: a plan that is given is
neither bent nor short of walls.
";

/// One later drive.
struct Later {
    /// Seconds and metres of path until the first claim.
    found: Option<[f64; 2]>,
    wrong: usize,
    rmse_m: Option<f64>,
    /// Natural logarithm of the best odds that a search had; none where the map has no grid, without which nothing is searched for.
    log_odds: Option<f64>,
}

fn main() {
    print!("{HEAD}");
    for [earlier, later] in PAIRS {
        let [kept, begun] = [earlier, later].map(|part| part.rows());
        let all: Vec<Later> = NOISES.iter().map(|noise| pair(&kept, &begun, *noise)).collect();
        println!("| {} | {} | {} |", earlier.name(), later.name(), figures(&all));
    }
    print!("{TAIL}");
}

fn pair(kept: &LoadedLog, begun: &LoadedLog, noise: f32) -> Later {
    let trial = Trial { noise, config: Config { hand_overs: true, ..Config::real_rooms() }, ..Trial::default() };
    let earlier = kept.drive_in(None, &trial).expect("a drive without a map");
    let Ok(later) = begun.drive_in(earlier.map.clone(), &trial) else {
        return Later { found: None, wrong: 0, rmse_m: None, log_odds: None };
    };
    let errors = frame(&earlier).and_then(|frame| errors(&later, frame));
    let steps = &later.recording.steps;
    let is_claim = |index: &usize| !steps[*index].searching && (*index == 0 || steps[index - 1].searching);
    let claims: Vec<usize> = (0..steps.len()).filter(is_claim).collect();
    let is_wrong =
        |claim: &&usize| errors.as_ref().is_some_and(|all| all[**claim..].iter().flatten().next() > Some(&WRONG_M));
    let located: Vec<f64> = errors.iter().flatten().flatten().copied().collect();
    Later {
        found: claims.first().map(|claim| until(&later.recording, *claim)),
        wrong: claims.iter().filter(is_wrong).count(),
        rmse_m: lab::evaluate::statistics::rms(&located),
        log_odds: later.recording.searches.iter().map(|search| f64::from(search.log_odds)).max_by(f64::total_cmp),
    }
}

/// What leads from the earlier drive's start frame to its truth's.
fn frame(earlier: &Driven) -> Option<Pose2> {
    let truth = earlier.truth.as_ref()?;
    let pairs = earlier.recording.steps.iter().zip(truth);
    Some(path::align(&pairs.filter_map(|(step, truth)| Some((step.pose_from_start(), (*truth)?))).collect::<Vec<_>>()))
}

/// How far off the position was at every step at which it was claimed and the truth is known, metres.
fn errors(later: &Driven, frame: Pose2) -> Option<Vec<Option<f64>>> {
    let steps = later.recording.steps.iter().zip(later.truth.as_ref()?);
    let error = |(step, truth): (&lab::recording::Step, &Option<Pose2>)| {
        let (truth, pose) = ((*truth)?, frame.compose(&step.pose_from_start()));
        (!step.searching).then(|| f64::hypot(pose.x_m - truth.x_m, pose.y_m - truth.y_m))
    };
    Some(steps.map(error).collect())
}

/// Seconds and metres of path until a step.
fn until(recording: &Recording, step: usize) -> [f64; 2] {
    let path = recording.steps[..=step].iter().map(|step| step.dead_reckoning);
    [recording.steps[step].t_s, path::length_m(path)]
}

fn figures(all: &[Later]) -> String {
    let found: Vec<[f64; 2]> = all.iter().filter_map(|later| later.found).collect();
    let errors: Vec<f64> = all.iter().filter_map(|later| later.rmse_m).collect();
    let middle = |axis: usize, unit: &str| {
        median(&found.iter().map(|found| found[axis]).collect::<Vec<_>>())
            .map_or("–".to_owned(), |value| format!("{value:.0} {unit}"))
    };
    let error = match (median(&errors), max(&errors)) {
        (Some(middle), Some(worst)) => format!("{:.0} cm / {:.0} cm", 100.0 * middle, 100.0 * worst),
        _ if found.is_empty() => "–".to_owned(),
        _ => "no truth".to_owned(),
    };
    let missed = || all.iter().filter(|later| later.found.is_none());
    let odds = missed().filter_map(|later| later.log_odds).max_by(f64::total_cmp);
    let without = missed().filter(|later| later.log_odds.is_none()).count();
    let without = if without > 0 { format!(", no search in {without}") } else { String::new() };
    let odds = odds.map_or("–".to_owned(), |odds| format!("e^{odds:.1}")) + &without;
    let wrong: usize = all.iter().map(|later| later.wrong).sum();
    format!("{} of {} | {wrong} | {} | {} | {error} | {odds}", found.len(), all.len(), middle(0, "s"), middle(1, "m"))
}
