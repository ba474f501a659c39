//! After Jensfelt and Christensen 1999: pose tracking in a home whose walls are known.
//!
//! For each wall that can be seen, the points in its gate vote in a local Hough transform in which a point's weight is its range
//! (so that near walls, which have more points, count no more), a line is fitted, and the pose follows in a Kalman filter of
//! three states. Numbers of the gates and cells after their public code's comments, the windows ours.

use nalgebra::{Matrix2, Vector2};
use std::f64::consts::PI;

use crate::ekf::{Ekf, Observation};
use crate::fit::fit;
use crate::geometry::{Line, Point, Segment, overlap, unit, wrap};
use crate::hough::Hough;
use crate::known::Known;
use crate::window::{Extent, Seen, Window};
use crate::{Input, Output, Relative};

const WINDOW: Extent = Extent { path: 0.5, turn: 0.6, points: 2000, step: 0.01 };
const HOUGH: Hough = Hough { angles: 360, width: 0.02, reach: 9.0, votes: 0.5, inlier: 0.09, gap: 1.0 };
/// Way between two updates, metres.
const EVERY: f64 = 0.15;
/// Fewest points, and shortest stretch of a wall, metres.
const POINTS: usize = 10;
const LENGTH: f64 = 0.25;
/// Half the span of the local transform, radians and metres.
const SPAN: (f64, f64) = (8.0 * PI / 180.0, 0.15);
/// Variance of an inlier, m^2, and of a reading's neighbours that share its error: a wall as it was measured by hand.
const MEASURED: f64 = 1e-4;
/// 99 % of a chi-square distribution with two degrees of freedom.
const GATE: f64 = 9.21;
const REACH: f64 = 8.5;

/// The tracker.
pub struct RangeHough {
    known: Known,
    ekf: Ekf,
    window: Window,
    updated: f64,
}

impl RangeHough {
    /// At the start pose in this map.
    pub fn new(known: Known) -> Self {
        Self { known, ekf: Ekf::default(), window: Window::new(WINDOW), updated: 0.0 }
    }

    /// The points of the window that may be of a wall.
    fn gated(&self, wall: usize, line: &Line) -> Vec<usize> {
        let pose = self.ekf.pose();
        let Segment { from, to } = self.known.walls[wall];
        let extent = line.stretch([from, to].map(|end| pose.inverse_transform(end)));
        let sigma = (self.ekf.variance(0) + self.ekf.variance(1) + 9.0 * self.ekf.variance(2) + MEASURED).sqrt();
        let near = |seen: &Seen| {
            let off = line.beyond(seen.at).abs();
            let along = line.along(seen.at);
            off < (3.0 * sigma).clamp(0.1, SPAN.1 + 0.15)
                && overlap([along, along], extent) > -0.05
                && unit(seen.bearing).dot(&unit(line.a)) > 0.2
        };
        (0..self.window.points.len()).filter(|i| near(&self.window.points[*i])).collect()
    }

    fn observe(&self, wall: usize) -> Option<(Observation<2>, Vec<usize>)> {
        let expected = self.known.seen(wall, &self.ekf.pose());
        let gated = self.gated(wall, &expected);
        if gated.len() < POINTS {
            return None;
        }
        let points: Vec<&Seen> = gated.iter().map(|i| &self.window.points[*i]).collect();
        let allowed = |a: f64| wrap(a - expected.a).abs() <= SPAN.0;
        let (peak, _) = HOUGH.peak(&points, allowed, |seen| seen.range)?;
        let own = HOUGH.inliers(&self.window, &gated, &peak);
        let fit = fit(&self.window, &own);
        if own.len() < POINTS || fit.length() < LENGTH {
            return None;
        }
        let n = unit(expected.a + self.ekf.pose().theta);
        // What a wall was measured wrong by is shared by all of its points.
        let noise =
            fit.covariance + Matrix2::new(MEASURED, 0.0, 0.0, MEASURED / (fit.length() * fit.length()).max(1.0));
        let off = Line { rho: fit.line.rho - expected.rho, a: wrap(fit.line.a - expected.a) };
        // d(rho, a) of the wall by the pose; the heading turns the line about the robot.
        let column = |direction: Point| Vector2::new(-n.dot(&direction), 0.0);
        let by = vec![(0, column(Point::x())), (1, column(Point::y())), (2, Vector2::new(0.0, -1.0))];
        Some((Observation { innovation: Vector2::new(off.rho, off.a), by, noise }, own))
    }
}

impl Relative for RangeHough {
    fn step(&mut self, input: &Input<'_>) -> Output {
        self.ekf.predict(&input.motion, &input.motion_cov);
        self.window.step(input);
        let way = self.window.path + self.window.turned / 3.0;
        if way - self.updated >= EVERY {
            self.updated = way;
            let mut used = Vec::new();
            for wall in self.known.visible(&self.ekf.pose(), REACH) {
                if let Some((observation, own)) = self.observe(wall)
                    && self.ekf.distance(&observation) < GATE
                {
                    self.ekf.update(&observation);
                    used.extend(own);
                }
            }
            self.window.drop(&used);
        }
        Output { pose: self.ekf.pose(), covariance: Some(self.ekf.pose_covariance()) }
    }

    fn walls(&self) -> Vec<Segment> {
        self.known.walls.clone()
    }

    fn bytes(&self) -> usize {
        self.ekf.bytes() + self.window.bytes() + self.known.walls.len() * size_of::<Segment>()
    }
}
