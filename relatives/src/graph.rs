//! A graph of poses and lines, and where they are likeliest: Levenberg-Marquardt over sparse normal equations.
//!
//! Odometry between neighbours, lines seen from poses, right angles between lines, and loop closures between poses, whose weight
//! falls where they do not fit (dynamic covariance scaling; Agarwal et al. 2013).

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Vector2, Vector3};
use nalgebra_sparse::factorization::CscCholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix};
use std::f64::consts::PI;

use crate::fit::off_quarter;
use crate::geometry::{Line, Pose, perp, unit, wrap};

/// A line as it was seen from a pose.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// Index of the pose.
    pub pose: usize,
    /// Index of the line.
    pub line: usize,
    /// What was seen, in the robot's frame, its distance not negative.
    pub seen: Line,
    /// Inverse covariance of (rho, a).
    pub information: Matrix2<f64>,
}

/// Where one pose lies in another one's frame.
#[derive(Clone, Copy, Debug)]
pub struct Relation {
    /// Index of the pose in whose frame the other is given.
    pub from: usize,
    /// Index of the other.
    pub to: usize,
    /// Where it is.
    pub between: Pose,
    /// Inverse covariance.
    pub information: Matrix3<f64>,
}

/// The graph.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// The poses, in order.
    pub poses: Vec<Pose>,
    /// The lines.
    pub lines: Vec<Line>,
    /// Odometry: relation i is from pose i to pose i + 1.
    pub odometry: Vec<Relation>,
    /// Lines seen, in the poses' order.
    pub sightings: Vec<Sighting>,
    /// Pairs of lines that should be parallel or at right angles.
    pub squares: Vec<[usize; 2]>,
    /// Loop closures.
    pub loops: Vec<Relation>,
}

/// Least-chi-square at which a loop closure's weight begins to fall.
const PHI: f64 = 10.0;
/// Sigma of a right angle, radians.
const SQUARE: f64 = PI / 180.0;
/// Iterations end where the sum falls by less than this share.
const SETTLED: f64 = 1e-4;

/// Where a variable stands among the unknowns; none where it is held.
struct Layout {
    poses: Vec<Option<usize>>,
    lines: Vec<Option<usize>>,
    len: usize,
}

/// Error of a factor with its derivatives by up to two variables, and its weight.
struct Linear {
    error: DVector<f64>,
    by: Vec<(usize, DMatrix<f64>)>,
    weight: DMatrix<f64>,
}

impl Graph {
    /// How a relation fails, by the poses as they are, and the derivatives by both.
    fn relation(&self, r: &Relation) -> (Vector3<f64>, Matrix3<f64>, Matrix3<f64>) {
        let (from, to) = (self.poses[r.from], self.poses[r.to]);
        let expected = from.relative(&to);
        let off = expected.at - r.between.at;
        let (by_from, by_to) = from.relative_jacobians(&to);
        (Vector3::new(off.x, off.y, wrap(expected.theta - r.between.theta)), by_from, by_to)
    }

    /// How a sighting fails, and the derivatives by the pose and the line.
    fn sighting(&self, s: &Sighting) -> (Vector2<f64>, nalgebra::Matrix2x3<f64>, Matrix2<f64>) {
        let (pose, line) = (self.poses[s.pose], self.lines[s.line]);
        let n = unit(line.a);
        let distance = line.rho - pose.at.dot(&n);
        let slope = -pose.at.dot(&perp(n));
        // The side is that of what was seen: a line that is crossed while it is placed does not turn round.
        let turned = wrap(s.seen.a - line.a + pose.theta);
        let (side, half) = if turned.abs() > 0.5 * PI { (-1.0, PI) } else { (1.0, 0.0) };
        let error = Vector2::new(side * distance - s.seen.rho, wrap(line.a - pose.theta + half - s.seen.a));
        let by_pose = nalgebra::Matrix2x3::new(-side * n.x, -side * n.y, 0.0, 0.0, 0.0, -1.0);
        (error, by_pose, Matrix2::new(side, side * slope, 0.0, 1.0))
    }

    /// Chi-square of one sighting.
    pub fn chi2_of(&self, s: &Sighting) -> f64 {
        let (error, ..) = self.sighting(s);
        (error.transpose() * s.information * error)[(0, 0)]
    }

    /// Weight of a loop closure as it fits now: the square of the scale by which its error counts.
    fn loop_weight(&self, r: &Relation) -> f64 {
        let (error, ..) = self.relation(r);
        let chi2 = (error.transpose() * r.information * error)[(0, 0)];
        (2.0 * PHI / (PHI + chi2)).min(1.0).powi(2)
    }

