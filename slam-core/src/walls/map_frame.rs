//! The map frame, and what holds it.
//!
//! The filter's states are in the frame of the start pose. How the map as a whole lies in that frame is what is known
//! least: the first turns, made before there was a wall, have an error that no reading tells, until a loop or a scale does.
//! Then the map turns about the start pose, with the robot in it, and what was drawn before lies askew. Nobody needs to
//! know where the robot started to a degree; where it is in its map is what a map is for. So walls can hold the frame: a
//! wall that is known well enough to be drawn stays, in the frame, where it was first drawn; the walls in view more than the
//! others, since it is there that the robot is. Where they disagree, each weighs less the farther it is off, as least absolute
//! deviations have it: a few that a closing loop moves do not take the frame along. The start pose is what moves.

use crate::filter::ekf::EkfView;
use crate::filter::layout::{X, Y};
use crate::geometry::angle::{normal, sin_cos, wrap};
use crate::geometry::line::Line;
use crate::geometry::matrix::{Matrix, propagated, rotation};
use crate::geometry::pose::Pose;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::{MapFrame, MapView};
use crate::walls::wall::Wall;

/// Displacement up to which a wall has full weight, metres; a larger one lowers the weight in proportion.
const STAY_M: f32 = 0.002;

/// Weight of the frame's present place, that of a wall's end a decimetre off: it holds the directions that no wall holds.
const INERTIA: f32 = 10.0;

/// More such weight in every direction, as a share of what all walls hold: of where they are along themselves a wall ten degrees askew to them
/// says a thirtieth of that, and its own error draws the frame along, step by step and far in the end. What more and less do: docs/notes/real-logs.md.
const STEADINESS: f32 = 0.3;

/// Number of readings after which a wall is drawn: twice the number below which it may be forgotten as noise.
const DRAWN_AFTER: u32 = 20;

/// Length of path within which a wall that was met counts as in view, metres: about the range of the sensors.
const IN_VIEW_M: f32 = 3.0;

/// Weight of a wall out of view against one in view, since there are many more of them.
const OUT_OF_VIEW: f32 = 0.1;

/// Rounds of least absolute deviations where the map was changed as a whole.
const REDRAW_ROUNDS: usize = 10;

/// Walls that turned by more than this as the map was changed say nothing of where it lies, radians: six degrees. Their direction was
/// not known.
const TURNED_RAD: f32 = 0.1;

/// The motion that brings lines closest to others, by weighted least squares: normal equations of (turn, dx, dy) about a
/// pivot.
pub struct CommonMotion {
    pivot: [f32; 2],
    /// Matrix and right-hand side.
    rows: [[f32; 4]; 3],
}

impl CommonMotion {
    /// Normal equations without any line, about a pivot point, metres.
    pub fn about(pivot: [f32; 2]) -> Self {
        let mut rows = [[0.0; 4]; 3];
        for (i, row) in rows.iter_mut().enumerate() {
            row[i] = INERTIA;
        }
        Self { pivot, rows }
    }

    /// Adds the equation that a point of a wall's line comes to lie on another line, with a weight.
    pub fn add(&mut self, from: &Line, to: &Line, along_m: f32, importance: f32) {
        let point = from.at(along_m);
        let off_m = to.distance(point);
        let arm = [point[0] - self.pivot[0], point[1] - self.pivot[1]];
        let derivatives = [to.normal[1] * arm[0] - to.normal[0] * arm[1], to.normal[0], to.normal[1]];
        let weight = importance / (off_m.abs() + STAY_M);
        for (row, a) in self.rows.iter_mut().zip(derivatives) {
            for (entry, b) in row.iter_mut().zip(derivatives.into_iter().chain([off_m])) {
                *entry += weight * a * b;
            }
        }
    }

    /// With a weight of the frame's present place in proportion to what holds it.
    pub fn steadied(mut self) -> Self {
        let held = self.rows[1][1] + self.rows[2][2];
        self.rows[1][1] += STEADINESS * held;
        self.rows[2][2] += STEADINESS * held;
        self
    }

    /// The motion; none where it is not a number.
    pub fn solve(mut self) -> Option<Pose> {
        // Gauss and Jordan: the matrix is positive definite, the diagonal is pivot enough.
        for i in 0..3 {
            let inverse = 1.0 / self.rows[i][i];
            let row = self.rows[i].map(|entry| entry * inverse);
            self.rows[i] = row;
            for (_, other) in self.rows.iter_mut().enumerate().filter(|(j, _)| *j != i) {
                let factor = other[i];
                for (entry, pivot) in other.iter_mut().zip(row) {
                    *entry -= factor * pivot;
                }
            }
        }
        let [turn, dx, dy] = self.rows.map(|row| row[3]);
        let (s, c) = sin_cos(turn);
        let [x, y] = self.pivot;
        let motion = Pose { x_m: x + dx - (c * x - s * y), y_m: y + dy - (s * x + c * y), theta_rad: turn };
        (motion.x_m.is_finite() && motion.y_m.is_finite() && turn.is_finite()).then_some(motion)
    }
}

/// The filter's frame in the map frame, with sine and cosine of its direction; none where they are one.
struct Moved(Option<(Pose, (f32, f32))>);

