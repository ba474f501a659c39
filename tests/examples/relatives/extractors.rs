//! Line extractors on the same windows of readings: end points, Hough transforms, the probabilistic one after Stephens 1991, clusters after
//! Ester 1996, and the estimator over the same stretch of the drive.

use std::collections::VecDeque;
use std::path::Path;
use std::time::Instant;

use hal_sim::MAX_SENSORS;
use lab::evaluate::statistics::median;
use monte_carlo::file::Experiment;
use monte_carlo::unit::{Driven, Unit};
use relatives::Input;
use relatives::fit::{Splitting, split};
use relatives::front::Front;
use relatives::geometry::{Line, Pose, Segment, overlap, wrap};
use relatives::hough::Hough;
use relatives::window::{Extent, Window};
use slam_core::{Config, HostSlam, Sample};

use crate::lines::{clusters, probabilistic};
use crate::rows::{self, Row};
use crate::words;

/// The file of what was found.
pub const FILE: &str = "extractors.csv";

/// The cases of the experiment that are driven: how far the odometry drifts, degrees a metre.
const CASES: [(&str, &str); 3] = [("0", "nominal"), ("1", "drift_deg_per_m = 1"), ("3", "drift_deg_per_m = 3")];

/// The extractors.
const NAMES: [&str; 6] = ["end points", "Hough", "Hough by range", "after Stephens", "after Ester", "ours"];

const WINDOW: Extent = Extent { path: 1.5, turn: 2.0, points: 800, step: 0.01 };
const SPLITTING: Splitting = Splitting { split: 0.05, gap: 0.25, length: LENGTH, points: 8, rms: 0.05 };
const HOUGH: Hough = Hough { angles: 360, width: 0.02, reach: 3.0, votes: 8.0, inlier: 0.03, gap: 0.3 };
/// Shortest line, metres.
const LENGTH: f64 = 0.3;
/// Way between two windows, metres.
const EVERY: f64 = 1.0;
/// A wall was seen where so many readings ended so near to it (metres), over such a length (metres).
const SEEN: (usize, f64, f64) = (10, 0.05, 0.4);
/// A line is of a wall within these, metres and radians, where they share so much, metres.
const NEAR: (f64, f64, f64) = (0.08, 5.0 * std::f64::consts::PI / 180.0, 0.1);

/// What one extractor did: walls that were seen, of these found, lines that are of no wall, sums of squares of angle (radians) and
/// offset (metres), windows, and microseconds of the middle one.
type Score = [f64; 7];

/// Measures what is not in the file yet.
///
/// # Errors
/// The file cannot be written.
pub fn run(file: &Path, experiment: &Experiment, seeds: u64) -> Result<(), String> {
    let drive = |case: &str, seed: u64| {
        let case = experiment.cases.iter().find(|other| other.name == case).expect("a case of the file");
        Unit { plan: "flat", case, seed }.drive(experiment).unwrap_or_else(|error| panic!("{error}"))
    };
    for (name, case) in CASES {
        rows::missing(file, name, seeds, |seed| measure(&drive(case, seed)).into_iter().flatten().collect())?;
    }
    Ok(())
}

fn measure(driven: &Driven) -> [Score; NAMES.len()] {
    let mut scores = [[0.0; 7]; NAMES.len()];
    let mut front = Front::<MAX_SENSORS>::new(driven.robot.rig.clone());
    let [mut window, mut truly] = [Window::new(WINDOW), Window::new(WINDOW)];
    let mut samples: VecDeque<(f64, f64, Sample<MAX_SENSORS>)> = VecDeque::new();
    let (mut last, mut done) = (None::<Pose>, 0.0);
    let mut costs = NAMES.map(|_| Vec::new());
    for frame in &driven.frames {
        let input = front.read(&frame.sample, None);
        window.step(&input);
        let truth = Pose::new(frame.truth.x_m, frame.truth.y_m, frame.truth.theta_rad);
        let motion = last.replace(truth).map_or(Pose::default(), |last| last.relative(&truth));
        truly.step(&Input { motion, ..input });
        samples.push_back((window.path, window.turned, frame.sample));
        while samples.front().is_some_and(|s| window.path - s.0 > WINDOW.path || window.turned - s.1 > WINDOW.turn) {
            samples.pop_front();
        }
        if window.path - done < EVERY {
            continue;
        }
        done = window.path;
        let back = |p: [f64; 2]| truth.inverse_transform(p.into());
        let walls: Vec<Segment> =
            driven.walls().iter().map(|w| Segment { from: back(w.from_m), to: back(w.to_m) }).collect();
        for (i, score) in scores.iter_mut().enumerate() {
            let before = Instant::now();
            let lines = extract(i, &window, driven, &samples);
            let took = 1e6 * before.elapsed().as_secs_f64();
            rate(&lines, &walls, &truly, score);
            score[5] += 1.0;
            costs[i].push(took);
        }
    }
    for (score, costs) in scores.iter_mut().zip(&costs) {
        score[6] = median(costs).unwrap_or(f64::NAN);
    }
    scores
}

