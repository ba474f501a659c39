//! One estimator, fed row by row, with everything it did kept in a [`Recording`].

use std::time::{Duration, Instant};

use kept_map::{Record, rig_hash};
use look_back::RobotBackEnd;
use robot::{Bounds, POSE_RECORD_BYTES, PoseNotes, Whereabouts, read_last_pose};
use slam_core::{Config, DriveModel, HostSlam, Outcome, Parameter, RigError, Sample, StepReport};

use super::life::{Life, Place, Searched};
use super::map_file::{MapId, newest};
use super::suits::suits;
use crate::evaluate::score::{nis, path};
use crate::evaluate::statistics;
use crate::input::log::Row;
use crate::input::rig_file::{MAX_SENSORS, Robot};
use crate::recording::{
    CalibrationSnapshot, Figures, HandOver, MapSnapshot, ParameterInfo, Pose2, Recording, SensorInfo, Step,
};

/// How often map and calibration are recorded where nothing else asks for it, seconds of the log.
const SNAPSHOT_EVERY_S: f64 = 1.0;

/// An estimator and the record of what it did.
pub struct Session {
    slam: Box<HostSlam>,
    /// The back end in a robot's size, which does as much in a second as a robot's.
    back: Option<Box<RobotBackEnd>>,
    last_us: Option<u64>,
    life: Life,
    parameters: Vec<Parameter>,
    recording: Recording,
    first_s: Option<f64>,
    estimator_time: Duration,
}

impl Session {
    /// An estimator at the origin with an empty map.
    ///
    /// # Errors
    /// A value of the rig that the estimator refuses.
    pub fn new(robot: &Robot, config: Config, title: impl Into<String>) -> Result<Self, RigError> {
        let slam = Box::new(HostSlam::with_config(robot.rig.clone(), config)?);
        let (parameters, recording) = (parameters_of(robot), begun(robot, title));
        let back = config.hand_overs.then(|| Box::new(RobotBackEnd::IDLE));
        let life = Life::new(&robot.rig);
        let (first_s, estimator_time) = (None, Duration::ZERO);
        Ok(Self { slam, back, last_us: None, life, parameters, recording, first_s, estimator_time })
    }

    /// Begins in a kept map, the bytes of a `map.bin`, not knowing where.
    ///
    /// # Errors
    /// What is wrong with the map.
    pub fn begin_in(&mut self, map: Vec<u8>) -> Result<(), String> {
        let rig = rig_hash(self.slam.rig());
        let map = newest(&map).to_vec();
        let record =
            Record::parse(&map).and_then(|record| record.of_rig(rig)).map_err(|refused| refused.to_string())?;
        suits(&self.slam, &record)?;
        let sequence = record.sequence();
        self.life.begin_in(map, sequence);
        Ok(())
    }

    /// The record that the robot would keep, as a `map.bin`; none where there is no map.
    pub fn map(&self) -> Option<Vec<u8>> {
        self.life.record(&self.slam)
    }

    /// Where the robot is if its power goes now, in this kept map, as it writes it down; none where it is not sure of that.
    pub fn pose_in(&self, map: MapId) -> Option<[u8; POSE_RECORD_BYTES]> {
        let mut memory = [0; POSE_RECORD_BYTES];
        PoseNotes::default().write(&self.life.last_pose(&self.slam)?, map.0, &mut memory);
        Some(memory)
    }

    /// Having begun in this kept map, the robot expects itself where it was when its power went, if these bytes say that.
    pub fn recall(&mut self, map: MapId, bytes: &[u8]) {
        let memory = <[u8; POSE_RECORD_BYTES]>::try_from(bytes);
        if let Some(last) = memory.ok().and_then(|memory| read_last_pose(map.0, &memory)) {
            self.life.stood(last);
        }
    }

    /// These areas, in the frame of the drive's start, are kept with the map.
    pub fn draw_areas(&mut self, bounds: &Bounds) {
        self.life.draw_areas(bounds);
    }

