//! Robots drawn at random about the built-in ones, each with a home of its own: `docs/results/robots.md` says what is drawn.

use std::path::Path;

use hal_sim::SimOptions;
use hal_sim::plan::Plan;
use hal_sim::rng::Rng;
use lab::input::rig_file::Robot;
use lab::run::{FloorDrive, clean_by};
use slam_core::{DriveModel, Mount, RangeModel};

/// Directions of four to eight sensors, degrees.
const BEARINGS: [&[f64]; 5] = [
    &[0.0, 90.0, -90.0, 180.0],
    &[0.0, 45.0, -45.0, 90.0, -90.0],
    &[0.0, 45.0, -45.0, 90.0, -90.0, 180.0],
    &[0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0],
    &[0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0],
];

/// The home of the robot of this number.
///
/// # Panics
/// A random home is no good one.
pub fn home(number: u64) -> Plan {
    hal_sim::plan_file::load(&format!("random-{number}")).expect("a random home")
}

/// How the robot of this number about a built-in one cleans the floor of its home.
///
/// # Panics
/// It does not fit into its home.
pub fn job(kind: &str, number: u64) -> FloorDrive {
    clean_by(&robot(kind, number), &home(number), SimOptions::default(), number, None, |_, _| ())
        .expect("the robot fits")
}

/// The robot of this number about a built-in one.
///
/// # Panics
/// There is no such one.
pub fn robot(kind: &str, number: u64) -> Robot {
    let mut robot = lab::input::robot(Path::new(kind)).expect("a built-in robot").0;
    let mut rng = Rng::stream(number, "robot", 0);
    robot.rig.drive = match robot.rig.drive {
        DriveModel::Wheels { .. } => DriveModel::Wheels {
            track_m: rng.uniform(0.15, 0.3) as f32,
            track_sigma: one_of(&mut rng, &[0.0, 0.002, 0.005]),
            metres_per_tick: rng.uniform(1e-4, 1e-3) as f32,
            scale_sigma: one_of(&mut rng, &[0.005, 0.01, 0.02]),
            noise_m2_per_m: rng.uniform(5e-6, 3e-5) as f32,
        },
        DriveModel::Odometry { .. } => DriveModel::Odometry {
            scale_sigma: one_of(&mut rng, &[0.02, 0.05]),
            noise_m2_per_m: one_of(&mut rng, &[1e-4, 3e-4]),
            noise_rad2_per_m: one_of(&mut rng, &[1e-4, 3e-4]),
            noise_rad2_per_rad: one_of(&mut rng, &[2e-4, 5e-4]),
            veer_sigma: one_of(&mut rng, &[0.0f32, 0.5, 1.0]).to_radians(),
        },
    };
    let mut sensor = robot.rig.sensors[0];
    if let RangeModel::Metric { noise_m, noise_rel } = &mut sensor.model {
        *noise_m = one_of(&mut rng, &[0.005, 0.01, 0.02]);
        *noise_rel = one_of(&mut rng, &[0.0, 0.01, 0.03]);
        sensor.max_m = one_of(&mut rng, &[1.2, 2.0, 3.0, 4.0]);
    }
    let bearings = one_of(&mut rng, &BEARINGS);
    let radius_m = rng.uniform(0.02, 0.14);
    robot.rig.sensors = bearings
        .iter()
        .map(|bearing| {
            let bearing_rad = (bearing + rng.uniform(-8.0, 8.0)).to_radians();
            let [x_m, y_m] = [radius_m * bearing_rad.cos(), radius_m * bearing_rad.sin()].map(|at_m| at_m as f32);
            sensor.mount = Mount { x_m, y_m, bearing_rad: bearing_rad as f32 };
            sensor
        })
        .collect();
    robot.names = (0..bearings.len()).map(|number| format!("sensor{number}")).collect();
    robot
}

fn one_of<T: Copy>(rng: &mut Rng, values: &[T]) -> T {
    values[(rng.unit() * values.len() as f64) as usize]
}
