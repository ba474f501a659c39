//! Poses, lines and segments in the plane, in double precision. Metres, radians counter-clockwise.

use nalgebra::{Matrix2, Matrix3, Vector2};
use std::f64::consts::{PI, TAU};

/// A point or a direction, metres.
pub type Point = Vector2<f64>;

/// The angle in (-pi, pi] that equals `angle` modulo a full turn.
pub fn wrap(angle: f64) -> f64 {
    let wrapped = angle - TAU * (angle / TAU).round();
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}

/// The unit vector in this direction.
pub fn unit(angle: f64) -> Point {
    Point::new(angle.cos(), angle.sin())
}

/// The vector turned left by a right angle.
pub fn perp(v: Point) -> Point {
    Point::new(-v.y, v.x)
}

/// The rotation by an angle.
pub fn rotation(angle: f64) -> Matrix2<f64> {
    let (s, c) = angle.sin_cos();
    Matrix2::new(c, -s, s, c)
}

/// A planar pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position, metres.
    pub at: Point,
    /// Heading, radians.
    pub theta: f64,
}

impl Pose {
    /// A pose; the heading is wrapped.
    pub fn new(x: f64, y: f64, theta: f64) -> Self {
        Self { at: Point::new(x, y), theta: wrap(theta) }
    }

    /// A point of this pose's frame in the outer frame.
    pub fn transform(&self, point: Point) -> Point {
        self.at + rotation(self.theta) * point
    }

    /// A point of the outer frame in this pose's frame.
    pub fn inverse_transform(&self, point: Point) -> Point {
        rotation(-self.theta) * (point - self.at)
    }

    /// `inner`, which is in this pose's frame, in the outer frame.
    pub fn compose(&self, inner: &Self) -> Self {
        Self { at: self.transform(inner.at), theta: wrap(self.theta + inner.theta) }
    }

    /// `other`, given in the outer frame, in this pose's frame.
    pub fn relative(&self, other: &Self) -> Self {
        Self { at: self.inverse_transform(other.at), theta: wrap(other.theta - self.theta) }
    }

    /// Derivatives of `self.relative(other)` by self and by other.
    pub fn relative_jacobians(&self, other: &Self) -> (Matrix3<f64>, Matrix3<f64>) {
        let mut by_other = Matrix3::identity();
        by_other.fixed_view_mut::<2, 2>(0, 0).copy_from(&rotation(-self.theta));
        let mut by_self = -by_other;
        // d(R(-theta) v)/d theta = -perp(R(-theta) v).
        let arm = perp(self.relative(other).at);
        (by_self[(0, 2)], by_self[(1, 2)]) = (-arm.x, -arm.y);
        (by_self, by_other)
    }

    /// Derivatives of `self.compose(inner)` by self and by inner.
    pub fn compose_jacobians(&self, inner: &Self) -> (Matrix3<f64>, Matrix3<f64>) {
        let arm = perp(rotation(self.theta) * inner.at);
        let mut by_self = Matrix3::identity();
        by_self[(0, 2)] = arm.x;
        by_self[(1, 2)] = arm.y;
        let mut by_inner = Matrix3::identity();
        by_inner.fixed_view_mut::<2, 2>(0, 0).copy_from(&rotation(self.theta));
        (by_self, by_inner)
    }
}

/// A straight piece between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// One end, metres.
    pub from: Point,
    /// The other end, metres.
    pub to: Point,
}

impl Segment {
    /// Length, metres.
    pub fn length(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// The same segment as it is in the outer frame of `pose`.
    pub fn moved(&self, pose: &Pose) -> Self {
        Self { from: pose.transform(self.from), to: pose.transform(self.to) }
    }
}

/// The points p with p . unit(a) = rho.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Distance from the origin along the normal, metres.
    pub rho: f64,
    /// Direction of the normal, radians.
    pub a: f64,
}

