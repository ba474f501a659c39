//! The whole pipeline, in the order of the report's section 3: predict, observe, extend the map.

use crate::angle::{sin_cos, wrap};
use crate::association::{Candidate, first_met};
use crate::beam::{Beam, FixedMount, Prediction};
use crate::birth::{self, LocalLine, Verdict};
use crate::buffer::{Outlier, OutlierBuffer};
use crate::cluster::{Members, newest_line};
use crate::config::WallPolicy;
use crate::ekf::{Ekf, Jacobian};
use crate::grid;
use crate::grid::GridDirection;
use crate::layout::{ALPHA, Layout, THETA, X, Y};
use crate::line_fit::FittedLine;
use crate::map::Map;
use crate::motion::{self, Encoders, Factor, Factors, Step};
use crate::odometry::Odometry;
use crate::range::{FrontEnd, Noise, Reading, SHARP_HOLD_S};
use crate::report::ReadingReport;
use crate::wall::{Direction, Wall, WallKind};
use crate::{Config, Counters, DriveModel, Outcome, Pose, RangeInput, Refusal, Rig, RigError, Sample, StepReport};

/// A calibration state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Parameter {
    /// Scale of the left wheel.
    ScaleLeft,
    /// Scale of the right wheel.
    ScaleRight,
    /// Factor of the track.
    Track,
    /// Scale of travelled distance.
    ScaleDistance,
    /// Scale of turned angle.
    ScaleTurn,
    /// Gain of the range sensor with this index.
    Gain(u8),
}

/// A wall of the map: the points p with p . (cos beta, sin beta) = rho, from lo to hi along (-sin beta, cos beta).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WallView {
    /// Identifier, never used again after the wall is gone.
    pub id: u16,
    /// Representation.
    pub kind: WallKind,
    /// Signed distance of the line from the origin along its normal, metres.
    pub rho_m: f32,
    /// Direction of the normal, radians. It points away from the side that the wall was seen from.
    pub beta_rad: f32,
    /// Start of the observed extent, metres.
    pub lo_m: f32,
    /// End of the observed extent, metres.
    pub hi_m: f32,
    /// 1-sigma of rho, metres.
    pub sigma_rho_m: f32,
    /// Readings that updated it.
    pub updates: u32,
}

/// The estimator as it runs on the robot: 8 range sensors, 64 walls, 128 buffered outliers, 80 states.
pub type RobotSlam = Slam<8, 64, 128, 10, 440>;

/// The estimator as the workbench runs it: 16 range sensors, 64 walls of any kind, 160 states.
pub type HostSlam = Slam<16, 64, 128, 20, 1680>;

/// A length that a wall must have to be told from a chair leg, metres; what the buffer's room per sensor is spread over
/// twice.
const SHORTEST_WALL_M: f32 = 0.25;

/// Walls that one beam is held against: beyond its end a wall may go on or not, and at a corner two may.
const MAX_CANDIDATES: usize = 4;

/// The estimator: at most `S` range sensors, `W` walls, `B` buffered outliers and `8 NB` states; `BLOCKS` must be
/// `4 NB (NB + 1)`.
pub struct Slam<const S: usize, const W: usize, const B: usize, const NB: usize, const BLOCKS: usize> {
    rig: Rig<S>,
    config: Config,
    layout: Layout<S>,
    mounts: [FixedMount; S],
    front_ends: [FrontEnd; S],
    ekf: Ekf<NB, BLOCKS>,
    has_grid: bool,
    encoders: Encoders,
    time_us: Option<u64>,
    last_step: Step,
    dt_s: f32,
    nominal: Pose,
    odometry: Odometry,
    map: Map<W>,
    buffer: OutlierBuffer<B>,
    /// Sensors with a buffered point that has not been clustered yet.
    pending: [bool; S],
    counters: Counters,
}

