//! What one drive of an experiment differs in from the default: the robot's errors, its manner of driving, its home.

use std::collections::BTreeMap;
use std::path::Path;

use hal_sim::{SharpOptions, SimOptions};
use robot::PilotConfig;
use slam_core::{DriveModel, RangeModel};

use lab::error::FileError;
use lab::input::built_in_robot;
use lab::input::rig_file::Robot;
use lab::input::toml_table::{Allowed, Table};

/// A quantity that an experiment can set or sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Key {
    /// 1-sigma of the range sensors' gains; the true gains are drawn from it.
    GainSigma,
    /// 1-sigma of the wheels' scales; the true scales are drawn from it.
    ScaleSigma,
    /// 1-sigma of the track; the true track is drawn from it.
    TrackSigma,
    /// 1-sigma of the range sensors' output, volts.
    NoiseV,
    /// Longest range that is a reading, metres.
    MaxRange,
    /// Number of range sensors: 8, 6, 4 or 2.
    Sensors,
    /// Cruising speed, m/s.
    Speed,
    /// Samples per second.
    Rate,
    /// Wheel slips per metre.
    Slips,
    /// Chair legs strewn over the rooms.
    ChairLegs,
    /// People walking in the rooms.
    People,
    /// Angle by which the walls miss the right angle, degrees.
    Skew,
    /// When the plan's doors of the experiment close, seconds.
    DoorCloses,
    /// When they open again, seconds.
    DoorOpens,
    /// Length of the drive, minutes.
    Minutes,
}

const fn within(min: f64, max: f64, words: &'static str) -> Allowed {
    Allowed { min, above_min: false, max, below_max: false, words }
}

const RELATIVE: Allowed = Allowed { below_max: true, ..within(0.0, 0.5, "a ratio of at least 0 and less than 0.5") };

impl Key {
    /// Every key.
    pub const ALL: [Key; 15] = [
        Self::GainSigma,
        Self::ScaleSigma,
        Self::TrackSigma,
        Self::NoiseV,
        Self::MaxRange,
        Self::Sensors,
        Self::Speed,
        Self::Rate,
        Self::Slips,
        Self::ChairLegs,
        Self::People,
        Self::Skew,
        Self::DoorCloses,
        Self::DoorOpens,
        Self::Minutes,
    ];

    /// As experiment files write it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::GainSigma => "gain_sigma",
            Self::ScaleSigma => "scale_sigma",
            Self::TrackSigma => "track_sigma",
            Self::NoiseV => "noise_v",
            Self::MaxRange => "max_m",
            Self::Sensors => "sensors",
            Self::Speed => "speed_mps",
            Self::Rate => "rate_hz",
            Self::Slips => "slips_per_m",
            Self::ChairLegs => "chair_legs",
            Self::People => "people",
            Self::Skew => "skew_deg",
            Self::DoorCloses => "door_closes_s",
            Self::DoorOpens => "door_opens_s",
            Self::Minutes => "minutes",
        }
    }

    /// As the axis of a figure says it.
    pub const fn label(self) -> &'static str {
        match self {
            Self::GainSigma => "1-sigma error of the sensors' gains",
            Self::ScaleSigma => "1-sigma error of the wheels' scales",
            Self::TrackSigma => "1-sigma error of the track",
            Self::NoiseV => "noise of the sensors' output, V",
            Self::MaxRange => "range limit, m",
            Self::Sensors => "range sensors",
            Self::Speed => "speed, m/s",
            Self::Rate => "samples per second",
            Self::Slips => "wheel slips per metre",
            Self::ChairLegs => "chair legs added",
            Self::People => "people walking",
            Self::Skew => "walls off the right angle, degrees",
            Self::DoorCloses => "door closes at, s",
            Self::DoorOpens => "door opens at, s",
            Self::Minutes => "drive, minutes",
        }
    }

    /// What its values may be.
    pub const fn allowed(self) -> Allowed {
        match self {
            Self::GainSigma | Self::ScaleSigma | Self::TrackSigma => RELATIVE,
            Self::NoiseV => within(0.001, 1.0, "volts from 0.001 to 1"),
            Self::MaxRange => within(0.2, 10.0, "metres from 0.2 to 10"),
            Self::Sensors => within(2.0, 8.0, "8, 6, 4 or 2"),
            Self::Speed => within(0.05, 0.55, "m/s from 0.05 to 0.55"),
            Self::Rate => within(1.0, 100.0, "a rate from 1 to 100"),
            Self::Slips => within(0.0, 100.0, "slips from 0 to 100"),
            Self::ChairLegs | Self::People => within(0.0, 200.0, "a number from 0 to 200"),
            Self::Skew => within(-20.0, 20.0, "degrees from -20 to 20"),
            Self::DoorCloses | Self::DoorOpens => Allowed::NOT_NEGATIVE,
            Self::Minutes => Allowed { above_min: true, ..within(0.0, 240.0, "minutes above 0 and up to 240") },
        }
    }

    /// The key of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|key| key.name() == name)
    }
}

/// Values of the keys that differ from the default, and the rig where it is another one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setting {
    /// Name or file of the rig; the built-in robot where not given. `measured` is the built-in robot with the sensors
    /// of [`hal_sim::measured_rig`].
    pub rig: Option<String>,
    /// The values.
    pub values: BTreeMap<Key, f64>,
}

