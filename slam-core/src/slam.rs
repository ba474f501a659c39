//! The whole pipeline, in the order of the report's section 3: predict, observe, extend the map.

use crate::births::buffer::OutlierBuffer;
use crate::births::verdict::Doubts;
use crate::config::{Clustering, Config, Linearisation, MapFrame, WallPolicy};
use crate::filter::ekf::{Ekf, Jacobian};
use crate::filter::layout::{Layout, THETA};
use crate::geometry::angle::{sin_cos, wrap};
use crate::geometry::pose::Pose;
use crate::measurement::beam::FixedMount;
use crate::measurement::first_estimates::First;
use crate::motion::dead_reckoning::Odometry;
use crate::motion::mean_motion::Pace;
use crate::motion::step::{self, Factor, Factors, Step};
use crate::motion::travel::{Encoders, Travel};
use crate::report::{Counters, ReadingReport, StepReport};
use crate::rig::{DriveModel, Rig, RigError};
use crate::sample::Sample;
use crate::sensing::correlation::Repeats;
use crate::sensing::noise_level::NoiseLevels;
use crate::sensing::range::FrontEnd;
use crate::walls::list::Map;
use heapless::Vec;

/// What scales multiply is an average of the motion over this time, seconds: noise of a fifteenth of a step's square, ten
/// times a second, then draws them down by a hundredth (tests/paces.rs).
const TRAVEL_S: f32 = 1.0;

/// The estimator as it runs on the robot: 8 range sensors, 64 walls, 128 buffered outliers, 80 states.
pub type RobotSlam = Slam<8, 64, 128, 10, 480>;

/// The estimator as the workbench runs it: 16 range sensors, 64 walls of any kind, 160 states.
pub type HostSlam = Slam<16, 64, 128, 20, 1760>;

/// The estimator: at most `S` range sensors, `W` walls, `B` buffered outliers and `8 NB` states; `BLOCKS` must be
/// [`covariance::blocks`](crate::filter::covariance::blocks)`(NB)`.
pub struct Slam<const S: usize, const W: usize, const B: usize, const NB: usize, const BLOCKS: usize> {
    pub(crate) rig: Rig<S>,
    pub(crate) config: Config,
    pub(crate) layout: Layout<S>,
    pub(crate) mounts: [FixedMount; S],
    /// Cosine of the largest incidence at which each sensor is trusted.
    pub(crate) min_cos: [f32; S],
    pub(crate) front_ends: [FrontEnd; S],
    pub(crate) ekf: Ekf<NB, BLOCKS>,
    pub(crate) has_grid: bool,
    pub(crate) encoders: Encoders,
    pub(crate) time_us: Option<u64>,
    pub(crate) last_step: Step,
    pub(crate) dt_s: f32,
    /// Time between two samples, as a rule, seconds.
    pub(crate) typical_dt_s: f32,
    /// Motion over the time that a reading may be late.
    pub(crate) pace: Pace,
    /// Motion as the odometry says it, before the scales.
    pub(crate) travel: Pace,
    pub(crate) nominal: Pose,
    pub(crate) odometry: Odometry,
    pub(crate) map: Map<W>,
    pub(crate) buffer: OutlierBuffer<B>,
    /// Sensors with a buffered point that has not been clustered yet.
    pub(crate) pending: [bool; S],
    /// The sensor whose points were clustered last.
    pub(crate) last_clustered: usize,
    pub(crate) counters: Counters,
    pub(crate) repeats: Repeats<S>,
    pub(crate) levels: NoiseLevels,
    pub(crate) doubts: Doubts,
    pub(crate) first: First,
    /// Where the robot started, in the map frame.
    pub(crate) start: Pose,
}

