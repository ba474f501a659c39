//! The home of one drive: a floor plan, changed as the setting says.

use hal_sim::Pose2;
use hal_sim::plan::{Door, Face, Person, Plan, Room, Round};
use hal_sim::rng::Rng;
use hal_sim::world::World;

use crate::key::Key;
use crate::setting::Setting;

/// Radius of a chair leg, metres.
const LEG_M: f64 = 0.02;

/// Free space around a chair leg: the robot passes between it and a wall, metres.
const LEG_CLEARANCE_M: f64 = 0.5;

/// Radius of a person as the sensors see it, metres.
const PERSON_M: f64 = 0.15;

/// Free space around somebody's path, metres.
const PERSON_CLEARANCE_M: f64 = 0.25;

/// Walking speed in a home, m/s.
const WALK_MPS: f64 = 0.5;

/// Thickest wall between two rooms, metres; what is thicker is furniture.
const PARTITION_M: f64 = 0.2;

/// Draws before a place is given up: a room may be too full.
const TRIES: usize = 200;

/// A door of an experiment: its leaf when closed, plan frame, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct DoorLeaf {
    /// The plan that has it.
    pub plan: String,
    /// One end.
    pub from_m: [f64; 2],
    /// The other end.
    pub to_m: [f64; 2],
}

/// The plan as the setting changes it; what is random in that follows from `seed`.
pub fn changed(plan: &Plan, name: &str, doors: &[DoorLeaf], setting: &Setting, seed: u64) -> Plan {
    let mut plan = plan.clone();
    let count = |key: Key| setting.get(key).unwrap_or(0.0) as usize;
    add_legs(&mut plan, count(Key::ChairLegs), &mut Rng::stream(seed, "chair-legs", 0));
    add_people(&mut plan, count(Key::People), &mut Rng::stream(seed, "walks", 0));
    if let Some(closes_at_s) = setting.get(Key::DoorCloses) {
        let opens_at_s = setting.get(Key::DoorOpens).unwrap_or(f64::INFINITY);
        let own = doors.iter().filter(|leaf| leaf.plan == name);
        plan.doors.extend(own.map(|leaf| Door { from_m: leaf.from_m, to_m: leaf.to_m, closes_at_s, opens_at_s }));
    }
    if let Some(inner_deg) = setting.get(Key::Inner) {
        turn_inner_walls(&mut plan, inner_deg.to_radians());
    }
    if let Some(most_deg) = setting.get(Key::Furniture) {
        turn_furniture(&mut plan, most_deg.to_radians(), &mut Rng::stream(seed, "furniture", 0));
    }
    if let Some(scatter_deg) = setting.get(Key::Scatter) {
        scatter(&mut plan, scatter_deg.to_radians(), &mut Rng::stream(seed, "scatter", 0));
    }
    if let Some(skew_deg) = setting.get(Key::Skew) {
        shear(&mut plan, skew_deg.to_radians().tan());
    }
    plan
}

fn place(room: &Room, clearance_m: f64, world: &World, rng: &mut Rng) -> Option<[f64; 2]> {
    (0..TRIES)
        .map(|_| [0, 1].map(|axis| rng.uniform(room.min_m[axis], room.max_m[axis])))
        .find(|at_m| world.clearance_m(*at_m) > clearance_m)
}

fn add_legs(plan: &mut Plan, legs: usize, rng: &mut Rng) {
    for i in 0..legs {
        let Some(room) = plan.rooms.get(i % plan.rooms.len().max(1)) else { return };
        // Built anew: legs keep clear of each other, too, and of the robot's start.
        let start_m = [plan.start.x_m, plan.start.y_m];
        let mut with_start = plan.clone();
        with_start.rounds.push(Round { centre_m: start_m, radius_m: LEG_M });
        if let Some(centre_m) = place(room, LEG_CLEARANCE_M, &World::new(&with_start), rng) {
            plan.rounds.push(Round { centre_m, radius_m: LEG_M });
        }
    }
}