    /// What the robot's job is told of the map that the pose is in now.
    pub fn whereabouts(&self) -> Whereabouts {
        let slam = &self.slam;
        Whereabouts {
            kept: None,
            world: self.life.world(),
            redrawn: slam.counters().second_copies,
            fresh: self.life.fresh(),
            is_located: self.life.is_located(),
            grid_rad: slam.alpha().map(|(alpha_rad, _)| alpha_rad),
            start: slam.start_pose(),
            reckoned: slam.dead_reckoning(),
            corner: self.life.corner(slam),
        }
    }

    /// Whether the pose is claimed in the frame of the kept map, or of the drive's start where there is none.
    pub fn is_located(&self) -> bool {
        self.life.is_located()
    }

    /// How often a place was given up.
    pub fn lost(&self) -> usize {
        self.life.lost()
    }

    /// What the searches for the place in the kept map found so far.
    pub fn searches(&self) -> &[Searched] {
        self.life.searches()
    }

    /// Where the last search found that the robot may be, likeliest first; empty while it is located.
    pub fn places(&self) -> Vec<Place> {
        self.life.places(&self.slam)
    }

    /// The kept map that the robot looks for itself in; none while it is located, or has none.
    pub fn sought(&self) -> Option<Record<'_>> {
        self.life.sought()
    }

    /// Takes in what the charging contact says of the sample that is estimated next.
    pub fn dock(&mut self, is_docked: bool) {
        self.life.dock(is_docked);
    }

    /// Takes in whether the wheel-drop switches say that a wheel hangs.
    pub fn lift(&mut self, hangs: bool) {
        self.life.lift(&mut self.slam, hangs);
    }

    /// Gives one row to the estimator and records what came of it.
    pub fn push(&mut self, row: &Row) -> &Step {
        self.dock(row.docked);
        let sample = if row.lifted { row.sample.without_ranges() } else { row.sample };
        let report = self.estimate(&sample);
        self.lift(row.lifted);
        self.record(row, &report)
    }

    /// Gives one sample to the estimator.
    pub fn estimate(&mut self, sample: &Sample<MAX_SENSORS>) -> StepReport<MAX_SENSORS> {
        self.look_back(sample.time_us);
        let before = now();
        let mut report = self.slam.step(sample);
        self.estimator_time += before.map_or(Duration::ZERO, |before| before.elapsed());
        if let Some(back) = &mut self.back {
            back.record(&self.slam, &report);
        }
        let index = self.recording.steps.len();
        let is_new_frame = self.life.step(&mut self.slam, &report, index);
        if is_new_frame || self.life.is_carried() {
            // Where readings ended is in a frame that is given up.
            report.readings.iter_mut().for_each(|reading| reading.hit_m = None);
        }
        report
    }

    /// Between two samples, as the robot does: looks back, then takes over what was found, if there is anything.
    fn look_back(&mut self, next_us: u64) {
        let since_us = next_us.saturating_sub(self.last_us.replace(next_us).unwrap_or(next_us));
        let Some(back) = &mut self.back else { return };
        back.work(u32::try_from(since_us).unwrap_or(u32::MAX));
        let before = self.slam.pose();
        if let Some(taken) = back.hand_over(&mut self.slam) {
            let moved = Pose2::from(before).relative(&self.slam.pose().into());
            self.recording.hand_overs.push(HandOver { step: self.recording.steps.len(), refused: taken.err(), moved });
        }
    }

    /// Records what came of the sample estimated last.
    pub fn record(&mut self, row: &Row, report: &StepReport<MAX_SENSORS>) -> &Step {
        let index = self.recording.steps.len();
        let estimate = self.slam.estimate();
        let sensed = self.recording.steps.last().map_or_else(Pose2::default, |last| last.sensed);
        let step = Step {
            t_text: row.t_text.clone(),
            t_s: row.t_s - *self.first_s.get_or_insert(row.t_s),
            pose: estimate.pose.into(),
            start: self.slam.start_pose().into(),
            covariance: estimate.covariance.into(),
            alpha: self.slam.alpha(),
            dead_reckoning: self.slam.dead_reckoning().into(),
            sensed: sensed.compose(&self.slam.last_motion().into()),
            lost: self.slam.lost_motion(),
            truth: row.truth.filter(|_| !self.life.is_carried()),
            searching: !self.life.is_located(),
            carried: self.life.is_carried(),
            walls: self.slam.walls().count(),
            births: report.births,
            merges: report.merges,
            prunes: report.prunes,
            restarts: self.slam.counters().restarts,
            health: report.health,
        };
        self.recording.readings.extend_from_slice(&report.readings[..self.recording.sensors.len()]);
        let is_handed_over = self.recording.hand_overs.last().is_some_and(|found| found.step == index);
        let changed = step.births > 0 || step.merges > 0 || step.prunes > 0 || is_handed_over;
        if changed || self.is_due(step.t_s) {
            let (map, calibration) = self.snapshot(index);
            self.recording.maps.push(map);
            self.recording.calibration.push(calibration);
        }
        self.recording.steps.push(step);
        &self.recording.steps[index]
    }

    /// The estimator.
    pub fn slam(&self) -> &HostSlam {
        &self.slam
    }

    /// The record so far.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Ends the session: the record with the figures that need no truth.
    pub fn finish(mut self) -> Recording {
        let figures = self.figures();
        let recording = core::mem::take(&mut self.recording);
        self.closed(recording, figures)
    }

    /// The record as it would be if the session ended now.
    pub fn so_far(&self) -> Recording {
        self.closed(self.recording.clone(), self.figures())
    }

    fn closed(&self, mut recording: Recording, figures: Figures) -> Recording {
        if let Some(last) = recording.steps.len().checked_sub(1)
            && recording.maps.last().is_none_or(|map| map.step != last)
        {
            let (map, calibration) = self.snapshot(last);
            recording.maps.push(map);
            recording.calibration.push(calibration);
        }
        recording.counters = *self.slam.counters();
        recording.searches = self.life.searches().to_vec();
        recording.lost = self.life.lost();
        recording.figures = figures;
        recording
    }

    /// The figures so far that need no truth.
    pub fn figures(&self) -> Figures {
        let recording = &self.recording;
        let mut figures = Figures {
            estimator_s: self.estimator_time.as_secs_f64(),
            duration_s: recording.steps.last().map_or(0.0, |step| step.t_s),
            lost: recording.lost(),
            path_m: path::length_m(recording.steps.iter().map(|step| step.dead_reckoning)),
            walls: recording.steps.last().map_or(0, |step| step.walls),
            latency_s: self.slam.latency().map(|(value, sigma)| (value.into(), sigma.into())),
            ..Figures::default()
        };
        let (mut used, mut all) = (Vec::new(), Vec::new());
        let mut innovations = Vec::new();
        let sensors = recording.sensors.iter().cycle();
        for (reading, sensor) in recording.readings.iter().zip(sensors) {
            innovations.extend(innovation(&reading.outcome, sensor));
            let finite = crate::recording::nis(&reading.outcome).filter(|value| value.is_finite());
            all.extend(finite);
            match reading.outcome {
                Outcome::Updated { .. } => used.push(finite.unwrap_or(0.0)),
                Outcome::Gated { .. } | Outcome::Unexplained => figures.outliers += 1,
                Outcome::Missing | Outcome::Refused(_) => {}
            }
        }
        figures.updates = used.len() as u64;
        figures.mean_nis = statistics::mean(&used);
        figures.nis_before_gate = statistics::mean(&all);
        figures.outside_gate = (!all.is_empty()).then(|| 1.0 - used.len() as f64 / all.len() as f64);
        figures.median_nis_before_gate = statistics::median(&all);
        figures.nis_associated = nis::of_associated(&innovations);
        figures
    }

    fn is_due(&self, t_s: f64) -> bool {
        let last = self.recording.maps.last().map(|map| self.recording.steps[map.step].t_s);
        last.is_none_or(|last_s| t_s - last_s >= SNAPSHOT_EVERY_S)
    }

    /// Map and calibration after this step.
    fn snapshot(&self, step: usize) -> (MapSnapshot, CalibrationSnapshot) {
        // A parameter that is no state is known exactly.
        let value = |parameter: &Parameter| {
            let found = self.slam.calibration().find(|(state, ..)| state == parameter);
            let known = if *parameter == Parameter::Veer { 0.0 } else { 1.0 };
            found.map_or((known, 0.0), |(_, estimate, sigma)| (estimate, sigma))
        };
        let values = self.parameters.iter().map(value).collect();
        (MapSnapshot { step, walls: self.slam.walls().collect() }, CalibrationSnapshot { step, values })
    }
}

