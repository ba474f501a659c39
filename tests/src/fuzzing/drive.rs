//! A drive through a room that the bytes make, with whatever samples they make of it.

use slam_core::{
    Adc, Clustering, Config, DriveModel, HostSlam, Increment, Linearisation, MapFrame, Motion, Mount, Outcome,
    RangeInput, RangeModel, RangeSensor, Rig, RobotSlam, Sample, Slam, Slip, StepReport, Ticks, WallPolicy, ekf,
};

use super::source::Source;
use crate::frames::{narrowed, narrowed_rig};
use crate::positivity::flaw;

/// A full map, a full buffer and a full state are reached soon.
type SmallSlam = Slam<4, 6, 16, { ekf::storage(24) }>;

/// Most sensors of a rig.
const SENSORS: usize = 16;

/// The whole covariance is looked at once in so many steps.
const LOOK_EVERY: u64 = 50;

/// Drives as the bytes say, with a rig and settings that are good ones; the number of steps.
pub fn samples(bytes: &[u8]) -> u64 {
    let mut source = Source::new(bytes);
    let size = source.below(3);
    let rig = rig(&mut source);
    let config = config(&mut source, &rig);
    match size {
        0 => drive(HostSlam::with_config(rig.clone(), config).expect("a good rig"), &rig, source),
        1 => drive(RobotSlam::with_config(narrowed_rig(&rig), config).expect("a good rig"), &rig, source),
        _ => drive(SmallSlam::with_config(narrowed_rig(&rig), config).expect("a good rig"), &rig, source),
    }
}

/// Steps the estimator through all that the bytes make, and checks it after every one.
pub(super) fn drive<const S: usize, const W: usize, const B: usize, const BLOCKS: usize>(
    mut slam: Slam<S, W, B, BLOCKS>,
    rig: &Rig<SENSORS>,
    mut source: Source,
) -> u64 {
    let mut robot = Robot::new(&mut source);
    let mut steps = 0;
    while !source.is_empty() {
        let stretch = Stretch::of(&mut robot, &mut source);
        for _ in 0..stretch.steps {
            let sample = robot.sample(rig, &stretch, &mut source);
            let report = slam.step(&narrowed(&sample));
            steps += 1;
            check(&slam, &report, steps);
        }
    }
    if let Some(flaw) = flaw(&slam) {
        panic!("after step {steps}: {flaw}");
    }
    steps
}

/// What must be true after every step.
fn check<const S: usize, const W: usize, const B: usize, const BLOCKS: usize>(
    slam: &Slam<S, W, B, BLOCKS>,
    report: &StepReport<S>,
    step: u64,
) {
    let n = slam.state_len();
    for i in 0..n {
        let (mean, variance) = (slam.state_mean(i), slam.state_covariance(i, i));
        assert!(mean.is_finite(), "step {step}: state {i} of {n} is {mean}");
        assert!(variance.is_finite() && variance >= 0.0, "step {step}: variance of state {i} of {n} is {variance:e}");
    }
    for (i, reading) in report.readings.iter().enumerate() {
        if let Outcome::Updated { innovation_m, variance_m2, .. } | Outcome::Gated { innovation_m, variance_m2, .. } =
            reading.outcome
        {
            assert!(innovation_m.is_finite(), "step {step}: innovation of sensor {i} is {innovation_m}");
            assert!(variance_m2.is_finite() && variance_m2 > 0.0, "step {step}: its variance is {variance_m2:e}");
        }
        assert!(reading.range_m.is_none_or(|m| m.is_finite() && m > 0.0), "step {step}: {reading:?}");
        assert!(reading.hit_m.is_none_or(|hit| hit.iter().all(|m| m.is_finite())), "step {step}: {reading:?}");
    }
    let (pose, reckoned) = (slam.pose(), slam.dead_reckoning());
    for value in [pose.x_m, pose.y_m, pose.theta_rad, reckoned.x_m, reckoned.y_m, reckoned.theta_rad] {
        assert!(value.is_finite(), "step {step}: {pose:?}, by dead reckoning {reckoned:?}");
    }
    for wall in slam.walls() {
        assert!(wall.rho_m.is_finite() && wall.beta_rad.is_finite() && wall.lo_m <= wall.hi_m, "step {step}: {wall:?}");
    }
    if step.is_multiple_of(LOOK_EVERY)
        && let Some(flaw) = flaw(slam)
    {
        panic!("step {step}: {flaw}");
    }
}

