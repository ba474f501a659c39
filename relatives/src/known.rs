//! A map that is given: its walls, and which of them a robot can see.

use crate::geometry::{Line, Point, Pose, Segment, perp};

/// Walls that are known, in the start frame.
#[derive(Clone, Debug)]
pub struct Known {
    /// The walls.
    pub walls: Vec<Segment>,
    lines: Vec<Line>,
}

/// Rays that are cast along a wall to see what hides it.
const RAYS: usize = 9;

impl Known {
    /// Walls at least so long, metres, moved by up to a sigma of `error` as if measured by hand; which way follows from the seed.
    pub fn new(walls: &[Segment], least: f64, error: f64, seed: u64) -> Self {
        let mut random = crate::random::Random::new(seed);
        let mut measured = |wall: &Segment| {
            let along = (wall.to - wall.from).normalize();
            let off = perp(along) * (error * random.gaussian());
            Segment { from: wall.from + off, to: wall.to + off }
        };
        let walls: Vec<Segment> = walls.iter().filter(|wall| wall.length() >= least).map(&mut measured).collect();
        let line = |wall: &Segment| {
            let n = -perp((wall.to - wall.from).normalize());
            Line { rho: n.dot(&wall.from), a: n.y.atan2(n.x) }
        };
        Self { lines: walls.iter().map(line).collect(), walls }
    }

    /// How far a ray goes before it meets a wall; infinite where it meets none.
    pub fn cast(&self, from: Point, direction: Point) -> f64 {
        let meets = |wall: &Segment| {
            let along = wall.to - wall.from;
            let cross = direction.perp(&along);
            let off = wall.from - from;
            let (t, u) = (off.perp(&along) / cross, off.perp(&direction) / cross);
            if cross.abs() > 1e-12 && t > 1e-9 && (0.0..=1.0).contains(&u) { t } else { f64::INFINITY }
        };
        self.walls.iter().map(meets).fold(f64::INFINITY, f64::min)
    }

    /// A wall's line as it is seen from this pose, in the robot's frame, with its normal away from the robot.
    pub fn seen(&self, wall: usize, pose: &Pose) -> Line {
        let line = self.lines[wall];
        Line {
            rho: line.rho - pose.at.dot(&crate::geometry::unit(line.a)),
            a: crate::geometry::wrap(line.a - pose.theta),
        }
        .facing()
    }

    /// The walls of which a part is nearer than `reach` and not hidden.
    pub fn visible(&self, pose: &Pose, reach: f64) -> Vec<usize> {
        let sees = |wall: &Segment| {
            (0..RAYS).any(|i| {
                let share = (i as f64 + 0.5) / RAYS as f64;
                let to = wall.from + (wall.to - wall.from) * share - pose.at;
                let range = to.norm();
                range < reach && range > 1e-6 && self.cast(pose.at, to / range) > range - 0.05
            })
        };
        (0..self.walls.len()).filter(|i| sees(&self.walls[*i])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_behind_another_is_not_seen() {
        let wall = |x: f64, y: f64| Segment { from: Point::new(x, -y), to: Point::new(x, y) };
        let known = Known::new(&[wall(2.0, 2.0), wall(3.0, 1.0), wall(-4.0, 1.0)], 1.0, 0.0, 1);
        assert_eq!(known.visible(&Pose::default(), 3.5), vec![0]);
        assert!((known.cast(Point::zeros(), Point::new(1.0, 0.0)) - 2.0).abs() < 1e-12);
        let seen = known.seen(2, &Pose::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
        assert!((seen.rho - 4.0).abs() < 1e-12 && (seen.a - std::f64::consts::FRAC_PI_2).abs() < 1e-12, "{seen:?}");
    }
}
