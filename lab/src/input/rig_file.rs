//! `rig.toml`: what the robot is made of.

use std::fmt::Write as _;
use std::path::Path;

use slam_core::{Adc, DriveModel, Mount, RangeModel, RangeSensor, Rig, RigError};

use crate::error::FileError;
use crate::input::text_file;
use crate::input::toml_table::{Allowed, Table, parse};

/// Most range sensors that the workbench takes.
pub const MAX_SENSORS: usize = 16;

/// Largest incidence where the rig file names none, degrees: at grazing incidence an infrared spot smears over the wall.
const DEFAULT_MAX_INCIDENCE_DEG: f32 = 70.0;

/// Largest incidence that the estimator takes, degrees: a rig file's 90 means no limit.
const WIDEST_INCIDENCE_DEG: f32 = 89.9;

/// Shortest range that the estimator takes, metres: a rig file's 0 means no limit.
const SHORTEST_M: f32 = 1e-6;

const fn closed(min: f64, max: f64, words: &'static str) -> Allowed {
    Allowed { min, above_min: false, max, below_max: false, words }
}

const RELATIVE: Allowed = Allowed { below_max: true, ..closed(0.0, 0.5, "a ratio of at least 0 and less than 0.5") };
const INCIDENCE: Allowed = Allowed { above_min: true, ..closed(0.0, 90.0, "an angle above 0 and up to 90") };
const BEARING: Allowed = closed(-360.0, 360.0, "an angle from -360 to 360");
const EXPONENT: Allowed = Allowed { below_max: true, ..closed(-4.0, 0.0, "a number from -4 to below 0") };

/// A robot as its rig file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// What the estimator needs.
    pub rig: Rig<MAX_SENSORS>,
    /// The sensors' names.
    pub names: Vec<String>,
}

impl Robot {
    /// Reads a rig file.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML, or a value is missing, unknown or impossible.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let text = text_file::read(file)?;
        Self::parse(file, &text)
    }

    /// Reads a rig file's text; `file` is for messages.
    ///
    /// # Errors
    /// The text is not TOML, or a value is missing, unknown or impossible.
    pub fn parse(file: &Path, text: &str) -> Result<Self, FileError> {
        let document = parse(file, text)?;
        let root = Table::root(file, text, document.get_ref());
        let drive = read_drive(&root)?;
        let adc = root.table("adc")?.map(|table| read_adc(&table)).transpose()?;
        let tables = root.tables("range_sensor")?;
        if tables.is_empty() || tables.len() > MAX_SENSORS {
            let message = format!("there are {}; there must be 1 to {MAX_SENSORS} [[range_sensor]]", tables.len());
            return Err(root.error("range_sensor", message));
        }
        let mut rig = Rig { drive, adc, sensors: Default::default() };
        let mut names: Vec<String> = Vec::new();
        for table in &tables {
            let name = table.text("name")?;
            if names.contains(&name) {
                return Err(table.error("name", format!("is {name:?} again; each sensor has its own name")));
            }
            if name.contains([',', '"', '\n', '\r']) {
                return Err(table.error("name", "holds a comma, quote or line break, which a CSV file cannot carry"));
            }
            names.push(name);
            let sensor = read_sensor(table)?;
            if matches!(sensor.model, RangeModel::Sharp { .. }) && rig.adc.is_none() {
                return Err(root.error("adc", format!("is missing; {} is an analogue sensor", names[names.len() - 1])));
            }
            // Cannot fail: the count was checked above.
            let _ = rig.sensors.push(sensor);
        }
        root.nothing_else()?;
        rig.validate().map_err(|error| {
            let drive = if root.has("wheels") { root.table("wheels") } else { root.table("odometry") };
            let own = |table: &Table<'_>| table.error(error.key, format!("must be {}", error.allowed));
            match error.sensor.and_then(|index| tables.get(usize::from(index))) {
                Some(table) => own(table),
                None => drive.ok().flatten().map_or_else(|| own(&root), |table| own(&table)),
            }
        })?;
        Ok(Self { rig, names })
    }

    /// The rig file's text for this robot. Angles are rounded to 0.0001 degrees: who needs a replay with the same bits
    /// must itself use what [`Robot::parse`] makes of this text.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = write_drive(&mut text, &self.rig.drive);
        if let Some(adc) = self.rig.adc {
            let _ = writeln!(text, "\n[adc]\nbits = {}\nvref_v = {:?}", adc.bits, adc.vref_v);
        }
        for (sensor, name) in self.rig.sensors.iter().zip(&self.names) {
            let _ = write_sensor(&mut text, sensor, name);
        }
        text
    }
}