impl<const S: usize, const W: usize, const B: usize, const NB: usize, const BLOCKS: usize> Slam<S, W, B, NB, BLOCKS> {
    /// An estimator at the map frame's origin with an empty map.
    ///
    /// # Errors
    /// A value of the rig that cannot be.
    pub fn new(rig: Rig<S>, config: Config) -> Result<Self, RigError> {
        const { assert!(S <= 16 && B <= 255 && 4 + 3 + S <= 8 * NB, "S <= 16, B <= 255, room for the calibration") };
        rig.validate()?;
        let mut ekf = Ekf::EMPTY;
        for _ in [X, Y, THETA, ALPHA] {
            ekf.augment(0.0, &Jacobian::new(), 0.0);
        }
        let layout = Layout::new(&rig, &config, |sigma| {
            ekf.augment(1.0, &Jacobian::new(), sigma * sigma);
        });
        let mut mounts = [FixedMount::new(&Default::default()); S];
        for (mount, sensor) in mounts.iter_mut().zip(&rig.sensors) {
            *mount = FixedMount::new(&sensor.mount);
        }
        Ok(Self {
            rig,
            config,
            layout,
            mounts,
            front_ends: [FrontEnd::default(); S],
            ekf,
            has_grid: false,
            encoders: Encoders::default(),
            time_us: None,
            last_step: Step::default(),
            dt_s: 0.0,
            nominal: Pose::default(),
            odometry: Odometry::default(),
            map: Map::default(),
            buffer: OutlierBuffer::default(),
            pending: [false; S],
            counters: Counters::default(),
        })
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
        self.place_hits(&mut report);
        report
    }

    /// Moves the pose by the motion input (report 3.1).
    fn predict(&mut self, sample: &Sample<S>) {
        let first = self.time_us.is_none();
        let elapsed_us = sample.time_us - self.time_us.replace(sample.time_us).unwrap_or(sample.time_us);
        self.dt_s = elapsed_us as f32 * 1e-6;
        self.last_step = Step::default();
        let travel = self.encoders.travel(&self.rig.drive, &sample.motion, self.dt_s);
        let Some(travel) = travel else {
            self.counters.bad_motion = self.counters.bad_motion.saturating_add(1);
            return;
        };
        if first {
            return;
        }
        let factors = self.factors();
        let step = motion::step(&self.rig.drive, &travel, &factors);
        let heading = sin_cos(self.ekf.mean(THETA));
        let (jacobian, noise) = step.in_map(heading, &factors);
        let pose = step.applied_to(&self.pose());
        self.ekf.predict([pose.x_m, pose.y_m, pose.theta_rad], &jacobian, &noise);
        self.odometry.advance(&step);
        let known = Factor { value: 1.0, state: None };
        let nominal = motion::step(&self.rig.drive, &travel, &Factors { first: known, second: known, track: known });
        self.nominal = nominal.applied_to(&self.nominal);
        self.last_step = step;
    }

    fn factors(&self) -> Factors {
        let factor = |state: Option<usize>| Factor { value: state.map_or(1.0, |i| self.ekf.mean(i)), state };
        Factors {
            first: factor(self.layout.first_scale),
            second: factor(self.layout.second_scale),
            track: factor(self.layout.track),
        }
    }

    fn gain(&self, sensor: usize) -> f32 {
        self.layout.gains.get(sensor).copied().flatten().map_or(1.0, |i| self.ekf.mean(i))
    }

    /// One scalar update for every reading (report eq. 3).
    fn observe(&mut self, sample: &Sample<S>, report: &mut StepReport<S>) {
        for (i, (input, report)) in sample.ranges.iter().zip(&mut report.readings).enumerate() {
            let (Some(sensor), Some(front_end)) = (self.rig.sensors.get(i), self.front_ends.get_mut(i)) else { break };
            if *input == RangeInput::Missing {
                continue;
            }
            let path_m = self.odometry.path_m;
            let reading = match front_end.read(sensor, self.rig.adc.as_ref(), *input, self.dt_s, path_m) {
                Ok(reading) => reading,
                Err(refusal) => {
                    report.outcome = self.refuse(refusal);
                    continue;
                }
            };
            let gain = self.gain(i);
            report.range_m = Some(reading.range_m / gain);
            report.outcome = match self.associate(i, &reading) {
                Ok(outcome) => outcome,
                Err(refusal) => self.refuse(refusal),
            };
            if matches!(report.outcome, Outcome::Unexplained | Outcome::Gated { .. }) {
                self.keep_outlier(i, &reading);
            }
        }
    }

