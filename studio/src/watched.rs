//! A robot that is listened to: frames of its serial line, made a run that the page shows.
//!
//! Pose, walls and calibration are what the robot says. What became of its readings is known from an estimator of the robot's
//! size that gets the same samples here, as long as it says the same bits as the robot's.

mod words;

use std::collections::BTreeMap;

use lab::input::log::{Row, writer};
use lab::input::rig_file::{MAX_SENSORS, Robot};
use lab::numbers::shortest;
use lab::recording::{CalibrationSnapshot, MapSnapshot, Pose2, Recording, Step};
use lab::run::{begun, parameter_name};
use lab::show::report::growing::Growing;
use lab::show::report::{self};
use serde_json::{Value, json};
use slam_core::{Config, RangeInput, ReadingReport, RobotSlam, WallView};
use wire::{Command, DecodeError, Decoder, Estimate, Faults, Floor, Frame, Place, SENSORS, encode};

use crate::errands::Errands;
use crate::looking_back::LookingBack;
use crate::rig::robot_of;
use crate::simulated::LONGEST_S;
use words::{floor_words, place_words};

/// Most samples that are kept: an hour at 25 a second.
const LONGEST: usize = (25.0 * LONGEST_S) as usize;

/// What the line carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Line {
    bytes: u64,
    frames: u64,
    damaged: u64,
    other_version: Option<u8>,
    /// Bytes since the last whole frame.
    strange_bytes: u64,
    /// Estimates that the estimator here agreed with bit for bit, and that it did not.
    same: u64,
    other: u64,
}

/// A robot at the other end of a line.
pub struct Watched {
    robot: Robot,
    rig_toml: String,
    decoder: Decoder,
    line: Line,
    shadow: Box<RobotSlam>,
    readings: Option<(u64, [ReadingReport; SENSORS])>,
    walls: BTreeMap<u8, wire::Wall>,
    faults: Option<Faults>,
    place: Option<Place>,
    floor: Option<Floor>,
    contacts: wire::Contacts,
    recording: Recording,
    growing: Growing,
    back: LookingBack,
    errands: Errands,
    /// 1-sigma of the calibration before anything was driven, in the record's order.
    priors: Vec<f32>,
    log: String,
    first_us: Option<u64>,
    last_us: u64,
    /// Counts the robot's starts: with each one the page begins anew.
    starts: u32,
}

impl Watched {
    /// A robot with this rig, the name of a built-in one or a rig file's text.
    ///
    /// # Errors
    /// What is wrong with the rig.
    pub fn new(rig: &str) -> Result<Self, String> {
        let (robot, rig_toml) = robot_of(rig)?;
        let shadow = shadow_of(&robot)?;
        let log = writer::header(&robot) + "\n";
        let recording = begun(&robot, "Your robot");
        let priors = recording.parameters.iter().map(|parameter| prior(&shadow, &robot, &parameter.name)).collect();
        Ok(Self {
            robot,
            rig_toml,
            decoder: Decoder::new(),
            line: Line::default(),
            shadow,
            readings: None,
            walls: BTreeMap::new(),
            faults: None,
            place: None,
            floor: None,
            contacts: wire::Contacts::default(),
            recording,
            growing: Growing::default(),
            back: LookingBack::default(),
            errands: Errands::default(),
            priors,
            log,
            first_us: None,
            last_us: 0,
            starts: 0,
        })
    }