/// The lines that an extractor finds, in the robot's frame.
fn extract(
    which: usize,
    window: &Window,
    driven: &Driven,
    samples: &VecDeque<(f64, f64, Sample<MAX_SENSORS>)>,
) -> Vec<Segment> {
    let fits = match which {
        0 => split(window, &SPLITTING),
        1 => HOUGH.lines(window, |_| true, |_| 1.0),
        // As many metres as eight readings in the middle of the sensors' range have.
        2 => Hough { votes: 6.0, ..HOUGH }.lines(window, |_| true, |seen| seen.range),
        3 => probabilistic(window),
        4 => clusters(window),
        _ => return ours(driven, samples),
    };
    let segment = |fit: relatives::fit::Fit| fit.line.piece(fit.extent);
    fits.into_iter().filter(|fit| fit.length() >= LENGTH).map(segment).collect()
}

/// The walls that the estimator has after the same stretch of the drive, begun afresh.
fn ours(driven: &Driven, samples: &VecDeque<(f64, f64, Sample<MAX_SENSORS>)>) -> Vec<Segment> {
    let rig = &driven.robot.rig;
    let Ok(slam) = HostSlam::with_config(rig.clone(), Config::for_rig(rig)) else { return Vec::new() };
    let mut slam = Box::new(slam);
    for (_, _, sample) in samples {
        slam.step(sample);
    }
    let pose = slam.pose();
    let pose = Pose::new(pose.x_m.into(), pose.y_m.into(), pose.theta_rad.into());
    let line = |rho: f32, a: f32| Line { rho: rho.into(), a: a.into() };
    let walls = slam.walls().map(|w| line(w.rho_m, w.beta_rad).piece([w.lo_m.into(), w.hi_m.into()]));
    walls.map(|w| Segment { from: pose.inverse_transform(w.from), to: pose.inverse_transform(w.to) }).collect()
}

/// The line of a segment, with what of it there is.
fn line_of(segment: &Segment) -> (Line, [f64; 2]) {
    let along = segment.to - segment.from;
    let a = along.y.atan2(along.x) - std::f64::consts::FRAC_PI_2;
    let line = Line { rho: segment.from.dot(&relatives::geometry::unit(a)), a: wrap(a) };
    (line, line.stretch([segment.from, segment.to]))
}

/// How far a line is from a wall in angle (radians) and offset (metres); none where it is not of that wall.
fn off(line: &Segment, wall: &Segment) -> Option<[f64; 2]> {
    let ((own, _), (true_line, extent)) = (line_of(line), line_of(wall));
    let turn = wrap(2.0 * (own.a - true_line.a)) / 2.0;
    let offset = true_line.beyond(0.5 * (line.from + line.to));
    let shared = overlap(true_line.stretch([line.from, line.to]), extent);
    (turn.abs() < NEAR.1 && offset.abs() < NEAR.0 && shared > NEAR.2).then_some([turn, offset])
}

fn rate(lines: &[Segment], walls: &[Segment], truly: &Window, score: &mut Score) {
    for wall in walls {
        let (line, extent) = line_of(wall);
        let places =
            truly.points.iter().filter(|seen| line.beyond(seen.at).abs() < SEEN.1).map(|seen| line.along(seen.at));
        let on: Vec<f64> = places.filter(|t| *t > extent[0] && *t < extent[1]).collect();
        let span = on.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], t| [lo.min(*t), hi.max(*t)]);
        if on.len() < SEEN.0 || span[1] - span[0] < SEEN.2 {
            continue;
        }
        score[0] += 1.0;
        let best = lines.iter().filter_map(|line| off(line, wall)).min_by(|a, b| a[1].abs().total_cmp(&b[1].abs()));
        if let Some([turn, offset]) = best {
            score[1] += 1.0;
            score[3] += turn * turn;
            score[4] += offset * offset;
        }
    }
    score[2] += lines.iter().filter(|line| walls.iter().all(|wall| off(line, wall).is_none())).count() as f64;
}

/// The section of the page.
pub fn section(found: &[Row]) -> String {
    let mut text = words::EXTRACTORS.to_owned();
    for (case, _) in CASES {
        let own: Vec<&Row> = found.iter().filter(|row| row.name == case).collect();
        for (i, name) in NAMES.iter().enumerate().filter(|_| !own.is_empty()) {
            let sum = |figure: usize| own.iter().map(|row| row.figures[7 * i + figure]).sum::<f64>();
            let cost: Vec<f64> = own.iter().map(|row| row.figures[7 * i + 6]).collect();
            let matched = sum(1).max(1.0);
            text += &format!(
                "| {case} | {name} | {:.0} | {:.1} | {:.1} | {:.1} | {:.0} |\n",
                100.0 * sum(1) / sum(0).max(1.0),
                100.0 * sum(2) / sum(5).max(1.0),
                (sum(3) / matched).sqrt().to_degrees(),
                100.0 * (sum(4) / matched).sqrt(),
                cost.into_iter().fold(f64::INFINITY, f64::min),
            );
        }
    }
    text + "\n"
}
