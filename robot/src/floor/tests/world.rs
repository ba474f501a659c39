//! The floor job in a world of walls, with a pose that is known exactly and beams without noise.

use super::*;
use core::f32::consts::FRAC_PI_2;
use std::collections::BTreeSet;
use std::vec;

/// From here to there, metres.
pub(super) type Wall = [[f32; 2]; 2];

pub(super) fn room(x0: f32, y0: f32, x1: f32, y1: f32) -> Vec<Wall> {
    let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
    (0..4).map(|corner| [corners[corner], corners[(corner + 1) % 4]]).collect()
}

/// A wall along x with doors of 0.9 m around these places.
fn wall_with_doors(y: f32, [x0, x1]: [f32; 2], doors: &[f32]) -> Vec<Wall> {
    let ends = doors.iter().flat_map(|door| [door - 0.45, door + 0.45]);
    let ends: Vec<f32> = [x0].into_iter().chain(ends).chain([x1]).collect();
    ends.chunks(2).map(|ends| [[ends[0], y], [ends[1], y]]).collect()
}

/// How far along a beam from here in this direction the wall is, metres.
fn hit_m(from: [f32; 2], direction: [f32; 2], wall: &Wall) -> Option<f32> {
    let cross = |a: [f32; 2], b: [f32; 2]| a[0] * b[1] - a[1] * b[0];
    let minus = |a: [f32; 2], b: [f32; 2]| [a[0] - b[0], a[1] - b[1]];
    let (along, to) = (minus(wall[1], wall[0]), minus(wall[0], from));
    let across = cross(direction, along);
    let (at_m, share) = (cross(to, along) / across, cross(to, direction) / across);
    (across.abs() > 1e-9 && at_m > 0.0 && (0.0..=1.0).contains(&share)).then_some(at_m)
}

/// The point of a wall that is nearest to this one, and how far that is, metres.
fn nearest([x, y]: [f32; 2], [a, b]: &Wall) -> ([f32; 2], f32) {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let share = (((x - a[0]) * along[0] + (y - a[1]) * along[1]) / square.max(1e-9)).clamp(0.0, 1.0);
    let point = [a[0] + share * along[0], a[1] + share * along[1]];
    (point, slam_core::pose::length(x - point[0], y - point[1]))
}

/// A square of ten centimetres by its centre, in tenths of a metre.
type Square = [i16; 2];

/// The robot in its world.
pub(super) struct World {
    walls: Vec<Wall>,
    pub job: FloorJob<8>,
    pub at: Pose,
    pub seconds: u64,
    swept: BTreeSet<Square>,
}

impl World {
    /// At the origin.
    pub(super) fn new(walls: Vec<Wall>) -> Self {
        let job = FloorJob::new(FloorConfig::default(), &crate::rig::default_rig());
        Self { walls, job, at: Pose::ORIGIN, seconds: 0, swept: BTreeSet::new() }
    }

    fn senses(&self, time_us: u64) -> Senses<8> {
        let range_m = |beam: &Beam| {
            let ([x0, y0], [x1, y1]) = (self.at.transform(beam.mount_m), self.at.transform(beam.point_m(1.0)));
            let hits = self.walls.iter().filter_map(|wall| hit_m([x0, y0], [x1 - x0, y1 - y0], wall));
            hits.min_by(f32::total_cmp).filter(|range_m| (beam.min_m..=beam.max_m).contains(range_m))
        };
        let mut contacts = Contacts::default();
        for (point, off_m) in self.walls.iter().map(|wall| nearest([self.at.x_m, self.at.y_m], wall)) {
            let [x, y] = self.at.inverse().transform(point);
            let bearing_rad = libm::atan2f(y, x);
            let is_touched = off_m < 0.1705 && bearing_rad.abs() < FRAC_PI_2;
            contacts.bump_left |= is_touched && bearing_rad > -0.2;
            contacts.bump_right |= is_touched && bearing_rad < 0.2;
        }
        let mut ranges_m = [None; 8];
        ranges_m.iter_mut().zip(&self.job.beams).for_each(|(range, beam)| *range = range_m(beam));
        Senses { time_us, pose: self.at, ranges_m, contacts, condition: Condition::default() }
    }

    fn step(&mut self, time_us: u64) {
        let senses = self.senses(time_us);
        let WheelSpeeds { left_mps, right_mps } = senses.contacts.guard(self.job.step(&senses));
        let [ahead_m, turn_rad] = [0.02 * (left_mps + right_mps), 0.04 * (right_mps - left_mps) / 0.235];
        let to = self.at.compose(&Pose::new(ahead_m, 0.0, turn_rad));
        let mut centre = [to.x_m, to.y_m];
        // Whatever it runs into stops it: in a corner both walls do.
        for wall in self.walls.iter().chain(&self.walls) {
            let (point, off_m) = nearest(centre, wall);
            let out = (0.17 / off_m.max(1e-4)).max(1.0);
            centre = [0, 1].map(|axis| point[axis] + out * (centre[axis] - point[axis]));
        }
        self.at = Pose { x_m: centre[0], y_m: centre[1], theta_rad: to.theta_rad };
        let [col, row] = centre.map(|value| (10.0 * value).round() as i16);
        let near = (-2..=2).flat_map(|cols| (-2..=2).map(move |rows| [col + cols, row + rows]));
        let is_under_brush = |square: &Square| {
            let [x_m, y_m] = square.map(|index| 0.1 * f32::from(index));
            slam_core::pose::length(x_m - centre[0], y_m - centre[1]) < 0.5 * BRUSH_M
        };
        self.swept.extend(near.filter(is_under_brush));
    }

