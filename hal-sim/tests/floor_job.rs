//! The floor job by what it leaves: swept floor, and a robot that is back.

use hal_sim::mishap::Hold;
use hal_sim::{BatteryOptions, Pose2, SimOptions, clean, default_rig, plan_file};
use robot::{FloorConfig, FloorJob, FloorState};

#[test]
fn rooms_are_swept_and_the_robot_comes_back() {
    for plan in ["room", "l-shape"] {
        let plan = plan_file::load(plan).expect("a built-in plan");
        let drive = clean(&plan, SimOptions::default(), 1, 20.0).expect("the robot fits");
        let (score, progress) = (drive.score, drive.progress);
        assert_eq!(progress.state, FloorState::Done, "{}", plan.name);
        assert!(progress.share() >= 0.95, "{}: it takes {} for its share", plan.name, progress.share());
        let told_s: f64 = progress.seconds_in.iter().map(|seconds| f64::from(*seconds)).sum();
        assert!((told_s - 60.0 * drive.minutes).abs() < 2.0, "{}: {told_s} s are told", plan.name);
        assert!(score.swept >= 0.96, "{}: {} of the floor", plan.name, score.swept);
        assert!(score.largest_hole_m2 <= 0.05, "{}: {} m2 missed in one", plan.name, score.largest_hole_m2);
        assert!(score.home_m <= 0.2, "{}: {} m from where it started", plan.name, score.home_m);
    }
}

#[test]
fn a_flat_battery_is_charged_in_the_dock_and_the_job_goes_on() {
    let mut plan = plan_file::load("room").expect("a built-in plan");
    // At the western wall, which it looks to.
    plan.start = Pose2::new(0.185, 1.75, core::f64::consts::PI);
    let battery = Some(BatteryOptions { charge: 1.0, lasts_min: 6.0, charges_min: 2.0 });
    let options = SimOptions { has_dock: true, battery, ..SimOptions::default() };
    let drive = clean(&plan, options, 1, 30.0).expect("the robot fits");
    let seconds_in = |state: FloorState| drive.progress.seconds_in[state as usize];
    assert_eq!(drive.progress.state, FloorState::Done, "{:?}", drive.progress);
    assert!(seconds_in(FloorState::Charging) > 60, "{:?}", drive.progress);
    assert!(drive.score.swept >= 0.96, "{} of the floor", drive.score.swept);
    assert!(drive.score.home_m <= 0.05, "{} m from the dock", drive.score.home_m);
}

#[test]
fn without_a_dock_a_flat_battery_leads_back_to_the_start() {
    let plan = plan_file::load("room").expect("a built-in plan");
    let battery = Some(BatteryOptions { charge: 1.0, lasts_min: 6.0, charges_min: 2.0 });
    let drive = clean(&plan, SimOptions { battery, ..SimOptions::default() }, 1, 30.0).expect("the robot fits");
    assert_eq!(drive.progress.state, FloorState::Flat);
    assert!(drive.score.home_m <= 0.2, "{} m from where it started", drive.score.home_m);
}

#[test]
fn a_jammed_robot_stalls_stands_and_goes_on_when_it_is_free() {
    let mut plan = plan_file::load("room").expect("a built-in plan");
    plan.mishaps.holds.push(Hold { at_s: 60.0, held_s: 30.0, is_jammed: true });
    let drive = clean(&plan, SimOptions::default(), 1, 30.0).expect("the robot fits");
    assert_eq!(drive.progress.state, FloorState::Done, "{:?}", drive.progress);
    assert!(drive.progress.seconds_in[FloorState::Held as usize] >= 50, "{:?}", drive.progress);
    assert!(drive.worst_m < 0.2, "the pose ran off by {} m", drive.worst_m);
}

#[test]
fn a_held_robot_whose_wheels_turn_finds_out() {
    let mut plan = plan_file::load("room").expect("a built-in plan");
    plan.mishaps.holds.push(Hold { at_s: 60.0, held_s: 120.0, is_jammed: false });
    let drive = clean(&plan, SimOptions::default(), 1, 30.0).expect("the robot fits");
    assert!(drive.worst_m < 8.0, "the pose ran off by {} m", drive.worst_m);
}

#[test]
fn a_robot_that_does_not_know_where_it_is_stands() {
    let rig = default_rig();
    let mut job: FloorJob<16> = FloorJob::new(FloorConfig::default(), &rig);
    let pose = slam_core::Pose { x_m: f32::NAN, y_m: 0.0, theta_rad: 0.0 };
    let senses = robot::Senses {
        time_us: 0,
        pose,
        ranges_m: [None; 16],
        contacts: robot::Contacts::default(),
        condition: robot::Condition::default(),
    };
    assert_eq!(job.step(&senses), robot::WheelSpeeds::STOP);
}