/// A rig value that the estimator refuses, as an error in the rig file.
pub fn rig_error(file: &Path, error: &RigError) -> FileError {
    let key = match error.sensor {
        Some(index) => format!("range_sensor[{index}].{}", error.key),
        None => error.key.to_owned(),
    };
    FileError::new(file, format!("is impossible; it must be {}", error.allowed)).at(key)
}

fn read_drive(root: &Table<'_>) -> Result<DriveModel, FileError> {
    match (root.table("wheels")?, root.table("odometry")?) {
        (Some(_), Some(_)) => Err(root.error("odometry", "is there beside [wheels]; a robot has one of the two")),
        (None, None) => Err(root.error("wheels", "is missing; a robot has either [wheels] or [odometry]")),
        (Some(table), None) => {
            let drive = DriveModel::Wheels {
                track_m: table.number("track_m", Allowed::POSITIVE)?,
                track_sigma: table.optional_number("track_sigma", RELATIVE)?.unwrap_or(0.0),
                metres_per_tick: table.number("metres_per_tick", Allowed::POSITIVE)?,
                scale_sigma: table.number("scale_sigma", RELATIVE)?,
                noise_m2_per_m: table.number("noise_m2_per_m", Allowed::NOT_NEGATIVE)?,
            };
            table.nothing_else()?;
            Ok(drive)
        }
        (None, Some(table)) => {
            let drive = DriveModel::Odometry {
                scale_sigma: table.number("scale_sigma", RELATIVE)?,
                noise_m2_per_m: table.number("noise_m2_per_m", Allowed::NOT_NEGATIVE)?,
                noise_rad2_per_m: table.number("noise_rad2_per_m", Allowed::NOT_NEGATIVE)?,
                noise_rad2_per_rad: table.number("noise_rad2_per_rad", Allowed::NOT_NEGATIVE)?,
            };
            table.nothing_else()?;
            Ok(drive)
        }
    }
}

fn read_adc(table: &Table<'_>) -> Result<Adc, FileError> {
    let bits = table.integer("bits", 1, 16)?;
    let adc = Adc { bits: bits as u8, vref_v: table.number("vref_v", Allowed::POSITIVE)? };
    table.nothing_else()?;
    Ok(adc)
}

fn read_sensor(table: &Table<'_>) -> Result<RangeSensor, FileError> {
    let bearing_deg = table.number("bearing_deg", BEARING)?;
    let min_m = table.number("min_m", Allowed::NOT_NEGATIVE)?;
    let max_m = table.number("max_m", Allowed::POSITIVE)?;
    if max_m <= min_m {
        return Err(table.error("max_m", format!("is {max_m}; it must be above min_m, which is {min_m}")));
    }
    let max_incidence_deg = table.optional_number("max_incidence_deg", INCIDENCE)?.unwrap_or(DEFAULT_MAX_INCIDENCE_DEG);
    let sensor = RangeSensor {
        mount: Mount {
            x_m: table.number("x_m", Allowed::FINITE)?,
            y_m: table.number("y_m", Allowed::FINITE)?,
            bearing_rad: bearing_deg.to_radians(),
        },
        min_m: min_m.max(SHORTEST_M),
        max_m,
        max_incidence_rad: max_incidence_deg.min(WIDEST_INCIDENCE_DEG).to_radians(),
        gain_sigma: table.number("gain_sigma", RELATIVE)?,
        model: read_model(table)?,
    };
    table.nothing_else()?;
    Ok(sensor)
}

