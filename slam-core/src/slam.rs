//! The whole pipeline, in the order of section 3 of Rousse & Qiu: predict, observe, extend the map.

use crate::births::candidates::{Candidates, Kept, Unexplained};
use crate::clock::{Clock, Tick};
use crate::config::Config;
use crate::filter::ekf::{Ekf, Jacobian, storage};
use crate::filter::layout::{self, ALPHA, THETA};
use crate::geometry::angle::{sin_cos, wrap};
use crate::health::{Asked, HealthMonitor};
use crate::holds::Holds;
use crate::holds::frozen::Frozen;
use crate::jolts::Jolts;
use crate::jolts::recent::Seen;
use crate::measurement::first_estimates::{FirstEstimates, Linearisation};
use crate::measurement::observe::Observer;
use crate::measurement::sensor::{Sensor, SensorState};
use crate::measurement::slippage::{Direction, Slippage};
use crate::motion::Slip;
use crate::motion::drive::{Drive, DriveStates, Way};
use crate::motion::shortfall::Shortfall;
use crate::motion::step::{Step, start_variance};
use crate::report::{Counters, Outcome, Refusal, StepReport};
use crate::rig::{DriveModel, MAX_SENSORS, Rig, RigError};
use crate::sample::{Motion, RangeInput, Sample};
use crate::sensing::correlation::SurfaceCorrelation;
use crate::sensing::latency::{Latency, Timing};
use crate::sensing::noise_level::NoiseLevels;
use crate::sensing::output_noise::OutputNoise;
use crate::sensing::sign::Sign;
use crate::walls::map::{Map, MapFrame};
use heapless::Vec;

/// What rounding takes from the covariance is given back once in so many steps. Twice as often, walls that are out of sight
/// for a day would drift by millimetres; a quarter as often, a day's roundings at a metre's sigma would be too many.
const ROUNDING_STEPS: u32 = 16;

/// Variances from this on, (decimetres)^2 or (decirad)^2, get it back at once: such a wall does not drift by that.
const LARGE: f32 = 0.01;

/// The type of an estimator for so many range sensors (at most 16), walls of any kind, and readings that fit none and wait
/// to become walls (at most 255): `slam_type!(sensors: 4, walls: 32, outliers: 64)`.
#[macro_export]
macro_rules! slam_type {
    (sensors: $sensors:expr, walls: $walls:expr, outliers: $outliers:expr) => {
        $crate::Slam<{ $sensors }, { $walls }, { $outliers }, { $crate::ekf::storage($crate::states($sensors, $walls)) }>
    };
}

/// Most states that so many range sensors and walls have: pose and grid, calibration of the drive, gains, latency and a
/// row's offset from it, and two a wall.
pub const fn states(sensors: usize, walls: usize) -> usize {
    4 + 3 + sensors + 2 + 2 * walls
}

/// The estimator as it runs on the robot: 8 range sensors, 64 walls, 128 buffered outliers, 80 states.
pub type RobotSlam = Slam<8, 64, 128, { storage(80) }>;

/// The estimator as the workbench runs it: 16 range sensors, 64 walls of any kind, 160 states.
pub type HostSlam = Slam<16, 64, 128, { storage(160) }>;

