//! Poses, walls and scales, what was sensed of them, and where they are likeliest: Gauss and Newton with robust weights.
//!
//! State: `[x, y, theta of each keyframe, rho and beta of each wall, alpha, scales of distance and turning, veer]`. Poses
//! come first: each is tied to the next only, so that a Cholesky factor in this order fills in no more than the walls' rows.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use nalgebra_sparse::factorization::CscCholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix};
use slam_core::{BUILT_TOLERANCE, DriveModel, Rig, SLIP_M2_PER_RAD, SLIP_RUNS, WallKind, WallView};

use super::keyframes::{Keyframes, Stretch};
use super::line::Points;
use super::parts::{Line, Parts, off_grid};
use super::seen::{Beam, SIGMAS, Seen};
use super::sightings::{Noise, Sighting, ended_on};
use crate::input::rig_file::MAX_SENSORS;
use crate::recording::{Pose2, Recording, wrap};

/// Walls that are farther than six degrees from the grid are not on it, radians.
const OFF_GRID_RAD: f64 = 0.1;

/// A wall that fewer readings met is noise.
const FEWEST: usize = 10;

/// Residuals of so many sigmas count half (Cauchy).
const HALF_AT: f64 = 2.0;

/// What a round moves that is settled, metres and radians.
const SETTLED: f64 = 1e-4;

/// Variance that keeps what nothing is known of where it is.
const FREE: f64 = 1e6;

/// A measurement's variances for one stretch of path.
#[derive(Clone, Copy, Debug)]
struct StretchNoise {
    position_m2: f64,
    heading_rad2: f64,
}

/// The problem, and its present solution.
pub struct Graph {
    state: DVector<f64>,
    keys: usize,
    first: Pose2,
    /// Identifier of each wall, in order.
    ids: Vec<u16>,
    on_grid: Vec<bool>,
    /// Of each keyframe but the last: the sensed motion to the next, its length in metres, its noise.
    stretches: Vec<(Pose2, f64, StretchNoise)>,
    sightings: Vec<Sighting>,
    /// 1-sigma of the scales of distance and of turning, and of the veer, radians per metre.
    scale_sigmas: [f64; 3],
    information: Option<CscCholesky<f64>>,
}

impl Graph {
    /// Of a record; none where there is nothing to place.
    pub fn new(recording: &Recording, rig: &Rig<MAX_SENSORS>, keyframes: &Keyframes) -> Option<Self> {
        let mut parts = Parts::of(recording);
        let ended = ended_on(recording, rig, &parts);
        let mut counts: BTreeMap<u16, usize> = BTreeMap::new();
        for id in ended.iter().filter_map(|end| end.wall) {
            *counts.entry(id).or_default() += 1;
        }
        let ids: Vec<u16> = counts.into_iter().filter(|(_, count)| *count >= FEWEST).map(|(id, _)| id).collect();
        let keys = keyframes.steps().len();
        let mut sightings = Vec::new();
        let mut drawn = vec![Points::default(); ids.len()];
        let mut drawn_in = vec![0; ids.len()];
        for end in &ended {
            let wall = end.wall.and_then(|id| ids.binary_search(&id).ok());
            sightings.extend(Sighting::of(recording, rig, keyframes, end, wall));
            if let Some(wall) = wall {
                drawn_in[wall] = parts.at(end.step);
                let pose = recording.steps[end.step].pose;
                drawn[wall].add(end.at_m, [end.at_m[0] - pose.x_m, end.at_m[1] - pose.y_m]);
            }
        }
        let lines: Vec<Line> = drawn.iter().zip(drawn_in).map(|(points, part)| Line::of(points, part)).collect();
        parts.turn(&recording.steps, &lines);
        let mut state = DVector::zeros(3 * keys + 2 * ids.len() + 4);
        for (key, step) in keyframes.steps().iter().enumerate() {
            let pose = parts.frame(parts.at(*step)).compose(&recording.steps[*step].pose);
            state.as_mut_slice()[3 * key..3 * key + 3].copy_from_slice(&[pose.x_m, pose.y_m, pose.theta_rad]);
        }
        let mut on_grid = Vec::new();
        for (wall, line) in lines.iter().enumerate() {
            let (rho_m, beta_rad) = parts.place(line);
            state[3 * keys + 2 * wall] = rho_m;
            state[3 * keys + 2 * wall + 1] = beta_rad;
            let alpha = parts.grid(line.part);
            on_grid.push(alpha.is_some_and(|alpha| off_grid(beta_rad, alpha).abs() < OFF_GRID_RAD));
        }
        let calibration = 3 * keys + 2 * ids.len();
        state[calibration] = parts.grid(parts.at(recording.steps.len())).unwrap_or(0.0);
        state[calibration + 1] = 1.0;
        state[calibration + 2] = 1.0;
        let stretches = keyframes.stretches.iter();
        let stretches = stretches.map(|s| (s.motion, s.path_m, stretch_noise(&rig.drive, s)));
        (!ids.is_empty() && keys > 1).then(|| Self {
            state,
            keys,
            first: recording.steps[0].pose,
            ids,
            on_grid,
            stretches: stretches.collect(),
            sightings,
            scale_sigmas: scale_sigmas(&rig.drive),
            information: None,
        })
    }

