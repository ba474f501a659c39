//! After Beevers and Huang 2006: a Rao-Blackwellised particle filter over multiscans, FastSLAM 1.0 with lines, and as a switch the
//! prior that walls stand at right angles. The likelihood of a new line is ours.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use std::f64::consts::PI;

use crate::fit::{Fit, Splitting, off_quarter, split};
use crate::geometry::{Chain, Line, NOWHERE, Pose, Segment, hull, overlap, perp, unit, wrap};
use crate::random::Random;
use crate::window::{Extent, Window};
use crate::{Input, Output, Relative};

/// A multiscan: 50 rows, one every 2 cm.
const WINDOW: Extent = Extent { path: 1.1, turn: 1.3, points: 4000, step: 0.02 };
const SCAN: (f64, f64) = (1.0, 1.05);
const SPLITTING: Splitting = Splitting { split: 0.05, gap: 0.25, length: 0.4, points: 8, rms: 0.05 };
/// 99 % of a chi-square distribution with two degrees of freedom.
const GATE: f64 = 9.21;
const APART: f64 = 0.3;
/// A line nearer to a right angle than this is on it, to this sigma, radians.
const SNAP: f64 = PI / 10.0;
const SNAPPED: f64 = PI / 360.0;
/// Density of a line that was not known, per metre and radian: within 3 m and in any direction.
const NEW: f64 = 0.05;

#[derive(Clone)]
struct Wall {
    line: Line,
    covariance: Matrix2<f64>,
    extent: [f64; 2],
}

#[derive(Clone, Default)]
struct Particle {
    pose: Pose,
    walls: Vec<Wall>,
    log_weight: f64,
}

/// The particles.
pub struct Particles {
    particles: Vec<Particle>,
    is_square: bool,
    random: Random,
    window: Window,
    /// Motion since the last multiscan.
    since: Chain,
    scanned: (f64, f64),
    /// Mean and covariance of the particles' poses after the last multiscan.
    mean: Chain,
}

impl Particle {
    fn take(&mut self, fit: &Fit, is_square: bool) {
        let seen = fit.line.moved(&self.pose);
        let ends = fit.ends().map(|end| self.pose.transform(end));
        // The line in the map, given this particle's pose: d(rho, a) by (r, b).
        let by = Matrix2::new(1.0, self.pose.at.dot(&perp(unit(seen.a))), 0.0, 1.0);
        let noise = by * fit.covariance * by.transpose();
        let mut best: Option<(f64, usize, Vector2<f64>, Matrix2<f64>)> = None;
        for (i, wall) in self.walls.iter().enumerate() {
            let off = Vector2::new(seen.rho - wall.line.rho, wrap(seen.a - wall.line.a));
            let Some(inverse) = (wall.covariance + noise).try_inverse() else { continue };
            let distance = (off.transpose() * inverse * off)[(0, 0)];
            let shares = off.y.abs() < 0.5 && overlap(wall.line.stretch(ends), wall.extent) > -APART;
            if shares && distance < GATE && best.as_ref().is_none_or(|best| distance < best.0) {
                best = Some((distance, i, off, inverse));
            }
        }
        let wall = match best {
            Some((distance, i, off, inverse)) => {
                self.log_weight += 0.5 * inverse.determinant().ln() - 0.5 * distance - (2.0 * PI).ln();
                let wall = &mut self.walls[i];
                let gain = wall.covariance * inverse;
                let step = gain * off;
                wall.line = Line { rho: wall.line.rho + step.x, a: wrap(wall.line.a + step.y) };
                wall.covariance -= gain * wall.covariance;
                wall
            }
            None => {
                self.log_weight += NEW.ln();
                let (line, covariance) = self.born(seen, noise, is_square, ends);
                self.walls.push(Wall { line, covariance, extent: NOWHERE });
                let last = self.walls.len() - 1;
                &mut self.walls[last]
            }
        };
        wall.extent = hull(wall.extent, wall.line.stretch(ends));
    }

    /// A new line, on the first one's right angles where it is near and that is asked for: turned about its middle.
    fn born(
        &self,
        seen: Line,
        noise: Matrix2<f64>,
        is_square: bool,
        ends: [crate::geometry::Point; 2],
    ) -> (Line, Matrix2<f64>) {
        let off = self.walls.first().map(|first| off_quarter(seen.a, first.line.a));
        match off.filter(|off| is_square && off.abs() < SNAP) {
            Some(off) => {
                let a = wrap(seen.a - off);
                let middle = 0.5 * (ends[0] + ends[1]);
                let rho = middle.dot(&unit(a));
                let arm = seen.along(middle);
                let across = noise[(0, 0)] - 2.0 * arm * noise[(0, 1)] + arm * arm * noise[(1, 1)];
                let angle = SNAPPED * SNAPPED;
                let covariance = Matrix2::new(across.abs() + arm * arm * angle, arm * angle, arm * angle, angle);
                (Line { rho, a }, covariance)
            }
            None => (seen, noise),
        }
    }
}

