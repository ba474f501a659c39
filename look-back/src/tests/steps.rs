//! One Gauss-Newton step against a dense one in f64, whose derivatives are differences of each hit's own residual.

use std::vec;
use std::vec::Vec;

use nalgebra::{DMatrix, DVector};
use slam_core::{Pose, Standing};

use super::drive::DRIVE;
use super::random::Random;
use crate::rows::{LAST_POSE, WALLS};
use crate::solve::{FURTHEST_RAD, Slice, Solver};
use crate::wall::Wall;
use crate::{Diary, Hit, border_len, packed_len};

const W: usize = 8;
const B: usize = border_len(W);
type Problem = Diary<32, 256, W>;
type Small = Solver<32, W, B, { packed_len(B) }>;

const SIGMA_M: f64 = 0.02;
const ALIKE: f64 = 2.0;
const HITS: usize = 5;

/// How far the walls are from the origin, metres.
const OFFSET_M: f64 = 2.0;

/// Direction of a wall's normal: two of them are about the grid's, and one is behind the start.
fn direction(wall: usize) -> f64 {
    1.5 * wall as f64 % 3.0 + if wall == 3 { 1.0 } else { 0.0 }
}

/// What the dense step knows: hits by keyframe and wall, in the keyframe's frame.
struct Dense {
    poses: Vec<[f64; 3]>,
    motions: Vec<([f64; 3], f64, f64)>,
    walls: Vec<(f64, f64, f64)>,
    alpha: f64,
    groups: Vec<(usize, usize, Vec<[f64; 2]>)>,
}

/// A diary with everything a little off, and the same for the dense step.
fn problem(seed: u64) -> (Problem, Dense) {
    let mut random = Random(seed);
    let keys = 24;
    let mut poses: Vec<[f64; 3]> = vec![[0.0; 3]];
    let mut diary = Problem::new(&DRIVE, Pose::ORIGIN);
    let mut groups = Vec::new();
    let mut motions = Vec::new();
    for key in 0..keys {
        for wall in 0..W {
            if key > 0 && random.even() < 0.4 {
                continue;
            }
            let beta = direction(wall);
            let middle = 1.5 * random.normal();
            let off = OFFSET_M + 0.03 * random.normal();
            let hits: Vec<[f64; 2]> = (0..HITS)
                .map(|_| {
                    let (along, off) = (middle + 0.3 * random.normal(), off + SIGMA_M * random.normal());
                    let [x, y, theta] = poses[key];
                    let (s, c) = theta.sin_cos();
                    let (dx, dy) =
                        (off * beta.cos() - along * beta.sin() - x, off * beta.sin() + along * beta.cos() - y);
                    [c * dx + s * dy, c * dy - s * dx].map(|m| f64::from(m as f32))
                })
                .collect();
            for hit in &hits {
                let end_m = hit.map(|m| m as f32);
                let (variance_m2, alike) = ((SIGMA_M * SIGMA_M) as f32, ALIKE as f32);
                diary.hit(&Hit { from_m: [0.0; 2], end_m, variance_m2, alike, sensor: 0, wall: Some(wall as u16) });
            }
            groups.push((key, wall, hits));
        }
        if key + 1 == keys {
            break;
        }
        let turn = 0.3 * random.normal();
        let moved = slam_core::Increment { forward_m: 0.3, left_m: 0.02, turn_rad: turn as f32 };
        diary.travel(&moved);
        motions.push(([0.3, 0.02, turn].map(|m| f64::from(m as f32)), 0.3f64.hypot(0.02), turn.abs()));
        let [x, y, theta] = poses[key];
        let next = [
            x + 0.3 * theta.cos() + 0.03 * random.normal(),
            y + 0.3 * theta.sin() + 0.03 * random.normal(),
            theta + turn + 0.02 * random.normal(),
        ];
        diary.begin_keyframe(&Pose::new(next[0] as f32, next[1] as f32, next[2] as f32));
        let placed = diary.keyframes.last().expect("one was begun").pose;
        poses.push([placed.x_m, placed.y_m, placed.theta_rad].map(f64::from));
    }
    diary.alpha_rad = Some(0.02);
    let mut walls = Vec::new();
    for (wall, slot) in diary.walls.iter_mut().enumerate() {
        let (rho_m, beta_rad) = ((OFFSET_M + 0.02 * random.normal()) as f32, direction(wall) as f32 + 0.01);
        let anchor_m = random.normal() as f32;
        let (lo_m, hi_m) = (anchor_m - 1.0, anchor_m + 1.0);
        let seen = Wall { rho_m, beta_rad, lo_m, hi_m, hits: 100, ..Wall::NEW };
        *slot = Some(Wall { anchor_m, on_grid: wall < 2, is_placed: true, ..seen });
        walls.push((f64::from(rho_m), f64::from(beta_rad), f64::from(0.5 * (lo_m + hi_m))));
    }
    (diary, Dense { poses, motions, walls, alpha: 0.02, groups })
}

