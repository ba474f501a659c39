//! Floor jobs of robots of which a part fails, and over sills: what a robot believes of itself.

use hal_sim::SimOptions;
use hal_sim::fault::{Fault, Part};
use hal_sim::plan::Plan;
use hal_sim::random_home::{random_home, sills};
use lab::input::built_in;
use lab::run::{FloorDrive, clean_by};
use robot::FloorState;
use robot::rig::BuiltIn;

/// A home in which these parts of the robot fail after a minute, for so long, seconds.
fn with_faults(home: u64, lasts_s: f64, parts: impl IntoIterator<Item = Part>) -> Plan {
    let mut plan = random_home(home);
    plan.mishaps.faults = parts.into_iter().map(|part| Fault { part, at_s: 60.0, lasts_s }).collect();
    plan
}

fn swept(plan: &Plan) -> FloorDrive {
    swept_by(BuiltIn::default(), plan)
}

fn swept_by(kind: BuiltIn, plan: &Plan) -> FloorDrive {
    let (robot, _) = built_in(kind).expect("a built-in robot");
    let drive = clean_by(&robot, plan, SimOptions::default(), 1, None, |_, _| ()).expect("the robot fits");
    assert_eq!(drive.progress.state, FloorState::Done, "{}: {:?}", plan.name, drive.progress);
    assert!(drive.score.swept > 0.95, "{}: {} of the floor", plan.name, drive.score.swept);
    drive
}

#[test]
fn a_bumper_that_is_jammed_or_dust_on_the_cliff_sensor_stops_the_job_for_as_long_as_it_lasts() {
    for (home, part) in [(621, Part::BumpLeft), (622, Part::BumpRight), (623, Part::Cliff)] {
        let drive = swept(&with_faults(home, 200.0, [part]));
        let touched_s = drive.progress.seconds_in[FloorState::Touched as usize];
        assert!((150..=200).contains(&touched_s), "random-{home}: {touched_s} s");
    }
}

#[test]
fn a_robot_whose_sensors_all_fall_silent_stands_until_they_are_back() {
    for home in [624, 625, 626] {
        let silent = (0..4).map(|index| Part::Sensor { index, shows_m: None });
        let drive = swept_by(BuiltIn::TimeOfFlight, &with_faults(home, 600.0, silent));
        let blind_s = drive.progress.seconds_in[FloorState::Blind as usize];
        assert!(blind_s > 200, "random-{home}: {blind_s} s, {:?}", drive.progress);
        assert!(drive.worst_m < 1.0, "random-{home}: {} m off", drive.worst_m);
    }
}

#[test]
fn over_sills_the_robot_stays_in_its_map() {
    for home in (625..).filter(|home| !sills(*home).is_empty()).take(3) {
        let mut plan = random_home(home);
        plan.mishaps.sills = sills(home);
        assert_eq!(swept(&plan).lost, 0, "random-{home}");
    }
}