fn add_people(plan: &mut Plan, people: usize, rng: &mut Rng) {
    let world = World::new(plan);
    for i in 0..people {
        let Some(room) = plan.rooms.get(i % plan.rooms.len().max(1)) else { return };
        let walk = (0..TRIES).find_map(|_| {
            let from = place(room, PERSON_CLEARANCE_M, &world, rng)?;
            let to = place(room, PERSON_CLEARANCE_M, &world, rng)?;
            let free = (0..=50).all(|step| {
                let share = f64::from(step) / 50.0;
                let at_m = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                world.clearance_m(at_m) > PERSON_CLEARANCE_M
            });
            let length_m = (to[0] - from[0]).hypot(to[1] - from[1]);
            (free && length_m > 1.0).then(|| vec![from, to])
        });
        if let Some(path_m) = walk {
            plan.people.push(Person { radius_m: PERSON_M, speed_mps: WALK_MPS, path_m, gives_way: false });
        }
    }
}

/// Moves every point sideways by `slope` times its y: what stood along y now leans.
fn shear(plan: &mut Plan, slope: f64) {
    let moved = |at_m: [f64; 2]| [at_m[0] + slope * at_m[1], at_m[1]];
    for face in &mut plan.faces {
        (face.from_m, face.to_m) = (moved(face.from_m), moved(face.to_m));
    }
    for door in &mut plan.doors {
        (door.from_m, door.to_m) = (moved(door.from_m), moved(door.to_m));
    }
    for round in &mut plan.rounds {
        round.centre_m = moved(round.centre_m);
    }
    for corner_m in plan.people.iter_mut().flat_map(|person| &mut person.path_m) {
        *corner_m = moved(*corner_m);
    }
    for room in &mut plan.rooms {
        let shift_m = slope * 0.5 * (room.min_m[1] + room.max_m[1]);
        room.min_m[0] += shift_m;
        room.max_m[0] += shift_m;
    }
    [plan.start.x_m, plan.start.y_m] = moved([plan.start.x_m, plan.start.y_m]);
}

/// Corners of the rectangle that the walls lie in.
fn bounds(plan: &Plan) -> ([f64; 2], [f64; 2]) {
    let ends = || plan.faces.iter().flat_map(|face| [face.from_m, face.to_m]);
    let least = [0, 1].map(|axis| ends().map(|end| end[axis]).fold(f64::INFINITY, f64::min));
    let most = [0, 1].map(|axis| ends().map(|end| end[axis]).fold(f64::NEG_INFINITY, f64::max));
    (least, most)
}

/// Whether a face is one of a partition's: another one is its back, or it is an end of one.
fn is_partition(faces: &[Face], face: &Face) -> bool {
    let normal = face.normal();
    let is_back = |other: &Face| {
        let facing = normal[0] * other.normal()[0] + normal[1] * other.normal()[1];
        let middle = [0, 1].map(|axis| 0.5 * (other.from_m[axis] + other.to_m[axis]) - face.from_m[axis]);
        let behind_m = -(middle[0] * normal[0] + middle[1] * normal[1]);
        let along_m = middle[0] * normal[1] - middle[1] * normal[0];
        facing < -0.99 && (0.0..=PARTITION_M).contains(&behind_m) && (0.0..=face.length_m()).contains(&along_m)
    };
    face.two_sided || face.length_m() <= PARTITION_M || faces.iter().any(is_back)
}