fn rig(source: &mut Source) -> Rig<SENSORS> {
    let drive = if source.chance(128) {
        DriveModel::Wheels {
            track_m: source.decades(0.05, 1.0) as f32,
            track_sigma: zero_or(source, 1e-4, 0.1),
            metres_per_tick: source.decades(1e-5, 1e-2) as f32,
            scale_sigma: zero_or(source, 1e-4, 0.1),
            noise_m2_per_m: zero_or(source, 1e-8, 1e-3),
        }
    } else {
        DriveModel::Odometry {
            scale_sigma: zero_or(source, 1e-3, 0.2),
            noise_m2_per_m: zero_or(source, 1e-8, 1e-2),
            noise_rad2_per_m: zero_or(source, 1e-8, 1e-2),
            noise_rad2_per_rad: zero_or(source, 1e-8, 1e-2),
            veer_sigma: zero_or(source, 1e-3, 0.1),
        }
    };
    let count = source.below(SENSORS + 1);
    let sensors = (0..count).map(|i| sensor(source, i as f32 * std::f32::consts::TAU / count as f32 - 3.1)).collect();
    Rig { drive, adc: Some(Adc { bits: 12, vref_v: 3.3 }), sensors }
}

/// Zero, which stands for known exactly, one time in eight.
fn zero_or(source: &mut Source, low: f64, high: f64) -> f32 {
    if source.chance(32) { 0.0 } else { source.decades(low, high) as f32 }
}

fn sensor(source: &mut Source, bearing_rad: f32) -> RangeSensor {
    let model = if source.chance(128) {
        RangeModel::Sharp { scale_m: 0.6, exponent: -1.16, noise_v: source.decades(1e-3, 0.1) as f32 }
    } else {
        RangeModel::Metric { noise_m: zero_or(source, 1e-3, 0.1), noise_rel: source.decades(1e-4, 0.1) as f32 }
    };
    RangeSensor {
        mount: Mount { x_m: source.between(-0.2, 0.2) as f32, y_m: source.between(-0.2, 0.2) as f32, bearing_rad },
        min_m: source.between(0.02, 0.3) as f32,
        max_m: source.decades(0.5, 10.0) as f32,
        max_incidence_rad: source.between(0.3, 1.5) as f32,
        gain_sigma: zero_or(source, 1e-3, 0.1),
        model,
    }
}

fn config(source: &mut Source, rig: &Rig<SENSORS>) -> Config {
    let mut config = Config::for_rig(rig);
    if source.chance(128) {
        return config;
    }
    config.walls.policy = [
        WallPolicy::Free,
        WallPolicy::Grid,
        WallPolicy::NearGrid,
        WallPolicy::Snapped { theta_moves: false },
        WallPolicy::Snapped { theta_moves: true },
    ][source.below(5)];
    let mut coin = || source.chance(128);
    config.births.clustering = if coin() { Clustering::Dbscan } else { Clustering::BySensor };
    config.measurement.linearisation = if coin() { Linearisation::Latest } else { Linearisation::FirstEstimates };
    config.walls.frame = if coin() { MapFrame::Start } else { MapFrame::Walls };
    config.walls.relief_m = if coin() { 0.015 } else { 0.0 };
    config.measurement.clutter = coin();
    config.motion.calibrate_scales = coin();
    config.motion.calibrate_track = coin();
    config.motion.slip = if coin() { Slip::OfFloors } else { Slip::Learned };
    config.motion.mean_travel = coin();
    config.sensing.calibrate_gains = coin();
    config.sensing.calibrate_latency = coin();
    config.sensing.stamps = coin();
    config.motion.find_sign = coin();
    config.motion.find_holds = coin();
    config.sensing.repeats = coin();
    config.sensing.bends = coin();
    config.sensing.learn_noise = coin();
    config
}

