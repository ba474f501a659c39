//! Sparse-gslam (Zhao, Dawson, Xie and others 2022; numbers of its published settings) and, as a switch, the soft right angles
//! of SoMaSLAM.
//!
//! Lines of a short multiscan are landmarks of a graph while the robot passes them; loops are closed by matching the last metres
//! against occupancy grids of earlier stretches, with dynamic covariance scaling. Ours: one graph instead of two, of which the last
//! stretch is placed at each vertex and the whole where a loop was closed; how sure a match is; which right angles are tied.

use nalgebra::{Matrix3, Vector3};

use crate::fit::{Fit, Splitting, off_quarter, split};
use crate::geometry::{Chain, Line, NOWHERE, Point, Pose, Segment, hull, overlap};
use crate::graph::{Graph, Relation, Sighting};
use crate::matcher::{Grid, Pyramid, Range};
use crate::window::{Extent, Window};
use crate::{Beam, Input, Output, Relative};

/// Points are taken every 3 cm or 3 degrees: what 160 points of four beams at ten a second were in the source.
const WINDOW: Extent = Extent { path: 1.5, turn: 2.0, points: 320, step: 0.03 };
const SPLITTING: Splitting = Splitting { split: 0.1, gap: 0.25, length: 0.75, points: 10, rms: 0.1 };
/// 1-sigma of a range, and the longest one that is used, metres.
const SIGMA: f64 = 0.08;
const REACH: f64 = 2.0;
/// A vertex every so much way or turn, metres and radians.
const VERTEX: (f64, f64) = (0.5, std::f64::consts::FRAC_PI_6);
/// A line is a known one within this sum of the distances of its ends, metres, and this gap.
const NEAR: f64 = 0.5;
const APART: f64 = 0.5;
/// Landmarks are taken for seen again within this way, metres.
const MEMORY: f64 = 10.0;
/// Least variances of a way between two vertices, m^2 and rad^2.
const LEAST: (f64, f64) = (1e-6, 1e-6);
/// 99 % quantiles of chi-square distributions with 2, 4, 6 ... degrees of freedom.
const QUANTILES: [f64; 8] = [9.21, 13.28, 16.81, 20.09, 23.21, 26.22, 29.14, 32.0];
/// Poses that are placed at each vertex, and iterations of the solver.
const STRETCH: usize = 40;
const ITERATIONS: usize = 15;
/// Way of one submap, of the cloud that is matched, between matches, and to a submap that it is matched with, metres.
const SUBMAP: f64 = 6.0;
const CLOUD: f64 = 5.0;
const MATCH_EVERY: f64 = 2.0;
const MATCH_WITHIN: f64 = 5.0;
/// Submaps that are too recent to be matched.
const RECENT: usize = 6;
const SEARCH: Range = Range { shift: 2.5, turn: 1.0, score: 0.6 };
/// Most points of a cloud.
const CLOUD_POINTS: usize = 250;
/// 1-sigma of a match: a cell, and a cell over the cloud's length, metres and radians.
const MATCH_SIGMA: (f64, f64) = (0.1, 0.02);
/// Lines nearer to a right angle than this are tied, radians.
const SQUARE_WITHIN: f64 = 0.26;

/// A landmark beside its line in the graph.
struct Landmark {
    /// What of it was seen, along its tangent in the map.
    extent: [f64; 2],
    /// Way at which it was last seen, metres.
    seen: f64,
}

/// A finished submap: its grid in the frame of the vertex that it begins at.
struct Submap {
    vertex: usize,
    last: usize,
    pyramid: Pyramid,
    bytes: usize,
}

/// The graph and what feeds it.
pub struct SparseGslam {
    is_square: bool,
    graph: Graph,
    landmarks: Vec<Landmark>,
    window: Window,
    /// Motion since the last vertex.
    since: Chain,
    since_turn: f64,
    /// Covariances of the vertices when they were the last.
    covariances: Vec<Matrix3<f64>>,
    /// Way at each vertex, metres.
    ways: Vec<f64>,
    /// Beams since the last vertex in its frame, and those of each vertex before.
    beams: Vec<Segment>,
    drawn: Vec<Vec<Segment>>,
    submaps: Vec<Submap>,
    submap_from: usize,
    matched: f64,
    /// Vertex and place in its frame, one a step.
    steps: Vec<(usize, Pose)>,
}