impl Line {
    /// The same line with a distance that is not negative.
    pub fn facing(self) -> Self {
        if self.rho < 0.0 { Self { rho: -self.rho, a: wrap(self.a + PI) } } else { self }
    }

    /// Signed distance of a point behind the line, along the normal.
    pub fn beyond(&self, point: Point) -> f64 {
        point.dot(&unit(self.a)) - self.rho
    }

    /// How far along the line's tangent (the normal turned left) a point is.
    pub fn along(&self, point: Point) -> f64 {
        point.dot(&perp(unit(self.a)))
    }

    /// From where to where along the tangent two points lie.
    pub fn stretch(&self, ends: [Point; 2]) -> [f64; 2] {
        let [one, other] = ends.map(|end| self.along(end));
        [one.min(other), one.max(other)]
    }

    /// The piece of the line between two places along its tangent.
    pub fn piece(&self, extent: [f64; 2]) -> Segment {
        Segment { from: self.point(extent[0]), to: self.point(extent[1]) }
    }

    /// The point of the line so far along the tangent.
    pub fn point(&self, along: f64) -> Point {
        unit(self.a) * self.rho + perp(unit(self.a)) * along
    }

    /// The line in the outer frame of `pose`.
    pub fn moved(&self, pose: &Pose) -> Self {
        let a = wrap(self.a + pose.theta);
        Self { rho: self.rho + pose.at.dot(&unit(a)), a }
    }
}

/// Where a robot is by a chain of motions, and how sure.
#[derive(Clone, Debug, Default)]
pub struct Chain {
    /// Pose in the frame that the chain begins in.
    pub pose: Pose,
    /// Its covariance.
    pub covariance: Matrix3<f64>,
}

impl Chain {
    /// The chain with another one after it.
    pub fn then(&self, pose: &Pose, covariance: &Matrix3<f64>) -> Self {
        let (by_self, by_next) = self.pose.compose_jacobians(pose);
        let covariance = by_self * self.covariance * by_self.transpose() + by_next * covariance * by_next.transpose();
        Self { pose: self.pose.compose(pose), covariance }
    }
}

/// The smallest stretch that has both in it.
pub fn hull(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [one[0].min(other[0]), one[1].max(other[1])]
}

/// No stretch yet: what it is [joined](hull) with is the result.
pub const NOWHERE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// How much of two stretches is common, metres; negative: the gap between them.
pub fn overlap(one: [f64; 2], other: [f64; 2]) -> f64 {
    one[1].min(other[1]) - one[0].max(other[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_moves_with_its_points() {
        let (line, pose) = (Line { rho: 1.5, a: 0.4 }, Pose::new(0.3, -0.8, 2.9));
        for along in [-2.0, 0.7] {
            assert!(line.moved(&pose).beyond(pose.transform(line.point(along))).abs() < 1e-12);
        }
    }

    #[test]
    fn composition_is_differentiated_as_differences_say() {
        let (a, b) = (Pose::new(0.3, -0.8, 0.7), Pose::new(1.1, 0.2, -0.4));
        let (by_a, by_b) = a.compose_jacobians(&b);
        let step = 1e-6;
        for axis in 0..3 {
            let moved = |pose: Pose, by: f64| {
                let mut v = [pose.at.x, pose.at.y, pose.theta];
                v[axis] += by;
                Pose { at: Point::new(v[0], v[1]), theta: v[2] }
            };
            let slope = |up: Pose, down: Pose| {
                let d = (up.at - down.at) / (2.0 * step);
                [d.x, d.y, (up.theta - down.theta) / (2.0 * step)]
            };
            let expected_a = slope(moved(a, step).compose(&b), moved(a, -step).compose(&b));
            let expected_b = slope(a.compose(&moved(b, step)), a.compose(&moved(b, -step)));
            for row in 0..3 {
                assert!((by_a[(row, axis)] - expected_a[row]).abs() < 1e-8);
                assert!((by_b[(row, axis)] - expected_b[row]).abs() < 1e-8);
            }
        }
    }
}
