//! Hours in a home: as good, and as honest, as the first one. Days take a command (`tests/examples/long_drives.rs`).

use hal_sim::{ClosedLoop, Estimate, SimOptions, Simulation};
use lab::recording::Step;
use look_back::{RobotBackEnd, STEP_US};
use robot::PilotConfig;
use robot::rig::BuiltIn;
use slam_core::{Config, HostSlam};
use tests::long_drive::{Hour, drive};

/// 95 % of honest drives have a smaller NEES of a pose whose error stays as it is, as that of the start frame does:
/// chi-square with three degrees of freedom.
const NEES_AT_MOST: f64 = 7.81;

#[test]
fn four_hours_are_as_good_as_one() {
    let plan = hal_sim::plan_file::load("flat").expect("a built-in plan");
    let mut hours: Vec<Hour> = Vec::new();
    let (robot, _) = lab::input::built_in_robot().expect("the built-in rig is good");
    drive(&robot, &plan, 4.0, 1, |hour| hours.push(hour.clone()));
    println!("{hours:#?}");
    let [first, later @ ..] = &hours[..] else { panic!("no hour") };
    assert_eq!(later.len(), 3);
    for hour in &hours {
        assert_eq!(hour.flaw, None, "hour {}", hour.number);
        assert!(hour.nees < NEES_AT_MOST, "hour {}: NEES {}", hour.number, hour.nees);
        assert!(hour.rmse_m < 1.5 * first.rmse_m, "hour {}: {} m", hour.number, hour.rmse_m);
    }
    for hour in later {
        assert!(f64::from(hour.births) < hour.path_m, "hour {}: {} births", hour.number, hour.births);
    }
}

/// Largest error of the position in the start frame, metres, of a robot with time-of-flight sensors that looks back while it drives, and
/// how many look backs it took over.
fn worst_with_hand_overs(plan: &str, minutes: f64, seed: u64) -> (f64, u32) {
    let (home, rig) = (hal_sim::plan_file::load(plan).expect("a built-in plan"), BuiltIn::TimeOfFlight.rig());
    let simulation = Simulation::new(&home, &rig, SimOptions::default(), seed).expect("the robot fits");
    let mut slam = HostSlam::with_config(rig.clone(), Config::for_rig(&rig)).expect("a good rig");
    let mut robot = ClosedLoop::new(simulation, &rig, PilotConfig::default());
    let mut back = Box::new(RobotBackEnd::IDLE);
    let mut worst_m = 0.0f64;
    while robot.simulation.time_s() < 60.0 * minutes {
        let frame = robot.step(&mut |sample| {
            back.work(STEP_US);
            let _ = back.hand_over(&mut slam);
            let report = slam.step(sample);
            back.record(&slam, &report);
            Estimate::new(slam.pose(), &report)
        });
        let (pose, start) = (slam.pose().into(), slam.start_pose().into());
        let error = Step { pose, start, truth: Some(frame.truth), ..Step::default() }.error();
        worst_m = worst_m.max(error.map_or(0.0, |error| error.x_m.hypot(error.y_m)));
    }
    (worst_m, slam.counters().taken_over)
}

#[test]
fn hand_overs_of_a_diary_that_is_long_full_keep_the_map() {
    // In the second drive a surface once seemed to say that the robot drove backwards: two metres off.
    for seed in [1, 8] {
        let (worst_m, taken) = worst_with_hand_overs("corridor-loop", 34.0, seed);
        assert!(taken > 10 && worst_m < 0.4, "seed {seed}: {worst_m} m, {taken} taken over");
    }
}

#[test]
fn a_robot_that_was_held_keeps_the_frame_of_its_start() {
    let (worst_m, taken) = worst_with_hand_overs("room", 24.0, 1);
    assert!(taken > 5 && worst_m < 0.4, "{worst_m} m, {taken} taken over");
}