impl Dense {
    /// Unknowns as in the diary's order, but for the last pose, which is among the poses: poses without the first, then the
    /// border without the last pose.
    fn len(&self) -> usize {
        3 * (self.poses.len() - 1) + 4 + 2 * self.walls.len()
    }

    /// Every residual with its weight where the unknowns are moved by `x`.
    fn residuals(&self, x: &DVector<f64>) -> Vec<(f64, f64)> {
        let keys = self.poses.len();
        let pose = |key: usize| {
            let [px, py, theta] = self.poses[key];
            if key == 0 { [px, py, theta] } else { [0, 1, 2].map(|i| self.poses[key][i] + x[3 * (key - 1) + i]) }
        };
        let border = 3 * (keys - 1);
        let (distance, turn, veer) = (1.0 + x[border], 1.0 + x[border + 1], x[border + 2]);
        let mut all = vec![
            (x[border], 1.0 / 0.03f64.powi(2)),
            (x[border + 1], 1.0 / 0.03f64.powi(2)),
            (veer, 1e10),
            (x[border + 3], 1.0),
        ];
        for (key, (sensed, path, turning)) in self.motions.iter().enumerate() {
            let ([ax, ay, at], [bx, by, bt]) = (pose(key), pose(key + 1));
            let (dx, dy) = (bx - ax, by - ay);
            let local = [at.cos() * dx + at.sin() * dy, at.cos() * dy - at.sin() * dx];
            let slip = f64::from(slam_core::SLIP_RUNS) * 1e-4 * path + f64::from(slam_core::SLIP_M2_PER_RAD) * turning;
            let (position, heading) = (slip + 1e-8, 1e-4 * path + 1e-3 * turning + 1e-8);
            all.push((local[0] - distance * sensed[0], 1.0 / position));
            all.push((local[1] - distance * sensed[1], 1.0 / position));
            all.push(((bt - at) / turn - veer * path - sensed[2], 1.0 / heading));
        }
        for (wall, (_, beta, _)) in self.walls.iter().enumerate() {
            let at = border + 4 + 2 * wall;
            all.push((x[at], 0.01));
            all.push((x[at + 1], 1.0));
            if wall < 2 {
                let off = beta + x[at + 1] - self.alpha - x[border + 3];
                let quarter = std::f64::consts::FRAC_PI_2;
                let tolerance = f64::from(slam_core::BUILT_TOLERANCE);
                all.push((off - (off / quarter).round() * quarter, 1.0 / tolerance.powi(2)));
            }
        }
        let last = self.poses.len() - 1;
        for (key, wall, hits) in self.groups.iter().filter(|(key, ..)| *key < last) {
            let (rho, beta, anchor) = self.walls[*wall];
            let at = border + 4 + 2 * wall;
            let foot = [rho * beta.cos() - anchor * beta.sin(), rho * beta.sin() + anchor * beta.cos()];
            let (s, c) = (beta + x[at + 1]).sin_cos();
            let [px, py, theta] = pose(*key);
            let off = |[hx, hy]: &[f64; 2]| {
                let there = [px + theta.cos() * hx - theta.sin() * hy, py + theta.sin() * hx + theta.cos() * hy];
                c * (foot[0] - there[0]) + s * (foot[1] - there[1]) + x[at]
            };
            all.extend(hits.iter().map(|hit| (off(hit), 1.0 / (ALIKE * SIGMA_M * SIGMA_M))));
        }
        all
    }

    /// The step and the covariance.
    fn solve(&self) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.len();
        let zero = DVector::zeros(n);
        let mut now = self.residuals(&zero);
        let mut jacobian = DMatrix::zeros(now.len(), n);
        for i in 0..n {
            let mut x = zero.clone();
            x[i] = 1e-5;
            let ahead = self.residuals(&x);
            x[i] = -1e-5;
            let behind = self.residuals(&x);
            for row in 0..now.len() {
                jacobian[(row, i)] = (ahead[row].0 - behind[row].0) / 2e-5;
            }
        }
        // The robust weight is a group's.
        let last = self.poses.len() - 1;
        let hits: usize = self.groups.iter().filter(|(key, ..)| *key < last).count() * HITS;
        let before = now.len() - hits;
        for group in now[before..].chunks_mut(HITS) {
            let square = group.iter().map(|(r, _)| (r / SIGMA_M).powi(2)).sum::<f64>() / HITS as f64;
            group.iter_mut().for_each(|(_, weight)| *weight /= 1.0 + square / 4.0);
        }
        let weights = DVector::from_iterator(now.len(), now.iter().map(|(_, weight)| *weight));
        let residual = DVector::from_iterator(now.len(), now.iter().map(|(residual, _)| *residual));
        let weighted = DMatrix::from_fn(now.len(), n, |i, j| weights[i] * jacobian[(i, j)]);
        let information = jacobian.transpose() * &weighted;
        let covariance = information.try_inverse().expect("positive");
        (-&covariance * weighted.transpose() * residual, covariance)
    }
}

