//! The simulated robot in its home: commands in, what its sensors and encoders show out, and the truth beside it.

mod meddle;
mod ranges;

use robot::{Condition, Contacts, Duty, StallWatch, WheelControl, WheelControlConfig, WheelCounter, WheelSpeeds};
use slam_core::{Adc, Motion, RangeModel, RangeSensor, Rig, Sample, Ticks};

use crate::body::{Body, TrueDrive, Wheels};
use crate::coverage::Coverage;
use crate::fault::{self, Part};
use crate::history::History;
use crate::mishap::Fate;
use crate::odometer::Odometer;
use crate::options::SimOptions;
use crate::plan::{Cliff, Plan};
use crate::pose::Pose2;
use crate::rng::Rng;
use crate::sensor::SimSensor;
use crate::sim_error::SimError;
use crate::supply::Supply;
use crate::world::World;

/// Most range sensors of a simulated robot.
pub const MAX_SENSORS: usize = 16;

/// Period of the wheel-speed controller, seconds.
const CONTROL_S: f64 = 0.02;

/// What the robot's calibration really is, as against what its rig says: factors, 1 where exact.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueCalibration {
    /// Gain of each range sensor, in the rig's order: reported range = gain x true range.
    pub gains: Vec<f64>,
    /// Wheels and track.
    pub drive: TrueDrive,
    /// True distance per dead-reckoned one.
    pub scale_distance: f64,
    /// True turn per dead-reckoned one.
    pub scale_turn: f64,
}

/// Whether these can be simulated at all, wherever the robot stands.
fn check(plan: &Plan, rig: &Rig<MAX_SENSORS>, options: &SimOptions) -> Result<(), SimError> {
    if !(1.0..=100.0).contains(&options.rate_hz) {
        return Err(SimError::Rate(options.rate_hz));
    }
    let analogue = |sensor: &RangeSensor| matches!(sensor.model, RangeModel::Sharp { .. });
    if let (None, Some(index)) = (rig.adc, rig.sensors.iter().position(analogue)) {
        return Err(SimError::NeedsAdc(index));
    }
    for (i, fault) in plan.mishaps.faults.iter().enumerate() {
        if let Part::Sensor { index, .. } = fault.part
            && index >= rig.sensors.len()
        {
            return Err(SimError::NoSuchSensor(i, index, rig.sensors.len()));
        }
    }
    Ok(())
}

/// A robot in a home.
#[derive(Clone, Debug)]
pub struct Simulation {
    world: World,
    cliffs: Vec<Cliff>,
    start: Pose2,
    adc: Option<Adc>,
    options: SimOptions,
    body: Body,
    last_pose: Pose2,
    history: History,
    odometer: Option<Odometer>,
    stamps: Rng,
    last_stamp_us: Option<u64>,
    sensors: Vec<SimSensor>,
    fate: Fate,
    supply: Supply,
    stalls: StallWatch,
    coverage: Coverage,
    calibration: TrueCalibration,
    counter_offset: [u16; 2],
    counters: [WheelCounter; 2],
    control: WheelControl,
    track_m: f64,
    duty: Duty,
    time_s: f64,
    samples: u64,
}

