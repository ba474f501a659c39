//! Ray casting and contact in a floor plan.

use crate::inside::is_inside;
use crate::plan::{Door, Face, Person, Plan};

/// Where a beam ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the beam, metres.
    pub range_m: f64,
    /// Cosine of the angle between beam and surface normal.
    pub cos_incidence: f64,
    /// Index into [`Plan::faces`]; none for round things, door leaves and people.
    pub face: Option<usize>,
}

/// A place where the body touches something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// From the touched thing to the body's centre, unit length.
    pub away: [f64; 2],
    /// How deep the body is in it, metres.
    pub depth_m: f64,
}

/// A plan laid out for speed: one array per coordinate, static things first.
#[derive(Clone, Debug, Default)]
pub struct World {
    from_x: Vec<f64>,
    from_y: Vec<f64>,
    along_x: Vec<f64>,
    along_y: Vec<f64>,
    faces: usize,
    centre_x: Vec<f64>,
    centre_y: Vec<f64>,
    radius: Vec<f64>,
    rounds: usize,
    doors: Vec<Door>,
    people: Vec<Person>,
    /// How far each of them is ahead of the time, seconds: who turned round is elsewhere on the path.
    ahead_s: Vec<f64>,
    /// What closes the home in, if something does, and the boxes in it.
    closed: Vec<Face>,
    closes_in: bool,
}

/// A body that something pushed out of a wall touches it to this, metres.
const ROUNDING_M: f64 = 1e-9;

/// A body is pressed into something where it is so deep in it, metres, and by whoever is this near to it.
const WEDGED_M: f64 = 0.002;
const TOUCH_M: f64 = 0.02;

/// Who gives way turns round so near to the robot, metres, where they would be nearer so much later, seconds.
const SEES_M: f64 = 0.1;
const SOON_S: f64 = 0.1;

/// Beams and surfaces nearer to parallel than this do not meet.
const PARALLEL: f64 = 1e-12;

impl World {
    /// The plan at time 0.
    pub fn new(plan: &Plan) -> Self {
        let mut world = World {
            doors: plan.doors.clone(),
            people: plan.people.clone(),
            ahead_s: vec![0.0; plan.people.len()],
            faces: plan.faces.len(),
            closed: plan.faces.iter().filter(|face| !face.two_sided).copied().collect(),
            closes_in: plan.closes_in(),
            ..World::default()
        };
        for face in &plan.faces {
            world.push_segment(face.from_m, face.to_m);
        }
        for round in &plan.rounds {
            world.push_disc(round.centre_m, round.radius_m);
        }
        world.rounds = plan.rounds.len();
        world.set_time(0.0);
        world
    }

    /// This world in the place of another one at this time (seconds since the start): people who are in both go on as they walked.
    pub fn in_place_of(mut self, other: &World, time_s: f64) -> Self {
        for (person, ahead_s) in self.people.iter().zip(&mut self.ahead_s) {
            let same = other.people.iter().zip(&other.ahead_s).find(|(old, _)| *old == person);
            *ahead_s = same.map_or(0.0, |(_, ahead_s)| *ahead_s);
        }
        self.set_time(time_s);
        self
    }

