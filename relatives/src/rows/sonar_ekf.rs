//! Sonar SLAM by triangulation: edges as points (after Zunino and Christensen 2001), and with walls as lines beside them (after
//! Choi, Ahn and Chung 2005). Association and the numbers are ours.

use nalgebra::Matrix2;

use crate::ekf::{Ekf, Observation};
use crate::features::{add_line, add_point, line, line_at, point};
use crate::geometry::{Line, NOWHERE, Point, Segment, hull, overlap, wrap};
use crate::tbf::{Fusion, Target};
use crate::{Input, Output, Relative};

/// 95 % of a chi-square distribution with two degrees of freedom.
const GATE: f64 = 5.99;
/// A new feature is believed when it is seen again after this way, within this distance and way, metres.
const AGAIN: f64 = 0.1;
const NEAR: f64 = 0.12;
const MEMORY: f64 = 3.0;
/// Way between two updates with one feature, metres: pairs that share readings err together.
const EVERY: f64 = 0.1;
/// Stretches of one wall may be so far apart, metres.
const APART: f64 = 0.6;
/// Features of one kind are farther apart than this, metres; walls that differ more in direction are two, radians.
const CROWD: f64 = 0.3;
const ALIKE: f64 = 0.5;

/// A feature: its place in the filter, the way when it was last used, and what was seen of it if it is a wall.
struct Feature {
    at: usize,
    used: f64,
    wall: Option<[f64; 2]>,
}

/// What was seen once: in the map frame, with the way.
struct Waiting {
    at: Point,
    a: Option<f64>,
    path: f64,
}

/// The filter.
pub struct SonarEkf {
    with_walls: bool,
    ekf: Ekf,
    fusion: Fusion,
    features: Vec<Feature>,
    waiting: Vec<Waiting>,
    path: f64,
}

impl SonarEkf {
    /// At the start pose; with walls beside edges or without.
    pub fn new(with_walls: bool) -> Self {
        let (ekf, fusion) = (Ekf::default(), Fusion::default());
        Self { with_walls, ekf, fusion, features: Vec::new(), waiting: Vec::new(), path: 0.0 }
    }

    /// Whether something like it was seen before, some way ago; what is new waits.
    fn is_again(&mut self, at: Point, a: Option<f64>) -> bool {
        let path = self.path;
        self.waiting.retain(|old| path - old.path < MEMORY);
        let is_same = |old: &Waiting| match (old.a, a) {
            (Some(one), Some(other)) => {
                let off = Line { rho: old.at.dot(&crate::geometry::unit(one)), a: one }.beyond(at);
                wrap(one - other).abs() < 0.15 && off.abs() < NEAR && (old.at - at).norm() < 1.0
            }
            (None, None) => (old.at - at).norm() < NEAR,
            _ => false,
        };
        match self.waiting.iter().position(is_same) {
            Some(i) if path - self.waiting[i].path >= AGAIN => {
                self.waiting.swap_remove(i);
                true
            }
            Some(_) => false,
            None => {
                self.waiting.push(Waiting { at, a, path });
                false
            }
        }
    }

    /// Whether a feature of that kind is so near that another one beside it would only be taken for it.
    fn is_crowded(&self, at: Point, a: Option<f64>) -> bool {
        self.features.iter().any(|feature| match (a, feature.wall) {
            (Some(a), Some(extent)) => {
                let line = self.line(feature.at);
                let along = line.along(at);
                let off = line.beyond(at).abs();
                wrap(line.a - a).abs() < ALIKE && off < CROWD && overlap([along, along], extent) > -APART
            }
            (None, None) => (self.ekf.states::<2>(feature.at) - at).norm() < CROWD,
            _ => false,
        })
    }

    /// The feature that fits best within the gate.
    fn nearest(&self, observe: impl Fn(&Feature) -> Option<Observation<2>>) -> Option<(usize, Observation<2>)> {
        let candidates = self.features.iter().enumerate().filter_map(|(i, feature)| {
            let observation = observe(feature)?;
            let distance = self.ekf.distance(&observation);
            (distance < GATE).then_some((distance, i, observation))
        });
        candidates.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i, observation)| (i, observation))
    }

    fn take_edge(&mut self, seen: Point, noise: Matrix2<f64>) {
        let observe = |f: &Feature| f.wall.is_none().then(|| point(&self.ekf, f.at, seen, noise));
        if let Some((i, observation)) = self.nearest(observe) {
            self.update(i, &observation);
        } else if !self.is_crowded(self.ekf.pose().transform(seen), None)
            && self.is_again(self.ekf.pose().transform(seen), None)
        {
            let at = add_point(&mut self.ekf, seen, noise);
            self.features.push(Feature { at, used: self.path, wall: None });
        }
    }

    fn take_wall(&mut self, seen: &Line, noise: Matrix2<f64>, touched: [Point; 2]) {
        let pose = self.ekf.pose();
        let touched = touched.map(|at| pose.transform(at));
        let observe = |f: &Feature| {
            let extent = f.wall?;
            let (observation, is_front) = line(&self.ekf, f.at, seen, noise);
            let along = self.line(f.at).stretch(touched);
            let near = observation.innovation.y.abs() < 0.5 && overlap(along, extent) > -APART;
            (is_front && near).then_some(observation)
        };
        let i = if let Some((i, observation)) = self.nearest(observe) {
            self.update(i, &observation);
            i
        } else if !self.is_crowded(touched[0], Some(seen.moved(&pose).a))
            && self.is_again(touched[0], Some(seen.moved(&pose).a))
        {
            let at = add_line(&mut self.ekf, seen, noise);
            self.features.push(Feature { at, used: self.path, wall: Some(NOWHERE) });
            self.features.len() - 1
        } else {
            return;
        };
        let known = self.line(self.features[i].at);
        if let Some(extent) = &mut self.features[i].wall {
            *extent = hull(*extent, known.stretch(touched));
        }
    }

    fn update(&mut self, i: usize, observation: &Observation<2>) {
        if self.path - self.features[i].used >= EVERY {
            self.ekf.update(observation);
            self.features[i].used = self.path;
        }
    }

    fn line(&self, at: usize) -> Line {
        line_at(&self.ekf, at)
    }
}

impl Relative for SonarEkf {
    fn step(&mut self, input: &Input<'_>) -> Output {
        self.ekf.predict(&input.motion, &input.motion_cov);
        self.path += input.motion.at.norm();
        for target in self.fusion.step(input) {
            match target {
                Target::Edge(at, noise) => self.take_edge(at, noise),
                Target::Wall(seen, noise, touched) if self.with_walls => self.take_wall(&seen, noise, touched),
                Target::Wall(..) => {}
            }
        }
        Output { pose: self.ekf.pose(), covariance: Some(self.ekf.pose_covariance()) }
    }

    fn walls(&self) -> Vec<Segment> {
        self.features.iter().filter_map(|f| Some(self.line(f.at).piece(f.wall?))).collect()
    }

    fn bytes(&self) -> usize {
        self.ekf.bytes() + self.fusion.bytes() + self.features.len() * size_of::<Feature>()
    }
}