impl Setting {
    /// Reads the keys of a table that are a setting's.
    ///
    /// # Errors
    /// A value that is not allowed.
    pub fn read(table: &Table<'_>) -> Result<Self, FileError> {
        let mut setting = Self { rig: table.optional_text("rig")?, ..Self::default() };
        for key in Key::ALL {
            if let Some(value) = table.optional_number(key.name(), key.allowed())? {
                // A file's 0.04 is 0.04, not the nearest f32.
                let value = format!("{value}").parse().unwrap_or_else(|_| f64::from(value));
                setting.values.insert(key, value);
            }
        }
        Ok(setting)
    }

    /// This setting where `over` says nothing else.
    pub fn overlaid(&self, over: &Setting) -> Self {
        let mut both = self.clone();
        both.rig = over.rig.clone().or(both.rig);
        both.values.extend(&over.values);
        both
    }

    /// The value of a key that was set.
    pub fn get(&self, key: Key) -> Option<f64> {
        self.values.get(&key).copied()
    }

    /// The robot of this setting.
    ///
    /// # Errors
    /// The rig file cannot be used.
    pub fn robot(&self) -> Result<Robot, FileError> {
        let mut robot = match self.rig.as_deref() {
            None => built_in_robot()?.0,
            Some("measured") => Robot { rig: hal_sim::measured_rig(), ..built_in_robot()?.0 },
            Some(file) => Robot::read(Path::new(file))?,
        };
        self.keep_sensors(&mut robot);
        let single = |key: Key| self.get(key).map(|value| value as f32);
        if let DriveModel::Wheels { scale_sigma, track_sigma, .. } = &mut robot.rig.drive {
            *scale_sigma = single(Key::ScaleSigma).unwrap_or(*scale_sigma);
            *track_sigma = single(Key::TrackSigma).unwrap_or(*track_sigma);
        }
        for sensor in &mut robot.rig.sensors {
            sensor.gain_sigma = single(Key::GainSigma).unwrap_or(sensor.gain_sigma);
            sensor.max_m = single(Key::MaxRange).unwrap_or(sensor.max_m);
            if let RangeModel::Sharp { noise_v, .. } = &mut sensor.model {
                *noise_v = single(Key::NoiseV).unwrap_or(*noise_v);
            }
        }
        Ok(robot)
    }

    /// Eight sensors are an eighth of a turn apart. Six leave out those behind at a slant, four look ahead, to both sides
    /// and back, two ahead and to the left.
    fn keep_sensors(&self, robot: &mut Robot) {
        let kept: &[usize] = match self.get(Key::Sensors) {
            Some(n) if n < 4.0 => &[0, 2],
            Some(n) if n < 6.0 => &[0, 2, 4, 6],
            Some(n) if n < 8.0 => &[0, 1, 2, 4, 6, 7],
            _ => return,
        };
        let present: Vec<usize> = kept.iter().copied().filter(|i| *i < robot.rig.sensors.len()).collect();
        robot.names = present.iter().map(|i| robot.names[*i].clone()).collect();
        robot.rig.sensors = present.iter().map(|i| robot.rig.sensors[*i]).collect();
    }

    /// The simulator's options.
    pub fn options(&self) -> SimOptions {
        let default = SimOptions::default();
        let mut options = SimOptions { rate_hz: self.get(Key::Rate).unwrap_or(default.rate_hz), ..default };
        options.drive.slips_per_m = self.get(Key::Slips).unwrap_or(options.drive.slips_per_m);
        if self.rig.as_deref() == Some("measured") {
            options.sharp = SharpOptions::measured();
        }
        options
    }

    /// The pilot's manner of driving.
    pub fn pilot(&self) -> PilotConfig {
        let default = PilotConfig::default();
        let speed_mps = self.get(Key::Speed).map_or(default.speed_mps, |value| value as f32);
        PilotConfig { speed_mps, ..default }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(key: Key, value: f64) -> Setting {
        Setting { rig: None, values: BTreeMap::from([(key, value)]) }
    }

    #[test]
    fn the_overlaid_value_wins_and_the_rest_stays() {
        let base = Setting { rig: Some("measured".into()), values: [(Key::Rate, 25.0), (Key::Speed, 0.2)].into() };
        let both = base.overlaid(&set(Key::Rate, 10.0));
        assert_eq!((both.get(Key::Rate), both.get(Key::Speed)), (Some(10.0), Some(0.2)));
        assert_eq!(both.rig.as_deref(), Some("measured"));
    }

    #[test]
    fn a_robot_with_fewer_sensors_keeps_their_names() {
        for (asked, expected) in [(8.0, 8), (6.0, 6), (4.0, 4), (2.0, 2)] {
            let robot = set(Key::Sensors, asked).robot().expect("a robot");
            assert_eq!((robot.rig.sensors.len(), robot.names.len()), (expected, expected));
        }
        let robot = set(Key::Sensors, 4.0).robot().expect("a robot");
        assert_eq!(robot.names, ["front", "left", "back", "right"]);
    }

    #[test]
    fn every_key_changes_what_is_simulated_or_driven() {
        let (robot, options, pilot) =
            (Setting::default().robot().expect("a robot"), SimOptions::default(), PilotConfig::default());
        for (key, value) in [
            (Key::GainSigma, 0.2),
            (Key::ScaleSigma, 0.2),
            (Key::TrackSigma, 0.2),
            (Key::NoiseV, 0.2),
            (Key::MaxRange, 0.9),
            (Key::Sensors, 4.0),
            (Key::Speed, 0.2),
            (Key::Rate, 5.0),
            (Key::Slips, 1.0),
        ] {
            let changed = set(key, value);
            let same =
                changed.robot().expect("a robot") == robot && changed.options() == options && changed.pilot() == pilot;
            assert!(!same, "{key:?}");
        }
    }
}