    fn refuse(&mut self, refusal: Refusal) -> Outcome {
        if let Some(count) = self.counters.refused.get_mut(refusal as usize) {
            *count = count.saturating_add(1);
        }
        Outcome::Refused(refusal)
    }

    /// The mount as it was when the reading was made: an analogue sensor's is half a hold old when it comes out, and has
    /// been held for half a sampling period, or hold, on average.
    fn mount_then(&self, sensor: usize, reading: &Reading) -> FixedMount {
        let mount = self.mounts.get(sensor).copied().unwrap_or_else(|| FixedMount::new(&Default::default()));
        if matches!(reading.noise, Noise::Metres { .. }) || self.dt_s <= 0.0 {
            return mount;
        }
        let age_s = 0.5 * (SHARP_HOLD_S + self.dt_s.min(SHARP_HOLD_S));
        let i = self.last_step.increment;
        let ratio = age_s / self.dt_s;
        mount.lagging([ratio * i.forward_m, ratio * i.left_m], ratio * i.turn_rad)
    }

    fn position(&self) -> [f32; 2] {
        [self.ekf.mean(X), self.ekf.mean(Y)]
    }

    /// Finds the wall that the beam meets and updates with it.
    fn associate(&mut self, sensor: usize, reading: &Reading) -> Result<Outcome, Refusal> {
        let heading = sin_cos(self.ekf.mean(THETA));
        let beam = self.mount_then(sensor, reading).beam(self.position(), heading);
        let grid = GridDirection::of(&self.ekf);
        let Some(limits) = self.rig.sensors.get(sensor).copied() else { return Err(Refusal::Invalid) };
        let gain = self.gain(sensor);
        let mut outcome = Outcome::Unexplained;
        let mut beyond_m = 0.0;
        for _ in 0..MAX_CANDIDATES {
            let met = first_met(&self.ekf, &grid, self.map.walls(), &beam, beyond_m, 1.5 * limits.max_m);
            let Some(met) = met else { break };
            // A tenth of a millimetre on, so that rounding does not bring the same wall again.
            beyond_m = met.range_m + 1e-4;
            let Some(&wall) = self.map.walls().get(met.index) else { break };
            let prediction = beam.predict(&met.line);
            let predicted_m = gain * prediction.range_m;
            let innovation = reading.innovation(predicted_m);
            let jacobian = self.jacobian(sensor, gain, &wall, &prediction);
            let noise = innovation.noise_m2 + self.timing_variance(reading, &prediction, heading);
            let variance_m2 = self.ekf.variance(&jacobian) + noise;
            let innovation_m = innovation.value_m;
            if innovation_m * innovation_m <= self.config.gate * variance_m2 {
                if met.cos_incidence < libm::cosf(limits.max_incidence_rad) {
                    return Err(Refusal::Incidence);
                }
                // A reading that only its noise brought inside the sensor's limits is a biased one.
                let margin = 2.0 * libm::sqrtf(innovation.noise_m2);
                if predicted_m > limits.max_m - margin {
                    return Err(Refusal::TooFar);
                }
                if predicted_m < limits.min_m + margin.min(0.5 * limits.min_m) {
                    return Err(Refusal::TooNear);
                }
                self.ekf.update(innovation_m, &jacobian, noise).map_err(|_| Refusal::Degenerate)?;
                self.ekf.set_mean(THETA, wrap(self.ekf.mean(THETA)));
                self.counters.updates = self.counters.updates.saturating_add(1);
                self.map.met(met.index, met.along_m, self.odometry.path_m);
                return Ok(Outcome::Updated { wall: wall.id, innovation_m, variance_m2 });
            }
            if outcome == Outcome::Unexplained {
                outcome = Outcome::Gated { wall: wall.id, innovation_m, variance_m2 };
            }
            if met.inside_m > 0.0 {
                self.judge_pass(&met, innovation_m, variance_m2);
                break;
            }
        }
        Ok(outcome)
    }