/// The time; none in a browser, whose clock the standard library does not know.
fn now() -> Option<Instant> {
    (!cfg!(target_family = "wasm")).then(Instant::now)
}

/// The innovation of a reading that met a wall.
fn innovation(outcome: &Outcome, sensor: &SensorInfo) -> Option<nis::Innovation> {
    let (Outcome::Updated { innovation_m, variance_m2, .. } | Outcome::Gated { innovation_m, variance_m2, .. }) =
        *outcome
    else {
        return None;
    };
    let possible = innovation_m.is_finite() && variance_m2.is_finite() && variance_m2 > 0.0;
    let span_m = sensor.span_m[1] - sensor.span_m[0];
    possible.then(|| nis::Innovation { value_m: innovation_m.into(), variance_m2: variance_m2.into(), span_m })
}

/// The record of a robot about to begin.
pub fn begun(robot: &Robot, title: impl Into<String>) -> Recording {
    let info = |parameter| ParameterInfo { name: parameter_name(parameter, &robot.names), truth: None };
    Recording {
        title: title.into(),
        sensors: robot.rig.sensors.iter().zip(&robot.names).map(sensor_info).collect(),
        parameters: parameters_of(robot).into_iter().map(info).collect(),
        ..Recording::default()
    }
}

/// What a record says of a sensor.
pub(super) fn sensor_info((sensor, name): (&slam_core::RangeSensor, &String)) -> SensorInfo {
    SensorInfo {
        name: name.clone(),
        x_m: sensor.mount.x_m.into(),
        y_m: sensor.mount.y_m.into(),
        bearing_rad: sensor.mount.bearing_rad.into(),
        span_m: [sensor.min_m.into(), sensor.max_m.into()],
    }
}

