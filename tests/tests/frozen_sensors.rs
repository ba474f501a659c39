//! A range sensor whose output stays the same is found out, and believed again when it changes.

use hal_sim::fault::{Fault, Part};
use hal_sim::plan::Plan;
use hal_sim::random_home::random_home;
use hal_sim::rng::Rng;
use hal_sim::{SimOptions, plan_file};
use lab::input::built_in_robot;
use lab::input::settings::by_default;
use lab::run::{Drive, Session};
use slam_core::{RangeInput, RangeModel, RangeSensor, Refusal, Rig};
use tests::carries::{Driven, SENSORS, drive, drive_altered, rig};

/// When a sensor freezes, and for how long, seconds.
const AT_S: f64 = 60.0;
const FROZEN_S: f64 = 90.0;

/// When a drive ends, seconds.
const END_S: f64 = 240.0;

/// What a frozen sensor says.
#[derive(Clone, Copy)]
enum Says {
    /// What it said last.
    Last,
    /// A range, metres, with so much of the sensor's stated noise.
    Range(f64, f64),
}

/// What became of a drive in which a sensor freezes.
struct Found {
    /// Whether it could be seen: it froze at a range.
    is_told: bool,
    /// When it was found so, and when it was believed again, seconds.
    from_s: Option<f64>,
    until_s: Option<f64>,
    /// Whether any other was.
    others: bool,
    holds: u32,
    off_m: f64,
}

/// The output of a sensor at this range, metres, with so many standard deviations of noise.
fn output(rig: &Rig<SENSORS>, sensor: &RangeSensor, range_m: f64, sigmas: f64) -> RangeInput {
    match (sensor.model, rig.adc) {
        (RangeModel::Sharp { scale_m, exponent, noise_v }, Some(adc)) => {
            let volts = (range_m / f64::from(scale_m)).powf(1.0 / f64::from(exponent)) + sigmas * f64::from(noise_v);
            RangeInput::Counts((volts / f64::from(adc.vref_v) * f64::from(adc.full_scale())).round() as u16)
        }
        (RangeModel::Metric { noise_m, noise_rel }, _) => {
            RangeInput::Metres((range_m + sigmas * (f64::from(noise_m) + f64::from(noise_rel) * range_m)) as f32)
        }
        _ => RangeInput::Missing,
    }
}

fn found(rig: &Rig<SENSORS>, sensor: usize, says: Says, seed: u64) -> Found {
    let plan = plan_file::load("flat").expect("a built-in plan");
    let mut found = Found { is_told: false, from_s: None, until_s: None, others: false, holds: 0, off_m: 0.0 };
    let mut last = RangeInput::Missing;
    let mut noise = Rng::stream(seed, "frozen", sensor);
    let freeze = |input: &mut RangeInput, t_s: f64| match says {
        _ if !(AT_S..AT_S + FROZEN_S).contains(&t_s) => last = *input,
        Says::Last => *input = last,
        Says::Range(range_m, times) => *input = output(rig, &rig.sensors[sensor], range_m, times * noise.gaussian()),
    };
    let mut freeze = freeze;
    let alter = |sample: &mut slam_core::Sample<SENSORS>| {
        freeze(&mut sample.ranges[sensor], sample.time_us as f64 * 1e-6);
    };
    drive_altered(&plan, rig, END_S, seed, alter, |Driven { slam, sample, report, in_plan, .. }| {
        let t_s = sample.time_us as f64 * 1e-6;
        if t_s < AT_S {
            found.is_told = report.readings[sensor].range_m.is_some() || matches!(says, Says::Range(..));
        }
        let frozen = slam.frozen_sensors();
        found.others |= frozen & !(1 << sensor) != 0;
        if slam.is_frozen(sensor) {
            found.from_s.get_or_insert(t_s);
        } else if found.from_s.is_some() {
            found.until_s.get_or_insert(t_s);
        }
        let error = plan.start.relative(&in_plan).relative(&slam.pose().into());
        (found.holds, found.off_m) = (slam.counters().holds, error.x_m.hypot(error.y_m));
        true
    });
    found
}

#[test]
fn a_frozen_sensor_is_found_out_and_believed_again() {
    let (mut told, mut known, mut back) = (0, 0, 0);
    for seed in 1..=8 {
        for sensor in 0..4 {
            let Found { is_told, from_s, until_s, others, holds, off_m } = found(&rig(4), sensor, Says::Last, seed);
            let name = format!("seed {seed}, sensor {sensor}: from {from_s:?} until {until_s:?} s, {off_m} m off");
            assert!(!others && holds == 0, "{name}");
            assert!(from_s.is_none_or(|from_s| from_s > AT_S), "{name}");
            if is_told {
                told += 1;
                known += u32::from(from_s.is_some_and(|from_s| from_s < AT_S + FROZEN_S));
                back += u32::from(until_s.is_some_and(|until_s| until_s > AT_S + FROZEN_S));
                assert!(off_m < 0.2, "{name}");
            }
        }
    }
    assert!(told >= 12 && 10 * known >= 9 * told && 10 * back >= 9 * known, "{known} of {told} found, {back} back");
}

