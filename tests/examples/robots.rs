//! Prints `docs/results/robots.md`: how robots drawn at random map and sweep homes drawn at random.
//! `cargo run --release --package tests --example robots`; with two numbers after ` -- `, how robots and homes from the one to the other sweep.

use std::convert::Infallible;
use std::ops::RangeInclusive;
use std::thread;

use hal_sim::SimOptions;
use lab::evaluate::statistics::{mean, quantile};
use lab::run::{Drive, FloorDrive, Session};
use robot::FloorState;
use slam_core::Config;
use tests::drawn_robots::{home, job, robot};

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

The same robots clean the floor of the same homes, with hand-overs, as on the robot. A robot is home
where it says that it is done and is within 20 cm of its start. A hole is floor that was missed in one piece; overlap is the path over the least
that the floor asks for. Means, with the worst in brackets.

| robot | drives | done and home | swept, % | at least 95 % | largest hole, m2 | overlap | minutes |
|---|---|---|---|---|---|---|---|";

/// Robots and homes with these numbers.
const NUMBERS: RangeInclusive<u64> = 501..=560;
const MINUTES: f64 = 10.0;

/// Built-in robots that others are drawn about, and what they are called.
const KINDS: [(&str, &str); 3] =
    [("sharp", "analogue, wheels"), ("time-of-flight", "metres, wheels"), ("odometry", "metres, odometry")];

fn main() {
    let asked: Vec<u64> = std::env::args().skip(1).map(|number| number.parse().expect("a robot's number")).collect();
    if let [from, to] = asked[..] {
        return print_sweeping(&(from..=to));
    }
    println!("{HEAD}");
    for (kind, name) in KINDS {
        for (hand_overs, with) in [(false, "without"), (true, "with")] {
            let drives = in_homes(&NUMBERS, move |number| drive(kind, hand_overs, number));
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
    print_sweeping(&NUMBERS);
}

fn print_sweeping(numbers: &RangeInclusive<u64>) {
    println!("{SWEEPING}");
    for (kind, name) in KINDS {
        print_jobs(name, &in_homes(numbers, move |number| job(kind, number)));
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
fn in_homes<T: Send + 'static>(
    numbers: &RangeInclusive<u64>,
    one: impl Fn(u64) -> T + Copy + Send + 'static,
) -> Vec<T> {
    let of = |parity: u64| {
        let numbers = numbers.clone().filter(move |number| number % 2 == parity);
        thread::spawn(move || numbers.map(one).collect::<Vec<_>>())
    };
    [0, 1].map(of).into_iter().flat_map(|half| half.join().expect("no panic")).collect()
}

/// Path's error, metres, NEES, walls missed and invented.
fn drive(kind: &str, hand_overs: bool, number: u64) -> [f64; 4] {
    let robot = robot(kind, number);
    let mut drive = Drive::new(&home(number), &robot, SimOptions::default(), number).expect("the robot fits");
    let config = Config { hand_overs, ..Config::for_rig(&robot.rig) };
    let mut session = Session::new(&robot, config, "random").expect("a good rig");
    drive.run(&mut session, 60.0 * MINUTES, |_, _, _| Ok::<(), Infallible>(())).expect("nothing can fail");
    let figures = drive.finish(session).figures;
    let (path, map) = figures.estimate.zip(figures.map).expect("a truth and a plan");
    [path.ate_m, path.nees.expect("a covariance"), map.missed as f64, map.invented as f64]
}
