//! Board, wheel control, the robot's job and an estimator in one loop.

use robot::{FloorConfig, Job, PilotConfig, Senses, WheelSpeeds, Whereabouts};
use slam_core::{Adc, Pose, RangeInput, RangeModel, Rig, Sample, StepReport};

use crate::pose::Pose2;
use crate::simulation::{MAX_SENSORS, Simulation};

/// What an estimator makes of one sample, for the pilot to drive by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimated pose in the start frame.
    pub pose: Pose,
    /// Corrected ranges, metres, in the rig's order; none where there is no valid reading.
    pub ranges_m: [Option<f32>; MAX_SENSORS],
}

impl Estimate {
    /// Of a robot with at most as many sensors as are simulated, by its pose and what came of its readings.
    pub fn new<const S: usize>(pose: Pose, report: &StepReport<S>) -> Self {
        const { assert!(S <= MAX_SENSORS) };
        let range_m = |index: usize| report.readings.get(index)?.range_m;
        Self { pose, ranges_m: std::array::from_fn(range_m) }
    }
}

/// One sample and the truth at its time: record a drive once, feed it to many estimators.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// What the robot sensed.
    pub sample: Sample<MAX_SENSORS>,
    /// The true pose in the start frame.
    pub truth: Pose2,
    /// The wheel-drop switches say that it is off the floor.
    pub lifted: bool,
}

/// A robot that drives through its home by what an estimator tells its job.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// The robot in its home.
    pub simulation: Simulation,
    /// What it is at: the robot's own program.
    pub job: Job<MAX_SENSORS>,
    command: Option<WheelSpeeds>,
}

impl ClosedLoop {
    /// A robot about to take its first sample, which explores. The pilot's body radius and track are the simulation's.
    pub fn new(simulation: Simulation, rig: &Rig<MAX_SENSORS>, config: PilotConfig) -> Self {
        let job = Job::exploring(fitted(config, &simulation), rig);
        Self { simulation, job, command: None }
    }

    /// A robot that cleans.
    pub fn cleaning(simulation: Simulation, rig: &Rig<MAX_SENSORS>, config: FloorConfig) -> Self {
        let drive = fitted(config.drive, &simulation);
        let job = Job::cleaning(FloorConfig { drive, ..config }, rig);
        Self { simulation, job, command: None }
    }

    /// Carries out the last command until the next sample, has it estimated, and lets the job choose the next
    /// command. The first call takes the sample at time 0. The pose is in one map all the time.
    pub fn step(&mut self, estimator: &mut impl FnMut(&Sample<MAX_SENSORS>) -> Estimate) -> Frame {
        self.step_in(&mut |sample| (estimator(sample), Whereabouts::START))
    }

    /// The same where what is known of the map is told.
    pub fn step_in(&mut self, estimator: &mut impl FnMut(&Sample<MAX_SENSORS>) -> (Estimate, Whereabouts)) -> Frame {
        let sample = match self.command {
            Some(command) => self.simulation.step(command),
            None => self.simulation.sample(),
        };
        let (contacts, condition) = (self.simulation.contacts(), self.simulation.condition());
        let seen = if contacts.lifted { sample.without_ranges() } else { sample };
        let (Estimate { pose, ranges_m }, whereabouts) = estimator(&seen);
        let senses = Senses { time_us: sample.time_us, pose, ranges_m, contacts, condition };
        self.command = Some(self.job.step(&senses, &whereabouts));
        Frame { sample, truth: self.simulation.pose(), lifted: contacts.lifted }
    }

    /// Drives for a time (seconds) and records every frame.
    pub fn record(
        &mut self,
        duration_s: f64,
        estimator: &mut impl FnMut(&Sample<MAX_SENSORS>) -> Estimate,
    ) -> Vec<Frame> {
        let end_s = self.simulation.time_s() + duration_s;
        let mut frames = Vec::with_capacity((duration_s.max(0.0) * self.simulation.options().rate_hz) as usize + 2);
        while self.command.is_none() || self.simulation.time_s() < end_s - 1e-9 {
            frames.push(self.step(estimator));
        }
        frames
    }
}

/// The manner of driving of a robot of this size.
fn fitted(config: PilotConfig, simulation: &Simulation) -> PilotConfig {
    PilotConfig { radius_m: simulation.options().body_radius_m as f32, track_m: simulation.track_m() as f32, ..config }
}

/// The ranges of a sample by the rig's nominal curves, metres: no gain, no filter. None outside a sensor's limits.
pub fn nominal_ranges(rig: &Rig<MAX_SENSORS>, sample: &Sample<MAX_SENSORS>) -> [Option<f32>; MAX_SENSORS] {
    let mut ranges_m = [None; MAX_SENSORS];
    for ((range_m, input), sensor) in ranges_m.iter_mut().zip(&sample.ranges).zip(&rig.sensors) {
        let nominal_m = match (*input, sensor.model, rig.adc) {
            (RangeInput::Metres(metres), _, _) => metres,
            (RangeInput::Counts(counts), RangeModel::Sharp { scale_m, exponent, .. }, Some(adc)) => {
                scale_m * libm::powf(volts(adc, counts), exponent)
            }
            _ => continue,
        };
        *range_m = (nominal_m >= sensor.min_m && nominal_m <= sensor.max_m).then_some(nominal_m);
    }
    ranges_m
}

fn volts(adc: Adc, counts: u16) -> f32 {
    f32::from(counts) / adc.full_scale() as f32 * adc.vref_v
}
