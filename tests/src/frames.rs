//! What a simulated robot senses on a drive: recorded once, fed to many estimators.

use hal_sim::{ClosedLoop, Estimate, Frame, SimOptions, Simulation, default_rig};
use robot::PilotConfig;
use slam_core::{Config, HostSlam, Rig, Sample};

/// The default robot's frames from a built-in plan; the pilot drives by the default estimator.
pub fn recorded(plan: &str, minutes: f64, seed: u64, options: SimOptions) -> Vec<Frame> {
    let plan = hal_sim::plan_file::load(plan).expect("a built-in plan");
    let rig = default_rig();
    let simulation = Simulation::new(&plan, &rig, options, seed).expect("the robot fits");
    let mut slam = HostSlam::with_config(rig.clone(), Config::default()).expect("a good rig");
    let mut robot = ClosedLoop::new(simulation, &rig, PilotConfig::default());
    robot.record(60.0 * minutes, &mut |sample| {
        let report = slam.step(sample);
        Estimate::new(slam.pose(), &report)
    })
}

/// The first `S` sensors' part of a sample.
pub fn narrowed<const S: usize, const T: usize>(sample: &Sample<T>) -> Sample<S> {
    let mut ranges = [slam_core::RangeInput::Missing; S];
    for (range, input) in ranges.iter_mut().zip(sample.ranges) {
        *range = input;
    }
    Sample { time_us: sample.time_us, motion: sample.motion, ranges }
}

/// The first `S` sensors of a rig.
pub fn narrowed_rig<const S: usize, const T: usize>(rig: &Rig<T>) -> Rig<S> {
    Rig { drive: rig.drive, adc: rig.adc, sensors: rig.sensors.iter().copied().take(S).collect() }
}