impl Moved {
    /// A line of the filter's frame in the map frame, and how much its coordinates along it grow.
    fn line(&self, line: &Line) -> (Line, f32) {
        let Some((Pose { x_m, y_m, theta_rad }, (s, c))) = self.0 else { return (*line, 0.0) };
        let [nx, ny] = line.normal;
        let normal = [c * nx - s * ny, s * nx + c * ny];
        let rho_m = line.rho_m + x_m * normal[0] + y_m * normal[1];
        let beta_rad = wrap(line.beta_rad + theta_rad);
        (Line { rho_m, beta_rad, normal }, y_m * normal[0] - x_m * normal[1])
    }
}

impl MapView {
    /// Moves the start pose so that walls stay where they were first drawn. `path_m` is the robot's path length so far.
    pub fn hold_frame(&mut self, ekf: &EkfView, path_m: f32) {
        if self.frame == MapFrame::Start {
            return;
        }
        let importance = |wall: &Wall, _: &Line| if path_m - wall.seen_at_m < IN_VIEW_M { 1.0 } else { OUT_OF_VIEW };
        let motion = self.motion_of_drawn(ekf, importance).steadied().solve();
        self.draw_all(ekf, |wall| wall.drawn.is_none() && wall.updates >= DRAWN_AFTER);
        if let Some(motion) = motion {
            self.start = motion.compose(&self.start);
        }
    }

    /// The map was changed as a whole: moves the start pose to where most walls stay where they were drawn, in view or not, and draws
    /// all of them anew.
    pub fn redraw(&mut self, ekf: &EkfView) {
        if self.frame == MapFrame::Start {
            return;
        }
        let origin_rad = self.origin().map_or(0.0, |origin| origin.theta_rad);
        let importance = |wall: &Wall, line: &Line| {
            let beta_rad = line.beta_rad + origin_rad;
            let has_turned = wall.drawn.is_some_and(|[_, drawn_rad]| wrap(drawn_rad - beta_rad).abs() > TURNED_RAD);
            if has_turned { 0.0 } else { 1.0 }
        };
        for _ in 0..REDRAW_ROUNDS {
            let Some(motion) = self.motion_of_drawn(ekf, importance).solve() else { break };
            self.start = motion.compose(&self.start);
        }
        self.draw_all(ekf, |wall| wall.updates >= DRAWN_AFTER);
    }

    fn draw_all(&mut self, ekf: &EkfView, is_wanted: impl Fn(&Wall) -> bool) {
        let grid = ManhattanFrame::of(ekf);
        for index in 0..self.walls().len() {
            let Some(wall) = self.walls().get(index).filter(|wall| is_wanted(wall)) else { continue };
            let (line, _) = self.in_map(&wall.line(ekf, &grid));
            self.draw(index, line);
        }
    }

    /// The motion of the map that brings the walls back to where they were drawn, by how important each is, and its line in the filter's frame.
    fn motion_of_drawn(&self, ekf: &EkfView, importance: impl Fn(&Wall, &Line) -> f32) -> CommonMotion {
        let (grid, moved) = (ManhattanFrame::of(ekf), self.moved());
        let mut motion = CommonMotion::about(self.point_in_map([ekf.mean(X), ekf.mean(Y)]));
        for (wall, [rho_m, beta_rad]) in self.walls().iter().filter_map(|wall| Some((wall, wall.drawn?))) {
            let drawn = Line { rho_m, beta_rad, normal: normal(beta_rad) };
            let own = wall.line(ekf, &grid);
            let ((line, origin_m), importance) = (moved.line(&own), importance(wall, &own));
            motion.add(&line, &drawn, wall.lo_m + origin_m, importance);
            motion.add(&line, &drawn, wall.hi_m + origin_m, importance);
        }
        motion
    }

    /// The filter's frame in the map frame; none where they are one.
    pub fn origin(&self) -> Option<Pose> {
        let anchor = self.anchor.map(|anchor| anchor.pose);
        match self.frame {
            MapFrame::Start => anchor,
            MapFrame::Walls => Some(anchor.map_or(self.start, |anchor| self.start.compose(&anchor))),
        }
    }

    /// The motion from the filter's frame to the map frame, for many lines.
    fn moved(&self) -> Moved {
        Moved(self.origin().map(|origin| (origin, sin_cos(origin.theta_rad))))
    }

    /// A line of the filter's frame in the map frame, and how much its coordinates along it grow.
    pub fn in_map(&self, line: &Line) -> (Line, f32) {
        self.moved().line(line)
    }

    /// A point of the filter's frame in the map frame.
    pub fn point_in_map(&self, point: [f32; 2]) -> [f32; 2] {
        self.origin().map_or(point, |origin| origin.transform(point))
    }

    /// A pose of the filter's frame in the map frame.
    pub fn pose_in_map(&self, pose: &Pose) -> Pose {
        self.origin().map_or(*pose, |origin| origin.compose(pose))
    }

    /// A covariance of (x, y, theta) in the start pose's frame in the map frame: R P R^T for the frame's turn R.
    pub fn covariance_in_map(&self, from_start: Matrix) -> Matrix {
        if self.frame == MapFrame::Start {
            return from_start;
        }
        propagated(&rotation(self.start.theta_rad), &from_start)
    }
}