/// Turns partitions, and nothing else, as a whole about the middle of the home; those that end at an outer wall still do.
fn turn_inner_walls(plan: &mut Plan, angle_rad: f64) {
    let (least, most) = bounds(plan);
    let middle = Pose2::new(0.5 * (least[0] + most[0]), 0.5 * (least[1] + most[1]), angle_rad);
    let still = Pose2::new(middle.x_m, middle.y_m, 0.0);
    let at = |value: f64, limit: f64| (value - limit).abs() < 0.01;
    let original = plan.faces.clone();
    for face in plan.faces.iter_mut() {
        let outer = (0..2).any(|axis| {
            [least[axis], most[axis]]
                .into_iter()
                .any(|limit| at(face.from_m[axis], limit) && at(face.to_m[axis], limit))
        });
        if outer || !is_partition(&original, face) {
            continue;
        }
        let turned = [face.from_m, face.to_m].map(|end| middle.transform(still.inverse_transform(end)));
        let length_m = face.length_m();
        let along = [0, 1].map(|axis| (turned[1][axis] - turned[0][axis]) / length_m);
        let extended = |before: [f64; 2], after: [f64; 2]| {
            let limit = (0..2).find_map(|axis| {
                let limit = [least[axis], most[axis]].into_iter().find(|limit| at(before[axis], *limit))?;
                (along[axis].abs() > 0.5).then_some((axis, limit))
            });
            limit.map_or(after, |(axis, limit)| {
                let by_m = (limit - after[axis]) / along[axis];
                [after[0] + by_m * along[0], after[1] + by_m * along[1]]
            })
        };
        let ends = [extended(face.from_m, turned[0]), extended(face.to_m, turned[1])];
        [face.from_m, face.to_m] = ends;
    }
}

/// Turns faces as one about the mean of their ends.
fn turn(faces: &mut [Face], angle_rad: f64) {
    let ends = 2.0 * faces.len() as f64;
    let [x_m, y_m] =
        [0, 1].map(|axis| faces.iter().map(|face| face.from_m[axis] + face.to_m[axis]).sum::<f64>() / ends);
    let (still, turned) = (Pose2::new(x_m, y_m, 0.0), Pose2::new(x_m, y_m, angle_rad));
    for face in faces {
        face.from_m = turned.transform(still.inverse_transform(face.from_m));
        face.to_m = turned.transform(still.inverse_transform(face.to_m));
    }
}

/// How many of these faces, from the first on, are the outline of one thing.
fn loop_len(faces: &[Face]) -> usize {
    let Some(first) = faces.first() else { return 0 };
    let meet = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6;
    let chain = faces.windows(2).take_while(|pair| meet(pair[0].to_m, pair[1].from_m)).count();
    faces[..=chain].iter().position(|face| meet(face.to_m, first.from_m)).map_or(1, |last| last + 1)
}

/// Turns each piece of furniture about its middle, by an angle of its own: what has an outline thicker than a partition, and is not
/// the home's.
fn turn_furniture(plan: &mut Plan, most_rad: f64, rng: &mut Rng) {
    let (least, most) = bounds(plan);
    let mut rest = &mut plan.faces[..];
    while !rest.is_empty() {
        let (own, others) = rest.split_at_mut(loop_len(rest));
        let reaches = |axis: usize, limit: f64| own.iter().any(|face| (face.from_m[axis] - limit).abs() < 0.01);
        let is_home = (0..2).all(|axis| reaches(axis, least[axis]) && reaches(axis, most[axis]));
        if own.len() > 2 && !is_home && own.iter().all(|face| face.length_m() > PARTITION_M) {
            turn(own, rng.uniform(-most_rad, most_rad));
        }
        rest = others;
    }
}