    /// Takes in bytes of the line, whatever they are.
    pub fn take(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.line.bytes += 1;
            self.line.strange_bytes += 1;
            match self.decoder.push(*byte) {
                None => {}
                Some(Ok(frame)) => {
                    self.line.frames += 1;
                    self.line.strange_bytes = 0;
                    self.frame(frame);
                }
                Some(Err(DecodeError::Version(theirs))) => self.line.other_version = Some(theirs),
                Some(Err(_)) => self.line.damaged += 1,
            }
        }
    }

    fn frame(&mut self, frame: Frame) {
        match frame {
            Frame::Sample(sample) => self.sample(&sample),
            Frame::Estimate(estimate) => self.estimate(&estimate),
            Frame::Wall(wall) => self.wall(wall),
            Frame::Calibration(calibration) => self.calibration(&calibration),
            Frame::Faults(faults) => self.faults = Some(faults),
            Frame::Place(place) => self.place = Some(place),
            Frame::Floor(floor) => self.floor = Some(floor),
            Frame::LookBack(_) | Frame::Frozen(_) | Frame::Motors(_) | Frame::Command(_) | Frame::MapRequest(_) => {}
            Frame::MapAnswer(answer) => self.errands.map_answer(&answer),
        }
    }

    fn sample(&mut self, sample: &wire::Sample) {
        if self.first_us.is_some() && sample.time_us <= self.last_us {
            self.begin_anew();
        }
        self.last_us = sample.time_us;
        self.errands.sample(sample);
        let first_us = *self.first_us.get_or_insert(sample.time_us);
        self.contacts = sample.contacts;
        let report = self.shadow.step(&sample.to_slam());
        self.readings = Some((sample.time_us, report.readings));
        if self.recording.steps.len() < LONGEST {
            let few = sample.to_slam();
            let mut ranges = [RangeInput::Missing; MAX_SENSORS];
            ranges.iter_mut().zip(few.ranges).for_each(|(wide, range)| *wide = range);
            let t_s = (sample.time_us - first_us) as f64 * 1e-6;
            let sample = slam_core::Sample { time_us: few.time_us, motion: few.motion, ranges };
            let wire::Contacts { lifted, docked, .. } = self.contacts;
            let row = Row { t_text: shortest(t_s), t_s, sample, odometry: None, truth: None, lifted, docked };
            self.log += &writer::line(&self.robot, &row);
            self.log.push('\n');
        }
    }

    fn estimate(&mut self, estimate: &Estimate) {
        self.walls.retain(|index, _| *index < estimate.walls);
        let of_it = self.readings.take().filter(|(time_us, _)| *time_us == estimate.time_us);
        let own = Estimate::of(&*self.shadow, estimate.time_us);
        let agrees = of_it.is_some() && own.same_bits(estimate);
        *if agrees { &mut self.line.same } else { &mut self.line.other } += 1;
        if self.recording.steps.len() >= LONGEST {
            return;
        }
        let readings = of_it.filter(|_| agrees).map_or([ReadingReport::default(); SENSORS], |(_, readings)| readings);
        self.recording.readings.extend_from_slice(&readings[..self.recording.sensors.len().min(SENSORS)]);
        let since_us = estimate.time_us.saturating_sub(self.first_us.unwrap_or(estimate.time_us));
        self.recording.steps.push(step_of(estimate, since_us as f64 * 1e-6));
    }

    fn wall(&mut self, wall: wire::Wall) {
        let is_last = wall.index + 1 == wall.of;
        self.walls.insert(wall.index, wall);
        if let Some(step) = self.recording.steps.len().checked_sub(1).filter(|_| is_last) {
            let walls = self.walls.values().filter(|known| known.index < wall.of).map(WallView::from).collect();
            self.recording.maps.push(MapSnapshot { step, walls });
            if self.recording.calibration.is_empty() {
                let values = vec![(1.0, 0.0); self.recording.parameters.len()];
                self.recording.calibration.push(CalibrationSnapshot { step, values });
            }
        }
    }

    fn calibration(&mut self, calibration: &wire::Calibration) {
        let Some(step) = self.recording.steps.len().checked_sub(1) else { return };
        let of_name = |name: &str| {
            let found = calibration
                .factors
                .iter()
                .find(|factor| parameter_name(factor.parameter.into(), &self.robot.names) == name);
            found.map_or((1.0, 0.0), |factor| (factor.estimate, factor.sigma))
        };
        let values = self.recording.parameters.iter().map(|parameter| of_name(&parameter.name)).collect();
        self.recording.calibration.push(CalibrationSnapshot { step, values });
    }

    /// The robot was started again: what was shown is of another life.
    fn begin_anew(&mut self) {
        if let Ok(fresh) = Self::new(&self.rig_toml) {
            // Somebody may be at an errand that has the robot begin anew.
            let errands = core::mem::take(&mut self.errands);
            let (line, starts) = (self.line, self.starts + 1);
            *self = Self { line, starts, errands, ..fresh };
        }
    }

    /// What the robot did so far.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// What stays as it is until the robot starts again.
    pub fn head(&self) -> Value {
        let mut head = Growing::head(&self.recording);
        head["longest_s"] = json!(LONGEST_S);
        head
    }

    /// The page has shown another run meanwhile.
    pub fn tell_again(&mut self) {
        self.growing.tell_again();
    }

    /// The steps that the page has not got, see [`Growing::steps`].
    pub fn steps(&mut self) -> Vec<f64> {
        self.growing.steps(&self.recording)
    }

    /// Map and calibration, where the page has older ones.
    pub fn map(&mut self) -> Option<Value> {
        self.growing.map(&self.recording)
    }

    /// Length, time and walls so far.
    pub fn figures(&self) -> Value {
        let steps = &self.recording.steps;
        let mut figures = lab::recording::Figures {
            path_m: lab::evaluate::score::path::length_m(steps.iter().map(|step| step.dead_reckoning)),
            duration_s: steps.last().map_or(0.0, |step| step.t_s),
            walls: steps.last().map_or(0, |step| step.walls),
            ..Default::default()
        };
        let used = self.recording.readings.iter().filter(|r| matches!(r.outcome, slam_core::Outcome::Updated { .. }));
        let nis: Vec<f64> =
            used.filter_map(|r| lab::recording::nis(&r.outcome)).filter(|nis| nis.is_finite()).collect();
        figures.updates = nis.len() as u64;
        figures.mean_nis = lab::evaluate::statistics::mean(&nis);
        report::figures(&figures)
    }

    /// The line, the robot's faults and inputs, in names and numbers.
    pub fn state(&self) -> Value {
        let Line { bytes, frames, damaged, other_version, strange_bytes, same, other } = self.line;
        let faults = self.faults.map(|Faults { slam, board }| {
            json!({
                "ranges failed": board.ranges_failed, "encoders failed": board.encoders_failed,
                "motors failed": board.motors_failed, "samples dropped": board.samples_dropped,
                "frames dropped": board.frames_dropped, "commands dropped": board.commands_dropped,
                "bytes lost": board.bytes_lost, "contact stops": board.contact_stops,
                "dead-man stops": board.dead_man_stops, "watchdog resets": board.watchdog_resets,
                "late tasks": board.late_tasks, "maps begun anew": slam.restarts,
            })
        });
        let wire::Contacts { bump_left, bump_right, cliff, lifted, docked } = self.contacts;
        let names = [
            (bump_left, "bumper left"),
            (bump_right, "bumper right"),
            (cliff, "cliff"),
            (lifted, "lifted"),
            (docked, "dock"),
        ];
        let touched: Vec<&str> = names.iter().filter(|(on, _)| *on).map(|(_, name)| *name).collect();
        let health = self.recording.steps.last().map(|step| lab::recording::health::name(step.health));
        json!({
            "bytes": bytes, "frames": frames, "damaged": damaged, "other_version": other_version,
            "version": wire::VERSION, "strange_bytes": strange_bytes, "same": same, "other": other,
            "faults": faults, "touched": touched, "health": health, "starts": self.starts,
            "errands": self.errands.state(),
            "calibration": self.calibrated(),
            "place": self.place.as_ref().map(place_words),
            "floor": self.floor.as_ref().map(floor_words),
            "full": self.recording.steps.len() >= LONGEST,
        })
    }

    /// The page that the workbench writes of a run.
    pub fn report(&self) -> Option<String> {
        (!self.recording.steps.is_empty()).then(|| report::html(&self.recording))
    }

    /// Goes on looking back, see [`LookingBack::work`].
    ///
    /// # Errors
    /// Why there is nothing to look back on.
    pub fn look_back(&mut self, pieces: usize) -> Result<bool, &'static str> {
        self.back.work(&self.recording, &self.robot.rig, pieces)
    }

    /// The look back.
    pub fn back(&self) -> &LookingBack {
        &self.back
    }

    /// The page of the look back, see [`LookingBack::page`].
    pub fn look_back_page(&self) -> Option<String> {
        self.back.page(self.recording.clone())
    }

    /// Each calibration factor that is estimated: its name, value, 1-sigma, and that before anything was driven.
    fn calibrated(&self) -> Value {
        let last = self.recording.calibration.last().map_or(&[][..], |last| &last.values);
        let factors = self.recording.parameters.iter().zip(last).zip(&self.priors);
        let estimated = factors.filter(|((_, (_, sigma)), prior)| *sigma > 0.0 && **prior > 0.0);
        estimated.map(|((parameter, (value, sigma)), prior)| json!([parameter.name, value, sigma, prior])).collect()
    }

    /// What is done with the robot beside watching it.
    pub fn errands(&mut self) -> &mut Errands {
        &mut self.errands
    }

    /// Begins to examine the robot.
    pub fn examine(&mut self) {
        self.errands.examine(&self.robot);
    }

    /// What the robot sensed so far, as a `log.csv`.
    pub fn log(&self) -> &str {
        &self.log
    }

    /// The robot as a rig file.
    pub fn rig_toml(&self) -> &str {
        &self.rig_toml
    }
}

