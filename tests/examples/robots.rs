//! Prints `docs/results/robots.md`: how robots drawn at random map and sweep homes drawn at random.
//! `cargo run --release --package tests --example robots`.

use std::convert::Infallible;
use std::path::Path;
use std::thread;

use hal_sim::SimOptions;
use hal_sim::rng::Rng;
use lab::evaluate::statistics::{mean, quantile};
use lab::input::rig_file::Robot;
use lab::run::{Drive, FloorDrive, Session, clean_by};
use robot::FloorState;
use slam_core::{Config, DriveModel, Mount, RangeModel};

const HEAD: &str = "\
# Robots drawn at random

Printed by `cargo run --release --package tests --example robots`. Each robot maps one random home for ten minutes, with nothing disturbed: robot and drive 501 the home `random-501`, and so
on to 560, without and with [hand-overs](../explanation/look-back.md#handing-over). The robot is drawn about the built-in ones:

- four to eight sensors on a circle of 2 to 14 cm radius, each turned by up to 8 degrees: one ahead, one to each side, the others between these or behind;
- wheels: a track of 15 to 30 cm, known to 0, 2 or 5 mm; ticks of 0.1 to 1 mm; scales known to 0.5, 1 or 2 %; a noise of 0.5 to 3 x 10^-5 m^2/m;
- odometry: scale known to 2 or 5 %; a noise of 1 or 3 x 10^-4 m^2/m and rad^2/m, 2 or 5 x 10^-4 rad^2/rad; a drift of 0, 0.5 or 1 degree a metre, 1 sigma;
- sensors that report metres: up to 1.2, 2, 3 or 4 m (VL53L0X to VL53L1X), noise 5, 10 or 20 mm and 0, 1 or 3 % of the range. Analogue ones are the built-in robot's.

The path's error is RMSE after the best alignment; a NEES of 3 is ideal. Walls missed and invented are means of a drive.

| robot | hand-overs | path, median | 90 % | worst | NEES, mean | 90 % | worst | missed | invented |
|---|---|---|---|---|---|---|---|---|---|";

const SWEEPING: &str = "
## Sweeping the floor

The same robots clean the floor of the same homes, with what the workbench does by default: hand-overs with analogue sensors. A robot is home
where it says that it is done and is within 20 cm of its start. A hole is floor that was missed in one piece; overlap is the path over the least
that the floor asks for. Means, with the worst in brackets.

| robot | drives | done and home | swept, % | at least 95 % | largest hole, m2 | overlap | minutes |
|---|---|---|---|---|---|---|---|";

/// Robots and homes with these numbers.
const NUMBERS: std::ops::RangeInclusive<u64> = 501..=560;
const MINUTES: f64 = 10.0;

/// Built-in robots that others are drawn about, and what they are called.
const KINDS: [(&str, &str); 3] =
    [("sharp", "analogue, wheels"), ("time-of-flight", "metres, wheels"), ("odometry", "metres, odometry")];

/// Directions of four to eight sensors, degrees.
const BEARINGS: [&[f64]; 5] = [
    &[0.0, 90.0, -90.0, 180.0],
    &[0.0, 45.0, -45.0, 90.0, -90.0],
    &[0.0, 45.0, -45.0, 90.0, -90.0, 180.0],
    &[0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0],
    &[0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0],
];

fn main() {
    println!("{HEAD}");
    for (kind, name) in KINDS {
        for (hand_overs, with) in [(false, "without"), (true, "with")] {
            let drives = in_all_homes(move |number| drive(kind, hand_overs, number));
            let of = |i: usize| drives.iter().map(|figures| figures[i]).collect::<Vec<f64>>();
            let share = |i: usize, share: f64| quantile(&of(i), share).expect("there are drives");
            let mean = |i: usize| mean(&of(i)).expect("there are drives");
            println!(
                "| {name} | {with} | {:.2} cm | {:.1} cm | {:.1} cm | {:.1} | {:.1} | {:.0} | {:.2} | {:.2} |",
                100.0 * share(0, 0.5),
                100.0 * share(0, 0.9),
                100.0 * share(0, 1.0),
                mean(1),
                share(1, 0.9),
                share(1, 1.0),
                mean(2),
                mean(3),
            );
        }
    }
    println!("{SWEEPING}");
    for (kind, name) in KINDS {
        print_jobs(name, &in_all_homes(move |number| job(kind, number)));
    }
}

fn print_jobs(name: &str, jobs: &[FloorDrive]) {
    let both = |value: fn(&FloorDrive) -> f64, worst: f64| {
        let values: Vec<f64> = jobs.iter().map(value).collect();
        (mean(&values).expect("there are jobs"), quantile(&values, worst).expect("there are jobs"))
    };
    let home = jobs.iter().filter(|job| job.progress.state == FloorState::Done && job.score.home_m < 0.2).count();
    let swept = jobs.iter().filter(|job| job.score.swept >= 0.95).count();
    let (swept_mean, swept_least) = both(|job| 100.0 * job.score.swept, 0.0);
    let (hole_m2, largest_m2) = both(|job| job.score.largest_hole_m2, 1.0);
    let (overlap, most_overlap) = both(|job| job.score.overlap, 1.0);
    let (minutes, most_minutes) = both(|job| job.minutes, 1.0);
    println!(
        "| {name} | {} | {home} | {swept_mean:.1} ({swept_least:.1}) | {swept} | {hole_m2:.2} ({largest_m2:.2}) \
         | {overlap:.2} ({most_overlap:.2}) | {minutes:.1} ({most_minutes:.1}) |",
        jobs.len(),
    );
}

/// What became of one in each home, in two threads.
fn in_all_homes<T: Send + 'static>(one: impl Fn(u64) -> T + Copy + Send + 'static) -> Vec<T> {
    let of = move |parity: u64| {
        let numbers = NUMBERS.filter(move |number| number % 2 == parity);
        thread::spawn(move || numbers.map(one).collect::<Vec<_>>())
    };
    [0, 1].map(of).into_iter().flat_map(|half| half.join().expect("no panic")).collect()
}

fn job(kind: &str, number: u64) -> FloorDrive {
    let home = hal_sim::plan_file::load(&format!("random-{number}")).expect("a random home");
    clean_by(&robot(kind, number), &home, SimOptions::default(), number, None, |_, _| ()).expect("the robot fits")
}

/// Path's error, metres, NEES, walls missed and invented.
fn drive(kind: &str, hand_overs: bool, number: u64) -> [f64; 4] {
    let robot = robot(kind, number);
    let home = hal_sim::plan_file::load(&format!("random-{number}")).expect("a random home");
    let mut drive = Drive::new(&home, &robot, SimOptions::default(), number).expect("the robot fits");
    let config = Config { hand_overs, ..Config::for_rig(&robot.rig) };
    let mut session = Session::new(&robot, config, "random").expect("a good rig");
    drive.run(&mut session, 60.0 * MINUTES, |_, _, _| Ok::<(), Infallible>(())).expect("nothing can fail");
    let figures = drive.finish(session).figures;
    let (path, map) = figures.estimate.zip(figures.map).expect("a truth and a plan");
    [path.ate_m, path.nees.expect("a covariance"), map.missed as f64, map.invented as f64]
}

/// A robot about this built-in one.
fn robot(kind: &str, number: u64) -> Robot {
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