/// What goes on for some steps.
struct Stretch {
    steps: usize,
    forward_mps: f64,
    turn_radps: f64,
    period_us: u64,
    /// Of 256 samples so many are odd.
    odd: u8,
    /// Nothing is seen.
    blind: bool,
}

impl Stretch {
    fn of(robot: &mut Robot, source: &mut Source) -> Self {
        let kind = source.below(16);
        let mut stretch = Self {
            steps: 1 + source.below(200),
            forward_mps: source.between(-0.1, 0.5),
            turn_radps: if source.chance(100) { 0.0 } else { source.between(-2.0, 2.0) },
            period_us: [40_000, 40_000, 20_000, 100_000, 330_000][source.below(5)],
            odd: 0,
            blind: false,
        };
        match kind {
            0 => (stretch.forward_mps, stretch.turn_radps) = (0.0, 0.0),
            1 => stretch.blind = true,
            2 => stretch.odd = source.byte(),
            3 => stretch.period_us = [1, 1_000, 1_000_000, 3_600_000_000][source.below(4)],
            4 => robot.pose = [source.between(-1.0, 1.0), source.between(-1.0, 1.0), source.between(-3.0, 3.0)],
            5 => robot.room = room(source),
            _ => {}
        }
        stretch
    }
}

type Segment = [[f64; 2]; 2];

/// A room that stands askew, and what stands in it.
fn room(source: &mut Source) -> Vec<Segment> {
    let (half_x, half_y) = (source.decades(0.4, 8.0), source.decades(0.4, 8.0));
    let (sin, cos) = source.between(-0.8, 0.8).sin_cos();
    let turned = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
    let corners = [[-half_x, -half_y], [half_x, -half_y], [half_x, half_y], [-half_x, half_y]];
    let mut walls: Vec<Segment> = (0..4).map(|i| [turned(corners[i]), turned(corners[(i + 1) % 4])]).collect();
    for _ in 0..source.below(8) {
        let from = [source.between(-half_x, half_x), source.between(-half_y, half_y)];
        let (length, quarter) = (source.between(0.1, 2.0), source.below(4) as f64 * std::f64::consts::FRAC_PI_2);
        let to = [from[0] + length * quarter.cos(), from[1] + length * quarter.sin()];
        walls.push([turned(from), turned(to)]);
    }
    walls
}

/// The robot as it really is, and what its odometry has counted.
struct Robot {
    room: Vec<Segment>,
    /// x, y and heading.
    pose: [f64; 3],
    wheels_m: [f64; 2],
    time_us: u64,
}

impl Robot {
    fn new(source: &mut Source) -> Self {
        let time_us = [0, 1 << 40, u64::MAX - 60_000_000][source.below(3)];
        Self { room: room(source), pose: [0.0; 3], wheels_m: [0.0; 2], time_us }
    }

    /// Metres to the nearest wall from a place, in a direction.
    fn cast(&self, [x, y]: [f64; 2], bearing_rad: f64) -> Option<f64> {
        let (dy, dx) = bearing_rad.sin_cos();
        let hits = self.room.iter().filter_map(|[from, to]| {
            let wall = [to[0] - from[0], to[1] - from[1]];
            let cross = dx * wall[1] - dy * wall[0];
            let offset = [from[0] - x, from[1] - y];
            let range = (offset[0] * wall[1] - offset[1] * wall[0]) / cross;
            let along = (offset[0] * dy - offset[1] * dx) / cross;
            (range > 1e-3 && (0.0..=1.0).contains(&along)).then_some(range)
        });
        hits.min_by(f64::total_cmp)
    }

