//! The floor job by what it leaves: swept floor, and a robot that is back.

use hal_sim::floor::{FloorRaster, FloorScore, Moment};
use hal_sim::{ClosedLoop, Estimate, Plan, SimOptions, Simulation, default_rig, plan_file};
use robot::{FloorConfig, FloorJob, FloorState};
use slam_core::{Config, HostSlam};

/// Cleans a home with the default robot and estimator, for so many minutes at most.
fn clean(plan: &Plan, seed: u64, minutes: f64) -> (FloorScore, FloorState) {
    let rig = default_rig();
    let simulation = Simulation::new(plan, &rig, SimOptions::default(), seed).expect("the robot fits");
    let mut slam = HostSlam::with_config(rig.clone(), Config::default()).expect("a good rig");
    let mut floor = FloorRaster::new(plan, simulation.options().body_radius_m, simulation.pose_in_plan());
    let mut robot = ClosedLoop::cleaning(simulation, &rig, FloorConfig::default());
    while !robot.is_over() && robot.simulation.time_s() < 60.0 * minutes {
        robot.step(&mut |sample| {
            let report = slam.step(sample);
            Estimate { pose: slam.pose(), ranges_m: report.readings.map(|reading| reading.range_m) }
        });
        if let (Some((alpha_rad, _)), Some(job)) = (slam.alpha(), &mut robot.floor_job) {
            job.align(alpha_rad);
        }
        let contacts = robot.simulation.contacts();
        floor.record(&Moment {
            t_s: robot.simulation.time_s(),
            pose: robot.simulation.pose_in_plan(),
            doing: robot.doing(),
            is_pressed: contacts.bump_left || contacts.bump_right,
            is_on_floor: true,
        });
    }
    let state = robot.floor_job.expect("it cleans").state();
    (floor.score(), state)
}

#[test]
fn rooms_are_swept_and_the_robot_comes_back() {
    for plan in ["room", "l-shape"] {
        let plan = plan_file::load(plan).expect("a built-in plan");
        let (score, state) = clean(&plan, 1, 20.0);
        assert_eq!(state, FloorState::Done, "{}", plan.name);
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