    /// A reading well beyond a wall, well inside its extent, went through it.
    fn judge_pass(&mut self, met: &Candidate, innovation_m: f32, variance_m2: f32) {
        let margin_m = 0.1 + 3.0 * libm::sqrtf(variance_m2);
        if innovation_m > margin_m && met.inside_m > margin_m {
            self.map.passed_through(met.index);
        }
    }

    /// Variance of an analogue reading from not knowing when it was made: uniform within a sampling period or hold.
    fn timing_variance(&self, reading: &Reading, prediction: &Prediction, (sin, cos): (f32, f32)) -> f32 {
        if matches!(reading.noise, Noise::Metres { .. }) || self.dt_s <= 0.0 {
            return 0.0;
        }
        let i = self.last_step.increment;
        let moved = [cos * i.forward_m - sin * i.left_m, sin * i.forward_m + cos * i.left_m];
        let change_m = prediction.by_position[0] * moved[0]
            + prediction.by_position[1] * moved[1]
            + prediction.by_heading * i.turn_rad;
        let spread_m = change_m * (self.dt_s.min(SHARP_HOLD_S) / self.dt_s);
        spread_m * spread_m * (1.0 / 12.0)
    }

    /// Row of the measurement Jacobian, at most seven entries.
    fn jacobian(&self, sensor: usize, gain: f32, wall: &Wall, prediction: &Prediction) -> Jacobian {
        let mut row = Jacobian::new();
        let mut push = |i: usize, derivative: f32| {
            // The capacity is three times what a measurement has.
            let _ = row.push((i, derivative));
        };
        push(X, gain * prediction.by_position[0]);
        push(Y, gain * prediction.by_position[1]);
        push(THETA, gain * prediction.by_heading);
        match wall.direction {
            Direction::Grid(_) => push(ALPHA, gain * prediction.by_beta),
            Direction::Free(theta) => push(theta, gain * prediction.by_beta),
            Direction::Snapped(theta) => {
                push(ALPHA, gain * prediction.by_beta);
                if self.config.walls == (WallPolicy::Snapped { theta_moves: true }) {
                    push(theta, gain * prediction.by_beta);
                }
            }
        }
        push(wall.rho, gain * prediction.by_rho);
        if let Some(state) = self.layout.gains.get(sensor).copied().flatten() {
            push(state, prediction.range_m);
        }
        row
    }

    /// Puts a reading that fits no wall into the ring buffer, unless the sensor's last one ended at the same place.
    fn keep_outlier(&mut self, sensor: usize, reading: &Reading) {
        let pose = self.odometry.pose;
        let beam = self.mount_then(sensor, reading).beam([pose.x_m, pose.y_m], sin_cos(pose.theta_rad));
        let hit_m = beam.at(reading.range_m / self.gain(sensor));
        let spacing_m = self.spacing_m();
        if let Some((_, last)) = self.buffer.newest_of(sensor as u8) {
            // Across the beam: along it, noise alone moves the hit.
            let d = [hit_m[0] - last.hit_m[0], hit_m[1] - last.hit_m[1]];
            let across_m = d[1] * beam.direction[0] - d[0] * beam.direction[1];
            if across_m.abs() < spacing_m {
                return;
            }
        }
        let outlier = Outlier {
            sensor: sensor as u8,
            hit_m,
            direction: beam.direction,
            by_factor: self.odometry.by_factor(hit_m),
            range_m: reading.range_m,
            sigma_m: reading.sigma_m(),
            position_variance: self.odometry.position_variance,
            heading_variance: self.odometry.heading_variance,
        };
        self.counters.buffered = self.counters.buffered.saturating_add(1);
        if self.buffer.push(outlier) {
            self.counters.overwritten = self.counters.overwritten.saturating_add(1);
        }
        if let Some(pending) = self.pending.get_mut(sensor) {
            *pending = true;
        }
    }

    /// Distance between buffered hits of one sensor at which the buffer holds a stretch twice as long as the shortest
    /// wall for every sensor at once.
    fn spacing_m(&self) -> f32 {
        2.0 * SHORTEST_WALL_M * self.rig.sensors.len() as f32 / B as f32
    }

