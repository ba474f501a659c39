//! What one drive of an experiment differs in from the default: the robot's errors, its manner of driving, its home.

use std::collections::BTreeMap;
use std::path::Path;

use hal_sim::rng::Rng;
use hal_sim::{Age, SharpOptions, SimOptions};
use robot::PilotConfig;
use slam_core::{DriveModel, RangeModel};

use crate::key::Key;
use input_file::FileError;
use lab::input::built_in_robot;
use lab::input::rig_file::Robot;

/// Values of the keys that differ from the default, and the rig where it is another one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setting {
    /// Name or file of the rig; the built-in robot where not given. `measured` is the built-in robot with the sensors
    /// of [`hal_sim::measured_rig`], `short` one with those of [`hal_sim::short_rig`].
    pub rig: Option<String>,
    /// The values.
    pub values: BTreeMap<Key, f64>,
    /// Keys whose value each seed draws, uniformly from the least to the most.
    pub draws: BTreeMap<Key, [f64; 2]>,
}

impl Setting {
    /// This setting where `over` says nothing else.
    pub fn overlaid(&self, over: &Setting) -> Self {
        let mut both = self.clone();
        both.rig = over.rig.clone().or(both.rig);
        // What is set is not drawn, and the other way round.
        both.draws.retain(|key, _| !over.values.contains_key(key));
        both.values.retain(|key, _| !over.draws.contains_key(key));
        both.values.extend(&over.values);
        both.draws.extend(&over.draws);
        both
    }

    /// This setting as one seed draws it.
    pub fn drawn(&self, seed: u64) -> Self {
        let mut drawn = Self { draws: BTreeMap::new(), ..self.clone() };
        for (key, [least, most]) in &self.draws {
            drawn.values.insert(*key, Rng::stream(seed, key.name(), 0).uniform(*least, *most));
        }
        drawn
    }

    /// The value of a key that was set.
    pub fn get(&self, key: Key) -> Option<f64> {
        self.values.get(&key).copied()
    }

    /// The rig file; none where the rig is one of the program's own.
    pub(crate) fn rig_file(&self) -> Option<&str> {
        self.rig.as_deref().filter(|rig| !["measured", "short"].contains(rig))
    }

    /// The robot of this setting.
    ///
    /// # Errors
    /// The rig file cannot be used.
    pub fn robot(&self) -> Result<Robot, FileError> {
        let mut robot = match self.rig.as_deref() {
            None => built_in_robot()?.0,
            Some("measured") => Robot { rig: hal_sim::measured_rig(), ..built_in_robot()?.0 },
            Some("short") => Robot { rig: hal_sim::short_rig(), ..built_in_robot()?.0 },
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

    /// What the estimator is told of this robot: its odometry where samples have no ticks.
    pub fn told(&self, robot: &Robot) -> Robot {
        let mut told = robot.clone();
        if let (Some(_), DriveModel::Wheels { track_m, scale_sigma, noise_m2_per_m, .. }) =
            (self.get(Key::OdometryRate), robot.rig.drive)
        {
            // The mean and the difference of two wheels' noises; a turn on the spot is half a track's travel a radian.
            let noise_rad2_per_m = 2.0 * noise_m2_per_m / (track_m * track_m);
            told.rig.drive = DriveModel::Odometry {
                scale_sigma,
                noise_m2_per_m: 0.5 * noise_m2_per_m,
                noise_rad2_per_m,
                noise_rad2_per_rad: 0.5 * track_m * noise_rad2_per_m,
                veer_sigma: 2.0f32.sqrt() * scale_sigma / track_m,
            };
        }
        told
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
        let mut options = SimOptions::default();
        let over = |value: &mut f64, key: Key, unit: f64| *value = self.get(key).map_or(*value, |set| set * unit);
        over(&mut options.rate_hz, Key::Rate, 1.0);
        over(&mut options.error_ratio, Key::ErrorRatio, 1.0);
        over(&mut options.tick_s, Key::Tick, 1e-3);
        over(&mut options.stamp_jitter_s, Key::StampJitter, 1e-3);
        over(&mut options.drive.slips_per_m, Key::Slips, 1.0);
        over(&mut options.drive.slip_m, Key::SlipLength, 1.0);
        over(&mut options.drive.slip_tail, Key::SlipTail, 1.0);
        over(&mut options.drive.drift_rad_per_m, Key::Drift, 1_f64.to_radians());
        options.odometry_hz = self.get(Key::OdometryRate);
        if self.rig.as_deref() == Some("measured") {
            options.sharp = SharpOptions::measured();
        }
        over(&mut options.sharp.filter_s, Key::Filter, 1e-3);
        options.sharp.noise_v = self.get(Key::TrueNoiseV);
        let spread_s = 1e-3 * self.get(Key::AgeSpread).unwrap_or(0.0);
        options.sharp.age = self.get(Key::Age).map(|mean_ms| Age { mean_s: 1e-3 * mean_ms, spread_s });
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
        Setting { values: BTreeMap::from([(key, value)]), ..Setting::default() }
    }

    #[test]
    fn the_overlaid_value_wins_and_the_rest_stays() {
        let base = Setting {
            rig: Some("measured".into()),
            values: [(Key::Rate, 25.0), (Key::Speed, 0.2)].into(),
            ..Setting::default()
        };
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
            (Key::SlipLength, 0.02),
            (Key::SlipTail, 1.0),
            (Key::Drift, 1.0),
            (Key::ErrorRatio, 2.0),
            (Key::TrueNoiseV, 0.045),
            (Key::Age, 20.0),
            (Key::Filter, 10.0),
            (Key::StampJitter, 5.0),
            (Key::OdometryRate, 20.0),
            (Key::Tick, 1.0),
        ] {
            let changed = set(key, value);
            let same =
                changed.robot().expect("a robot") == robot && changed.options() == options && changed.pilot() == pilot;
            assert!(!same, "{key:?}");
        }
    }

    #[test]
    fn each_seed_draws_its_own_value_within_the_limits() {
        let setting = Setting { draws: [(Key::Age, [10.0, 30.0])].into(), ..Setting::default() };
        let ages: Vec<f64> = (0..50).filter_map(|seed| setting.drawn(seed).get(Key::Age)).collect();
        assert_eq!(ages.len(), 50);
        assert!(ages.iter().all(|age| (10.0..30.0).contains(age)));
        assert!(ages.iter().any(|age| *age < 15.0) && ages.iter().any(|age| *age > 25.0));
        assert_eq!(setting.drawn(7), setting.drawn(7));
        let fixed = setting.overlaid(&set(Key::Age, 5.0)).drawn(1);
        assert_eq!(fixed.get(Key::Age), Some(5.0));
    }
}