impl<const S: usize, const W: usize, const B: usize, const NB: usize, const BLOCKS: usize> Slam<S, W, B, NB, BLOCKS> {
    /// Not started. Every value here is one whose bytes are zero, so that a static of it costs no flash.
    pub const IDLE: Self = Self {
        rig: Rig {
            drive: DriveModel::Wheels {
                track_m: 0.0,
                track_sigma: 0.0,
                metres_per_tick: 0.0,
                scale_sigma: 0.0,
                noise_m2_per_m: 0.0,
            },
            adc: None,
            sensors: Vec::new(),
        },
        config: Config {
            walls: WallPolicy::Snapped { theta_moves: false },
            clustering: Clustering::BySensor,
            calibrate_gains: false,
            calibrate_scales: false,
            calibrate_track: false,
            gate: 0.0,
            linearisation: Linearisation::Latest,
            repeats: false,
            relief_m: 0.0,
            frame: MapFrame::Start,
            clutter: false,
            calibrate_latency: false,
            slip: false,
            mean_travel: false,
            learn_noise: false,
        },
        layout: Layout { first_scale: None, second_scale: None, track: None, gains: [None; S], latency: None },
        mounts: [FixedMount::NONE; S],
        min_cos: [0.0; S],
        front_ends: [FrontEnd::NEW; S],
        ekf: Ekf::EMPTY,
        has_grid: false,
        encoders: Encoders::NEW,
        time_us: None,
        last_step: Step::STILL,
        dt_s: 0.0,
        typical_dt_s: 0.0,
        pace: Pace::STILL,
        travel: Pace::STILL,
        nominal: Pose::ORIGIN,
        odometry: Odometry::START,
        map: Map::EMPTY,
        buffer: OutlierBuffer::EMPTY,
        pending: [false; S],
        last_clustered: 0,
        counters: Counters::ZERO,
        repeats: Repeats::NEW,
        levels: NoiseLevels::STATED,
        doubts: Doubts::NONE,
        first: First::START,
        start: Pose::ORIGIN,
    };

    /// An estimator at the map frame's origin with an empty map.
    ///
    /// # Errors
    /// A value of the rig that cannot be.
    pub fn new(rig: Rig<S>, config: Config) -> Result<Self, RigError> {
        let mut slam = Self::IDLE;
        slam.start(rig, config)?;
        Ok(slam)
    }

    /// Starts, or starts afresh, in place: where the robot stands is the map frame's origin, and the map is empty. Unlike
    /// [`Slam::new`] it puts no copy of the estimator on the stack.
    ///
    /// # Errors
    /// A value of the rig that cannot be; nothing is changed then.
    pub fn start(&mut self, rig: Rig<S>, config: Config) -> Result<(), RigError> {
        const { assert!(S <= 16 && B <= 255 && 4 + 3 + S < 8 * NB, "S <= 16, B <= 255, room for the calibration") };
        rig.validate()?;
        self.ekf.clear();
        for variance in step::start_variance(&rig.drive).into_iter().chain([0.0]) {
            self.ekf.augment(0.0, &Jacobian::new(), variance);
        }
        let ekf = &mut self.ekf;
        self.layout = Layout::new(&rig, &config, |mean, sigma| {
            ekf.augment(mean, &Jacobian::new(), sigma * sigma);
        });
        for ((mount, min_cos), sensor) in self.mounts.iter_mut().zip(&mut self.min_cos).zip(&rig.sensors) {
            *mount = FixedMount::new(&sensor.mount);
            *min_cos = libm::cosf(sensor.max_incidence_rad);
        }
        self.rig = rig;
        self.config = config;
        self.front_ends = [FrontEnd::NEW; S];
        self.has_grid = false;
        self.encoders = Encoders::NEW;
        self.time_us = None;
        self.last_step = Step::STILL;
        self.dt_s = 0.0;
        self.typical_dt_s = 0.0;
        self.pace = Pace::STILL;
        self.travel = Pace::STILL;
        self.nominal = Pose::ORIGIN;
        self.odometry = Odometry::START;
        self.map.clear();
        self.buffer.clear();
        self.pending = [false; S];
        self.last_clustered = 0;
        self.counters = Counters::ZERO;
        self.repeats = Repeats::NEW;
        self.levels = NoiseLevels::STATED;
        self.doubts = Doubts::NONE;
        self.first = First::START;
        self.start = Pose::ORIGIN;
        Ok(())
    }

