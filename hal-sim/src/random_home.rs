//! Homes drawn at random: rooms with doors between them, furniture along the walls, tables on legs. For tests of what must not
//! depend on the homes at hand.

use crate::floor::FloorRaster;
use crate::mishap::{HANGS_S, Sill, free_place};
use crate::options::SimOptions;
use crate::plan::{Door, Face, Person, Plan, Room, Round};
use crate::pose::Pose2;
use crate::rig::BODY_RADIUS_M;
use crate::rng::Rng;
use crate::world::World;

/// Thickness of walls between rooms, metres.
const WALL_M: f64 = 0.1;

/// A room is at least this long on each side, metres.
const ROOM_M: f64 = 2.2;

/// Way that is left free beside doors and between pieces of furniture, metres.
const WAY_M: f64 = 0.55;

/// Somebody walks so far from what stands there, metres.
const LEGS_M: f64 = 0.2;

/// A robot in a dock stands so far before the wall, metres.
const DOCK_DEPTH_M: f64 = 0.015;

/// Way that is left free beside a robot that comes to a dock, metres.
const BESIDE_DOCK_M: f64 = 0.05;

/// Draws of a place until there is none.
const DRAWS: usize = 40;

/// A rectangle, metres.
#[derive(Clone, Copy, Debug)]
struct Area {
    min_m: [f64; 2],
    max_m: [f64; 2],
}

impl Area {
    fn size_m(&self, axis: usize) -> f64 {
        self.max_m[axis] - self.min_m[axis]
    }

    fn grown(&self, by_m: f64) -> Self {
        Self { min_m: self.min_m.map(|low| low - by_m), max_m: self.max_m.map(|high| high + by_m) }
    }

    fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.min_m[axis] < other.max_m[axis] && other.min_m[axis] < self.max_m[axis])
    }

    /// The four sides, clockwise, so that each is seen from outside.
    fn faces(&self) -> [Face; 4] {
        let ([x0, y0], [x1, y1]) = (self.min_m, self.max_m);
        let corners = [[x0, y0], [x0, y1], [x1, y1], [x1, y0]];
        [0, 1, 2, 3].map(|i| Face { from_m: corners[i], to_m: corners[(i + 1) % 4], two_sided: false })
    }
}

/// A home as it is drawn.
struct Draft {
    rng: Rng,
    whole: Area,
    rooms: Vec<Area>,
    /// Openings in walls.
    doors: Vec<Area>,
    solid: Vec<Area>,
    furniture: Vec<Area>,
    legs: Vec<Round>,
}

/// The home of this seed: 12 to 60 m^2, up to six rooms.
pub fn random_home(seed: u64) -> Plan {
    Draft::rooms(seed).furnished(seed)
}

/// The large home of this seed: 80 to 200 m^2, up to 18 m long, in rooms of 12 to 30 m^2.
pub fn large_home(seed: u64) -> Plan {
    let mut rng = Rng::stream(seed, "large home", 0);
    let size_m = [rng.uniform(13.0, 18.0), rng.uniform(6.5, 11.0)];
    let rooms = size_m[0] * size_m[1] / rng.uniform(12.0, 30.0);
    Plan { name: format!("large-{seed}"), ..Draft::divided(rng, size_m, rooms as usize).furnished(seed) }
}

/// One of the doors of the random home of this seed, drawn, its leaf shut between these times (seconds since the start); none in a home of
/// one room.
pub fn shut_door(seed: u64, closes_at_s: f64, opens_at_s: f64) -> Option<Door> {
    let doors = Draft::rooms(seed).doors;
    let Area { min_m, max_m } = *doors.get((Rng::stream(seed, "door", 0).unit() * doors.len() as f64) as usize)?;
    // In the middle of the wall.
    let thin = usize::from(max_m[1] - min_m[1] < max_m[0] - min_m[0]);
    let (mut from_m, mut to_m) = (min_m, max_m);
    from_m[thin] += 0.5 * WALL_M;
    to_m[thin] -= 0.5 * WALL_M;
    Some(Door { from_m, to_m, closes_at_s, opens_at_s })
}