impl Simulation {
    /// A robot at the plan's start. Every random number follows from `seed`.
    ///
    /// # Errors
    /// The rig cannot be simulated or the robot does not fit where the plan puts it.
    pub fn new(plan: &Plan, rig: &Rig<MAX_SENSORS>, options: SimOptions, seed: u64) -> Result<Self, SimError> {
        let wheels = Wheels::of(&rig.drive);
        check(plan, rig, &options)?;
        let world = World::new(plan);
        let blocked_m = |pose: &Pose2| world.blocked_m([pose.x_m, pose.y_m], options.body_radius_m);
        let start = options.start.unwrap_or(plan.start);
        if let Some(clearance_m) = blocked_m(&start) {
            return Err(SimError::StartBlocked(clearance_m, options.body_radius_m));
        }
        for (i, to) in plan.mishaps.kidnaps.iter().enumerate().filter_map(|(i, kidnap)| Some((i, kidnap.to?))) {
            if let Some(clearance_m) = blocked_m(&to) {
                return Err(SimError::PlaceBlocked(i, clearance_m, options.body_radius_m));
            }
        }
        let sensors: Vec<_> =
            rig.sensors.iter().enumerate().map(|(i, sensor)| SimSensor::new(sensor, i, &options, seed)).collect();
        let gains = sensors.iter().map(|sensor| sensor.gain).collect();
        let drive = wheels.draw(&options, seed);
        let odometer = Odometer::new(&rig.drive, wheels.track_m, &options, seed);
        let scale = odometer.as_ref().map_or([1.0; 2], Odometer::scale);
        let mut offsets = Rng::stream(seed, "encoder-offset", 0);
        let counter_offset = [offsets.next_u64() as u16, offsets.next_u64() as u16];
        let mut simulation = Self {
            coverage: Coverage::new(&plan.faces),
            fate: Fate::new(&plan.mishaps, &plan.rooms, seed),
            supply: Supply::new(plan, start),
            stalls: StallWatch::new(wheels.metres_per_tick as f32, options.drive.full_speed_mps as f32),
            world,
            cliffs: plan.cliffs.clone(),
            start: plan.start,
            adc: rig.adc,
            body: Body::new(start, wheels, drive, seed),
            last_pose: start,
            history: History::starting_at(start),
            odometer,
            stamps: Rng::stream(seed, "stamps", 0),
            last_stamp_us: None,
            sensors,
            calibration: TrueCalibration { gains, drive, scale_distance: scale[0], scale_turn: scale[1] },
            counter_offset,
            counters: counter_offset.map(WheelCounter::starting_at),
            control: WheelControl::new(WheelControlConfig {
                metres_per_tick: wheels.metres_per_tick as f32,
                full_speed_mps: options.drive.full_speed_mps as f32,
                ..WheelControlConfig::default()
            }),
            track_m: wheels.track_m,
            duty: Duty::default(),
            time_s: 0.0,
            samples: 0,
            options,
        };
        simulation.first_light();
        Ok(simulation)
    }

    /// Drives with these wheel speeds until the next sample is due, and takes it. The wheel-speed controller runs at
    /// 50 Hz; a touched bumper or a cliff stops the wheels at once.
    pub fn step(&mut self, command: WheelSpeeds) -> Sample<MAX_SENSORS> {
        self.samples += 1;
        let until_s = self.samples as f64 / self.options.rate_hz;
        let ticks = (libm::ceil((until_s - self.time_s) / self.options.tick_s - 1e-6) as usize).max(1);
        let tick_s = (until_s - self.time_s) / ticks as f64;
        let control_ticks = (libm::round(CONTROL_S / self.options.tick_s) as usize).max(1);
        for tick in 0..ticks {
            if tick % control_ticks == 0 {
                let counts = self.ticks();
                let period_s = (control_ticks.min(ticks) as f64 * tick_s) as f32;
                self.stalls.update(self.duty, counts, period_s);
                let allowed = self.stalls.guard(self.contacts().guard(command));
                self.duty = self.control.update(allowed, counts, period_s);
            } else if self.contacts().guard(command) != command {
                self.duty = Duty::default();
            }
            self.tick(tick_s);
        }
        self.time_s = until_s;
        self.sample()
    }

    /// Lets time pass with the duty set last, without control: for code that owns the motors itself.
    pub fn advance(&mut self, period_s: f64) {
        let ticks = (libm::ceil(period_s / self.options.tick_s - 1e-6) as usize).max(1);
        for _ in 0..ticks {
            self.tick(period_s / ticks as f64);
        }
    }

    /// Sets both motors' duty for [`Simulation::advance`].
    pub fn set_duty(&mut self, duty: Duty) {
        self.duty = duty;
    }

