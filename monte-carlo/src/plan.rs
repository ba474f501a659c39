//! The home of one drive: a floor plan, changed as the setting says.

use hal_sim::plan::{Door, Person, Plan, Room, Round};
use hal_sim::rng::Rng;
use hal_sim::world::World;

use crate::setting::{Key, Setting};

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
    add_people(&mut plan, count(Key::People), &mut Rng::stream(seed, "people", 0));
    if let Some(closes_at_s) = setting.get(Key::DoorCloses) {
        let opens_at_s = setting.get(Key::DoorOpens).unwrap_or(f64::INFINITY);
        let own = doors.iter().filter(|leaf| leaf.plan == name);
        plan.doors.extend(own.map(|leaf| Door { from_m: leaf.from_m, to_m: leaf.to_m, closes_at_s, opens_at_s }));
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
            plan.people.push(Person { radius_m: PERSON_M, speed_mps: WALK_MPS, path_m });
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

#[cfg(test)]
mod tests {
    use super::*;

    fn flat() -> Plan {
        hal_sim::plan_file::load("flat").expect("a built-in plan")
    }

    fn set(key: Key, value: f64) -> Setting {
        Setting { rig: None, values: [(key, value)].into() }
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
    fn a_door_closes_in_its_own_plan_only() {
        let leaf = DoorLeaf { plan: "flat".into(), from_m: [4.55, 1.0], to_m: [4.55, 1.85] };
        let setting = set(Key::DoorCloses, 60.0);
        assert_eq!(changed(&flat(), "flat", std::slice::from_ref(&leaf), &setting, 1).doors.len(), 1);
        assert!(changed(&flat(), "other", &[leaf], &setting, 1).doors.is_empty());
    }
}