/// A sill in each door of the random home of this seed, over which a wheel hangs for as long as it takes to drive ten centimetres.
pub fn sills(seed: u64) -> Vec<Sill> {
    let sill = |door: &Area| Sill { min_m: door.min_m, max_m: door.max_m, hangs_s: HANGS_S };
    Draft::rooms(seed).doors.iter().map(sill).collect()
}

/// Somebody who walks to and fro between three places of a home, a metre apart at least, drawn from a seed; the first of them is
/// a metre from where the robot starts. None where there are no such places that a straight way leads between.
pub fn somebody(plan: &Plan, seed: u64, gives_way: bool) -> Option<Person> {
    let mut rng = Rng::stream(seed, "somebody", 0);
    let world = World::new(plan);
    let is_way = |from_m: [f64; 2], to_m: [f64; 2]| {
        (0..=40).all(|index| {
            let share = f64::from(index) / 40.0;
            world.clearance_m([0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]))) > LEGS_M
        })
    };
    let mut path_m: Vec<[f64; 2]> = Vec::new();
    for _ in 0..10_000 {
        let place = free_place(&plan.rooms, &mut rng, &world, &SimOptions::default())?;
        let to_m = [place.x_m, place.y_m];
        let is_next =
            |from_m: &[f64; 2]| libm::hypot(to_m[0] - from_m[0], to_m[1] - from_m[1]) > 1.0 && is_way(*from_m, to_m);
        let is_far = || libm::hypot(to_m[0] - plan.start.x_m, to_m[1] - plan.start.y_m) > 1.0;
        if path_m.last().map_or_else(is_far, is_next) {
            path_m.push(to_m);
        }
        if path_m.len() == 3 {
            return Some(Person { radius_m: 0.15, speed_mps: 0.5, path_m, gives_way });
        }
    }
    None
}

/// A place where somebody sets the robot down, and its heading there: the body has room, and as much floor can be reached from there as from
/// the start. None where there is none.
pub fn elsewhere(plan: &Plan, rng: &mut Rng) -> Option<Pose2> {
    let world = World::new(plan);
    let reached_m2 = floor_m2(plan, plan.start);
    (0..DRAWS).find_map(|_| {
        let place = free_place(&plan.rooms, rng, &world, &SimOptions::default())?;
        reaches_as_much(floor_m2(plan, place), reached_m2).then_some(place)
    })
}

/// The floor that a robot can sweep from a start, m^2.
fn floor_m2(plan: &Plan, start: Pose2) -> f64 {
    FloorRaster::new(plan, BODY_RADIUS_M, start).score().floor_m2
}

/// Whether that is the same floor: next to the wall of a dock a little less can be reached.
fn reaches_as_much(floor_m2: f64, than_m2: f64) -> bool {
    (floor_m2 / than_m2 - 1.0).abs() < 0.05
}

/// A home whose robot starts in a dock at a wall, drawn from a seed: along it and for a metre behind the robot the floor is free, and as much
/// can be reached from there as from the start of before. None where no wall has such a place.
pub fn with_dock(plan: &Plan, seed: u64) -> Option<Plan> {
    let (mut rng, world) = (Rng::stream(seed, "dock", 0), World::new(plan));
    let reached_m2 = floor_m2(plan, plan.start);
    (0..10_000).find_map(|_| {
        let face = plan.faces.get(rng.uniform(0.0, plan.faces.len() as f64) as usize)?;
        let along_m = [0, 1].map(|axis| face.to_m[axis] - face.from_m[axis]);
        let share = rng.uniform(0.0, 1.0);
        let turn = if rng.uniform(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 };
        let to_rad = libm::atan2(turn * along_m[0], -turn * along_m[1]);
        let (s, c) = libm::sincos(to_rad);
        let from_wall = |far_m: f64| {
            let foot_m = [0, 1].map(|axis| face.from_m[axis] + share * along_m[axis]);
            Pose2::new(foot_m[0] - far_m * c, foot_m[1] - far_m * s, to_rad)
        };
        let start = from_wall(BODY_RADIUS_M + DOCK_DEPTH_M);
        let clear_m = |pose: Pose2| world.clearance_m([pose.x_m, pose.y_m]);
        let is_free = clear_m(start) > BODY_RADIUS_M
            && (4..=10).all(|tenths| clear_m(from_wall(0.1 * f64::from(tenths))) > BODY_RADIUS_M + BESIDE_DOCK_M);
        (is_free && reaches_as_much(floor_m2(plan, from_wall(0.6)), reached_m2)).then(|| Plan {
            start,
            has_dock: true,
            ..plan.clone()
        })
    })
}

