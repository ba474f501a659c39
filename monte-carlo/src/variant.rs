//! The estimators that an experiment compares.

use slam_core::{Config, Linearisation, RigError, WallPolicy};

use hal_sim::scanner::ScannerKind;
use relatives::Kind;

use crate::keys::{self, SensesName};
use crate::senses::Senses;
use input_file::{FileError, Number, TomlFile, Whole};
use lab::input::part::{self, Part};
use lab::input::settings::{Groups, Jacobians, Walls};

/// How a variant comes to a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The encoders alone.
    DeadReckoning,
    /// The estimator with these settings and this many buffered outliers.
    Slam(Config, Buffer),
    /// The same with what a robot has beside it: the back end, which hands over, and the map that is kept where readings contradict it.
    Robot,
    /// Localisation alone: the true map, the true gains, scales and track are given.
    Floor,
    /// Another system.
    Relative(Kind),
}

/// Room for outliers: a const generic of the estimator, so there are a few sizes only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Buffer {
    /// 32 points.
    B32,
    /// 64 points.
    B64,
    /// 128 points: the default.
    B128,
    /// 255 points: the most.
    B255,
}

/// One estimator of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// What tables and figures call it.
    pub name: String,
    /// How it works.
    pub method: Method,
    /// With what it senses.
    pub senses: Senses,
}

/// Rays of a laser where nothing else is said: one a degree over the half circle ahead.
const LASER_RAYS: usize = 181;

/// The estimator as it works by default, which also steers the drive.
pub const DEFAULT: &str = "grid, calibrated";

/// Names of the variants that need no description.
pub const NAMED: [&str; 8] = [
    "dead reckoning",
    "report 3.1, free",
    "report 3.2, snapped",
    "report 3.2, theta moves",
    "grid, uncalibrated",
    DEFAULT,
    "whole robot",
    "floor",
];

impl Variant {
    /// The variant of this name.
    pub fn named(name: &str) -> Option<Self> {
        // The report's filter is a plain one.
        let slam = |walls: WallPolicy, calibrate: bool| {
            let linearisation = match walls {
                WallPolicy::Grid | WallPolicy::NearGrid => Linearisation::FirstEstimates,
                _ => Linearisation::Latest,
            };
            let mut config = Config { walls: walls.into(), ..Config::default() };
            config.measurement.linearisation = linearisation;
            config.sensing.calibrate_gains = calibrate;
            config.sensing.calibrate_age = calibrate;
            config.motion.calibrate_scales = calibrate;
            config.motion.calibrate_track = calibrate;
            Method::Slam(config, Buffer::B128)
        };
        let methods = [
            Method::DeadReckoning,
            slam(WallPolicy::Free, false),
            slam(WallPolicy::Snapped { theta_moves: false }, false),
            slam(WallPolicy::Snapped { theta_moves: true }, false),
            slam(WallPolicy::Grid, false),
            Method::Slam(Config::default(), Buffer::B128),
            Method::Robot,
            Method::Floor,
        ];
        let found = NAMED.iter().position(|named| *named == name)?;
        Some(Self { name: name.to_owned(), method: methods[found], senses: Senses::Rig })
    }

