//! Line features in an extended Kalman filter, from windows of sparse readings: after Abrate, Bona and Indri, and after Choi, Lee
//! and Oh 2008.
//!
//! Abrate: lines by end-point fits; the numbers are ours. Choi: points kept and pre-treated, a Hough transform constrained around
//! the mean direction of the map, a covariance that the scatter alone makes (blind to the sensor's noise, as Rousse and Qiu say),
//! and right angles as an observation of each line; the numbers are ours.

use nalgebra::{Matrix1, Matrix2, Vector1};
use std::f64::consts::PI;

use crate::ekf::{Ekf, Observation};
use crate::features;
use crate::fit::{Fit, Splitting, mean_quarter, off_quarter, split};
use crate::geometry::{Line, NOWHERE, Segment, hull, overlap, wrap};
use crate::hough::Hough;
use crate::window::{Extent, Window};
use crate::{Input, Output, Relative};

/// How lines are extracted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extraction {
    /// Iterative end-point fit.
    EndPoints,
    /// Hough transform over all directions.
    Hough,
    /// Hough transform around the map's right angles, which are observed, too.
    ConstrainedHough,
}

const WINDOW: Extent = Extent { path: 1.0, turn: 1.05, points: 400, step: 0.01 };
const LONG_WINDOW: Extent = Extent { path: 2.0, turn: 2.0, points: 800, step: 0.01 };
const SPLITTING: Splitting = Splitting { split: 0.05, gap: 0.25, length: 0.3, points: 8, rms: 0.05 };
const HOUGH: Hough = Hough { angles: 360, width: 0.02, reach: 6.0, votes: 8.0, inlier: 0.03, gap: 0.3 };

/// Way between two extractions, metres.
const EVERY: f64 = 0.3;
/// 95 % of a chi-square distribution with two degrees of freedom.
const GATE: f64 = 5.99;
/// Stretches of one wall may be so far apart, metres.
const APART: f64 = 0.3;
/// Two fits agree within this, metres and radians, and while the first is no older than so many metres of way.
const AGREE: (f64, f64, f64) = (0.08, 0.09, 4.0);
/// Directions that may vote, and the sigma of a right angle, radians.
const AROUND: f64 = 10.0 * PI / 180.0;
const SQUARE: f64 = PI / 180.0;
/// Least sigma of a line by its scatter, metres and radians.
const FLOOR: (f64, f64) = (0.01, PI / 180.0);

/// A mapped line: its place in the filter, what of it was seen along its tangent, and how many points.
struct Wall {
    at: usize,
    extent: [f64; 2],
    points: f64,
}

/// A line that was seen once, in the map frame, and when.
struct Waiting {
    line: Line,
    extent: [f64; 2],
    path: f64,
}

/// The filter and its map.
pub struct LineEkf {
    how: Extraction,
    ekf: Ekf,
    window: Window,
    walls: Vec<Wall>,
    waiting: Vec<Waiting>,
    extracted: f64,
}

impl LineEkf {
    /// An empty map at the start pose.
    pub fn new(how: Extraction) -> Self {
        let extent = if how == Extraction::EndPoints { WINDOW } else { LONG_WINDOW };
        let window = Window::new(extent);
        Self { how, ekf: Ekf::default(), window, walls: Vec::new(), waiting: Vec::new(), extracted: 0.0 }
    }

    fn line(&self, wall: &Wall) -> Line {
        features::line_at(&self.ekf, wall.at)
    }

    /// Mean direction of the map's walls modulo a quarter turn.
    fn grid(&self) -> Option<f64> {
        mean_quarter(self.walls.iter().map(|wall| (self.line(wall).a, wall.points)))
    }

    fn extract(&self) -> Vec<Fit> {
        let theta = self.ekf.pose().theta;
        let grid = self.grid().filter(|_| self.how == Extraction::ConstrainedHough && self.walls.len() > 1);
        let allowed = |b: f64| grid.is_none_or(|a| off_quarter(b + theta, a).abs() <= AROUND);
        let mut fits = match self.how {
            Extraction::EndPoints => return split(&self.window, &SPLITTING),
            _ => HOUGH.lines(&self.window, allowed, |_| 1.0),
        };
        fits.retain(|fit| fit.length() >= SPLITTING.length);
        for fit in &mut fits {
            let (n, length) = (fit.points.len() as f64, fit.length());
            let rho = (fit.rms * fit.rms / n).max(FLOOR.0 * FLOOR.0);
            // Points spread evenly over a length have a twelfth of its square as variance along it.
            let a = (12.0 * fit.rms * fit.rms / (n * length * length)).max(FLOOR.1 * FLOOR.1);
            // The line's distance is known at the middle of the points, not at the foot of the robot's normal.
            let arm = 0.5 * (fit.extent[0] + fit.extent[1]);
            fit.covariance = Matrix2::new(rho + arm * arm * a, arm * a, arm * a, a);
        }
        fits
    }

