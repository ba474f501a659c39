//! The floor job by what it leaves: swept floor, and a robot that is back.

use hal_sim::{SimOptions, clean, default_rig, plan_file};
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
fn a_robot_that_does_not_know_where_it_is_stands() {
    let rig = default_rig();
    let mut job: FloorJob<16> = FloorJob::new(FloorConfig::default(), &rig);
    let pose = slam_core::Pose { x_m: f32::NAN, y_m: 0.0, theta_rad: 0.0 };
    let senses = robot::Senses { time_us: 0, pose, ranges_m: [None; 16], contacts: robot::Contacts::default() };
    assert_eq!(job.step(&senses), robot::WheelSpeeds::STOP);
}