    /// The variant of a `[[variant]]` at this place: the default, changed.
    ///
    /// # Errors
    /// A value that is not allowed.
    pub(crate) fn of(toml: &TomlFile<'_>, place: &str, keys: keys::Variant) -> Result<Self, FileError> {
        // Another system has no such settings, and an estimator with other sensors has those that suit these.
        let has_own = keys.relative.is_some() || !matches!(keys.senses, None | Some(SensesName::Rig));
        if let Some(key) = keys.setting().filter(|_| has_own) {
            let message =
                "is a setting of the estimator with the rig's sensors; it does not go with relative or other senses";
            return Err(toml.error(&format!("{place}.{key}"), message));
        }
        let mut config = Config::default();
        config.walls.policy = keys.walls.map_or(WallPolicy::Grid, Walls::policy);
        config.births.clustering = keys.clusters.map_or(config.births.clustering, Groups::clustering);
        config.measurement.linearisation =
            keys.jacobians.map_or(config.measurement.linearisation, Jacobians::linearisation);
        config.measurement.gate = keys.gate.as_ref().map_or(config.measurement.gate, Number::single);
        config.sensing.calibrate_gains = keys.calibrate_gains.unwrap_or(true);
        config.motion.calibrate_scales = keys.calibrate_scales.unwrap_or(true);
        config.motion.calibrate_track = keys.calibrate_track.unwrap_or(true);
        for name in keys.without {
            let error = || {
                let message = format!("names {:?}; parts are {}", name.as_ref(), part::names());
                toml.error(&format!("{place}.without"), message)
            };
            config = Part::of_name(name.as_ref()).ok_or_else(error)?.off(config);
        }
        config.validate().map_err(|RigError { key, allowed, .. }| {
            let place = format!("{place}.{key}");
            let given = toml.given(&place).unwrap_or_default();
            toml.error(&place, format!("is {given}; it must be {allowed}"))
        })?;
        let buffer = match keys.buffer.map(Whole::get) {
            Some(32) => Buffer::B32,
            Some(64) => Buffer::B64,
            None | Some(128) => Buffer::B128,
            Some(255) => Buffer::B255,
            Some(_) => {
                let message = "must be 32, 64, 128 or 255: the sizes that the workbench is built with";
                return Err(toml.error(&format!("{place}.buffer"), message));
            }
        };
        let kind = keys.relative.map(|name| {
            Kind::of_name(name.as_ref()).map_err(|allowed| toml.error(&format!("{place}.relative"), allowed))
        });
        let method = kind.transpose()?.map_or(Method::Slam(config, buffer), Method::Relative);
        if keys.rays.is_some() && keys.senses != Some(SensesName::Laser) {
            let message = "is there without senses = \"laser\", whose rays these are";
            return Err(toml.error(&format!("{place}.rays"), message));
        }
        let rays = keys.rays.map_or(LASER_RAYS, |rays| rays.get() as usize);
        let senses = match keys.senses {
            None | Some(SensesName::Rig) => Senses::Rig,
            Some(SensesName::Laser) => Senses::Scanner(ScannerKind::Laser(rays)),
            Some(SensesName::Sonar) => Senses::Scanner(ScannerKind::Sonar),
        };
        Ok(Self { name: keys::table_name(toml, place, keys.name)?, method, senses })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_can_be_left_out_by_name() {
        let read = |text: &str| {
            let file = std::path::Path::new("x.toml");
            let toml = TomlFile::new(file, text);
            toml.read().and_then(|keys| Variant::of(&toml, "variant[0]", keys)).map_err(|error| error.to_string())
        };
        let found = read("name = \"exact\"\nwithout = [\"gains\", \"scales\"]").expect("a variant");
        let mut expected = Config::default();
        expected.sensing.calibrate_gains = false;
        expected.motion.calibrate_scales = false;
        assert_eq!(found.method, Method::Slam(expected, Buffer::B128));
        let error = read("name = \"exact\"\nwithout = [\"luck\"]").expect_err("no such part");
        assert!(error.contains("variant[0].without: names \"luck\"; parts are grid, gains"), "{error}");
    }

    #[test]
    fn settings_that_would_be_ignored_are_refused() {
        let read = |text: &str| {
            let text = format!("name = \"x\"\n{text}");
            let toml = TomlFile::new(std::path::Path::new("x.toml"), &text);
            let found = toml.read().and_then(|keys| Variant::of(&toml, "variant[0]", keys));
            found.map(|_| ()).map_err(|error| error.to_string())
        };
        for text in ["senses = \"sonar\"\ngate = 6.63", "relative = \"abrate\"\nbuffer = 64"] {
            let error = read(text).expect_err("they do not go together");
            assert!(error.contains("is a setting of the estimator"), "{error}");
        }
        for text in ["senses = \"sonar\"", "senses = \"rig\"\ngate = 6.63", "relative = \"abrate\"\nsenses = \"laser\""]
        {
            read(text).expect("these do");
        }
    }

    #[test]
    fn every_name_is_a_different_method() {
        let variants: Vec<Variant> = NAMED.iter().map(|name| Variant::named(name).expect("named")).collect();
        for (i, one) in variants.iter().enumerate() {
            assert!(variants[..i].iter().all(|other| other.method != one.method), "{one:?}");
        }
        assert_eq!(Variant::named("grid"), None);
        let default = Method::Slam(Config::default(), Buffer::B128);
        assert_eq!(Variant::named(DEFAULT).map(|variant| variant.method), Some(default));
    }
}