    /// Finds at most one new wall among the outliers (report 3.3), and keeps the map tidy.
    fn extend_map(&mut self, report: &mut StepReport<S>) {
        if let Some(sensor) = self.pending.iter().position(|p| *p) {
            if let Some(pending) = self.pending.get_mut(sensor) {
                *pending = false;
            }
            let found = newest_line(&self.buffer, sensor as u8, self.config.clustering, self.spacing_m());
            if let Some((members, line)) = found
                && self.is_wall(sensor, &line)
                && self.give_birth(&members, &line)
            {
                report.births += 1;
                self.counters.births = self.counters.births.saturating_add(1);
            }
        }
        grid::upkeep(&mut self.map, &mut self.ekf, &mut self.has_grid, self.config.walls, self.counters.steps as usize);
        let walls = self.map.walls().len();
        // One wall a step is held against all others.
        let turn =
            if report.births > 0 { walls.saturating_sub(1) } else { self.counters.steps as usize % walls.max(1) };
        if self.map.merge(&mut self.ekf, turn) {
            report.merges += 1;
            self.counters.merges = self.counters.merges.saturating_add(1);
        }
        if self.map.prune(&mut self.ekf, self.odometry.path_m) {
            report.prunes += 1;
            self.counters.prunes = self.counters.prunes.saturating_add(1);
        }
    }

    /// Long enough, seen under angles that the sensor supports, and not bent around a corner (3 sigma).
    fn is_wall(&self, sensor: usize, line: &FittedLine) -> bool {
        let Some(limits) = self.rig.sensors.get(sensor) else { return false };
        line.length_m() >= SHORTEST_WALL_M
            && line.cos_incidence >= libm::cosf(limits.max_incidence_rad)
            && line.bend < 3.0
    }

    fn give_birth(&mut self, members: &Members<B>, line: &FittedLine) -> bool {
        let local = self.in_robot_frame(members, line);
        let grid = self.has_grid.then(|| GridDirection::of(&self.ekf));
        let verdict = birth::judge(&self.ekf, self.config.walls, grid.as_ref(), &local);
        if verdict == Verdict::Wait {
            return false;
        }
        let states = if self.map.is_full() { None } else { birth::add_states(&mut self.ekf, verdict, &local) };
        let Some((rho, direction)) = states else {
            self.counters.map_full = self.counters.map_full.saturating_add(1);
            return false;
        };
        let grid = GridDirection::of(&self.ekf);
        let wall = Wall { rho, direction, ..Wall::NEW };
        let centroid = self.pose().transform(local.centroid_m);
        let along_m = wall.line(&self.ekf, &grid).along(centroid);
        let extent = (along_m + line.lo_m, along_m + line.hi_m);
        self.map.add(rho, direction, extent, line.count, self.odometry.path_m);
        self.buffer.retain(|i, _| !members.get(i).copied().unwrap_or(false));
        true
    }

    /// The fitted line from the odometry frame into the robot's, with the odometry's noise since its points were seen.
    fn in_robot_frame(&self, members: &Members<B>, line: &FittedLine) -> LocalLine {
        let to_robot = self.odometry.pose.inverse();
        let centroid_m = to_robot.transform(line.centroid_m);
        let normal_rad = line.normal_rad - self.odometry.pose.theta_rad;
        let heading = (self.odometry.heading_variance - line.heading_variance).max(0.0);
        let position = (self.odometry.position_variance - line.position_variance).max(0.0);
        let (s, c) = sin_cos(normal_rad);
        let lever_m = centroid_m[1] * c - centroid_m[0] * s;
        let points = || self.buffer.iter().zip(members).filter(|(_, member)| **member).map(|(point, _)| point);
        let mut by_calibration = heapless::Vec::new();
        for (sensor, state) in self.layout.gains.iter().enumerate() {
            let Some(state) = *state else { continue };
            let gain = self.gain(sensor);
            let of_sensor = points().filter(|p| usize::from(p.sensor) == sensor);
            // hit = origin + range / gain * direction
            let (offset, direction) =
                line.by_parameter(of_sensor, |p| p.direction.map(|d| -p.range_m / (gain * gain) * d));
            if offset != 0.0 {
                let _ = by_calibration.push((state, offset, direction));
            }
        }
        for (factor, state) in [self.layout.first_scale, self.layout.second_scale, self.layout.track].iter().enumerate()
        {
            let Some(state) = *state else { continue };
            // What moves the point moves the robot too: what counts is the difference.
            let (offset, direction) = line.by_parameter(points(), |p| {
                let [then, now] =
                    [p.by_factor, self.odometry.by_factor(p.hit_m)].map(|d| d.get(factor).copied().unwrap_or([0.0; 2]));
                [then[0] - now[0], then[1] - now[1]]
            });
            let _ = by_calibration.push((state, offset, direction));
        }
        LocalLine {
            centroid_m,
            normal_rad,
            // A heading that walks randomly over a stretch moves its end by a third of the lever squared.
            variance_m2: line.variance_m2 + position + heading * lever_m * lever_m * (1.0 / 3.0),
            direction_variance: line.direction_variance + heading,
            by_calibration,
        }
    }

