//! A robot drives round and round along the walls of a room, and its odometry is wrong.

use std::vec::Vec;

use slam_core::{DriveModel, Increment, Pose};

use super::random::Random;
use crate::{Diary, Hit};

/// Walls of the room: x = 6, y = 4, x = 0, y = 0; the robot is inside.
const WALLS: [(f64, [f64; 2]); 4] = [(6.0, [1.0, 0.0]), (4.0, [0.0, 1.0]), (0.0, [-1.0, 0.0]), (0.0, [0.0, -1.0])];

/// Directions of the four beams.
const BEAMS: [f64; 4] = [0.0, 0.7, -0.7, -1.6];

pub const SIGMA_M: f64 = 0.01;
pub const SCALE: f64 = 0.97;

pub const DRIVE: DriveModel = DriveModel::Odometry {
    scale_sigma: 0.03,
    noise_m2_per_m: 1e-4,
    noise_rad2_per_m: 1e-4,
    noise_rad2_per_rad: 1e-3,
    veer_sigma: 0.0,
};

/// The robot as it is, and as its odometry has it.
pub struct Robot {
    pub random: Random,
    /// x, y, theta in the room.
    pub truth: [f64; 3],
    pub reckoned: Pose,
    /// Where it started, in the room.
    start: [f64; 3],
    pub laps: u16,
    corner: usize,
}

impl Robot {
    pub fn new(seed: u64) -> Self {
        let start = [1.5, 1.0, 0.0];
        Self { random: Random(seed), truth: start, reckoned: Pose::ORIGIN, start, laps: 0, corner: 0 }
    }

    /// A step of 4 cm along a rectangle, or a turn of 0.1 rad at its corners; what the odometry says of it.
    fn step(&mut self) -> Increment {
        let corners = [[4.5, 1.0], [4.5, 3.0], [1.5, 3.0], [1.5, 1.0]];
        let [x, y, theta] = self.truth;
        let way = [corners[self.corner][0] - x, corners[self.corner][1] - y];
        let off = wrapped(way[1].atan2(way[0]) - theta);
        let (forward, turn) = if way[0].hypot(way[1]) < 0.05 {
            self.corner = (self.corner + 1) % 4;
            self.laps += u16::from(self.corner == 0);
            (0.0, 0.0)
        } else if off.abs() > 0.1 {
            (0.0, 0.1 * off.signum())
        } else {
            (0.04, off.clamp(-0.02, 0.02))
        };
        self.truth = [x + forward * theta.cos(), y + forward * theta.sin(), wrapped(theta + turn)];
        let slip = 0.002 * self.random.normal() * f64::from(forward > 0.0);
        let noise = 0.01 * turn.abs().sqrt() * self.random.normal();
        Increment { forward_m: ((forward + slip) / SCALE) as f32, left_m: 0.0, turn_rad: (turn + noise) as f32 }
    }

    /// Drives so many steps and writes them down: walls by the names of the lap in which they are seen, as of a filter that does
    /// not know them again, poses by dead reckoning.
    pub fn drive<const K: usize, const G: usize, const W: usize>(&mut self, diary: &mut Diary<K, G, W>, steps: usize) {
        for _ in 0..steps {
            let moved = self.step();
            self.reckoned = self.reckoned.compose(&Pose::new(moved.forward_m, moved.left_m, moved.turn_rad));
            diary.travel(&moved);
            if diary.is_due() {
                diary.begin_keyframe(&self.reckoned);
            }
            for (sensor, beam) in BEAMS.iter().enumerate() {
                let (wall, range_m) = self.look(*beam);
                let range_m = range_m + SIGMA_M * self.random.normal();
                let end_m = [(range_m * beam.cos()) as f32, (range_m * beam.sin()) as f32];
                let wall = (range_m < 3.0).then_some(4 * self.laps.min(1) + wall);
                let variance_m2 = (SIGMA_M * SIGMA_M) as f32;
                diary.hit(&Hit { from_m: [0.0; 2], end_m, variance_m2, alike: 1.0, sensor: sensor as u8, wall });
            }
        }
    }

    /// Moves the robot in its own frame; the filter finds it there, but for an error.
    pub fn kick(&mut self, by: [f64; 3], error: [f64; 3]) {
        let ([x, y, theta], [dx, dy, turn]) = (self.truth, by);
        let (s, c) = theta.sin_cos();
        self.truth = [x + c * dx - s * dy, y + s * dx + c * dy, wrapped(theta + turn)];
        let [dx, dy, turn] = [0, 1, 2].map(|i| (by[i] + error[i]) as f32);
        self.reckoned = self.reckoned.compose(&Pose::new(dx, dy, turn));
    }

    /// Begins a keyframe here; the true pose in the map.
    pub fn begin_keyframe<const K: usize, const G: usize, const W: usize>(
        &mut self,
        diary: &mut Diary<K, G, W>,
    ) -> [f64; 3] {
        diary.begin_keyframe(&self.reckoned);
        let [x, y] = self.in_map([self.truth[0], self.truth[1]]);
        [x, y, self.truth[2]]
    }

    fn look(&self, beam: f64) -> (u16, f64) {
        let [x, y, theta] = self.truth;
        let way = [(theta + beam).cos(), (theta + beam).sin()];
        let ranges = WALLS.iter().map(|(rho, n)| (rho - n[0] * x - n[1] * y) / (n[0] * way[0] + n[1] * way[1]));
        let met = ranges.enumerate().filter(|(_, range)| *range > 0.0).min_by(|a, b| a.1.total_cmp(&b.1));
        met.map(|(wall, range)| (wall as u16, range)).expect("a room has walls all round")
    }

    /// A place in the frame of the start pose, which is the map.
    fn in_map(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x - self.start[0], y - self.start[1]]
    }

    /// How far a pose of the map is from the true one, metres.
    pub fn error_m(&self, pose: &Pose) -> f64 {
        let [x, y] = self.in_map([self.truth[0], self.truth[1]]);
        (f64::from(pose.x_m) - x).hypot(f64::from(pose.y_m) - y)
    }

    /// The same of dead reckoning.
    pub fn reckoned_error_m(&self) -> f64 {
        self.error_m(&self.reckoned)
    }

    /// The room's walls in the map: offset and normal.
    pub fn walls(&self) -> Vec<(f64, [f64; 2])> {
        WALLS.iter().map(|(rho, n)| (rho - n[0] * self.start[0] - n[1] * self.start[1], *n)).collect()
    }
}

fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let turn = angle.rem_euclid(TAU);
    if turn > PI { turn - TAU } else { turn }
}