    /// Predict, observe, extend the map (report section 3). Never fails: what cannot be used is refused and counted.
    pub fn step(&mut self, sample: &Sample<S>) -> StepReport<S> {
        let mut report = StepReport { readings: [ReadingReport::default(); S], births: 0, merges: 0, prunes: 0 };
        self.counters.steps = self.counters.steps.saturating_add(1);
        if self.time_us.is_some_and(|last| sample.time_us <= last) {
            self.counters.bad_motion = self.counters.bad_motion.saturating_add(1);
            return report;
        }
        self.predict(sample);
        self.observe(sample, &mut report);
        self.extend_map(&mut report);
        self.settle_latency();
        self.ekf.set_mean(THETA, wrap(self.ekf.mean(THETA)));
        self.hold_frame();
        self.place_hits(&mut report);
        report
    }

    /// Moves the pose by the motion input (report 3.1).
    fn predict(&mut self, sample: &Sample<S>) {
        let first = self.time_us.is_none();
        let elapsed_us = sample.time_us - self.time_us.replace(sample.time_us).unwrap_or(sample.time_us);
        self.dt_s = elapsed_us as f32 * 1e-6;
        let travel = self.encoders.travel(&self.rig.drive, &sample.motion, self.dt_s);
        if first {
            // Where motion starts from; there is none yet that could be wrong but in kind.
            self.counters.bad_motion += u32::from(!sample.motion.fits(&self.rig.drive));
            return;
        }
        let factors = self.factors();
        let step = match &travel {
            Some(travel) => self.real_step(travel, &factors),
            None => {
                self.counters.bad_motion = self.counters.bad_motion.saturating_add(1);
                self.last_step.lost()
            }
        };
        let heading = sin_cos(self.ekf.mean(THETA));
        let noise = if self.config.learn_noise { self.levels.of_motion(&step.noise) } else { step.noise };
        let (mut jacobian, noise) = Step { noise, ..step }.in_map(heading, &factors);
        let pose = step.applied_to(&self.pose_from_start());
        self.linearise_motion(&mut jacobian, pose);
        self.ekf.predict([pose.x_m, pose.y_m, pose.theta_rad], &jacobian, &noise);
        self.odometry.advance(&step);
        self.last_step = step;
        self.keep_pace();
        let Some(travel) = travel else { return };
        let known = Factor { value: 1.0, state: None };
        let nominal = step::step(&self.rig.drive, &travel, &Factors { first: known, second: known, track: known });
        self.nominal = nominal.applied_to(&self.nominal);
    }

    /// The step that was travelled, as real floors and odometry make it.
    fn real_step(&mut self, travel: &Travel, factors: &Factors) -> Step {
        let mut step = step::step(&self.rig.drive, travel, factors);
        let Travel::Body(raw) = *travel else { return step.unsteady(self.dt_s) };
        if self.config.slip {
            step = step.slipping();
        }
        if self.config.mean_travel {
            self.travel.follow(raw, self.dt_s, TRAVEL_S);
            step.by_factor = step::by_scales(self.travel.over(self.dt_s));
        }
        step
    }

    fn factors(&self) -> Factors {
        let factor = |state: Option<usize>| Factor { value: state.map_or(1.0, |i| self.ekf.mean(i)), state };
        Factors {
            first: factor(self.layout.first_scale),
            second: factor(self.layout.second_scale),
            track: factor(self.layout.track),
        }
    }

    pub(crate) fn gain(&self, sensor: usize) -> f32 {
        self.layout.gains.get(sensor).copied().flatten().map_or(1.0, |i| self.ekf.mean(i))
    }
}