    /// The keyframes' poses.
    pub fn poses(&self) -> Vec<Pose2> {
        (0..self.keys).map(|key| self.pose(key)).collect()
    }

    fn pose(&self, key: usize) -> Pose2 {
        Pose2::new(self.state[3 * key], self.state[3 * key + 1], self.state[3 * key + 2])
    }

    /// Place in the state of a wall's rho; its beta is the next.
    fn wall_at(&self, wall: usize) -> usize {
        3 * self.keys + 2 * wall
    }

    /// Places in the state of alpha, the scales of distance and turning, and the veer.
    fn calibration_at(&self) -> usize {
        self.wall_at(self.ids.len())
    }

    /// Moves everything to where it is likeliest, or so many rounds towards it, telling `round` of each; none where the
    /// problem has no solution.
    pub fn solve(&mut self, rounds: usize, mut round: impl FnMut()) -> Option<()> {
        for _ in 0..rounds {
            round();
            let mut normal = Normal::new(self.state.len());
            self.add_motion(&mut normal);
            self.add_sightings(&mut normal);
            self.add_grid(&mut normal);
            let (information, step) = normal.solve()?;
            self.information = Some(information);
            let largest = step.amax();
            if !largest.is_finite() {
                return None;
            }
            self.state += step;
            if largest < SETTLED {
                break;
            }
        }
        Some(())
    }

    /// The odometry: the motion is what was sensed times its scale. Where it ends the robot slipped to: a stretch on which
    /// nothing was sensed says nothing of the scale. A turn's noise is the odometry's.
    fn add_motion(&self, normal: &mut Normal) {
        let scales = self.calibration_at() + 1;
        let (distance, turn, veer) = (self.state[scales], self.state[scales + 1], self.state[scales + 2]);
        for (i, value) in [self.first.x_m, self.first.y_m, self.first.theta_rad].into_iter().enumerate() {
            normal.add(self.state[i] - value, 1.0 / 1e-12, &[(i, 1.0)]);
        }
        for (key, (sensed, path_m, noise)) in self.stretches.iter().enumerate() {
            let (a, b) = (3 * key, 3 * key + 3);
            let (s, c) = self.state[a + 2].sin_cos();
            let (dx, dy) = (self.state[b] - self.state[a], self.state[b + 1] - self.state[a + 1]);
            let (forward, left) = (c * dx + s * dy, c * dy - s * dx);
            let weight = 1.0 / noise.position_m2;
            let ahead = [(a, -c), (a + 1, -s), (a + 2, left), (b, c), (b + 1, s), (scales, -sensed.x_m)];
            normal.add(forward - distance * sensed.x_m, weight, &ahead);
            let aside = [(a, s), (a + 1, -c), (a + 2, -forward), (b, -s), (b + 1, c), (scales, -sensed.y_m)];
            normal.add(left - distance * sensed.y_m, weight, &aside);
            let turned = wrap(self.state[b + 2] - self.state[a + 2]);
            let terms = [
                (a + 2, -1.0 / turn),
                (b + 2, 1.0 / turn),
                (scales + 1, -turned / (turn * turn)),
                (scales + 2, -path_m),
            ];
            let residual = wrap(turned / turn - veer * path_m - sensed.theta_rad);
            normal.add(residual, 1.0 / noise.heading_rad2, &terms);
        }
        for (i, (nominal, sigma)) in [1.0, 1.0, 0.0].into_iter().zip(self.scale_sigmas).enumerate() {
            normal.add(self.state[scales + i] - nominal, 1.0 / sigma.max(1e-6).powi(2), &[(scales + i, 1.0)]);
        }
    }