impl Draft {
    /// The rooms of the home of this seed, and the doors between them.
    fn rooms(seed: u64) -> Self {
        let mut rng = Rng::stream(seed, "home", 0);
        let size_m = [rng.uniform(4.0, 9.0), rng.uniform(3.0, 6.5)];
        let rooms = 1 + (rng.unit() * (size_m[0] * size_m[1] / 9.0)) as usize;
        Self::divided(rng, size_m, rooms.min(6))
    }

    /// A home of this size in so many rooms at most.
    fn divided(rng: Rng, size_m: [f64; 2], rooms: usize) -> Self {
        let whole = Area { min_m: [0.0; 2], max_m: size_m };
        let mut draft = Self {
            rng,
            whole,
            rooms: vec![whole],
            doors: Vec::new(),
            solid: Vec::new(),
            furniture: Vec::new(),
            legs: Vec::new(),
        };
        for _ in 0..DRAWS {
            if draft.rooms.len() < rooms {
                draft.divide();
            }
        }
        draft
    }

    /// The same with furniture, and where the robot starts.
    fn furnished(mut self, seed: u64) -> Plan {
        for room in 0..self.rooms.len() {
            self.furnish(room);
        }
        self.finish(seed)
    }

    /// Divides the largest room by a wall with a door, if that leaves its doors and those of its neighbours free.
    fn divide(&mut self) {
        let area_m2 = |room: &Area| room.size_m(0) * room.size_m(1);
        let Some(index) =
            (0..self.rooms.len()).max_by(|&a, &b| area_m2(&self.rooms[a]).total_cmp(&area_m2(&self.rooms[b])))
        else {
            return;
        };
        let room = self.rooms[index];
        let axis = usize::from(room.size_m(1) > room.size_m(0));
        let across = 1 - axis;
        if room.size_m(axis) < 2.0 * ROOM_M + WALL_M {
            return;
        }
        let at_m = self.rng.uniform(room.min_m[axis] + ROOM_M, room.max_m[axis] - ROOM_M - WALL_M);
        let (mut wall, mut low, mut high) = (room, room, room);
        (wall.min_m[axis], wall.max_m[axis]) = (at_m, at_m + WALL_M);
        (low.max_m[axis], high.min_m[axis]) = (at_m, at_m + WALL_M);
        if self.doors.iter().any(|door| door.grown(0.3).overlaps(&wall)) {
            return;
        }
        let width_m = self.rng.uniform(0.75, 0.9);
        let from_m = self.rng.uniform(room.min_m[across] + 0.15, room.max_m[across] - 0.15 - width_m);
        let (mut before, mut after, mut door) = (wall, wall, wall);
        (before.max_m[across], after.min_m[across]) = (from_m, from_m + width_m);
        (door.min_m[across], door.max_m[across]) = (from_m, from_m + width_m);
        self.solid.extend([before, after]);
        self.doors.push(door);
        self.rooms[index] = low;
        self.rooms.push(high);
    }

    /// Puts furniture along a room's walls, and perhaps a table into it.
    fn furnish(&mut self, room: usize) {
        let room = self.rooms[room];
        let pieces = (room.size_m(0) * room.size_m(1) / 4.0 * self.rng.uniform(0.5, 1.2)) as usize;
        for _ in 0..pieces {
            let place = (0..DRAWS).find_map(|_| {
                let piece = self.along_wall(&room);
                self.is_free(&piece).then_some(piece)
            });
            self.furniture.extend(place);
        }
        if self.rng.unit() < 0.5 {
            self.put_table(&room);
        }
    }