/// The estimator: at most `S` range sensors, `W` walls, `B` buffered outliers and as many states as `ROWS` =
/// [`ekf::storage`](crate::ekf::storage)`(states)` is for.
pub struct Slam<const S: usize, const W: usize, const B: usize, const ROWS: usize> {
    pub(crate) rig: Rig<S>,
    pub(crate) config: Config,
    clock: Clock,
    pub(crate) drive: Drive,
    pub(crate) sign: Sign<S>,
    pub(crate) sensors: [SensorState; S],
    pub(crate) latency: Latency,
    pub(crate) levels: NoiseLevels,
    pub(crate) slippage: Slippage,
    pub(crate) output_noise: OutputNoise,
    pub(crate) correlation: SurfaceCorrelation<S>,
    pub(crate) ekf: Ekf<ROWS>,
    pub(crate) first: FirstEstimates,
    pub(crate) shortfall: Shortfall,
    pub(crate) map: Map<W>,
    pub(crate) candidates: Candidates<B>,
    pub(crate) monitor: HealthMonitor,
    pub(crate) jolts: Jolts,
    pub(crate) holds: Holds<S>,
    pub(crate) frozen: Frozen<S>,
    pub(crate) counters: Counters,
}

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
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
        config: Config::IDLE,
        clock: Clock::NEW,
        drive: Drive::START,
        sign: Sign::TRUE,
        sensors: [SensorState::NONE; S],
        latency: Latency::NONE,
        levels: NoiseLevels::STATED,
        slippage: Slippage::BELIEVED,
        output_noise: OutputNoise::UNKNOWN,
        correlation: SurfaceCorrelation::NEW,
        ekf: Ekf::IDLE,
        first: FirstEstimates::START,
        shortfall: Shortfall::NONE,
        map: Map::EMPTY,
        candidates: Candidates::NONE,
        monitor: HealthMonitor::NEW,
        jolts: Jolts::NONE,
        holds: Holds::NONE,
        frozen: Frozen::NONE,
        counters: Counters::ZERO,
    };

    /// An estimator at the map frame's origin with an empty map and the settings that suit the rig
    /// ([`Config::for_rig`]).
    ///
    /// # Errors
    /// A value of the rig that cannot be.
    pub fn new(rig: Rig<S>) -> Result<Self, RigError> {
        let config = Config::for_rig(&rig);
        Self::with_config(rig, config)
    }

    /// An estimator like that of [`Slam::new`] with other settings.
    ///
    /// # Errors
    /// A value of the rig that cannot be.
    pub fn with_config(rig: Rig<S>, config: Config) -> Result<Self, RigError> {
        let mut slam = Self::IDLE;
        slam.start_with_config(rig, config)?;
        Ok(slam)
    }

    /// Starts, or starts afresh, in place: where the robot stands is the map frame's origin, and the map is empty. Unlike
    /// [`Slam::new`] it puts no copy of the estimator on the stack.
    ///
    /// # Errors
    /// A value of the rig that cannot be; nothing is changed then.
    pub fn start(&mut self, rig: Rig<S>) -> Result<(), RigError> {
        let config = Config::for_rig(&rig);
        self.start_with_config(rig, config)
    }

    /// Starts like [`Slam::start`] with other settings.
    ///
    /// # Errors
    /// A value of the rig that cannot be; nothing is changed then.
    pub fn start_with_config(&mut self, rig: Rig<S>, config: Config) -> Result<(), RigError> {
        const {
            assert!(S <= MAX_SENSORS && B <= 255, "at most 16 sensors and 255 outliers");
            assert!(4 + 3 + S < Ekf::<ROWS>::CAPACITY, "room for the calibration");
        };
        rig.validate()?;
        config.validate()?;
        self.ekf.clear();
        self.rig = rig;
        self.config = config;
        // Every hand-over tells anew how the map lies to the start.
        if config.hand_overs {
            self.config.walls.frame = MapFrame::Walls;
        }
        self.clock = Clock::NEW;
        self.drive = Drive::START;
        self.sign = if config.motion.find_sign { Sign::unknown(&self.rig.drive) } else { Sign::TRUE };
        self.sensors = [SensorState::NONE; S];
        self.latency = Latency::NONE;
        self.levels = NoiseLevels::STATED;
        self.slippage = Slippage::BELIEVED;
        self.output_noise = OutputNoise::UNKNOWN;
        self.correlation = SurfaceCorrelation::NEW;
        (self.first, self.shortfall) = (FirstEstimates::START, Shortfall::NONE);
        self.map.clear(self.config.walls.frame);
        self.candidates.clear();
        self.monitor = HealthMonitor::NEW;
        (self.jolts, self.holds, self.frozen) = (Jolts::NONE, Holds::NONE, Frozen::NONE);
        (self.counters, self.map.has_dock) = (Counters::ZERO, false);
        self.add_states();
        Ok(())
    }

    /// Adds the pose, the grid's direction and every calibration state that is to be estimated and not known exactly.
    pub(crate) fn add_states(&mut self) {
        let Self { rig, config, drive, sensors, latency, ekf, .. } = self;
        for variance in start_variance(&rig.drive).into_iter().chain([0.0]) {
            ekf.augment(0.0, &Jacobian::new(), variance);
        }
        let mut allot = |is_wanted: bool, mean: f32, sigma: f32| {
            if is_wanted && sigma > 0.0 { ekf.augment(mean, &Jacobian::new(), sigma * sigma) } else { None }
        };
        let (scale_sigma, (is_wanted, mean, sigma)) = match rig.drive {
            DriveModel::Wheels { scale_sigma, track_sigma, .. } => {
                (scale_sigma, (config.motion.calibrate_track, 1.0, track_sigma))
            }
            DriveModel::Odometry { scale_sigma, veer_sigma, .. } => {
                (scale_sigma, (config.motion.calibrate_scales, 0.0, veer_sigma))
            }
        };
        let scales = config.motion.calibrate_scales;
        let allotted = [(scales, 1.0, scale_sigma), (scales, 1.0, scale_sigma), (is_wanted, mean, sigma)]
            .map(|(a, b, c)| allot(a, b, c));
        let [first_scale, second_scale, third] = allotted.map(|state| state.map(|i| i as u16));
        drive.states = DriveStates { first_scale, second_scale, third };
        for (state, sensor) in sensors.iter_mut().zip(&rig.sensors) {
            *state = SensorState::new(sensor, allot(config.sensing.calibrate_gains, 1.0, sensor.gain_sigma));
        }
        *latency = Latency::new(rig, &config.sensing, allot);
    }

    /// Predict, observe, extend the map (Rousse & Qiu section 3). Never fails: what cannot be used is refused and counted.
    pub fn step(&mut self, sample: &Sample<S>) -> StepReport<S> {
        let mut report = StepReport::NOTHING;
        self.forget_if_due();
        self.count_anew_if_due();
        self.counters.add_step();
        let Some(tick) = self.clock.tick(sample.time_us) else {
            self.counters.add_motion(true);
            self.drive.rest();
            report.health = self.monitor.health();
            return report;
        };
        report.dt_s = tick.dt_s;
        self.predict(&sample.motion, tick);
        self.turn_round(&sample.ranges);
        let predicted = Direction::of(&self.ekf);
        self.observe(&sample.ranges, tick.dt_s, &mut report);
        let updates = report.updates();
        self.watch_sensors(updates, &sample.ranges, &report);
        self.slippage.corrected(predicted, Direction::of(&self.ekf));
        if let Some(times) = self.slippage.restated() {
            let of_walls = self.map.first_state(&self.ekf);
            self.ekf.widen(times, ALPHA + 1..of_walls);
        }
        self.recover_from_hold();
        self.recover_from_jolt(updates > 0, tick.turns());
        self.extend_map(tick.turns(), &mut report);
        self.latency.settle(&mut self.ekf);
        let is_turn = self.counters.steps.is_multiple_of(ROUNDING_STEPS);
        self.ekf.restore_rounding(if is_turn { 0.0 } else { LARGE });
        report.health = self.examine(if is_turn { usize::MAX } else { ALPHA });
        let theta_rad = wrap(self.ekf.mean(THETA));
        self.ekf.set_mean(THETA, theta_rad);
        self.map.follow_calibration(&self.ekf, &self.drive.states);
        self.map.hold_frame(&self.ekf, self.drive.dead_reckoning.path_m);
        self.place_hits(tick.dt_s, &mut report);
        report
    }

    /// Moves the pose by the motion input (Rousse & Qiu 3.1).
    fn predict(&mut self, motion: &Motion, tick: Tick) {
        let travel = self.drive.travel(&self.rig.drive, motion, tick.dt_s);
        if tick.is_first {
            // Where motion starts from; there is none yet that could be wrong but in kind.
            self.counters.add_motion(!motion.fits(&self.rig.drive));
            return;
        }
        self.counters.add_motion(travel.is_none());
        let turn_rad = travel.map_or(0.0, |travel| travel.turn_rad(&self.rig.drive));
        let ended = travel.and_then(|travel| self.sign.follow(&travel, turn_rad, tick.dt_s));
        let noise = self.wheel_level();
        let way = Way { is_reversed: self.sign.is_reversed, is_held: self.holds.is_held(), noise };
        let Self { rig, config, drive, ekf, .. } = self;
        let seen = drive.dead_reckoning.pose;
        let factors = drive.advance(&rig.drive, &config.motion, travel, way, tick.dt_s, ekf);
        self.holds.follow(&drive.turned, tick.dt_s);
        let step = &drive.step;
        let learned = |noise| self.levels.of_motion(noise, &rig.drive);
        let mut noise = if config.sensing.learn_noise { learned(&step.noise) } else { step.noise };
        if config.motion.slip == Slip::Learned {
            self.slippage.moved(step.path_m, noise[2][2]);
        }
        noise[0][0] += self.shortfall.advance(step.path_m, self.map.heading_variance(ekf));
        let before = layout::pose(ekf);
        let (jacobian, noise) = Step { noise, ..*step }.in_map(sin_cos(before.theta_rad), &factors);
        let pose = step.applied_to(&before);
        let jacobian = match config.measurement.linearisation {
            Linearisation::Latest => jacobian,
            Linearisation::FirstEstimates => self.first.of_motion(jacobian, &pose),
        };
        self.first.pose = pose;
        ekf.predict([pose.x_m, pose.y_m, pose.theta_rad], &jacobian, &noise);
        let now = drive.dead_reckoning.pose;
        self.sign.moved([now.x_m - seen.x_m, now.y_m - seen.y_m]);
        self.latency.follow(step.increment, tick.dt_s);
        if let Some(ended) = ended {
            self.displace(ended.moved_m, ended.sigma_m);
        }
    }

    /// Time goes on by so much, seconds.
    fn wait(&mut self, dt_s: f32) {
        self.jolts.wait(dt_s, &self.drive.step, self.counters.steps);
        self.holds.wait(dt_s, &self.drive.step, self.counters.steps);
    }

    /// Updates with every reading that is a wall's, and keeps those that fit none (Rousse & Qiu eq. 3).
    #[inline(never)]
    fn observe(&mut self, inputs: &[RangeInput; S], dt_s: f32, report: &mut StepReport<S>) {
        self.wait(dt_s);
        self.latency.stamps.begin_row(&mut self.ekf);
        let odometry = &self.drive.dead_reckoning;
        let timing = Timing { dt_s, step: &self.drive.step, latency: &self.latency };
        let mut observer = Observer {
            settings: &self.config.measurement,
            sensing: &self.config.sensing,
            walls: &self.config.walls,
            ekf: &mut self.ekf,
            map: &mut self.map,
            levels: &mut self.levels,
            correlation: &mut self.correlation,
            first: &self.first,
            timing,
            path_m: odometry.path_m,
            number: self.counters.steps,
            along_m: 0.0,
        };
        let asked = Asked::in_step(self.counters.steps, self.drive.step.beams_moved_m());
        let sensors = self.rig.sensors.iter().zip(&mut self.sensors).enumerate();
        let rows =
            sensors.zip(inputs).zip(&mut report.readings).filter(|((_, input), _)| **input != RangeInput::Missing);
        for (((index, (limits, state)), input), report) in rows {
            let (adc, noise) = (self.rig.adc.as_ref(), &mut self.output_noise);
            let reading = state.front_end.read(limits, adc, *input, dt_s, odometry.path_m, noise);
            let sensor = Sensor { index, limits, state };
            if let Ok(reading) = &reading {
                report.range_m = Some(reading.range_m / state.gain(observer.ekf));
            } else if matches!(reading, Err(Refusal::TooFar | Refusal::Floor)) {
                self.monitor.note_absence(observer.judge_absence(&sensor));
                self.holds.note_absence(&sensor);
            }
            report.outcome = match reading {
                Ok(reading) if self.jolts.is_in_doubt() => Outcome::Refused(observer.why_not(&sensor, &reading)),
                Ok(reading) => observer.observe(&sensor, &reading).unwrap_or_else(Outcome::Refused),
                Err(refusal) => Outcome::Refused(refusal),
            };
            self.counters.add_reading(&report.outcome);
            self.monitor.note(&report.outcome, observer.path_m, asked.of(index, observer.along_m));
            if let Outcome::Updated { wall, .. } = report.outcome {
                self.shortfall = Shortfall::NONE;
                self.sign.met(index, || observer.normal_rad(wall));
            }
            let Ok(reading) = &reading else { continue };
            self.holds.note(&sensor, reading, &timing, (observer.ekf, observer.map), &report.outcome);
            if self.jolts.asks(index) {
                let seen = Seen::new(&sensor, reading, &timing, odometry, observer.ekf, observer.number);
                self.jolts.note(index, seen, &report.outcome);
            }
            if matches!(report.outcome, Outcome::Unexplained | Outcome::Gated { .. }) {
                let Observer { ekf, number, .. } = &observer;
                let outlier = Unexplained { sensor: &sensor, reading, timing, odometry, ekf, number: *number };
                let kept = self.candidates.keep(&outlier, Candidates::<B>::spacing_m(self.rig.sensors.len()));
                if kept != Kept::No {
                    self.counters.add_outlier(kept == Kept::ForOldest);
                }
            }
        }
        self.latency.stamps.end_row(&self.ekf);
    }
}