    fn add_sightings(&self, normal: &mut Normal) {
        for sighting in &self.sightings {
            let Some(wall) = sighting.wall else { continue };
            let (residual, terms) = self.residual(sighting, wall);
            let Noise { sigma_m, alike } = sighting.noise;
            let halves = residual / (HALF_AT * sigma_m);
            normal.add(residual, 1.0 / (alike * sigma_m * sigma_m * (1.0 + halves * halves)), &terms);
        }
    }

    /// How far before a wall a reading ended, and the derivatives of that.
    fn residual(&self, sighting: &Sighting, wall: usize) -> (f64, [(usize, f64); 5]) {
        let (k, w) = (3 * sighting.key, self.wall_at(wall));
        let pose = self.pose(sighting.key);
        let [x, y] = pose.transform(sighting.end_m);
        let (ny, nx) = self.state[w + 1].sin_cos();
        let arm = [x - pose.x_m, y - pose.y_m];
        let terms = [(k, -nx), (k + 1, -ny), (k + 2, nx * arm[1] - ny * arm[0]), (w, 1.0), (w + 1, ny * x - nx * y)];
        (self.state[w] - nx * x - ny * y, terms)
    }

    fn add_grid(&self, normal: &mut Normal) {
        let alpha = self.calibration_at();
        normal.add(0.0, 1.0 / FREE, &[(alpha, 1.0)]);
        for (wall, on_grid) in self.on_grid.iter().enumerate() {
            let rho = self.wall_at(wall);
            normal.add(0.0, 1.0 / FREE, &[(rho, 1.0)]);
            normal.add(0.0, 1.0 / FREE, &[(rho + 1, 1.0)]);
            if *on_grid {
                let off = off_grid(self.state[rho + 1], self.state[alpha]);
                normal.add(off, 1.0 / f64::from(BUILT_TOLERANCE).powi(2), &[(rho + 1, 1.0), (alpha, -1.0)]);
            }
        }
    }

    /// Every reading as it lies at present.
    pub fn beams(&self) -> Vec<Beam> {
        let beam = |sighting: &Sighting| {
            let Sighting { key, wall, from_m, end_m, min_cos, noise } = *sighting;
            let [from_m, end_m] = [from_m, end_m].map(|at_m| self.pose(key).transform(at_m));
            Beam { from_m, end_m, sigma_m: noise.sigma_m, min_cos, wall }
        };
        self.sightings.iter().map(beam).collect()
    }

    /// Gives each reading, in the order of [`Self::beams`], to a wall.
    pub fn give(&mut self, walls: &[Option<usize>]) {
        for (sighting, wall) in self.sightings.iter_mut().zip(walls) {
            sighting.wall = *wall;
        }
    }

    /// The walls that readings are on.
    pub fn seen(&self) -> Vec<Seen> {
        let mut places = vec![Vec::new(); self.ids.len()];
        for sighting in &self.sightings {
            let Some(wall) = sighting.wall else { continue };
            let (residual, _) = self.residual(sighting, wall);
            if residual.abs() < SIGMAS * sighting.noise.alike.sqrt() * sighting.noise.sigma_m {
                let [x, y] = self.pose(sighting.key).transform(sighting.end_m);
                let (ny, nx) = self.state[self.wall_at(wall) + 1].sin_cos();
                places[wall].push(nx * y - ny * x);
            }
        }
        let seen = places.iter().enumerate().filter(|(_, along)| along.len() >= FEWEST);
        seen.map(|(wall, along)| {
            let at = self.wall_at(wall);
            let ends = |a: [f64; 2], t: &f64| [a[0].min(*t), a[1].max(*t)];
            let span_m = along.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
            let stretches = along.iter().map(|t| Seen::stretch(*t)).collect();
            let (rho_m, beta_rad) = (self.state[at], wrap(self.state[at + 1]));
            Seen { wall, rho_m, beta_rad, span_m, stretches, count: along.len() }
        })
        .collect()
    }

    /// Variance of how far wall `b` is behind wall `a` where both are `along_m`, m^2; none before it is solved.
    pub fn variance_apart(&self, a: usize, b: usize, along_m: f64) -> Option<f64> {
        let (a, b) = (self.wall_at(a), self.wall_at(b));
        self.variance(&[(a, 1.0), (b, -1.0), (a + 1, -along_m), (b + 1, along_m)])
    }