/// An analogue output that repeats to the count is found within a second, whether or not the robot turns.
#[test]
fn an_output_without_noise_is_found_at_once() {
    for seed in 1..=8 {
        let Found { from_s, others, holds, .. } =
            found(&rig(8), seed as usize % 8, Says::Range(0.2 + 0.1 * seed as f64, 0.0), seed);
        assert!(from_s.is_some_and(|from_s| from_s < AT_S + 1.0) && !others && holds == 0, "seed {seed}: {from_s:?}");
    }
}

/// With the noise of a live sensor only what the robot's motion should have done tells.
#[test]
fn an_output_with_noise_is_found_by_motion() {
    for rig in [rig(4), robot::rig::time_of_flight_rig()] {
        let mut known = 0;
        for seed in 1..=20 {
            let says = Says::Range(0.3 + 0.05 * seed as f64, 1.0);
            let Found { from_s, others, .. } = found(&rig, seed as usize % 4, says, seed);
            assert!(!others && from_s.is_none_or(|from_s| from_s > AT_S), "seed {seed}: {from_s:?}");
            known += u32::from(from_s.is_some_and(|from_s| from_s < AT_S + FROZEN_S));
        }
        assert!(known >= 18, "{known} of 20");
    }
}

/// So is one that is out of the sensor's reach now and then, by its noise: a light that has failed, or is covered with dust.
#[test]
fn an_output_at_the_end_of_the_reach_is_found_by_motion() {
    for rig in [rig(8), robot::rig::time_of_flight_rig()] {
        let mut known = 0;
        for seed in 1..=10 {
            let sensor = seed as usize % rig.sensors.len();
            let says = Says::Range((0.93 + 0.006 * seed as f64) * f64::from(rig.sensors[sensor].max_m), 1.0);
            let Found { from_s, others, .. } = found(&rig, sensor, says, seed);
            assert!(!others && from_s.is_none_or(|from_s| from_s > AT_S), "seed {seed}: {from_s:?}");
            known += u32::from(from_s.is_some_and(|from_s| from_s < AT_S + FROZEN_S));
        }
        assert!(known >= 9, "{known} of 10");
    }
}

/// A sensor that is covered shows something just before the bumper, and a robot that takes it for an obstacle finds no way through its home.
#[test]
fn a_covered_sensor_is_found_by_turns_and_the_floor_is_swept() {
    for (home, sensor, shows_m) in [(608, 0, 0.13), (611, 1, 0.16), (612, 6, 0.18)] {
        let mut plan = random_home(home);
        let part = Part::Sensor { index: sensor, shows_m: Some(shows_m) };
        plan.mishaps.faults.push(Fault { part, at_s: AT_S, lasts_s: f64::INFINITY });
        let (frozen, swept) = sweep(&plan);
        assert_eq!(frozen, 1 << sensor, "random-{home}");
        assert!(swept > 0.95, "random-{home}: {:.1} %", 100.0 * swept);
    }
}

#[test]
fn no_sensor_is_found_frozen_that_is_not() {
    let rigs = [rig(4), rig(8), robot::rig::time_of_flight_rig(), hal_sim::odometry_rig(), hal_sim::measured_rig()];
    for name in ["flat", "l-shape", "clutter", "corridor-loop"] {
        for (rig, seed) in rigs.iter().flat_map(|rig| (1..=4).map(move |seed| (rig, seed))) {
            let plan = plan_file::load(name).expect("a built-in plan");
            let slam = drive(&plan, rig, 300.0, seed, |_| true);
            let counters = slam.counters();
            let found = (counters.frozen, counters.refused[Refusal::Frozen as usize]);
            assert_eq!(found, (0, 0), "{name}, seed {seed}");
        }
    }
}

/// A robot that hugs walls and goes round legs steers so that what it reads stays the same.
#[test]
fn no_sensor_of_a_robot_that_sweeps_is_found_frozen() {
    for home in [608, 611, 612, 618] {
        assert_eq!(sweep(&random_home(home)).0, 0, "random-{home}");
    }
}

/// Which sensors of a robot that sweeps a home were found frozen, a bit each, and what share of the floor it swept.
fn sweep(plan: &Plan) -> (u16, f64) {
    let (robot, _) = built_in_robot().expect("the built-in robot");
    let mut session = Session::new(&robot, by_default(&robot), "floor").expect("a rig");
    let mut drive = Drive::cleaning(plan, &robot, SimOptions::default(), 1).expect("it fits");
    let mut frozen = 0;
    while !drive.is_over() && drive.step(&mut session).t_s < 1800.0 {
        frozen |= session.slam().frozen_sensors();
    }
    (frozen, drive.floor().score().swept)
}