/// Turns each face about its middle, by an angle of its own.
fn scatter(plan: &mut Plan, sigma_rad: f64, rng: &mut Rng) {
    for face in &mut plan.faces {
        turn(std::slice::from_mut(face), sigma_rad * rng.gaussian());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat() -> Plan {
        hal_sim::plan_file::load("flat").expect("a built-in plan")
    }

    fn set(key: Key, value: f64) -> Setting {
        Setting { values: [(key, value)].into(), ..Setting::default() }
    }

    /// By how much each face is turned, degrees.
    fn turned_by(before: &Plan, after: &Plan) -> Vec<f64> {
        let angle = |face: &Face| (face.to_m[1] - face.from_m[1]).atan2(face.to_m[0] - face.from_m[0]);
        let off = |(a, b): (&Face, &Face)| hal_sim::pose::wrap(angle(b) - angle(a)).to_degrees();
        before.faces.iter().zip(&after.faces).map(off).collect()
    }

    #[test]
    fn legs_and_people_are_where_there_is_room_and_follow_from_the_seed() {
        let legs = changed(&flat(), "flat", &[], &set(Key::ChairLegs, 8.0), 3);
        assert_eq!(legs.rounds.len(), 8);
        assert_eq!(legs, changed(&flat(), "flat", &[], &set(Key::ChairLegs, 8.0), 3));
        assert_ne!(legs, changed(&flat(), "flat", &[], &set(Key::ChairLegs, 8.0), 4));
        let people = changed(&flat(), "flat", &[], &set(Key::People, 4.0), 3);
        assert_eq!(people.people.len(), 4);
        let world = World::new(&flat());
        for corner_m in people.people.iter().flat_map(|person| &person.path_m) {
            assert!(world.clearance_m(*corner_m) > PERSON_CLEARANCE_M);
        }
    }

    #[test]
    fn how_many_walk_and_where_are_drawn_apart() {
        let mut of_the_setting_s_stream = flat();
        add_people(&mut of_the_setting_s_stream, 4, &mut Rng::stream(3, Key::People.name(), 0));
        assert_ne!(changed(&flat(), "flat", &[], &set(Key::People, 4.0), 3), of_the_setting_s_stream);
    }

    #[test]
    fn sheared_walls_lean_by_the_angle() {
        let leaning = changed(&flat(), "flat", &[], &set(Key::Skew, 5.0), 1);
        for (before, after) in flat().faces.iter().zip(&leaning.faces) {
            let upright = (before.from_m[0] - before.to_m[0]).abs() < 1e-9;
            let lean = (after.to_m[0] - after.from_m[0]) / (after.to_m[1] - after.from_m[1]);
            if upright {
                assert!((lean.atan().to_degrees() - 5.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn inner_walls_turn_against_the_outer_ones_and_still_end_there() {
        let before = flat();
        let turned = changed(&before, "flat", &[], &set(Key::Inner, 5.0), 1);
        let by = turned_by(&before, &turned);
        assert!(by.iter().all(|by| by.abs() < 1e-9 || (by - 5.0).abs() < 1e-9));
        // Seven partitions of four faces, but for their ends that lie in outer walls: the outline and furniture stay.
        assert!((20..=28).contains(&by.iter().filter(|by| by.abs() > 1.0).count()));
        let ends_at_wall = |faces: &[Face]| {
            let on = |value: f64| value.abs() < 1e-9;
            faces.iter().flat_map(|face| [face.from_m, face.to_m]).filter(|end| on(end[0]) || on(end[1])).count()
        };
        assert!(ends_at_wall(&turned.faces) >= ends_at_wall(&before.faces) - 4);
    }

    #[test]
    fn furniture_turns_piece_by_piece_and_walls_stay() {
        let before = flat();
        let turned = changed(&before, "flat", &[], &set(Key::Furniture, 10.0), 1);
        let by = turned_by(&before, &turned);
        assert!(by.iter().all(|by| by.abs() < 10.0));
        let mut angles: Vec<f64> = by.into_iter().filter(|by| by.abs() > 1e-9).collect();
        let faces = angles.len();
        angles.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        assert!(angles.len() > 4 && faces == 4 * angles.len(), "{faces} faces, angles {angles:?}");
        let (least, most) = bounds(&before);
        assert!(turned.faces.iter().filter(|face| face.length_m() > most[0] - least[0] - 0.01).count() >= 2);
    }

    #[test]
    fn a_door_closes_in_its_own_plan_only() {
        let leaf = DoorLeaf { plan: "flat".into(), from_m: [4.55, 1.0], to_m: [4.55, 1.85] };
        let setting = set(Key::DoorCloses, 60.0);
        assert_eq!(changed(&flat(), "flat", std::slice::from_ref(&leaf), &setting, 1).doors.len(), 1);
        assert!(changed(&flat(), "other", &[leaf], &setting, 1).doors.is_empty());
    }
}