    /// Where each of the people is, metres, and their radii.
    pub fn people(&self) -> impl Iterator<Item = ([f64; 2], f64)> + '_ {
        let discs = self.centre_x.iter().zip(&self.centre_y).zip(&self.radius).skip(self.rounds);
        discs.map(|((x_m, y_m), radius_m)| ([*x_m, *y_m], *radius_m))
    }

    /// Whether a point is in the home, and not in a box.
    pub fn is_inside(&self, point_m: [f64; 2]) -> bool {
        is_inside(&self.closed, self.closes_in, point_m)
    }

    fn push_segment(&mut self, from_m: [f64; 2], to_m: [f64; 2]) {
        self.from_x.push(from_m[0]);
        self.from_y.push(from_m[1]);
        self.along_x.push(to_m[0] - from_m[0]);
        self.along_y.push(to_m[1] - from_m[1]);
    }

    fn push_disc(&mut self, centre_m: [f64; 2], radius_m: f64) {
        self.centre_x.push(centre_m[0]);
        self.centre_y.push(centre_m[1]);
        self.radius.push(radius_m);
    }

    /// Whether nothing in it ever moves.
    pub fn is_static(&self) -> bool {
        self.doors.is_empty() && self.people.is_empty()
    }

    /// Moves doors and people to where they are at this time (seconds since the start).
    pub fn set_time(&mut self, time_s: f64) {
        if self.is_static() {
            return;
        }
        for array in [&mut self.from_x, &mut self.from_y, &mut self.along_x, &mut self.along_y] {
            array.truncate(self.faces);
        }
        for array in [&mut self.centre_x, &mut self.centre_y, &mut self.radius] {
            array.truncate(self.rounds);
        }
        for i in 0..self.doors.len() {
            let door = self.doors[i];
            if (door.closes_at_s..door.opens_at_s).contains(&time_s) {
                self.push_segment(door.from_m, door.to_m);
            }
        }
        for i in 0..self.people.len() {
            let (position_m, radius_m) = (self.people[i].position(time_s + self.ahead_s[i]), self.people[i].radius_m);
            self.push_disc(position_m, radius_m);
        }
    }

    /// Lets people turn round from this time on (seconds since the start): who gives way, where a round body at this place is just
    /// before them; everybody, where they press it into something, for nobody walks a robot through a wall. Whether they pressed it.
    pub fn turn_round(&mut self, centre_m: [f64; 2], radius_m: f64, time_s: f64) -> bool {
        let is_wedged = !self.people.is_empty() && self.clearance_m(centre_m) < radius_m - WEDGED_M;
        let mut is_pressed = false;
        for (person, ahead_s) in self.people.iter().zip(&mut self.ahead_s) {
            let gap_m = |time_s: f64| {
                let [x_m, y_m] = person.position(time_s);
                libm::hypot(centre_m[0] - x_m, centre_m[1] - y_m) - radius_m - person.radius_m
            };
            let now_s = time_s + *ahead_s;
            let presses = is_wedged && gap_m(now_s) < TOUCH_M;
            let sees = person.gives_way && gap_m(now_s) < SEES_M && gap_m(now_s + SOON_S) < gap_m(now_s);
            if presses || sees {
                *ahead_s = (-now_s).rem_euclid(person.there_and_back_s()) - time_s;
            }
            is_pressed |= presses;
        }
        is_pressed
    }

    /// The first thing that a beam from `origin_m` in the unit direction `beam` meets.
    pub fn cast(&self, origin_m: [f64; 2], beam: [f64; 2]) -> Option<Hit> {
        let mut nearest_m = f64::INFINITY;
        let mut segment = usize::MAX;
        let segments = self.from_x.iter().zip(&self.from_y).zip(self.along_x.iter().zip(&self.along_y));
        for (i, ((&fx, &fy), (&ax, &ay))) in segments.enumerate() {
            let cross = beam[0] * ay - beam[1] * ax;
            let (dx, dy) = (fx - origin_m[0], fy - origin_m[1]);
            // Along the beam: t / cross; along the segment: u / cross. Compared without dividing.
            let sign = if cross < 0.0 { -1.0 } else { 1.0 };
            let (cross, t, u) = (sign * cross, sign * (dx * ay - dy * ax), sign * (dx * beam[1] - dy * beam[0]));
            if cross > PARALLEL && t >= 0.0 && u >= 0.0 && u <= cross && t < nearest_m * cross {
                nearest_m = t / cross;
                segment = i;
            }
        }
        let mut disc = usize::MAX;
        for i in 0..self.radius.len() {
            let (dx, dy) = (self.centre_x[i] - origin_m[0], self.centre_y[i] - origin_m[1]);
            let ahead = dx * beam[0] + dy * beam[1];
            let aside = dx * beam[1] - dy * beam[0];
            let half_square = self.radius[i] * self.radius[i] - aside * aside;
            if ahead <= 0.0 || half_square <= 0.0 {
                continue;
            }
            let range_m = (ahead - libm::sqrt(half_square)).max(0.0);
            if range_m < nearest_m {
                nearest_m = range_m;
                disc = i;
            }
        }
        self.describe(origin_m, beam, nearest_m, segment, disc)
    }

    fn describe(&self, origin_m: [f64; 2], beam: [f64; 2], range_m: f64, segment: usize, disc: usize) -> Option<Hit> {
        if disc != usize::MAX {
            let nx = (origin_m[0] + range_m * beam[0] - self.centre_x[disc]) / self.radius[disc];
            let ny = (origin_m[1] + range_m * beam[1] - self.centre_y[disc]) / self.radius[disc];
            let cos_incidence = (nx * beam[0] + ny * beam[1]).abs().min(1.0);
            return Some(Hit { range_m, cos_incidence, face: None });
        }
        if segment == usize::MAX {
            return None;
        }
        let (ax, ay) = (self.along_x[segment], self.along_y[segment]);
        let cos_incidence = ((beam[0] * ay - beam[1] * ax) / libm::sqrt(ax * ax + ay * ay)).abs().min(1.0);
        Some(Hit { range_m, cos_incidence, face: (segment < self.faces).then_some(segment) })
    }

    /// Distance from a point to the nearest thing (negative inside a round one), and the unit vector away from it.
    fn nearest(&self, point_m: [f64; 2]) -> (f64, [f64; 2]) {
        let mut best = (f64::INFINITY, [1.0, 0.0]);
        let mut offer = |dx: f64, dy: f64, radius: f64| {
            let centre_distance = libm::sqrt(dx * dx + dy * dy);
            if centre_distance - radius < best.0 {
                let scale = 1.0 / centre_distance.max(1e-12);
                best = (centre_distance - radius, [dx * scale, dy * scale]);
            }
        };
        for i in 0..self.from_x.len() {
            let (ax, ay) = (self.along_x[i], self.along_y[i]);
            let (px, py) = (point_m[0] - self.from_x[i], point_m[1] - self.from_y[i]);
            let share = ((px * ax + py * ay) / (ax * ax + ay * ay).max(1e-18)).clamp(0.0, 1.0);
            offer(px - share * ax, py - share * ay, 0.0);
        }
        for i in 0..self.radius.len() {
            offer(point_m[0] - self.centre_x[i], point_m[1] - self.centre_y[i], self.radius[i]);
        }
        best
    }

    /// How far from the nearest thing a round body would be that does not fit here, metres; none where it fits, be it that it touches something.
    pub fn blocked_m(&self, centre_m: [f64; 2], radius_m: f64) -> Option<f64> {
        let clearance_m = self.clearance_m(centre_m);
        (clearance_m < radius_m - ROUNDING_M).then_some(clearance_m)
    }

    /// Distance from a point to the nearest thing, metres.
    pub fn clearance_m(&self, point_m: [f64; 2]) -> f64 {
        self.nearest(point_m).0
    }

    /// What a round body at this place is in, deepest first.
    pub fn touch(&self, centre_m: [f64; 2], radius_m: f64) -> Option<Touch> {
        let (distance_m, away) = self.nearest(centre_m);
        (distance_m < radius_m).then_some(Touch { away, depth_m: radius_m - distance_m })
    }
}
