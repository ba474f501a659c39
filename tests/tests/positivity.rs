//! The whole covariance stays one where its numbers are hardest to hold, and the bars are honest there.

use hal_sim::{ClosedLoop, Estimate, Plan, SimOptions, Simulation, default_rig};
use robot::PilotConfig;
use slam_core::{Config, HostSlam, SURFACE_M};
use tests::long_drive::square;
use tests::positivity::{eigenvalues_are_above, flaw};

/// What the smallest eigenvalue of the correlation matrix stays above: sqrt(a R / (m J)), docs/explanation/estimator.md,
/// "Numbers". Of a reading's noise the surface's share is always there; each step has a reading of eight sensors at most; a
/// reading depends on three states as unsure as the least sure one.
fn least_eigenvalue(slam: &HostSlam) -> f64 {
    let largest = (0..slam.state_len()).map(|i| f64::from(slam.state_covariance(i, i))).fold(0.0, f64::max);
    let given_back = if largest < 0.01 { 2f64.powi(-26) } else { 2f64.powi(-22) };
    (given_back * f64::from(SURFACE_M).powi(2) / (8.0 * 3.0 * largest)).sqrt()
}

/// The covariance is looked at once in so many steps.
const LOOK_EVERY: u32 = 500;

/// Drives for this long and returns the mean over steps of the position's squared error over its variance, x and y together:
/// two for an honest filter.
fn drive(plan: &Plan, minutes: f64, seed: u64) -> f64 {
    let rig = default_rig();
    let simulation = Simulation::new(plan, &rig, SimOptions::default(), seed).expect("the robot fits");
    let mut slam = HostSlam::with_config(rig.clone(), Config::default()).expect("a good rig");
    let mut robot = ClosedLoop::new(simulation, &rig, PilotConfig::default());
    let (mut sum, mut steps) = (0.0, 0u32);
    while robot.simulation.time_s() < 60.0 * minutes {
        let frame = robot.step(&mut |sample| {
            let report = slam.step(sample);
            Estimate::new(slam.pose(), &report)
        });
        steps += 1;
        let (pose, p) = (slam.pose(), slam.estimate().covariance.map(f64::from));
        let (x, y) = (f64::from(pose.x_m) - frame.truth.x_m, f64::from(pose.y_m) - frame.truth.y_m);
        let determinant = p[(0, 0)] * p[(1, 1)] - p[(0, 1)] * p[(0, 1)];
        if determinant > 1e-18 {
            sum += (x * x * p[(1, 1)] - 2.0 * x * y * p[(0, 1)] + y * y * p[(0, 0)]) / determinant;
        }
        if steps.is_multiple_of(LOOK_EVERY) {
            assert_eq!(flaw(&slam), None, "{}, seed {seed}, step {steps}", plan.name);
            let least = least_eigenvalue(&slam);
            assert!(eigenvalues_are_above(&slam, least), "{}, seed {seed}, step {steps}: {least:e}", plan.name);
        }
    }
    assert!(slam.walls().count() >= 2, "{}, seed {seed}: no wall was found", plan.name);
    sum / f64::from(steps)
}

/// Squares in which the first wall is met after metres without any, up to a hall. The mean over the drives must be what an honest
/// filter has: 2, and at most 5 where each drive's error is that of one way to the first wall.
#[test]
fn large_empty_rooms_are_driven_with_honest_bars() {
    let sides_m = [8.0, 12.0, 20.0, 30.0, 60.0];
    let means = sides_m.map(|side_m| drive(&square(side_m), 12.0, 2));
    println!("mean squared errors over their variance, sides of {sides_m:?} m: {means:.2?}");
    assert!(means.iter().sum::<f64>() / means.len() as f64 <= 5.0, "{means:.2?}");
    assert!(means.iter().all(|mean| *mean < 12.0), "{means:.2?}");
}

/// An hour in each of the homes whose covariance was lost first: the bits of a day's drive take a command, not a test.
#[test]
fn an_hour_in_a_home_leaves_a_covariance() {
    for plan in ["flat", "clutter", "diagonal"] {
        let plan = hal_sim::plan_file::load(plan).expect("a built-in plan");
        drive(&plan, 60.0, 1);
    }
}
