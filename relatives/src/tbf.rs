//! Triangulation-based fusion (Wijk, Jensfelt and Christensen 1998): edges, and lines that are tangent, from pairs of sonar
//! readings. Numbers that are not of the method itself are ours.

use nalgebra::Matrix2;
use std::collections::VecDeque;

use crate::Input;
use crate::geometry::{Line, Point, Pose, perp, unit, wrap};

/// Readings of each sensor that are kept.
const KEPT: usize = 30;
/// Readings nearer to each other tell nothing together, metres.
const BASE: f64 = 0.12;
/// A pair agrees with the others within this, metres.
const NEAR: f64 = 0.1;
/// Pairs that make an edge, and a wall.
const EDGE: usize = 4;
const WALL: usize = 6;
/// Least variance of an edge, m^2.
const FLOOR: f64 = 9e-4;
/// Pairs whose lines differ by less agree, radians.
const TILT: f64 = 0.1;

/// A reading, in the frame of the odometry.
#[derive(Clone, Copy, Debug)]
pub struct Echo {
    /// Where the sensor was, metres.
    pub from: Point,
    /// Direction of its axis, radians.
    pub axis: f64,
    /// Full opening, radians.
    pub opening: f64,
    /// The range, metres.
    pub range: f64,
    /// Its 1-sigma, metres.
    pub sigma: f64,
}

/// What several readings agree on, in the robot's present frame.
#[derive(Clone, Debug)]
pub enum Target {
    /// An edge.
    Edge(Point, Matrix2<f64>),
    /// A line that is tangent to the arcs of these readings, its covariance, and the points that it was touched at.
    Wall(Line, Matrix2<f64>, [Point; 2]),
}

/// The points in which the arcs of two readings meet.
pub fn edges(one: &Echo, other: &Echo) -> Vec<Point> {
    let between = other.from - one.from;
    let base = between.norm();
    let k = (one.range.powi(2) - other.range.powi(2) + base * base) / (2.0 * base.max(1e-9));
    let square = one.range.powi(2) - k * k;
    if base < BASE || square < 0.0 {
        return Vec::new();
    }
    let (along, across) = (between / base, perp(between / base) * square.sqrt());
    [across, -across].map(|w| one.from + along * k + w).into_iter().filter(|t| one.sees(*t) && other.sees(*t)).collect()
}

/// The lines that are tangent to the arcs of two readings, their normals away from the sensors.
pub fn tangents(one: &Echo, other: &Echo) -> Vec<Line> {
    let between = other.from - one.from;
    let base = between.norm();
    let ratio = (one.range - other.range) / base.max(1e-9);
    if base < BASE || ratio.abs() > 1.0 {
        return Vec::new();
    }
    let phi = between.y.atan2(between.x);
    let line = |a: f64| Line { rho: one.from.dot(&unit(a)) + one.range, a: wrap(a) };
    let both = [line(phi + ratio.acos()), line(phi - ratio.acos())];
    both.into_iter().filter(|l| one.looks(l.a) && other.looks(l.a)).collect()
}

impl Echo {
    fn looks(&self, direction: f64) -> bool {
        wrap(direction - self.axis).abs() <= 0.5 * self.opening
    }

    fn sees(&self, point: Point) -> bool {
        let d = point - self.from;
        self.looks(d.y.atan2(d.x))
    }
}

/// The readings of the last while.
#[derive(Clone, Debug, Default)]
pub struct Fusion {
    pose: Pose,
    /// The scans, oldest first; the newest is not among them.
    scans: VecDeque<Vec<Echo>>,
}

impl Fusion {
    /// Moves on, and triangulates each new reading with all that are kept.
    pub fn step(&mut self, input: &Input<'_>) -> Vec<Target> {
        self.pose = self.pose.compose(&input.motion);
        let echo = |beam: &crate::Beam| Echo {
            from: self.pose.transform(beam.origin),
            axis: self.pose.theta + beam.bearing,
            opening: beam.opening,
            range: beam.range,
            sigma: beam.sigma,
        };
        let fresh: Vec<Echo> = input.beams.iter().flatten().filter(|beam| beam.opening > 0.0).map(echo).collect();
        if fresh.is_empty() {
            return Vec::new();
        }
        let targets = fresh.iter().filter_map(|echo| self.triangulate(echo)).collect();
        self.scans.push_back(fresh);
        while self.scans.len() > KEPT {
            self.scans.pop_front();
        }
        targets
    }

