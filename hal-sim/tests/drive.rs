//! Driving a room with nothing but a bumper and one side's range.
use hal_sim::{SimOptions, Simulation, default_rig, plan_file};
use robot::WheelSpeeds;
use slam_core::{RangeInput, Sample};

/// Range (metres) of a default-rig sensor by its nominal curve.
fn range_m(sample: &Sample<16>, sensor: usize) -> f32 {
    let RangeInput::Counts(counts) = sample.ranges[sensor] else { return f32::NAN };
    0.60374 * libm::powf(f32::from(counts) / 4095.0 * 3.3, -1.16)
}

#[test]
fn a_trivial_wall_follower_drives_along_the_walls_of_a_room() {
    let plan = plan_file::load("room").unwrap();
    let mut simulation = Simulation::new(&plan, &default_rig(), SimOptions::default(), 1).unwrap();
    let mut sample = simulation.sample();
    let mut visited = vec![false; plan.rooms.len()];
    let (mut path_m, mut last) = (0.0, simulation.pose());
    for _ in 0..25 * 180 {
        let ahead_m = range_m(&sample, 0).min(range_m(&sample, 7));
        let right_m = range_m(&sample, 6);
        let (forward_mps, turn_radps) = if ahead_m < 0.45 || simulation.contacts().any() {
            (0.0, 0.8)
        } else {
            (0.2, 2.0 * (0.4 - right_m).clamp(-0.4, 0.4))
        };
        sample = simulation.step(WheelSpeeds::from_twist(forward_mps, turn_radps, 0.235));
        let truth = simulation.pose();
        path_m += f64::hypot(truth.x_m - last.x_m, truth.y_m - last.y_m);
        last = truth;
        let place = simulation.pose_in_plan();
        for (room, visited) in plan.rooms.iter().zip(&mut visited) {
            *visited |= room.contains(place.x_m, place.y_m);
        }
    }
    assert_eq!(sample.time_us, 180_000_000);
    assert!(path_m > 15.0, "{path_m}");
    assert!(visited.iter().all(|&v| v), "{visited:?}");
    assert!(simulation.coverage().walls(3.0, 2.0).len() >= 4);
}
