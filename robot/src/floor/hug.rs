//! Along whatever stands on the right (or, mirrored, on the left), a finger's breadth from it.

use slam_core::angle::wrap;
use slam_core::pose::length;

use crate::pilot::steer::limited;

/// What the body is and how near it may come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hug {
    /// Radius of the body, metres.
    pub radius_m: f32,
    /// Gap between body and wall, metres.
    pub gap_m: f32,
    /// Speed along a straight wall, m/s.
    pub speed_mps: f32,
    /// Fastest turn, rad/s.
    pub turn_radps: f32,
}

/// Speed and turn rate, and whether there is anything to go along.
#[derive(Clone, Copy, Debug)]
pub(super) struct Along {
    pub forward_mps: f32,
    pub turn_radps: f32,
    pub is_beside: bool,
    /// Distance of the nearest thing from the robot's centre, metres.
    pub nearest_m: f32,
}

/// Beyond this distance there is no wall to go along, metres.
const LOST_M: f32 = 0.42;

/// Sums for a straight line through the points beside the robot.
#[derive(Clone, Copy, Debug, Default)]
struct Line {
    n: f32,
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
    yy: f32,
}

impl Line {
    fn add(&mut self, [x, y]: [f32; 2]) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// Offset at the robot (m) and slope, where the points are on a straight line: at least four over some 11 cm, within 9 mm.
    fn fit(&self) -> Option<[f32; 2]> {
        let n = self.n.max(1.0);
        let (x, y) = (self.x / n, self.y / n);
        let (var_x, cov, var_y) = (self.xx / n - x * x, self.xy / n - x * y, self.yy / n - y * y);
        if self.n < 4.0 || var_x < 0.0008 {
            return None;
        }
        let slope = cov / var_x;
        (var_y - slope * cov < 0.009 * 0.009).then_some([y - slope * x, slope])
    }
}

fn power_16(value: f32) -> f32 {
    let second = value * value;
    let fourth = second * second;
    let eighth = fourth * fourth;
    eighth * eighth
}

impl Hug {
    /// The command among these points (robot's frame, metres); `side` is 1 with the wall on the right, -1 on the left.
    pub(super) fn along(&self, points: impl Iterator<Item = [f32; 2]>, side: f32) -> Along {
        let keep_m = self.radius_m + self.gap_m;
        let (mut ahead_m, mut beside_m, mut other_m) = (f32::INFINITY, f32::INFINITY, f32::INFINITY);
        let mut nearest = [0.0, -1e-9];
        let mut line = Line::default();
        for [x, y] in points {
            let y = side * y;
            let bow_m = self.radius_m + 0.003;
            if x > 0.0 && y.abs() < self.radius_m - 0.01 {
                ahead_m = ahead_m.min(x - float::sqrtf(bow_m * bow_m - y * y));
            }
            let distance_m = length(x, y);
            // What is on the other side counts only where the body touches it.
            if y > 0.5 * distance_m {
                other_m = other_m.min(distance_m);
            } else {
                beside_m = beside_m.min(distance_m);
                // The direction of what is nearest, smoothly: what is a tenth farther counts a fifth.
                let weight = power_16(keep_m / distance_m.max(0.1));
                nearest = [nearest[0] + weight * x, nearest[1] + weight * y];
                if y < -0.1 && y > -keep_m - 0.035 && x.abs() < 0.14 {
                    line.add([x, y]);
                }
            }
        }
        let mut turn = match line.fit() {
            Some([offset_m, slope]) if ahead_m > 0.1 => {
                // On a straight wall: a second-order approach, damped, within some 20 cm of path.
                let off_m = (-offset_m - keep_m).clamp(-0.05, 0.06);
                -9.0 * off_m + 3.0 * slope
            }
            _ => {
                // Round a corner, or up to a wall: across the direction of what is nearest, and towards it where that is far.
                let off_m = beside_m - keep_m;
                let towards_rad = (off_m * 10.0).clamp(-0.8, 1.0);
                let across_rad = wrap(libm::atan2f(nearest[1], nearest[0]) + core::f32::consts::FRAC_PI_2);
                3.0 * (across_rad - towards_rad)
            }
        };
        let pressed_m = self.radius_m + 0.006 - other_m;
        if pressed_m > 0.0 {
            turn -= 10.0 * pressed_m;
        }
        turn = limited(turn, self.turn_radps);
        let mut forward_mps = self.speed_mps * (1.0 - 0.6 * turn.abs() / self.turn_radps);
        forward_mps = forward_mps.min(3.0 * (ahead_m - self.gap_m + 0.004));
        if ahead_m < self.gap_m + 0.003 {
            (forward_mps, turn) = (0.0, self.turn_radps);
        }
        let nearest_m = beside_m.min(other_m).min(ahead_m + self.radius_m);
        let is_beside = beside_m < LOST_M || ahead_m < LOST_M;
        Along { forward_mps: forward_mps.max(0.0), turn_radps: side * turn, is_beside, nearest_m }
    }
}