fn read_model(table: &Table<'_>) -> Result<RangeModel, FileError> {
    let analogue = ["scale_m", "exponent", "noise_v"].into_iter().find(|key| table.has(key));
    let metric = ["noise_m", "noise_rel"].into_iter().find(|key| table.has(key));
    match (analogue, metric) {
        (Some(one), Some(other)) => Err(table.error(
            other,
            format!("is there beside {one}; a sensor is analogue (scale_m, exponent, noise_v) or reports metres (noise_m, noise_rel)"),
        )),
        (Some(_), None) => Ok(RangeModel::Sharp {
            scale_m: table.number("scale_m", Allowed::POSITIVE)?,
            exponent: table.number("exponent", EXPONENT)?,
            noise_v: table.number("noise_v", Allowed::POSITIVE)?,
        }),
        (None, Some(_)) => {
            let noise_m = table.number("noise_m", Allowed::NOT_NEGATIVE)?;
            let noise_rel = table.number("noise_rel", Allowed::NOT_NEGATIVE)?;
            if noise_m == 0.0 && noise_rel == 0.0 {
                return Err(table.error("noise_m", "and noise_rel are both 0; one must be above 0, no sensor is exact"));
            }
            Ok(RangeModel::Metric { noise_m, noise_rel })
        }
        (None, None) => Err(table.error(
            "noise_m",
            "is missing; a sensor has scale_m, exponent and noise_v (analogue) or noise_m and noise_rel (reports metres)",
        )),
    }
}

fn write_drive(text: &mut String, drive: &DriveModel) -> std::fmt::Result {
    match drive {
        DriveModel::Wheels { track_m, track_sigma, metres_per_tick, scale_sigma, noise_m2_per_m } => write!(
            text,
            "[wheels]\ntrack_m = {track_m:?}\ntrack_sigma = {track_sigma:?}\nmetres_per_tick = {metres_per_tick:?}\n\
             scale_sigma = {scale_sigma:?}\nnoise_m2_per_m = {noise_m2_per_m:?}\n"
        ),
        DriveModel::Odometry { scale_sigma, noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad } => write!(
            text,
            "[odometry]\nscale_sigma = {scale_sigma:?}\nnoise_m2_per_m = {noise_m2_per_m:?}\n\
             noise_rad2_per_m = {noise_rad2_per_m:?}\nnoise_rad2_per_rad = {noise_rad2_per_rad:?}\n"
        ),
    }
}

/// Degrees to four places: enough for any mount, and 45 stays 45.
fn degrees(rad: f32) -> f64 {
    (f64::from(rad).to_degrees() * 1e4).round() / 1e4
}

fn write_sensor(text: &mut String, sensor: &RangeSensor, name: &str) -> std::fmt::Result {
    let RangeSensor { mount, min_m, max_m, max_incidence_rad, gain_sigma, model } = sensor;
    let bearing_deg = degrees(mount.bearing_rad);
    let max_incidence_deg = degrees(*max_incidence_rad);
    write!(
        text,
        "\n[[range_sensor]]\nname = {name:?}\nx_m = {:?}\ny_m = {:?}\nbearing_deg = {bearing_deg:?}\nmin_m = {min_m:?}\n\
         max_m = {max_m:?}\nmax_incidence_deg = {max_incidence_deg:?}\ngain_sigma = {gain_sigma:?}\n",
        mount.x_m, mount.y_m
    )?;
    match model {
        RangeModel::Sharp { scale_m, exponent, noise_v } => {
            writeln!(text, "scale_m = {scale_m:?}\nexponent = {exponent:?}\nnoise_v = {noise_v:?}")
        }
        RangeModel::Metric { noise_m, noise_rel } => {
            writeln!(text, "noise_m = {noise_m:?}\nnoise_rel = {noise_rel:?}")
        }
    }
}