    fn along_wall(&mut self, room: &Area) -> Area {
        let axis = usize::from(self.rng.unit() < 0.5);
        let across = 1 - axis;
        let length_m = self.rng.uniform(0.5, 2.0).min(0.6 * room.size_m(axis));
        let depth_m = self.rng.uniform(0.3, 0.8).min(0.3 * room.size_m(across));
        let from_m = self.rng.uniform(room.min_m[axis], room.max_m[axis] - length_m);
        let mut piece = *room;
        (piece.min_m[axis], piece.max_m[axis]) = (from_m, from_m + length_m);
        if self.rng.unit() < 0.5 {
            piece.max_m[across] = room.min_m[across] + depth_m;
        } else {
            piece.min_m[across] = room.max_m[across] - depth_m;
        }
        piece
    }

    fn is_free(&self, piece: &Area) -> bool {
        let apart = |others: &[Area]| !others.iter().any(|other| other.grown(WAY_M).overlaps(piece));
        apart(&self.doors) && apart(&self.furniture)
    }

    /// A table on four legs, a way from everything.
    fn put_table(&mut self, room: &Area) {
        let size_m = [self.rng.uniform(0.7, 1.4), self.rng.uniform(0.6, 0.9)];
        if (0..2).any(|axis| room.size_m(axis) < size_m[axis] + 2.0 * WAY_M) {
            return;
        }
        let radius_m = self.rng.uniform(0.02, 0.035);
        let place = (0..DRAWS).find_map(|_| {
            let min_m =
                [0, 1].map(|axis| self.rng.uniform(room.min_m[axis] + WAY_M, room.max_m[axis] - WAY_M - size_m[axis]));
            let table = Area { min_m, max_m: [min_m[0] + size_m[0], min_m[1] + size_m[1]] };
            self.is_free(&table).then_some(table)
        });
        let Some(table) = place else { return };
        self.furniture.push(table);
        let corners = table.faces().map(|face| face.from_m);
        self.legs.extend(corners.map(|centre_m| Round { centre_m, radius_m }));
    }

