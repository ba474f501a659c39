//! One estimator fed sample by sample, with what an experiment needs of it kept.

use std::time::Duration;

use hal_sim::{Estimate, Frame};
use look_back::RobotBackEnd;
use slam_core::ekf::storage;
use slam_core::{Config, HostSlam, Outcome, RigError, Sample, Slam, StepReport, WallView};

use lab::evaluate::statistics::mean;
use lab::input::rig_file::{MAX_SENSORS, Robot};
use lab::recording::Step;
use lab::run::Session;

/// What an estimator did on one drive.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// One entry per sample, with its truth.
    pub steps: Vec<Step>,
    /// Innovations of the readings used, in standard deviations, with their times (seconds).
    pub innovations: Vec<(f64, f64)>,
    /// Mean of their squares.
    pub mean_nis: Option<f64>,
    /// The final map.
    pub walls: Vec<WallView>,
    /// Processor time of the estimator, with that of its front end.
    pub time: Duration,
    /// Memory that its state takes, bytes; zero where there is none.
    pub bytes: usize,
    /// RMSE of the whole path as it is known in the end, after the best alignment, metres; none where the past is not corrected.
    pub back_m: Option<f64>,
}

/// The workbench's estimator with room for `B` outliers.
type Estimator<const B: usize> = Slam<MAX_SENSORS, 64, B, { storage(160) }>;

// With the default's room it is the very estimator of `lab run`.
const _: fn(Estimator<128>) -> HostSlam = |slam| slam;

/// A running estimator and its track so far.
pub struct Tracker<const B: usize> {
    slam: Box<Estimator<B>>,
    track: Track,
}

impl<const B: usize> Tracker<B> {
    /// An estimator at the origin with an empty map.
    ///
    /// # Errors
    /// A value of the rig that the estimator refuses.
    pub fn new(robot: &Robot, config: Config) -> Result<Self, RigError> {
        Ok(Self { slam: Box::new(Slam::with_config(robot.rig.clone(), config)?), track: Track::default() })
    }

    /// Estimates one sample; for a pilot to drive by.
    pub fn estimate(&mut self, sample: &Sample<MAX_SENSORS>) -> Estimate {
        let report = self.slam.step(sample);
        self.track.add(&self.slam, sample.time_us, &report, true);
        Estimate::new(self.slam.pose(), &report)
    }

    /// The track, with the truth of the frames that it was made from.
    pub fn finish(self, frames: &[Frame]) -> Track {
        self.track.ended(&self.slam, size_of_val(&*self.slam), frames)
    }
}

impl Track {
    /// Adds what an estimator said after the sample of this time.
    fn add<const B: usize>(
        &mut self,
        slam: &Estimator<B>,
        time_us: u64,
        report: &StepReport<MAX_SENSORS>,
        is_located: bool,
    ) {
        let (estimate, t_s) = (slam.estimate(), time_us as f64 * 1e-6);
        for reading in &report.readings {
            if let Outcome::Updated { innovation_m, variance_m2, .. } = reading.outcome {
                self.innovations.push((t_s, f64::from(innovation_m / variance_m2.sqrt())));
            }
        }
        self.steps.push(Step {
            t_s,
            pose: estimate.pose.into(),
            start: slam.start_pose().into(),
            covariance: estimate.covariance.into(),
            dead_reckoning: slam.dead_reckoning().into(),
            walls: slam.walls().count(),
            searching: !is_located,
            ..Step::default()
        });
    }

    /// The whole of it, with the estimator's map and memory and the truth of the frames that it was made from.
    fn ended<const B: usize>(mut self, slam: &Estimator<B>, bytes: usize, frames: &[Frame]) -> Self {
        let squares: Vec<f64> = self.innovations.iter().map(|(_, deviations)| deviations * deviations).collect();
        self.mean_nis = mean(&squares);
        self.walls = slam.walls().collect();
        self.bytes = bytes;
        self.reveal(frames);
        self
    }

    /// Puts the truth into the steps.
    pub fn reveal(&mut self, frames: &[Frame]) {
        for (step, frame) in self.steps.iter_mut().zip(frames) {
            step.truth = Some(frame.truth);
        }
    }
}

/// Feeds a whole drive to an estimator with room for `B` outliers.
///
/// # Errors
/// A value of the rig that the estimator refuses.
pub fn replay<const B: usize>(robot: &Robot, config: Config, frames: &[Frame]) -> Result<Track, RigError> {
    let mut tracker = Tracker::<B>::new(robot, config)?;
    for frame in frames {
        tracker.estimate(&frame.sample);
    }
    Ok(tracker.finish(frames))
}

/// Feeds a whole drive to a robot: the estimator with its back end and the kept map.
///
/// # Errors
/// A value of the rig that the estimator refuses.
pub fn whole_robot(robot: &Robot, frames: &[Frame]) -> Result<Track, RigError> {
    let config = Config::default().with_hand_overs();
    let mut session = Session::new(robot, config, "")?;
    let mut track = Track::default();
    for frame in frames {
        let report = session.estimate(&frame.sample);
        track.add(session.slam(), frame.sample.time_us, &report, session.is_located());
    }
    let bytes = size_of_val(session.slam()) + size_of::<RobotBackEnd>();
    Ok(track.ended(session.slam(), bytes, frames))
}