/// The bytes that tell a robot to do this; wheels turn for a short time with a share of the supply, -1 to 1.
pub fn command(name: &str, [left, right]: [f32; 2]) -> Vec<u8> {
    let command = match name {
        "start" => Command::Start,
        "clean" => Command::Clean { anew: false },
        "clean-anew" => Command::Clean { anew: true },
        "reset" => Command::ResetMap,
        "spin" => Command::Spin { left: left.clamp(-1.0, 1.0), right: right.clamp(-1.0, 1.0) },
        // What is not known must not set anything in motion.
        _ => Command::Stop,
    };
    encode(&Frame::Command(command)).map(|bytes| bytes.to_vec()).unwrap_or_default()
}

fn shadow_of(robot: &Robot) -> Result<Box<RobotSlam>, String> {
    let mut sensors = heapless::Vec::new();
    for sensor in &robot.rig.sensors {
        sensors.push(*sensor).map_err(|_| format!("the rig has more sensors than the {SENSORS} that a robot sends"))?;
    }
    let rig = slam_core::Rig { drive: robot.rig.drive, adc: robot.rig.adc, sensors };
    let config = Config::for_rig(&rig);
    let slam =
        RobotSlam::with_config(rig, config).map_err(|error| format!("rig: {} must be {}", error.key, error.allowed))?;
    Ok(Box::new(slam))
}

/// 1-sigma of a factor before anything was driven; 0 where it is not estimated.
fn prior(slam: &RobotSlam, robot: &Robot, name: &str) -> f32 {
    let found = slam.calibration().find(|(parameter, ..)| parameter_name(*parameter, &robot.names) == name);
    found.map_or(0.0, |(_, _, sigma)| sigma)
}

fn step_of(estimate: &Estimate, t_s: f64) -> Step {
    let [xx, xy, xt, yy, yt, tt] = estimate.covariance;
    let pose = |[x, y, theta]: [f32; 3]| Pose2::new(x.into(), y.into(), theta.into());
    Step {
        t_text: shortest(t_s),
        t_s,
        pose: pose(estimate.pose),
        covariance: [[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]],
        alpha: estimate.alpha.map(|[alpha_rad, sigma_rad]| (alpha_rad, sigma_rad)),
        dead_reckoning: pose(estimate.dead_reckoning),
        walls: estimate.walls.into(),
        health: estimate.health.into(),
        ..Step::default()
    }
}