    /// Where the beams ended, with the pose after the step.
    fn place_hits(&self, report: &mut StepReport<S>) {
        let heading = sin_cos(self.ekf.mean(THETA));
        for (mount, reading) in self.mounts.iter().zip(&mut report.readings) {
            let beam: Beam = mount.beam(self.position(), heading);
            reading.hit_m = reading.range_m.map(|range_m| beam.at(range_m));
        }
    }

    /// The rig.
    pub fn rig(&self) -> &Rig<S> {
        &self.rig
    }

    /// The estimated pose in the map frame.
    pub fn pose(&self) -> Pose {
        Pose { x_m: self.ekf.mean(X), y_m: self.ekf.mean(Y), theta_rad: self.ekf.mean(THETA) }
    }

    /// Covariance of (x, y, theta): m^2, m rad, rad^2.
    pub fn pose_covariance(&self) -> [[f32; 3]; 3] {
        [X, Y, THETA].map(|i| [X, Y, THETA].map(|j| self.ekf.covariance(i, j)))
    }

    /// The pose by the motion input alone, with the rig's nominal calibration.
    pub fn dead_reckoning(&self) -> Pose {
        self.nominal
    }

    /// Direction of the wall grid and its 1-sigma, radians; none before the first grid wall.
    pub fn alpha(&self) -> Option<(f32, f32)> {
        self.has_grid.then(|| (self.ekf.mean(ALPHA), self.sigma(ALPHA)))
    }

    fn sigma(&self, i: usize) -> f32 {
        libm::sqrtf(self.ekf.covariance(i, i).max(0.0))
    }

    /// The walls of the map.
    pub fn walls(&self) -> impl Iterator<Item = WallView> + '_ {
        let grid = GridDirection::of(&self.ekf);
        self.map.walls().iter().map(move |wall| {
            let line = wall.line(&self.ekf, &grid);
            WallView {
                id: wall.id,
                kind: wall.kind(),
                rho_m: line.rho_m,
                beta_rad: line.beta_rad,
                lo_m: wall.lo_m,
                hi_m: wall.hi_m,
                sigma_rho_m: self.sigma(wall.rho),
                updates: wall.updates,
            }
        })
    }

    /// Every calibration state with its estimate (a factor, 1 where exact) and 1-sigma.
    pub fn calibration(&self) -> impl Iterator<Item = (Parameter, f32, f32)> + '_ {
        let (first, second) = match self.rig.drive {
            DriveModel::Wheels { .. } => (Parameter::ScaleLeft, Parameter::ScaleRight),
            DriveModel::Odometry { .. } => (Parameter::ScaleDistance, Parameter::ScaleTurn),
        };
        let drive = [
            (first, self.layout.first_scale),
            (second, self.layout.second_scale),
            (Parameter::Track, self.layout.track),
        ];
        let gains = self.layout.gains.iter().enumerate().map(|(i, state)| (Parameter::Gain(i as u8), *state));
        drive
            .into_iter()
            .chain(gains)
            .filter_map(|(parameter, state)| state.map(|i| (parameter, self.ekf.mean(i), self.sigma(i))))
    }

    /// Counts of everything used and refused.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Length of the state vector at present.
    pub fn state_len(&self) -> usize {
        self.ekf.len()
    }
}
