//! A fast robot, or a slow log: readings that are far apart on their walls.

use super::random::Random;
use crate::{
    Config, DriveModel, Increment, Motion, Mount, Outcome, RangeInput, RangeModel, RangeSensor, Rig, RobotSlam, Sample,
};

/// A corridor as wide as twice this, metres.
const ASIDE_M: f32 = 0.8;

/// Share of the readings that are used by a robot that drives down a corridor in steps of this length, metres.
fn used(step_m: f32) -> f32 {
    let sensor = |bearing_rad| RangeSensor {
        mount: Mount { bearing_rad, ..Mount::default() },
        min_m: 0.1,
        max_m: 4.0,
        max_incidence_rad: 1.2,
        gain_sigma: 0.0,
        model: RangeModel::Metric { noise_m: 0.02, noise_rel: 0.0 },
    };
    let drive = DriveModel::Odometry {
        scale_sigma: 0.0,
        noise_m2_per_m: 1e-4,
        noise_rad2_per_m: 1e-4,
        noise_rad2_per_rad: 1e-4,
        veer_sigma: 0.0,
    };
    let sensors = [core::f32::consts::FRAC_PI_2, -core::f32::consts::FRAC_PI_2].map(sensor);
    let rig = Rig::<8> { drive, adc: None, sensors: sensors.into_iter().collect() };
    let mut slam = RobotSlam::with_config(rig, Config::real_rooms()).unwrap();
    let mut random = Random::new(1);
    let (mut used, mut all) = (0, 0);
    for number in 0..100 {
        let mut ranges = [RangeInput::Missing; 8];
        ranges[..2].fill_with(|| RangeInput::Metres(ASIDE_M + 0.02 * random.gaussian() as f32));
        let motion = Motion::Increment(Increment { forward_m: step_m, ..Increment::default() });
        let report = slam.step(&Sample { time_us: 250_000 * (number + 1), motion, ranges });
        let is_used = |outcome| matches!(outcome, Outcome::Updated { .. });
        used += report.readings[..2].iter().filter(|reading| is_used(reading.outcome)).count();
        all += 2;
    }
    used as f32 / all as f32
}

#[test]
fn walls_grow_in_steps_as_long_as_the_robots() {
    for step_m in [0.05, 0.1, 0.3, 0.45] {
        let share = used(step_m);
        assert!(share > 0.7, "in steps of {step_m} m {share} of the readings are used");
    }
}

/// In steps as wide as a door nobody knows what is between two readings.
#[test]
fn no_wall_grows_across_doors() {
    assert!(used(0.8) < 0.1);
}
