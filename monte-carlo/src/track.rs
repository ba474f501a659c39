//! One estimator fed sample by sample, with what an experiment needs of it kept.

use std::time::Duration;

use hal_sim::{Estimate, Frame};
use slam_core::ekf::storage;
use slam_core::{Config, HostSlam, Outcome, RigError, Sample, Slam, WallView};

use lab::input::rig_file::{MAX_SENSORS, Robot};
use lab::recording::{Step, nis};

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
    nis_sum: f64,
}

impl<const B: usize> Tracker<B> {
    /// An estimator at the origin with an empty map.
    ///
    /// # Errors
    /// A value of the rig that the estimator refuses.
    pub fn new(robot: &Robot, config: Config) -> Result<Self, RigError> {
        Ok(Self {
            slam: Box::new(Slam::with_config(robot.rig.clone(), config)?),
            track: Track::default(),
            nis_sum: 0.0,
        })
    }

    /// Estimates one sample; for a pilot to drive by.
    pub fn estimate(&mut self, sample: &Sample<MAX_SENSORS>) -> Estimate {
        let report = self.slam.step(sample);
        let t_s = sample.time_us as f64 * 1e-6;
        for reading in &report.readings {
            if let Outcome::Updated { innovation_m, variance_m2, .. } = reading.outcome {
                self.nis_sum += nis(&reading.outcome).unwrap_or(0.0);
                self.track.innovations.push((t_s, f64::from(innovation_m / variance_m2.sqrt())));
            }
        }
        let estimate = self.slam.estimate();
        self.track.steps.push(Step {
            t_s,
            pose: estimate.pose.into(),
            start: self.slam.start_pose().into(),
            covariance: estimate.covariance.into(),
            dead_reckoning: self.slam.dead_reckoning().into(),
            walls: self.slam.walls().count(),
            ..Step::default()
        });
        Estimate { pose: estimate.pose, ranges_m: report.readings.map(|reading| reading.range_m) }
    }

    /// The track, with the truth of the frames that it was made from.
    pub fn finish(mut self, frames: &[Frame]) -> Track {
        self.track.walls = self.slam.walls().collect();
        self.track.bytes = size_of_val(&*self.slam);
        let used = self.track.innovations.len();
        self.track.mean_nis = (used > 0).then(|| self.nis_sum / used as f64);
        self.track.reveal(frames);
        self.track
    }
}

impl Track {
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