    /// Drives until the job is over, or for so many hours.
    pub(super) fn drive(&mut self, hours: u64) {
        for second in self.seconds..self.seconds + 3600 * hours {
            (0..25).for_each(|step| self.step(1_000_000 * second + 40_000 * step));
            self.seconds = second + 1;
            if second == 2 {
                self.job.align(0.0);
            }
            if self.job.is_over() {
                return;
            }
        }
    }

    /// Where the robot's centre can be.
    fn reachable(&self) -> BTreeSet<Square> {
        let has_room = |square: Square| {
            let centre = square.map(|index| 0.1 * f32::from(index));
            self.walls.iter().all(|wall| nearest(centre, wall).1 > 0.18)
        };
        let (mut reached, mut front) = (BTreeSet::from([[0, 0]]), vec![[0, 0]]);
        while let Some([col, row]) = front.pop() {
            let beside = [[col + 1, row], [col - 1, row], [col, row + 1], [col, row - 1]];
            front.extend(beside.into_iter().filter(|square| has_room(*square) && reached.insert(*square)));
        }
        reached
    }

    /// The share of it that the brush came to, and the path under the brush over that floor.
    pub(super) fn score(&self) -> [f32; 2] {
        let reachable = self.reachable();
        let swept = reachable.intersection(&self.swept).count() as f32;
        [swept / reachable.len() as f32, BRUSH_M * self.job.path_m / (0.01 * swept)]
    }

    /// How far it is from where it started, metres.
    pub(super) fn off_m(&self) -> f32 {
        slam_core::pose::length(self.at.x_m, self.at.y_m)
    }
}

/// Homes that do not fit in the picture, which is 12.5 m wide.
fn larger() -> [(&'static str, Vec<Wall>); 8] {
    // A corridor with four rooms on either side.
    let mut flat = room(-10.0, -6.0, 10.0, 6.0);
    flat.extend(wall_with_doors(-0.8, [-10.0, 10.0], &[-8.0, -3.0, 3.0, 8.0]));
    flat.extend(wall_with_doors(0.8, [-10.0, 10.0], &[-7.0, -2.0, 2.0, 7.0]));
    flat.extend([-5.0, 0.0, 5.0].iter().flat_map(|x| [[[*x, -6.0], [*x, -0.8]], [[*x, 0.8], [*x, 6.0]]]));
    let mut ring = room(-1.0, -1.0, 16.0, 16.0);
    ring.extend(room(1.0, 1.0, 14.0, 14.0));
    // Two rooms side by side that meet at the far end.
    let mut back = room(-1.0, -1.0, 17.0, 5.2);
    back.push([[-1.0, 2.1], [15.5, 2.1]]);
    let corners = [[-1.0, -1.0], [15.0, -1.0], [15.0, 2.0], [2.0, 2.0], [2.0, 15.0], [-1.0, 15.0], [-1.0, -1.0]];
    let bent = corners.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let mut row = room(-1.0, -1.0, 19.0, 3.0);
    row.extend([3.0, 7.0, 11.0, 15.0].iter().flat_map(|x| [[[*x, -1.0], [*x, 0.5]], [[*x, 1.4], [*x, 3.0]]]));
    [
        ("flat of 20 x 12 m", flat),
        ("ring of 17 m", ring),
        ("there and back, 18 m", back),
        ("bent, 16 x 16 m", bent),
        ("five rooms in a row, 20 m", row),
        ("corridor of 24 m, from its middle", room(-12.0, -1.0, 12.0, 2.0)),
        ("corridor of 18 m, from its end", room(-1.0, -1.0, 17.0, 1.5)),
        ("hall of 14 x 14 m", room(-1.0, -1.0, 13.0, 13.0)),
    ]
}

#[test]
fn a_home_that_is_larger_than_the_picture_is_swept_and_the_robot_comes_back() {
    for (name, walls) in larger() {
        let mut world = World::new(walls);
        world.drive(4);
        let ([swept, overlap], off_m, minutes) = (world.score(), world.off_m(), world.seconds / 60);
        std::println!("{name}: {swept:.3} swept, overlap {overlap:.2}, {minutes} min, {off_m:.2} m from its start");
        assert_eq!(world.job.state(), FloorState::Done, "{name}: after {minutes} min");
        assert!(swept > 0.98 && overlap < 1.8 && off_m < 0.05, "{name}: {swept} {overlap} {off_m}");
    }
}