    /// Moves on, and senses.
    fn sample(&mut self, rig: &Rig<SENSORS>, stretch: &Stretch, source: &mut Source) -> Sample<SENSORS> {
        let is_odd = stretch.odd > 0 && source.chance(stretch.odd);
        self.time_us = match if is_odd { source.below(8) } else { 7 } {
            0 => self.time_us.wrapping_sub(1 << source.below(40)),
            1 => self.time_us.saturating_add(1 << source.below(50)),
            _ => self.time_us.saturating_add(stretch.period_us),
        };
        let dt_s = stretch.period_us.min(1_000_000) as f64 * 1e-6;
        let ahead = self.cast([self.pose[0], self.pose[1]], self.pose[2]).unwrap_or(f64::INFINITY);
        let (forward_m, turn_rad) = match stretch.forward_mps * dt_s {
            forward_m if ahead < 0.25 + forward_m => (0.0, dt_s),
            forward_m => (forward_m, stretch.turn_radps * dt_s),
        };
        let (sin, cos) = (self.pose[2] + 0.5 * turn_rad).sin_cos();
        self.pose = [self.pose[0] + forward_m * cos, self.pose[1] + forward_m * sin, self.pose[2] + turn_rad];
        let motion = if is_odd && source.chance(128) {
            odd_motion(source)
        } else {
            self.motion(&rig.drive, forward_m, turn_rad)
        };
        let mut ranges = [RangeInput::Missing; SENSORS];
        for (range, sensor) in ranges.iter_mut().zip(&rig.sensors).filter(|_| !stretch.blind) {
            *range = if is_odd && source.chance(100) { odd_range(source) } else { self.range(sensor) };
        }
        Sample { time_us: self.time_us, motion, ranges }
    }

    fn motion(&mut self, drive: &DriveModel, forward_m: f64, turn_rad: f64) -> Motion {
        match *drive {
            DriveModel::Wheels { track_m, metres_per_tick, .. } => {
                let aside_m = 0.5 * turn_rad * f64::from(track_m);
                self.wheels_m[0] += forward_m - aside_m;
                self.wheels_m[1] += forward_m + aside_m;
                let [left, right] = self.wheels_m.map(|m| (m / f64::from(metres_per_tick)) as i64 as i32);
                Motion::Ticks(Ticks { left, right })
            }
            DriveModel::Odometry { .. } => {
                let (forward_m, turn_rad) = (1.01 * forward_m as f32, 0.99 * turn_rad as f32);
                Motion::Increment(Increment { forward_m, left_m: 0.0, turn_rad })
            }
        }
    }

    fn range(&self, sensor: &RangeSensor) -> RangeInput {
        let (sin, cos) = self.pose[2].sin_cos();
        let (x, y) = (f64::from(sensor.mount.x_m), f64::from(sensor.mount.y_m));
        let origin = [self.pose[0] + cos * x - sin * y, self.pose[1] + sin * x + cos * y];
        let hit_m = self.cast(origin, self.pose[2] + f64::from(sensor.mount.bearing_rad));
        match (sensor.model, hit_m) {
            (RangeModel::Sharp { scale_m, exponent, .. }, hit_m) => {
                let volts = (hit_m.unwrap_or(30.0) / f64::from(scale_m)).powf(1.0 / f64::from(exponent));
                // Noise of a count or two, by the time.
                RangeInput::Counts(((volts / 3.3 * 4095.0) as u16).saturating_add((self.time_us / 1000 % 3) as u16))
            }
            (RangeModel::Metric { .. }, Some(metres)) => RangeInput::Metres(metres as f32),
            (RangeModel::Metric { .. }, None) => RangeInput::Missing,
        }
    }
}

fn odd_motion(source: &mut Source) -> Motion {
    let wide = source.byte();
    let mut ticks = || i32::from_le_bytes([source.byte(), source.byte(), wide, wide]);
    match wide {
        0..80 => Motion::Ticks(Ticks { left: ticks(), right: ticks() }),
        80..110 => Motion::Ticks(Ticks { left: i32::MIN, right: i32::MAX }),
        110..180 => {
            Motion::Increment(Increment { forward_m: source.odd(), left_m: source.odd(), turn_rad: source.odd() })
        }
        _ => {
            let [forward_m, left_m, turn_rad] = [0.4, 0.4, 3.1].map(|most| source.between(-most, most) as f32);
            Motion::Increment(Increment { forward_m, left_m, turn_rad })
        }
    }
}

fn odd_range(source: &mut Source) -> RangeInput {
    match source.below(4) {
        0 => RangeInput::Missing,
        1 => RangeInput::Counts(u16::from_le_bytes([source.byte(), source.byte()])),
        2 => RangeInput::Metres(source.odd()),
        _ => RangeInput::Metres(source.between(0.0, 3.0) as f32),
    }
}