    /// The nearest wall in the gate that lies where the fit does.
    fn nearest(&self, fit: &Fit) -> Option<(usize, Observation<2>)> {
        let seen = fit.line.moved(&self.ekf.pose());
        let candidates = self.walls.iter().enumerate().filter_map(|(i, wall)| {
            let (observation, is_front) = features::line(&self.ekf, wall.at, &fit.line, fit.covariance);
            let near = wrap(seen.a - self.line(wall).a).abs() < 0.5;
            let shared = overlap(self.along(fit, &self.line(wall)), wall.extent) > -APART;
            let distance = if is_front && near && shared { self.ekf.distance(&observation) } else { f64::INFINITY };
            (distance < GATE).then_some((distance, i, observation))
        });
        candidates.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i, observation)| (i, observation))
    }

    /// The fit's stretch along a line of the map.
    fn along(&self, fit: &Fit, line: &Line) -> [f64; 2] {
        let pose = self.ekf.pose();
        line.stretch(fit.ends().map(|end| pose.transform(end)))
    }

    fn take(&mut self, fit: &Fit) {
        let wall = match self.nearest(fit) {
            Some((wall, observation)) => {
                self.ekf.update(&observation);
                wall
            }
            None if self.agrees(fit) => {
                let at = features::add_line(&mut self.ekf, &fit.line, fit.covariance);
                self.walls.push(Wall { at, extent: NOWHERE, points: 0.0 });
                self.walls.len() - 1
            }
            None => return,
        };
        let seen = self.along(fit, &self.line(&self.walls[wall]));
        let wall = &mut self.walls[wall];
        wall.extent = hull(wall.extent, seen);
        wall.points += fit.points.len() as f64;
        let at = wall.at;
        if self.how == Extraction::ConstrainedHough && self.walls.len() > 1 {
            self.square(at);
        }
    }

    /// Whether a line that was seen before agrees with this one; if none does, this one waits for the next.
    fn agrees(&mut self, fit: &Fit) -> bool {
        let line = fit.line.moved(&self.ekf.pose());
        let extent = self.along(fit, &line);
        let middle = line.point(0.5 * (extent[0] + extent[1]));
        let path = self.window.path;
        self.waiting.retain(|old| path - old.path < AGREE.2);
        let is_same = |old: &Waiting| {
            wrap(old.line.a - line.a).abs() < AGREE.1
                && old.line.beyond(middle).abs() < AGREE.0
                && overlap(old.extent, extent) > -APART
        };
        let found = self.waiting.iter().position(is_same);
        match found {
            Some(i) => drop(self.waiting.swap_remove(i)),
            None => self.waiting.push(Waiting { line, extent, path }),
        }
        found.is_some()
    }

    /// Observes that a line stands at a right angle to the map's mean direction.
    fn square(&mut self, at: usize) {
        let Some(grid) = self.grid() else { return };
        let off = off_quarter(self.ekf.states::<2>(at)[1], grid);
        if off.abs() <= AROUND {
            let by = vec![(at + 1, Vector1::new(1.0))];
            let noise = Matrix1::new(SQUARE * SQUARE);
            self.ekf.update(&Observation { innovation: Vector1::new(-off), by, noise });
        }
    }
}

impl Relative for LineEkf {
    fn step(&mut self, input: &Input<'_>) -> Output {
        self.ekf.predict(&input.motion, &input.motion_cov);
        self.window.step(input);
        if self.window.path + self.window.turned / 3.0 - self.extracted >= EVERY {
            self.extracted = self.window.path + self.window.turned / 3.0;
            let fits = self.extract();
            for fit in &fits {
                self.take(fit);
            }
            // What was used is not used again.
            let used: Vec<usize> = fits.into_iter().flat_map(|fit| fit.points).collect();
            self.window.drop(&used);
        }
        Output { pose: self.ekf.pose(), covariance: Some(self.ekf.pose_covariance()) }
    }

    fn walls(&self) -> Vec<Segment> {
        self.walls.iter().map(|wall| self.line(wall).piece(wall.extent)).collect()
    }

    fn bytes(&self) -> usize {
        self.ekf.bytes() + self.window.bytes() + self.walls.len() * size_of::<Wall>()
    }
}