    fn finish(mut self, seed: u64) -> Plan {
        let whole = self.whole;
        let ([x0, y0], [x1, y1]) = (whole.min_m, whole.max_m);
        let outline = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        let mut faces: Vec<Face> =
            (0..4).map(|i| Face { from_m: outline[i], to_m: outline[(i + 1) % 4], two_sided: false }).collect();
        let is_table = |piece: &Area| self.legs.iter().any(|leg| leg.centre_m == piece.min_m);
        let boxes = self.furniture.iter().filter(|piece| !is_table(piece));
        faces.extend(self.solid.iter().chain(boxes).flat_map(Area::faces));
        let named = |(i, room): (usize, &Area)| Room { name: format!("{i}"), min_m: room.min_m, max_m: room.max_m };
        let rooms = self.rooms.iter().enumerate().map(named).collect();
        let mut plan = Plan {
            name: format!("random-{seed}"),
            start: Pose2::default(),
            has_dock: false,
            battery: None,
            faces,
            rounds: self.legs,
            rooms,
            doors: Vec::new(),
            people: Vec::new(),
            cliffs: Vec::new(),
            mishaps: crate::Mishaps::default(),
            bounds: robot::Bounds::default(),
        };
        let world = World::new(&plan);
        // A quarter of a metre beside the body: between its walls every room has that somewhere.
        let start = (0..10_000).find_map(|_| {
            let [x_m, y_m] = [0, 1].map(|axis| self.rng.uniform(whole.min_m[axis], whole.max_m[axis]));
            let is_within = self.rooms.iter().any(|room| {
                let here = Area { min_m: [x_m, y_m], max_m: [x_m, y_m] };
                room.overlaps(&here) && !self.furniture.iter().any(|piece| piece.overlaps(&here))
            });
            (is_within && world.clearance_m([x_m, y_m]) > 0.42).then_some([x_m, y_m])
        });
        let [x_m, y_m] = start.unwrap_or([0.5 * x1, 0.5 * y1]);
        plan.start = Pose2::new(x_m, y_m, self.rng.uniform(-core::f64::consts::PI, core::f64::consts::PI));
        plan
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn homes_differ_and_a_robot_can_drive_in_most_of_their_rooms() {
        for seed in 1..=40 {
            let plan = random_home(seed);
            assert_eq!(plan, random_home(seed));
            assert_ne!(plan.faces, random_home(seed + 1).faces);
            let world = World::new(&plan);
            assert!(world.clearance_m([plan.start.x_m, plan.start.y_m]) > 0.17, "{seed}");
            let floor_m2 = FloorRaster::new(&plan, 0.17, plan.start).score().floor_m2;
            let rooms_m2: f64 =
                plan.rooms.iter().map(|room| (room.max_m[0] - room.min_m[0]) * (room.max_m[1] - room.min_m[1])).sum();
            assert!(floor_m2 > 0.5 * rooms_m2, "{seed}: {floor_m2} of {rooms_m2} m2");
        }
    }

    #[test]
    fn a_robot_is_set_down_on_the_floor_that_it_swept() {
        // Beyond a wall there is a place that nothing leads to.
        let text = "[start]\nx_m = 1.0\ny_m = 1.0\n[[room]]\nname = \"here\"\nmin_m = [0.0, 0.0]\nmax_m = [11.0, 3.0]\n\
            [[room]]\nname = \"beyond\"\nmin_m = [11.1, 0.0]\nmax_m = [12.0, 3.0]\n\
            [[outline]]\npoints_m = [[0.0, 0.0], [12.0, 0.0], [12.0, 3.0], [0.0, 3.0]]\n\
            [[box]]\nmin_m = [11.0, 0.0]\nmax_m = [11.1, 3.0]\n";
        let plan = crate::plan_file::parse("home.toml", "home", text).expect("a plan");
        let (mut rng, world) = (Rng::stream(48, "places", 0), World::new(&plan));
        let from_m2 = |place: Option<Pose2>| floor_m2(&plan, place.expect("there is room"));
        let least = |from_m2: &mut dyn FnMut() -> f64| (0..16).map(|_| from_m2()).fold(f64::INFINITY, f64::min);
        let anywhere_m2 = least(&mut || from_m2(free_place(&plan.rooms, &mut rng, &world, &SimOptions::default())));
        let elsewhere_m2 = least(&mut || from_m2(elsewhere(&plan, &mut rng)));
        let reached_m2 = floor_m2(&plan, plan.start);
        assert!(anywhere_m2 < 0.1 * reached_m2, "{anywhere_m2} of {reached_m2} m2");
        assert!(elsewhere_m2 > 0.95 * reached_m2, "{elsewhere_m2} of {reached_m2} m2");
    }

    #[test]
    fn a_shut_door_keeps_the_robot_from_the_rooms_behind_it() {
        let floor_m2 = |plan: &Plan| FloorRaster::new(plan, 0.17, plan.start).score().floor_m2;
        let mut shut = 0;
        for seed in 1..=40 {
            let mut plan = random_home(seed);
            let open_m2 = floor_m2(&plan);
            let door = shut_door(seed, 0.0, f64::INFINITY);
            assert_eq!(door.is_none(), plan.rooms.len() == 1, "{seed}");
            plan.doors.extend(door);
            // A room has two square metres of floor, and that of the robot stays in reach.
            let left_m2 = floor_m2(&plan);
            assert!(left_m2 > 1.0, "{seed}: {left_m2} of {open_m2} m2");
            assert!(door.is_none() || left_m2 < open_m2 - 1.0, "{seed}: {left_m2} of {open_m2} m2");
            shut += usize::from(door.is_some());
        }
        assert!(shut > 15, "{shut} homes have doors");
    }
}