impl SparseGslam {
    /// At the start pose; with soft right angles or without.
    pub fn new(is_square: bool) -> Self {
        Self {
            is_square,
            graph: Graph { poses: vec![Pose::default()], ..Graph::default() },
            landmarks: Vec::new(),
            window: Window::new(WINDOW),
            since: Chain::default(),
            since_turn: 0.0,
            covariances: vec![Matrix3::zeros()],
            ways: vec![0.0],
            beams: Vec::new(),
            drawn: Vec::new(),
            submaps: Vec::new(),
            submap_from: 0,
            matched: 0.0,
            steps: Vec::new(),
        }
    }

    fn last(&self) -> usize {
        self.graph.poses.len() - 1
    }

    fn add_vertex(&mut self) {
        let from = self.last();
        let Chain { pose: between, mut covariance } = std::mem::take(&mut self.since);
        covariance += Matrix3::from_diagonal(&Vector3::new(LEAST.0, LEAST.0, LEAST.1));
        let information = covariance.try_inverse().unwrap_or_else(Matrix3::identity);
        self.graph.poses.push(self.graph.poses[from].compose(&between));
        self.graph.odometry.push(Relation { from, to: from + 1, between, information });
        self.ways.push(self.window.path);
        self.drawn.push(std::mem::take(&mut self.beams));
        self.since_turn = 0.0;
        let seen = self.see_lines();
        self.place(seen);
        self.finish_submap();
        self.close_loop();
    }

    /// Sees the multiscan's lines from the last vertex; how many.
    fn see_lines(&mut self) -> usize {
        let fits = split(&self.window, &SPLITTING);
        let vertex = self.last();
        for fit in &fits {
            let Some(information) = fit.covariance.try_inverse() else { continue };
            let line = self.associate(fit);
            self.graph.sightings.push(Sighting { pose: vertex, line, seen: fit.line, information });
        }
        self.graph.sightings.iter().rev().take_while(|s| s.pose == vertex).count()
    }

    fn associate(&mut self, fit: &Fit) -> usize {
        let pose = self.graph.poses[self.last()];
        let ends = fit.ends().map(|end| pose.transform(end));
        let way = self.window.path;
        let facing = fit.line.moved(&pose);
        let candidates = self.landmarks.iter().zip(&self.graph.lines).enumerate().filter_map(|(i, (known, line))| {
            let off: f64 = ends.iter().map(|end| line.beyond(*end).abs()).sum();
            let along = line.stretch(ends);
            let same_side = crate::geometry::wrap(line.a - facing.a).abs() < 1.0;
            let near = off < NEAR && overlap(along, known.extent) > -APART;
            (near && same_side && way - known.seen < MEMORY).then_some((off, i))
        });
        let line = match candidates.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((_, line)) => line,
            None => self.add_landmark(facing),
        };
        let known = &mut self.landmarks[line];
        known.extent = hull(known.extent, self.graph.lines[line].stretch(ends));
        known.seen = way;
        line
    }

    fn add_landmark(&mut self, line: Line) -> usize {
        let new = self.landmarks.len();
        if self.is_square {
            let way = self.window.path;
            let fresh = (0..new).filter(|i| way - self.landmarks[*i].seen < MEMORY);
            let square = fresh.filter(|i| off_quarter(line.a, self.graph.lines[*i].a).abs() < SQUARE_WITHIN);
            self.graph.squares.extend(square.map(|i| [i, new]));
        }
        self.graph.lines.push(line);
        self.landmarks.push(Landmark { extent: NOWHERE, seen: 0.0 });
        new
    }

    /// Places the last stretch anew; sightings of the last vertex that do not fit are taken out, and it is placed without them.
    fn place(&mut self, seen: usize) {
        let held = self.last().saturating_sub(STRETCH);
        let mut own = self.graph.solve(held, ITERATIONS, true);
        let first = self.graph.sightings.len() - seen;
        let chi2: f64 = self.graph.sightings[first..].iter().map(|s| self.graph.chi2_of(s)).sum();
        if seen > 0 && chi2 > QUANTILES[(seen - 1).min(QUANTILES.len() - 1)] {
            self.graph.sightings.truncate(first);
            own = self.graph.solve(held, ITERATIONS, true);
        }
        let between = self.graph.poses[held].relative(&self.graph.poses[self.last()]);
        let (by_held, _) = self.graph.poses[held].compose_jacobians(&between);
        let own = own.unwrap_or_else(|| self.covariances[held]);
        self.covariances.push(by_held * self.covariances[held] * by_held.transpose() + own);
    }

    fn finish_submap(&mut self) {
        let last = self.last();
        if self.ways[last] - self.ways[self.submap_from] < SUBMAP {
            return;
        }
        let (from, mut grid) = (self.submap_from, Grid::default());
        for beam in self.gathered(from, last) {
            grid.draw(&beam);
        }
        self.submaps.push(Submap { vertex: from, last, bytes: grid.bytes(), pyramid: grid.pyramid() });
        self.submap_from = last;
    }

    /// The beams between two vertices, in the frame of the first.
    fn gathered(&self, from: usize, to: usize) -> Vec<Segment> {
        let origin = self.graph.poses[from];
        let of = |vertex: usize| {
            let pose = origin.relative(&self.graph.poses[vertex]);
            self.drawn[vertex].iter().map(move |beam| beam.moved(&pose))
        };
        (from..to).flat_map(of).collect()
    }

    fn close_loop(&mut self) {
        let last = self.last();
        let way = self.ways[last];
        if way - self.matched < MATCH_EVERY {
            return;
        }
        self.matched = way;
        let first = self.ways.iter().position(|other| way - other <= CLOUD).unwrap_or(last);
        let beams = self.gathered(first, last);
        let origin = self.graph.poses[first].relative(&self.graph.poses[last]);
        let every = beams.len().div_ceil(CLOUD_POINTS).max(1);
        let cloud: Vec<Point> = beams.iter().step_by(every).map(|beam| origin.inverse_transform(beam.to)).collect();
        if cloud.len() < CLOUD_POINTS / 5 {
            return;
        }
        let pose = self.graph.poses[last];
        let old = self.submaps.len().saturating_sub(RECENT);
        let near = |submap: &&Submap| {
            (submap.vertex..=submap.last).any(|v| (self.graph.poses[v].at - pose.at).norm() < MATCH_WITHIN)
        };
        let best = self.submaps[..old].iter().filter(near).filter_map(|submap| {
            let guess = self.graph.poses[submap.vertex].relative(&pose);
            submap.pyramid.find(&cloud, &guess, &SEARCH).map(|found| (found, submap.vertex))
        });
        let Some((found, from)) = best.max_by(|a, b| a.0.score.total_cmp(&b.0.score)) else { return };
        let variances = [MATCH_SIGMA.0, MATCH_SIGMA.0, MATCH_SIGMA.1].map(|sigma: f64| 1.0 / (sigma * sigma));
        let information = Matrix3::from_diagonal(&Vector3::from(variances));
        self.graph.loops.push(Relation { from, to: last, between: found.pose, information });
        self.graph.solve(0, ITERATIONS, false);
    }
}