impl Particles {
    /// So many particles at the start pose.
    pub fn new(count: usize, is_square: bool, seed: u64) -> Self {
        Self {
            particles: vec![Particle::default(); count],
            is_square,
            random: Random::new(seed),
            window: Window::new(WINDOW),
            since: Chain::default(),
            scanned: (0.0, 0.0),
            mean: Chain::default(),
        }
    }

    fn scan(&mut self) {
        let fits = split(&self.window, &SPLITTING);
        self.window.points.clear();
        self.scanned = (self.window.path, self.window.turned);
        let Chain { pose: since, covariance } = std::mem::take(&mut self.since);
        let noise = covariance + Matrix3::identity() * 1e-12;
        let factor = noise.cholesky().map_or_else(Matrix3::zeros, |cholesky| cholesky.l());
        for particle in &mut self.particles {
            let off = factor * Vector3::from_fn(|_, _| self.random.gaussian());
            let moved = Pose::new(since.at.x + off.x, since.at.y + off.y, since.theta + off.z);
            particle.pose = particle.pose.compose(&moved);
            for fit in &fits {
                particle.take(fit, self.is_square);
            }
        }
        self.mean = self.mean_of_all();
        self.resample();
    }

    fn weights(&self) -> Vec<f64> {
        let most = self.particles.iter().map(|p| p.log_weight).fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = self.particles.iter().map(|p| (p.log_weight - most).exp()).collect();
        let sum: f64 = weights.iter().sum();
        weights.into_iter().map(|w| w / sum).collect()
    }

    /// Systematic resampling where fewer than half of the particles count.
    fn resample(&mut self) {
        let weights = self.weights();
        let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let n = self.particles.len();
        if effective >= 0.5 * n as f64 {
            return;
        }
        let offset = self.random.unit();
        let (mut place, mut sum) = (0, weights[0]);
        let mut next = Vec::with_capacity(n);
        for i in 0..n {
            while sum < (i as f64 + offset) / n as f64 && place + 1 < n {
                place += 1;
                sum += weights[place];
            }
            next.push(Particle { log_weight: 0.0, ..self.particles[place].clone() });
        }
        self.particles = next;
    }

    /// Mean and covariance of the particles' poses.
    fn mean_of_all(&self) -> Chain {
        let weights = self.weights();
        let all = || self.particles.iter().zip(&weights);
        let at = all().fold(Vector2::zeros(), |sum, (p, w)| sum + p.pose.at * *w);
        let direction = all().fold(Vector2::zeros(), |sum, (p, w)| sum + unit(p.pose.theta) * *w);
        let mean = Pose { at, theta: direction.y.atan2(direction.x) };
        let covariance = all().fold(Matrix3::zeros(), |sum, (p, w)| {
            let off = p.pose.at - at;
            let d = Vector3::new(off.x, off.y, wrap(p.pose.theta - mean.theta));
            sum + d * d.transpose() * *w
        });
        Chain { pose: mean, covariance }
    }
}

impl Relative for Particles {
    fn step(&mut self, input: &Input<'_>) -> Output {
        self.since = self.since.then(&input.motion, &input.motion_cov);
        self.window.step(input);
        let (path, turned) = self.scanned;
        if self.window.path - path >= SCAN.0 || self.window.turned - turned >= SCAN.1 {
            self.scan();
        }
        let Chain { pose, covariance } = self.mean.then(&self.since.pose, &self.since.covariance);
        Output { pose, covariance: Some(covariance) }
    }

    fn walls(&self) -> Vec<Segment> {
        let best = self.particles.iter().max_by(|a, b| a.log_weight.total_cmp(&b.log_weight));
        best.map_or(Vec::new(), |best| best.walls.iter().map(|wall| wall.line.piece(wall.extent)).collect())
    }

    fn bytes(&self) -> usize {
        let walls: usize = self.particles.iter().map(|particle| particle.walls.len()).sum();
        self.particles.len() * size_of::<Particle>() + walls * size_of::<Wall>() + self.window.bytes()
    }
}