    /// What the pairs of this reading agree on: more pairs for an edge or for a line decide which of the two it is.
    fn triangulate(&self, echo: &Echo) -> Option<Target> {
        let (mut edge, mut edges_n, mut farthest) = (Point::zeros(), 0, *echo);
        let (mut line, mut lines_n) = (Line::default(), 0);
        let (mut edge_base, mut line_other, mut line_base) = (0.0, *echo, 0.0);
        // The newest first: they drifted least.
        for other in self.scans.iter().rev().flatten() {
            let base = (other.from - echo.from).norm();
            for t in edges(echo, other) {
                if edges_n == 0 || (t - edge).norm() < NEAR {
                    edge = (edge * f64::from(edges_n) + t) / f64::from(edges_n + 1);
                    edges_n += 1;
                    if base > edge_base {
                        (edge_base, farthest) = (base, *other);
                    }
                }
            }
            for l in tangents(echo, other) {
                if lines_n == 0 || wrap(l.a - line.a).abs() < TILT {
                    line.a = wrap(line.a + wrap(l.a - line.a) / f64::from(lines_n + 1));
                    lines_n += 1;
                    if base > line_base {
                        (line_base, line_other) = (base, *other);
                    }
                }
            }
        }
        if lines_n as usize >= WALL && lines_n >= edges_n {
            line.rho = echo.from.dot(&unit(line.a)) + echo.range;
            return Some(self.wall(echo, &line_other, &line, line_base));
        }
        (edges_n as usize >= EDGE && edges_n > lines_n).then(|| self.edge(echo, &farthest, edge))
    }

    fn edge(&self, one: &Echo, other: &Echo, at: Point) -> Target {
        let row = |echo: &Echo| ((at - echo.from) / echo.range).transpose();
        let variance = Matrix2::from_diagonal(&crate::geometry::Point::new(one.sigma.powi(2), other.sigma.powi(2)));
        let inverse = Matrix2::from_rows(&[row(one), row(other)]).try_inverse().unwrap_or_else(Matrix2::identity);
        let covariance = inverse * variance * inverse.transpose() + Matrix2::identity() * FLOOR;
        let back = crate::geometry::rotation(-self.pose.theta);
        Target::Edge(self.pose.inverse_transform(at), back * covariance * back.transpose())
    }

    fn wall(&self, one: &Echo, other: &Echo, line: &Line, base: f64) -> Target {
        let touched = [one, other].map(|echo| self.pose.inverse_transform(echo.from + unit(line.a) * echo.range));
        let n = unit(line.a - self.pose.theta);
        let seen = Line { rho: touched[0].dot(&n), a: wrap(line.a - self.pose.theta) };
        // The direction by two ranges over their base; the distance where the new reading touched.
        let angle = 2.0 * one.sigma.powi(2) / (base * base) + FLOOR / (base * base);
        let arm = seen.along(touched[0]);
        let across = one.sigma.powi(2) + 0.1 * FLOOR;
        Target::Wall(seen, Matrix2::new(across + arm * arm * angle, arm * angle, arm * angle, angle), touched)
    }

    /// Memory that the readings take, bytes.
    pub fn bytes(&self) -> usize {
        self.scans.iter().map(Vec::len).sum::<usize>() * size_of::<Echo>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn echo(from: [f64; 2], axis: f64, range: f64) -> Echo {
        Echo { from: from.into(), axis, opening: 0.5, range, sigma: 0.01 }
    }

    #[test]
    fn two_arcs_meet_where_the_edge_is_and_touch_the_wall_that_is_there() {
        let edge = Point::new(0.4, 1.5);
        let seen = |x: f64| {
            let d = edge - Point::new(x, 0.0);
            echo([x, 0.0], d.y.atan2(d.x) + 0.1, d.norm())
        };
        let found = edges(&seen(0.0), &seen(0.5));
        assert_eq!(found.len(), 1);
        assert!((found[0] - edge).norm() < 1e-12, "{found:?}");
        let wall = Line { rho: 1.2, a: 1.4 };
        let facing = |x: f64| echo([x, 0.1 * x], 1.5, -wall.beyond(Point::new(x, 0.1 * x)));
        let found = tangents(&facing(0.0), &facing(0.6));
        assert_eq!(found.len(), 1);
        assert!((found[0].rho - 1.2).abs() < 1e-12 && (found[0].a - 1.4).abs() < 1e-12, "{found:?}");
        // Beyond both cones there is neither.
        assert!(edges(&echo([0.0, 0.0], -1.5, 1.0), &echo([0.5, 0.0], -1.5, 1.0)).iter().all(|t| t.y < 0.0));
    }
}