impl Relative for SparseGslam {
    fn step(&mut self, input: &Input<'_>) -> Output {
        let near = |beam: &Option<Beam>| beam.filter(|beam| beam.range <= REACH).map(|b| Beam { sigma: SIGMA, ..b });
        let beams: Vec<Option<Beam>> = input.beams.iter().map(near).collect();
        let (path, turned) = (self.window.path, self.window.turned);
        self.window.step(&Input { beams: &beams, ..*input });
        self.since = self.since.then(&input.motion, &input.motion_cov);
        self.since_turn += self.window.turned - turned;
        // As many beams are drawn as there are points.
        let is_new = ((self.window.path / WINDOW.step) as u64) != ((path / WINDOW.step) as u64);
        if is_new {
            let drawn = beams.iter().flatten().map(|b| Segment { from: b.origin, to: b.end() }.moved(&self.since.pose));
            self.beams.extend(drawn);
        }
        let way = self.window.path - self.ways[self.last()];
        if way >= VERTEX.0 || self.since_turn >= VERTEX.1 {
            self.add_vertex();
        }
        let vertex = self.last();
        self.steps.push((vertex, self.since.pose));
        let last = Chain { pose: self.graph.poses[vertex], covariance: self.covariances[vertex] };
        let Chain { pose, covariance } = last.then(&self.since.pose, &self.since.covariance);
        Output { pose, covariance: Some(covariance) }
    }

    fn walls(&self) -> Vec<Segment> {
        self.landmarks.iter().zip(&self.graph.lines).map(|(known, line)| line.piece(known.extent)).collect()
    }

    fn path(&self) -> Option<Vec<Pose>> {
        Some(self.steps.iter().map(|(vertex, since)| self.graph.poses[*vertex].compose(since)).collect())
    }

    fn bytes(&self) -> usize {
        let drawn: usize = self.drawn.iter().map(Vec::len).sum();
        let submaps: usize = self.submaps.iter().map(|submap| submap.bytes).sum();
        self.graph.bytes() + self.window.bytes() + drawn * size_of::<Segment>() + submaps
    }
}