    fn variance(&self, terms: &[(usize, f64)]) -> Option<f64> {
        let mut row = DMatrix::zeros(self.state.len(), 1);
        for (i, value) in terms {
            row[(*i, 0)] = *value;
        }
        let solved = self.information.as_ref()?.solve(&row);
        Some(terms.iter().map(|(i, value)| value * solved[(*i, 0)]).sum())
    }

    /// The readings of wall `gone` are wall `kept`'s.
    pub fn unite(&mut self, kept: usize, gone: usize) {
        for sighting in self.sightings.iter_mut().filter(|sighting| sighting.wall == Some(gone)) {
            sighting.wall = Some(kept);
        }
    }

    /// The map.
    pub fn walls(&self) -> Option<Vec<WallView>> {
        let view = |seen: &Seen| {
            let variance = self.variance(&[(self.wall_at(seen.wall), 1.0)])?;
            Some(WallView {
                id: self.ids[seen.wall],
                kind: if self.on_grid[seen.wall] { WallKind::Grid } else { WallKind::Free },
                rho_m: seen.rho_m as f32,
                beta_rad: seen.beta_rad as f32,
                lo_m: seen.span_m[0] as f32,
                hi_m: seen.span_m[1] as f32,
                sigma_rho_m: variance.max(0.0).sqrt() as f32,
                updates: seen.count as u32,
            })
        };
        self.seen().iter().map(view).collect()
    }
}

/// Normal equations of weighted residuals.
struct Normal {
    matrix: CooMatrix<f64>,
    right: DVector<f64>,
}

impl Normal {
    fn new(states: usize) -> Self {
        Self { matrix: CooMatrix::new(states, states), right: DVector::zeros(states) }
    }

    /// A residual of this weight with these derivatives.
    fn add(&mut self, residual: f64, weight: f64, terms: &[(usize, f64)]) {
        for (i, a) in terms {
            for (j, b) in terms {
                self.matrix.push(*i, *j, weight * a * b);
            }
            self.right[*i] -= weight * a * residual;
        }
    }

    /// The factor and the step; none where the matrix is not positive definite.
    fn solve(self) -> Option<(CscCholesky<f64>, DVector<f64>)> {
        let factor = CscCholesky::factor(&CscMatrix::from(&self.matrix)).ok()?;
        let step = factor.solve(&self.right);
        let step = DVector::from_column_slice(step.as_slice());
        Some((factor, step))
    }
}

fn stretch_noise(drive: &DriveModel, stretch: &Stretch) -> StretchNoise {
    let Stretch { path_m, turning_rad, lost: [lost_m, lost_rad], .. } = *stretch;
    let (position_m2, heading_rad2) = match *drive {
        DriveModel::Wheels { track_m, noise_m2_per_m, .. } => {
            let wheel_m2 = f64::from(noise_m2_per_m) * (path_m + 0.5 * f64::from(track_m) * turning_rad);
            (0.5 * wheel_m2, 2.0 * wheel_m2 / f64::from(track_m).powi(2))
        }
        DriveModel::Odometry { noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, .. } => (
            f64::from(SLIP_RUNS * noise_m2_per_m) * path_m + f64::from(SLIP_M2_PER_RAD) * turning_rad,
            f64::from(noise_rad2_per_m) * path_m + f64::from(noise_rad2_per_rad) * turning_rad,
        ),
    };
    // A tenth of a millimetre and of a milliradian: what stands still does so.
    StretchNoise {
        position_m2: position_m2 + lost_m * lost_m + 1e-8,
        heading_rad2: heading_rad2 + lost_rad * lost_rad + 1e-8,
    }
}

fn scale_sigmas(drive: &DriveModel) -> [f64; 3] {
    match *drive {
        DriveModel::Wheels { track_m, track_sigma, scale_sigma, .. } => {
            let (each, track) = (f64::from(scale_sigma), f64::from(track_m));
            let both = each * 0.5f64.sqrt();
            [both, both.hypot(f64::from(track_sigma)), 2.0 * both / track]
        }
        DriveModel::Odometry { scale_sigma, veer_sigma, .. } => {
            [f64::from(scale_sigma), f64::from(scale_sigma), f64::from(veer_sigma)]
        }
    }
}
