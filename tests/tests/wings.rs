//! Homes with a wing that stands askew: all that a robot sees there is turned by the same angle, as after a kick.

use std::thread;

use hal_sim::rng::Rng;
use hal_sim::{SimOptions, plan_file};
use lab::run::{FloorDrive, clean};
use robot::FloorState;

/// Homes, and drives in each.
const HOMES: u64 = 24;
const SEEDS: u64 = 2;

/// A room of 3 to 5 m, and through a door another one of 2.5 to 4.5 m, turned by 8 to 30 degrees about the middle of the door, either way.
fn wing(home: u64) -> String {
    let mut rng = Rng::stream(home, "wing", 0);
    let sign = if rng.uniform(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
    let (s, c) = (sign * rng.uniform(8.0, 30.0).to_radians()).sin_cos();
    let [width, height] = [rng.uniform(3.0, 5.0), rng.uniform(3.0, 5.0)];
    let [deep, wide] = [rng.uniform(2.5, 4.5), rng.uniform(2.5, 4.5)];
    let half = 0.5 * if rng.uniform(0.0, 1.0) < 0.75 { 0.9 } else { 1.8 };
    let door = rng.uniform(1.3, height - 1.3);
    let left = rng.uniform(0.35, 0.65) * wide;
    let right = left - wide;
    // So far behind the door that the wing's wall does not cut into the room.
    let behind = width + 0.12 + s.abs() * left.max(-right);
    let turned = |x: f64, y: f64| [behind + c * x - s * y, door + s * x + c * y];
    let corners = [
        [0.0, 0.0],
        [width, 0.0],
        [width, door - half],
        turned(0.0, -half),
        turned(0.0, right),
        turned(deep, right),
        turned(deep, left),
        turned(0.0, left),
        turned(0.0, half),
        [width, door + half],
        [width, height],
        [0.0, height],
    ];
    format!("[start]\nx_m = 1.0\ny_m = {}\n[[outline]]\npoints_m = {corners:?}\n", 0.5 * height)
}

fn job(home: u64, seed: u64) -> FloorDrive {
    let plan = plan_file::parse("wing.toml", "wing", &wing(home)).expect("a good plan");
    clean(&plan, SimOptions::default(), seed).expect("the robot fits")
}

/// Of these 48 robots 15 take what they see there for their own turn; most of them find out when they come back. 44 come home.
#[test]
fn a_robot_that_takes_a_wing_for_its_own_turn_mostly_comes_home() {
    let halves = [0, 1].map(|half| {
        let homes = (1..=HOMES).filter(move |home| home % 2 == half);
        let jobs = homes.flat_map(|home| (1..=SEEDS).map(move |seed| (home, seed, job(home, seed))));
        thread::spawn(move || jobs.collect::<Vec<_>>())
    });
    let jobs: Vec<_> = halves.into_iter().flat_map(|half| half.join().expect("no panic")).collect();
    let mut home = 0;
    for (number, seed, job) in &jobs {
        home += usize::from(job.progress.state == FloorState::Done && job.score.home_m < 0.2);
        assert!(job.score.swept >= 0.93, "wing {number}, seed {seed}: {} swept", job.score.swept);
    }
    assert!(10 * home >= 9 * jobs.len(), "{home} of {}", jobs.len());
}
