//! Triangulation of sonar echoes alone (after Wijk, Jensfelt and Christensen 1998): which of the edges that it reports are there, and which
//! of those that the robot passed it reports.

use std::path::Path;

use hal_sim::MAX_SENSORS;
use hal_sim::scanner::ScannerKind;
use lab::evaluate::statistics::median;
use monte_carlo::file::Experiment;
use monte_carlo::senses::{Scanned, beams_of};
use monte_carlo::unit::Unit;
use relatives::Input;
use relatives::front::Front;
use relatives::geometry::{Point, Pose, Segment};
use relatives::known::Known;
use relatives::tbf::{Fusion, Target};

use crate::rows::{self, Row};
use crate::words;

/// The file of what was found.
pub const FILE: &str = "corners.csv";

const HOMES: [&str; 2] = ["flat", "room"];

/// An edge is right within this, metres.
const RIGHT: f64 = 0.1;
/// An edge was passed where nothing stood between it and the robot at this distance or less, metres.
const PASSED: f64 = 2.0;
/// What is nearer than an edge by more than this hides it, metres.
const HIDDEN: f64 = 0.02;

/// Measures what is not in the file yet.
///
/// # Errors
/// The file cannot be written.
pub fn run(file: &Path, experiment: &Experiment, seeds: u64) -> Result<(), String> {
    HOMES
        .into_iter()
        .try_for_each(|home| rows::missing(file, home, seeds, |seed| measure(experiment, home, seed).to_vec()))
}

/// Edges reported, those of them that are right, edges passed, and those of them that were reported.
fn measure(experiment: &Experiment, home: &str, seed: u64) -> [f64; 4] {
    let case = &experiment.cases[0];
    let driven = Unit { plan: home, case, seed }.drive(experiment).unwrap_or_else(|error| panic!("{error}"));
    let scanned = Scanned::of(&driven, ScannerKind::Sonar, seed);
    let wall = |wall: &lab::recording::Segment| Segment { from: wall.from_m.into(), to: wall.to_m.into() };
    let known = Known::new(&driven.walls().iter().map(wall).collect::<Vec<_>>(), 0.0, 0.0, 1);
    let mut edges: Vec<Point> = Vec::new();
    for end in known.walls.iter().flat_map(|wall| [wall.from, wall.to]) {
        if edges.iter().all(|edge| (edge - end).norm() > HIDDEN) {
            edges.push(end);
        }
    }
    let (mut is_passed, mut is_found) = (vec![false; edges.len()], vec![false; edges.len()]);
    let (mut reported, mut right) = (0.0, 0.0);
    let mut front = Front::<MAX_SENSORS>::new(driven.robot.rig.clone());
    let mut fusion = Fusion::default();
    for (frame, scan) in driven.frames.iter().zip(&scanned.scans) {
        let read = front.read(&frame.sample, None);
        let beams = scan.as_ref().map_or(Vec::new(), |ranges| beams_of(scanned.kind, ranges));
        let truth = Pose::new(frame.truth.x_m, frame.truth.y_m, frame.truth.theta_rad);
        for target in fusion.step(&Input { beams: &beams, ..read }) {
            let Target::Edge(at, _) = target else { continue };
            let at = truth.transform(at);
            let near = (0..edges.len()).filter(|i| (edges[*i] - at).norm() <= RIGHT);
            let nearest = near.min_by(|i, j| (edges[*i] - at).norm().total_cmp(&(edges[*j] - at).norm()));
            reported += 1.0;
            if let Some(edge) = nearest {
                right += 1.0;
                is_found[edge] = true;
            }
        }
        for (edge, is_passed) in edges.iter().zip(&mut is_passed).filter(|_| scan.is_some()) {
            let to = edge - truth.at;
            *is_passed |= to.norm() < PASSED && known.cast(truth.at, to.normalize()) > to.norm() - HIDDEN;
        }
    }
    let passed = is_passed.iter().filter(|is_passed| **is_passed).count() as f64;
    let found = is_passed.iter().zip(&is_found).filter(|(passed, found)| **passed && **found).count() as f64;
    [reported, right, passed, found]
}

/// The section of the page.
pub fn section(found: &[Row]) -> String {
    let mut text = words::CORNERS.to_owned();
    for home in HOMES {
        let own: Vec<&Row> = found.iter().filter(|row| row.name == home).collect();
        let of = |figure: usize| median(&own.iter().map(|row| row.figures[figure]).collect::<Vec<_>>());
        let sum = |figure: usize| own.iter().map(|row| row.figures[figure]).sum::<f64>();
        let (Some(reported), Some(passed)) = (of(0), of(2)) else { continue };
        let [precision, recall] = [(1, 0), (3, 2)].map(|(part, whole)| 100.0 * sum(part) / sum(whole).max(1.0));
        text += &format!("| {home} | {} | {reported:.0} | {precision:.0} | {passed:.0} | {recall:.0} |\n", own.len());
    }
    text + "\n"
}