#[test]
fn a_step_is_the_dense_step_and_the_border_has_its_covariance() {
    for seed in 0..10 {
        let (mut diary, dense) = problem(seed);
        let before = diary.clone();
        let mut solver = Small::NEW;
        solver.choose(&diary, |_| true);
        solver.begin(&mut diary);
        while solver.slice(&mut diary).1 == Slice::More {}
        let (step, covariance) = dense.solve();
        let keys = dense.poses.len();
        let scale = step.amax();
        let close = |name: &str, found: f32, expected: f64| {
            assert!(
                (f64::from(found) - expected).abs() < 2e-3 * scale,
                "seed {seed}, {name}: {found} {expected} of {scale}"
            );
        };
        for key in 1..keys {
            let (a, b) = (before.keyframes[key].pose, diary.keyframes[key].pose);
            close("x", b.x_m - a.x_m, step[3 * (key - 1)]);
            close("y", b.y_m - a.y_m, step[3 * (key - 1) + 1]);
            close("theta", slam_core::angle::wrap(b.theta_rad - a.theta_rad), step[3 * (key - 1) + 2]);
        }
        let border = 3 * (keys - 1);
        close("distance", diary.calibration.distance - 1.0, step[border]);
        close("turn", diary.calibration.turn - 1.0, step[border + 1]);
        for wall in 0..W {
            let place = solver.place(wall).expect("it is placed");
            close("offset", solver.system.increment(place), step[border + 4 + 2 * wall]);
            close("direction", solver.system.increment(place + 1), step[border + 4 + 2 * wall + 1]);
        }
        // The last pose, and each wall, with one another.
        let mut places: Vec<(usize, usize)> = (0..3).map(|i| (LAST_POSE + i, 3 * (keys - 2) + i)).collect();
        places.extend((0..W).map(|wall| (solver.place(wall).expect("it is placed"), border + 4 + 2 * wall)));
        assert!(places.iter().any(|(place, _)| *place == WALLS));
        (0..solver.system.len()).for_each(|row| assert!(solver.system.invert_row(row)));
        (0..solver.system.len()).for_each(|row| assert!(solver.system.square_row(row)));
        for (place, at) in &places {
            for (other, there) in &places {
                let expected = covariance[(*at, *there)];
                let size = (covariance[(*at, *at)] * covariance[(*there, *there)]).sqrt();
                let found = f64::from(solver.system.covariance(*place, *other));
                assert!((found - expected).abs() < 0.01 * size, "seed {seed}, {place} {other}: {found} {expected}");
            }
        }
        assert_eq!(solver.system.held, 0);
    }
}

/// Derivatives at a pose that is turned far off say nothing of where it belongs: what they ask for is gone towards, not to.
#[test]
fn a_step_turns_no_pose_farther_than_derivatives_hold() {
    let (mut diary, _) = problem(0);
    diary.keyframes[3].pose.theta_rad += 2.0;
    let before = diary.clone();
    let mut solver = Small::NEW;
    solver.choose(&diary, |_| true);
    solver.begin(&mut diary);
    while solver.slice(&mut diary).1 == Slice::More {}
    let pairs = before.keyframes.iter().zip(&diary.keyframes);
    let turned = pairs.map(|(a, b)| slam_core::angle::wrap(b.pose.theta_rad - a.pose.theta_rad).abs());
    let most = turned.fold(0.0, f32::max);
    assert!((most - FURTHEST_RAD).abs() < 1e-3, "{most}");
}

/// A wall that was seen along a hand's breadth is drawn in the direction that the filter has it in, not through the noise of its hits.
#[test]
fn a_short_wall_is_drawn_as_the_filter_has_it() {
    let mut diary = Problem::new(&DRIVE, Pose::ORIGIN);
    diary.grid(0.1);
    for (x_m, y_m) in [(1.99, 0.0), (2.02, 0.03), (1.97, 0.06), (2.03, 0.09)] {
        diary.hit(&Hit {
            from_m: [0.0; 2],
            end_m: [x_m, y_m],
            variance_m2: 1e-4,
            alike: 1.0,
            sensor: 0,
            wall: Some(7),
        });
    }
    let drawn_rad = |diary: &Problem| crate::place::place(diary, 0).expect("it has hits").beta_rad;
    assert!((drawn_rad(&diary) - 0.1).abs() > 0.3, "through the hits: {}", drawn_rad(&diary));
    diary.stand(7, Standing::Near(0));
    assert!((drawn_rad(&diary) - 0.1).abs() < 1e-5, "{}", drawn_rad(&diary));
    // What stands there exactly stands so for good.
    diary.stand(7, Standing::Exact(0));
    diary.stand(7, Standing::Off);
    assert!((drawn_rad(&diary) - 0.1).abs() < 1e-5, "{}", drawn_rad(&diary));
}