    fn tick(&mut self, period_s: f64) {
        self.last_pose = self.body.pose;
        let (begin_s, end_s) = (self.time_s, self.time_s + period_s);
        self.world.set_time(end_s);
        self.fate.hold(&mut self.body, end_s);
        let duty = if self.supply.is_empty() { Duty::default() } else { self.duty };
        self.body.advance(duty, period_s, &self.world, &self.options);
        self.let_people_turn(end_s);
        self.supply.advance(&self.last_pose, &mut self.body.pose, period_s);
        if !self.fate.is_kind() {
            self.fate.befall(&mut self.body, &self.last_pose, end_s, &self.world, &self.options);
        }
        self.time_s = end_s;
        self.history.push(end_s, self.body.pose);
        if let Some(odometer) = &mut self.odometer {
            odometer.advance(end_s, self.body.counted_m());
        }
        for i in 0..self.sensors.len() {
            self.run_cycle(i, begin_s, end_s);
        }
        self.body.contacts.cliff = self.over_cliff();
    }

    fn over_cliff(&self) -> bool {
        if self.cliffs.is_empty() {
            return false;
        }
        let [x_m, y_m] = self.body.pose.transform([self.options.body_radius_m, 0.0]);
        let inside = |c: &Cliff| (c.min_m[0]..=c.max_m[0]).contains(&x_m) && (c.min_m[1]..=c.max_m[1]).contains(&y_m);
        self.cliffs.iter().any(inside)
    }

    /// Everything sensed now.
    pub fn sample(&mut self) -> Sample<MAX_SENSORS> {
        let ranges = self.read_ranges();
        let motion = match &mut self.odometer {
            Some(odometer) => Motion::Increment(odometer.take()),
            None => Motion::Ticks(self.ticks()),
        };
        Sample { time_us: self.stamp_us(), motion, ranges }
    }

    /// The dead-reckoned pose that the last sample's motion led to; none where samples have ticks.
    pub fn odometry(&self) -> Option<Pose2> {
        self.odometer.as_ref().map(Odometer::given)
    }

    /// What the sample of now is stamped with.
    fn stamp_us(&mut self) -> u64 {
        let jitter_s = self.options.stamp_jitter_s;
        let off_s = if jitter_s > 0.0 { jitter_s * self.stamps.gaussian() } else { 0.0 };
        let stamp_us = libm::round((self.time_s + off_s).max(0.0) * 1e6) as u64;
        // A thousandth of a second after the last one at least.
        let earliest_us = self.last_stamp_us.map_or(0, |last_us| last_us + 1000);
        *self.last_stamp_us.insert(stamp_us.max(earliest_us))
    }

    /// The encoders' 16-bit hardware counters; they start anywhere and wrap.
    pub fn raw_counters(&self) -> [u16; 2] {
        let ticks = self.body.ticks();
        [0, 1].map(|wheel| self.counter_offset[wheel].wrapping_add(ticks[wheel] as u16))
    }

    /// Cumulative counts, unwrapped from the hardware counters.
    pub fn ticks(&mut self) -> Ticks {
        let [left, right] = self.raw_counters();
        Ticks { left: self.counters[0].update(left), right: self.counters[1].update(right) }
    }

    /// Bumper, cliff and wheel-drop inputs.
    pub fn contacts(&self) -> Contacts {
        fault::told(self.fate.faults(), self.body.contacts, self.time_s)
    }

    /// Battery, charging contact and stalled wheels.
    pub fn condition(&self) -> Condition {
        Condition {
            battery_v: self.supply.battery_v(),
            is_charging: self.supply.is_charging(),
            is_stalled: self.stalls.is_stalled(),
            is_lost: false,
        }
    }

    /// Time since the start, seconds.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// The true pose in the plan's frame.
    pub fn pose_in_plan(&self) -> Pose2 {
        self.body.pose
    }

    /// The true pose in the start frame: what an estimate can be compared with.
    pub fn pose(&self) -> Pose2 {
        self.start.relative(&self.body.pose)
    }

    /// What the robot's calibration really is.
    pub fn calibration(&self) -> &TrueCalibration {
        &self.calibration
    }

    /// Which walls were seen so far.
    pub fn coverage(&self) -> &Coverage {
        &self.coverage
    }

    /// Nominal distance between the wheels, metres.
    pub fn track_m(&self) -> f64 {
        self.track_m
    }

    /// The settings.
    pub fn options(&self) -> &SimOptions {
        &self.options
    }
}
