//! The estimators that an experiment compares.

use slam_core::{Clustering, Config, Linearisation, WallPolicy};

use crate::toml_table::{Allowed, Table};
use input_file::FileError;
use lab::input::part::{self, Part};

/// How a variant comes to a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The encoders alone.
    DeadReckoning,
    /// The estimator with these settings and this many buffered outliers.
    Slam(Config, Buffer),
    /// Localisation alone: the true map, the true gains, scales and track are given.
    Floor,
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
}

/// The estimator as it works by default, which also steers the drive.
pub const DEFAULT: &str = "grid, calibrated";

/// Names of the variants that need no description.
pub const NAMED: [&str; 7] = [
    "dead reckoning",
    "report 3.1, free",
    "report 3.2, snapped",
    "report 3.2, theta moves",
    "grid, uncalibrated",
    DEFAULT,
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
            let config = Config {
                walls,
                linearisation,
                calibrate_gains: calibrate,
                calibrate_scales: calibrate,
                calibrate_track: calibrate,
                ..Config::default()
            };
            Method::Slam(config, Buffer::B128)
        };
        let methods = [
            Method::DeadReckoning,
            slam(WallPolicy::Free, false),
            slam(WallPolicy::Snapped { theta_moves: false }, false),
            slam(WallPolicy::Snapped { theta_moves: true }, false),
            slam(WallPolicy::Grid, false),
            Method::Slam(Config::default(), Buffer::B128),
            Method::Floor,
        ];
        let found = NAMED.iter().position(|named| *named == name)?;
        Some(Self { name: name.to_owned(), method: methods[found] })
    }

    /// Reads a `[[variant]]`: the default, changed.
    ///
    /// # Errors
    /// A key that is not known, or a value that is not allowed.
    pub fn read(table: &Table<'_>) -> Result<Self, FileError> {
        let flag = |key: &'static str| Ok::<_, FileError>(table.optional_flag(key)?.unwrap_or(true));
        let mut config = Config { walls: read_walls(table)?, clustering: read_clusters(table)?, ..Config::default() };
        config.calibrate_gains = flag("calibrate_gains")?;
        config.calibrate_scales = flag("calibrate_scales")?;
        config.calibrate_track = flag("calibrate_track")?;
        config.linearisation = read_linearisation(table)?;
        config.gate = table.optional_number("gate", Allowed::POSITIVE)?.unwrap_or(config.gate);
        for name in table.texts("without")? {
            let unknown = || table.error("without", format!("names {name:?}; parts are {}", part::names()));
            config = Part::of_name(&name).ok_or_else(unknown)?.off(config);
        }
        let variant = Self { name: table.text("name")?, method: Method::Slam(config, read_buffer(table)?) };
        if variant.name.contains(['"', '\n', '|']) {
            return Err(table.error("name", "holds a quote, line break or |, which the tables cannot carry"));
        }
        table.nothing_else()?;
        Ok(variant)
    }
}

fn read_walls(table: &Table<'_>) -> Result<WallPolicy, FileError> {
    match table.optional_text("walls")?.as_deref() {
        None | Some("grid") => Ok(WallPolicy::Grid),
        Some("near-grid") => Ok(WallPolicy::NearGrid),
        Some("free") => Ok(WallPolicy::Free),
        Some("snapped") => Ok(WallPolicy::Snapped { theta_moves: false }),
        Some("snapped-moving") => Ok(WallPolicy::Snapped { theta_moves: true }),
        Some(_) => {
            Err(table.error("walls", "must be \"grid\", \"near-grid\", \"free\", \"snapped\" or \"snapped-moving\""))
        }
    }
}

fn read_clusters(table: &Table<'_>) -> Result<Clustering, FileError> {
    match table.optional_text("clusters")?.as_deref() {
        None | Some("sensor") => Ok(Clustering::BySensor),
        Some("dbscan") => Ok(Clustering::Dbscan),
        Some(_) => Err(table.error("clusters", "must be \"sensor\" or \"dbscan\"")),
    }
}

fn read_linearisation(table: &Table<'_>) -> Result<Linearisation, FileError> {
    match table.optional_text("jacobians")?.as_deref() {
        Some("latest") => Ok(Linearisation::Latest),
        None | Some("first") => Ok(Linearisation::FirstEstimates),
        Some(_) => Err(table.error("jacobians", "must be \"latest\" or \"first\"")),
    }
}

fn read_buffer(table: &Table<'_>) -> Result<Buffer, FileError> {
    match table.optional_number("buffer", Allowed::POSITIVE)? {
        Some(32.0) => Ok(Buffer::B32),
        Some(64.0) => Ok(Buffer::B64),
        None | Some(128.0) => Ok(Buffer::B128),
        Some(255.0) => Ok(Buffer::B255),
        Some(_) => Err(table.error("buffer", "must be 32, 64, 128 or 255: the sizes that the workbench is built with")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_can_be_left_out_by_name() {
        let read = |text: &str| {
            let file = std::path::Path::new("x.toml");
            let entries = crate::toml_table::parse(file, text).expect("TOML");
            Variant::read(&Table::root(file, text, entries.get_ref())).map_err(|error| error.to_string())
        };
        let found = read("name = \"exact\"\nwithout = [\"gains\", \"scales\"]").expect("a variant");
        let expected = Config { calibrate_gains: false, calibrate_scales: false, ..Config::default() };
        assert_eq!(found.method, Method::Slam(expected, Buffer::B128));
        let error = read("name = \"exact\"\nwithout = [\"luck\"]").expect_err("no such part");
        assert!(error.contains("x.toml:2: without: names \"luck\"; parts are grid, gains"), "{error}");
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