/// Every parameter that the robot could have as a state.
fn parameters_of(robot: &Robot) -> Vec<Parameter> {
    let drive: &[Parameter] = match robot.rig.drive {
        DriveModel::Wheels { .. } => &[Parameter::ScaleLeft, Parameter::ScaleRight, Parameter::Track],
        DriveModel::Odometry { .. } => &[Parameter::ScaleDistance, Parameter::ScaleTurn, Parameter::Veer],
    };
    let gains = (0..robot.rig.sensors.len()).map(|index| Parameter::Gain(index as u8));
    gains.chain(drive.iter().copied()).collect()
}

/// What a parameter is called, of a robot with sensors of these names.
pub fn parameter_name(parameter: Parameter, sensors: &[String]) -> String {
    match parameter {
        Parameter::ScaleLeft => "scale_left".to_owned(),
        Parameter::ScaleRight => "scale_right".to_owned(),
        Parameter::Track => "track".to_owned(),
        Parameter::ScaleDistance => "scale_distance".to_owned(),
        Parameter::ScaleTurn => "scale_turn".to_owned(),
        Parameter::Veer => "veer".to_owned(),
        Parameter::Gain(index) => match sensors.get(usize::from(index)) {
            Some(name) => format!("gain_{name}"),
            None => format!("gain_{index}"),
        },
    }
}
