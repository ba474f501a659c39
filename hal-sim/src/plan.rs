//! A floor plan: what stands where in a simulated home.

use robot::{AreaKind, Bounds};

use crate::mishap::Mishaps;
use crate::pose::Pose2;

/// A flat piece of wall or furniture, seen from its left side (looking from `from_m` to `to_m`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// One end, metres.
    pub from_m: [f64; 2],
    /// The other end, metres.
    pub to_m: [f64; 2],
    /// Whether it is seen from its right side, too.
    pub two_sided: bool,
}

impl Face {
    /// Length, metres.
    pub fn length_m(&self) -> f64 {
        libm::hypot(self.to_m[0] - self.from_m[0], self.to_m[1] - self.from_m[1])
    }

    /// Unit normal towards the side from which the face is seen.
    pub fn normal(&self) -> [f64; 2] {
        let length_m = self.length_m();
        [-(self.to_m[1] - self.from_m[1]) / length_m, (self.to_m[0] - self.from_m[0]) / length_m]
    }

    /// The same face in the frame of `origin`, which is given in the face's frame.
    pub fn seen_from(&self, origin: &Pose2) -> Face {
        Face { from_m: origin.inverse_transform(self.from_m), to_m: origin.inverse_transform(self.to_m), ..*self }
    }
}

/// A round thing: a chair leg, a column, a flower pot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Centre, metres.
    pub centre_m: [f64; 2],
    /// Radius, metres.
    pub radius_m: f64,
}

/// A part of the home that a drive should visit: a rectangle along the plan's axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// What it is called.
    pub name: String,
    /// Lower corner, metres.
    pub min_m: [f64; 2],
    /// Upper corner, metres.
    pub max_m: [f64; 2],
}

impl Room {
    /// Whether a point lies in it.
    pub fn contains(&self, x_m: f64, y_m: f64) -> bool {
        (self.min_m[0]..=self.max_m[0]).contains(&x_m) && (self.min_m[1]..=self.max_m[1]).contains(&y_m)
    }
}

/// A door leaf that stands in its frame from one time to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Door {
    /// One end of the closed leaf, metres.
    pub from_m: [f64; 2],
    /// The other end, metres.
    pub to_m: [f64; 2],
    /// When it closes, seconds since the start.
    pub closes_at_s: f64,
    /// When it opens again, seconds since the start.
    pub opens_at_s: f64,
}

/// Somebody who walks to and fro along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Person {
    /// Radius as the sensors see it, metres.
    pub radius_m: f64,
    /// Walking speed, m/s.
    pub speed_mps: f64,
    /// Corners of the path, metres; at least one.
    pub path_m: Vec<[f64; 2]>,
    /// Whether they look where they go: before the robot they turn round. Others walk into it and push it aside.
    pub gives_way: bool,
}

impl Person {
    /// Length of the path, metres.
    fn length_m(&self) -> f64 {
        self.path_m.windows(2).map(|ends| libm::hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1])).sum()
    }

    /// How long they walk to be back where they were, seconds; positive.
    pub fn there_and_back_s(&self) -> f64 {
        (2.0 * self.length_m() / self.speed_mps).max(1e-3)
    }

    /// Where they are at a time (seconds since the start), metres.
    pub fn position(&self, time_s: f64) -> [f64; 2] {
        let legs = || self.path_m.windows(2).map(|p| (p[0], p[1], libm::hypot(p[1][0] - p[0][0], p[1][1] - p[0][1])));
        let length_m = self.length_m();
        let start_m = self.path_m.first().copied().unwrap_or_default();
        if length_m <= 0.0 {
            return start_m;
        }
        let phase_m = libm::fmod(self.speed_mps * time_s.max(0.0), 2.0 * length_m);
        let mut left_m = phase_m.min(2.0 * length_m - phase_m);
        for (from, to, leg_m) in legs() {
            if left_m <= leg_m && leg_m > 0.0 {
                let share = left_m / leg_m;
                return [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
            }
            left_m -= leg_m;
        }
        self.path_m.last().copied().unwrap_or(start_m)
    }
}

/// A rectangle without a floor, along the plan's axes: stairs going down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cliff {
    /// Lower corner, metres.
    pub min_m: [f64; 2],
    /// Upper corner, metres.
    pub max_m: [f64; 2],
}

/// Three lithium cells, and a charger in the dock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Battery {
    /// Charge at the start, 0 to 1.
    pub charge: f64,
    /// A full battery lasts so long out of the dock, minutes.
    pub lasts_min: f64,
    /// An empty one is full after so long in the dock, minutes.
    pub charges_min: f64,
}

/// A home and where the robot starts in it. Metres, in the plan's own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What it is called.
    pub name: String,
    /// The robot's start pose.
    pub start: Pose2,
    /// The robot's dock is there, which it looks into.
    pub has_dock: bool,
    /// The robot's battery; one that never empties, and is not measured, where not given.
    pub battery: Option<Battery>,
    /// Walls and flat sides of furniture.
    pub faces: Vec<Face>,
    /// Round things.
    pub rounds: Vec<Round>,
    /// Rooms to visit.
    pub rooms: Vec<Room>,
    /// Doors that close.
    pub doors: Vec<Door>,
    /// People.
    pub people: Vec<Person>,
    /// Places without a floor.
    pub cliffs: Vec<Cliff>,
    /// What befalls the robot.
    pub mishaps: Mishaps,
    /// Where it must not go, and what it is to clean.
    pub bounds: Bounds,
}

impl Plan {
    /// The edges of the areas that the robot must not go to, as if walls stood there.
    pub fn fences(&self) -> Vec<Face> {
        let point = |corner: &[f32; 2]| corner.map(f64::from);
        let edges = |corners: &[[f32; 2]]| -> Vec<Face> {
            let next = corners.iter().cycle().skip(1);
            let face = |(from, to)| Face { from_m: point(from), to_m: point(to), two_sided: true };
            corners.iter().zip(next).map(face).collect()
        };
        self.bounds.areas(AreaKind::KeepOut).flat_map(edges).collect()
    }

    /// Every face in the robot's start frame, in the order of [`Plan::faces`]: what a map can be compared with.
    pub fn faces_in_start_frame(&self) -> Vec<Face> {
        self.faces.iter().map(|face| face.seen_from(&self.start)).collect()
    }

    /// Every round thing in the robot's start frame.
    pub fn rounds_in_start_frame(&self) -> Vec<Round> {
        let moved = |r: &Round| Round { centre_m: self.start.inverse_transform(r.centre_m), ..*r };
        self.rounds.iter().map(moved).collect()
    }
}