    /// The unknowns when all poses up to `held` stay: poses by time, each line after the last pose that saw it, so that the
    /// factor stays narrow; poses of loop closures last.
    fn layout(&self, held: usize) -> Layout {
        let mut order: Vec<(f64, bool, usize)> = Vec::new();
        let in_loop = |pose: usize| self.loops.iter().any(|r| r.from == pose || r.to == pose);
        for pose in held + 1..self.poses.len() {
            let late = if in_loop(pose) { self.poses.len() as f64 } else { 0.0 };
            order.push((late + pose as f64, true, pose));
        }
        let mut last = vec![None; self.lines.len()];
        for s in self.sightings.iter().filter(|s| s.pose > held) {
            last[s.line] = Some(s.pose);
        }
        order.extend(last.iter().enumerate().filter_map(|(i, seen)| Some(((*seen)? as f64 + 0.5, false, i))));
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut poses, mut lines) = (vec![None; self.poses.len()], vec![None; self.lines.len()]);
        let mut len = 0;
        for (_, is_pose, index) in order {
            if is_pose {
                poses[index] = Some(len)
            } else {
                lines[index] = Some(len)
            }
            len += if is_pose { 3 } else { 2 };
        }
        Layout { poses, lines, len }
    }

    /// Every factor that touches an unknown, as it is now.
    fn factors(&self, layout: &Layout) -> Vec<Linear> {
        let dynamic = |m: &[f64], rows: usize| DMatrix::from_column_slice(rows, m.len() / rows, m);
        let mut factors = Vec::new();
        let weighted = self.odometry.iter().map(|r| (r, 1.0));
        for (r, weight) in weighted.chain(self.loops.iter().map(|r| (r, self.loop_weight(r)))) {
            let (error, by_from, by_to) = self.relation(r);
            let sides = [(layout.poses[r.from], by_from), (layout.poses[r.to], by_to)];
            let by: Vec<_> = sides.iter().filter_map(|(at, m)| Some(((*at)?, dynamic(m.as_slice(), 3)))).collect();
            let weight = dynamic((r.information * weight).as_slice(), 3);
            factors.push(Linear { error: DVector::from_column_slice(error.as_slice()), by, weight });
        }
        for s in &self.sightings {
            let Some(line) = layout.lines[s.line] else { continue };
            let (error, by_pose, by_line) = self.sighting(s);
            let mut by = vec![(line, dynamic(by_line.as_slice(), 2))];
            by.extend(layout.poses[s.pose].map(|at| (at, dynamic(by_pose.as_slice(), 2))));
            let weight = dynamic(s.information.as_slice(), 2);
            factors.push(Linear { error: DVector::from_column_slice(error.as_slice()), by, weight });
        }
        for [i, j] in &self.squares {
            let by: Vec<_> = [(layout.lines[*i], 1.0), (layout.lines[*j], -1.0)]
                .iter()
                .filter_map(|(at, sign)| Some(((*at)?, DMatrix::from_row_slice(1, 2, &[0.0, *sign]))))
                .collect();
            let error = DVector::from_element(1, off_quarter(self.lines[*i].a, self.lines[*j].a));
            factors.push(Linear { error, by, weight: DMatrix::from_element(1, 1, 1.0 / (SQUARE * SQUARE)) });
        }
        factors.retain(|factor| !factor.by.is_empty());
        factors
    }

    fn chi2(factors: &[Linear]) -> f64 {
        factors.iter().map(|f| (f.error.transpose() * &f.weight * &f.error)[(0, 0)]).sum()
    }

    /// Normal equations with damping: the matrix and the right-hand side.
    fn normal(factors: &[Linear], len: usize, damping: f64) -> (CscMatrix<f64>, DVector<f64>) {
        let mut matrix = CooMatrix::new(len, len);
        let mut right = DVector::zeros(len);
        for factor in factors {
            for (at, by) in &factor.by {
                let weighted = by.transpose() * &factor.weight;
                let mut rows = right.rows_mut(*at, by.ncols());
                rows -= &weighted * &factor.error;
                for (other, by_other) in &factor.by {
                    matrix.push_matrix(*at, *other, &(&weighted * by_other));
                }
            }
        }
        (0..len).for_each(|i| matrix.push(i, i, damping));
        (CscMatrix::from(&matrix), right)
    }

    fn moved(&self, layout: &Layout, by: &DMatrix<f64>) -> Self {
        let mut moved = self.clone();
        for (pose, at) in moved.poses.iter_mut().zip(&layout.poses) {
            let Some(at) = *at else { continue };
            *pose = Pose::new(pose.at.x + by[at], pose.at.y + by[at + 1], pose.theta + by[at + 2]);
        }
        for (line, at) in moved.lines.iter_mut().zip(&layout.lines) {
            let Some(at) = *at else { continue };
            *line = Line { rho: line.rho + by[at], a: wrap(line.a + by[at + 1]) };
        }
        moved
    }

    /// Places everything after pose `held` anew, in at most so many iterations; the covariance of the last pose given the held
    /// one, where it was asked for.
    pub fn solve(&mut self, held: usize, iterations: usize, with_covariance: bool) -> Option<Matrix3<f64>> {
        let layout = self.layout(held);
        if layout.len == 0 {
            return None;
        }
        let mut damping = 1e-6;
        let mut factors = self.factors(&layout);
        let mut chi2 = Self::chi2(&factors);
        for _ in 0..iterations {
            let (matrix, right) = Self::normal(&factors, layout.len, damping);
            let Ok(cholesky) = CscCholesky::factor(&matrix) else { break };
            let next = self.moved(&layout, &cholesky.solve(&right));
            let next_factors = next.factors(&layout);
            let next_chi2 = Self::chi2(&next_factors);
            if next_chi2 > chi2 {
                damping = (damping * 100.0).max(1e-3);
                if damping > 1e6 {
                    break;
                }
                continue;
            }
            let is_settled = chi2 - next_chi2 <= SETTLED * chi2;
            (*self, factors, chi2, damping) = (next, next_factors, next_chi2, (damping * 0.1).max(1e-9));
            if is_settled {
                break;
            }
        }
        let last = layout.poses.last().copied().flatten().filter(|_| with_covariance)?;
        let (matrix, _) = Self::normal(&factors, layout.len, 1e-9);
        let mut unit = DMatrix::zeros(layout.len, 3);
        (0..3).for_each(|i| unit[(last + i, i)] = 1.0);
        let columns = CscCholesky::factor(&matrix).ok()?.solve(&unit);
        Some(columns.fixed_view::<3, 3>(last, 0).into_owned())
    }

    /// Memory that the graph takes, bytes.
    pub fn bytes(&self) -> usize {
        self.poses.len() * size_of::<Pose>()
            + self.lines.len() * size_of::<Line>()
            + (self.odometry.len() + self.loops.len()) * size_of::<Relation>()
            + self.sightings.len() * size_of::<Sighting>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relation(from: usize, to: usize, between: Pose, sigma: f64) -> Relation {
        Relation { from, to, between, information: Matrix3::identity() / (sigma * sigma) }
    }

    /// Four sides of a square with a wrong turn at each corner: a loop closure spreads the error evenly.
    #[test]
    fn a_loop_spreads_what_is_wrong_and_a_false_one_does_not_matter() {
        let side = Pose::new(1.0, 0.0, 1.6);
        let mut graph = Graph { poses: vec![Pose::default()], ..Graph::default() };
        for i in 0..4 {
            let pose = graph.poses[i].compose(&side);
            graph.poses.push(pose);
            graph.odometry.push(relation(i, i + 1, side, 0.05));
        }
        graph.loops.push(relation(0, 4, Pose::default(), 0.02));
        graph.solve(0, 30, false);
        assert!(graph.poses[4].at.norm() < 0.02, "{:?}", graph.poses);
        let turns: Vec<f64> = (0..4).map(|i| graph.poses[i].relative(&graph.poses[i + 1]).theta).collect();
        assert!(turns.iter().all(|turn| (turn - 0.5 * PI).abs() < 0.02), "{turns:?}");
        let before = graph.poses.clone();
        graph.loops.push(relation(0, 3, Pose::new(5.0, 5.0, 1.0), 0.05));
        graph.solve(0, 30, false);
        let moved = graph.poses.iter().zip(&before).map(|(a, b)| (a.at - b.at).norm()).fold(0.0, f64::max);
        assert!(moved < 0.05, "{moved}");
    }

    /// With one line and one pose everything is linear: the covariance is that of a Kalman filter.
    #[test]
    fn the_last_covariance_is_a_kalman_filters() {
        let mut graph = Graph { poses: vec![Pose::default(), Pose::new(1.0, 0.0, 0.0)], ..Graph::default() };
        graph.odometry.push(relation(0, 1, Pose::new(1.0, 0.0, 0.0), 0.1));
        graph.lines.push(Line { rho: 2.0, a: 0.0 });
        let information = Matrix2::from_diagonal(&Vector2::new(1.0 / 0.0004, 1.0 / 0.0001));
        let sight = |pose: usize, rho: f64| Sighting { pose, line: 0, seen: Line { rho, a: 0.0 }, information };
        graph.sightings = vec![sight(0, 2.0), sight(1, 1.0)];
        let found = graph.solve(0, 20, true).expect("a covariance");
        // x: prior 0.01, measured through the line with twice 0.0004; theta: 0.01 and twice 0.0001.
        let expected = [1.0 / (100.0 + 1.0 / 0.0008), 0.01, 1.0 / (100.0 + 1.0 / 0.0002)];
        for (i, expected) in expected.into_iter().enumerate() {
            assert!((found[(i, i)] - expected).abs() < 1e-3 * expected, "{i}: {} {expected}", found[(i, i)]);
        }
    }
}
