//! `rig.toml`: what the robot is made of.

mod keys;

use std::fmt::Write as _;
use std::path::Path;

use input_file::{FileError, Limits, Number, TomlFile};
use slam_core::{Adc, DriveModel, Mount, RangeModel, RangeSensor, Rig, RigError, VEER_SIGMA};

/// Most range sensors that the workbench takes.
pub const MAX_SENSORS: usize = 16;

/// Largest incidence where the rig file names none, degrees: at grazing incidence an infrared spot smears over the wall.
const DEFAULT_MAX_INCIDENCE_DEG: f32 = 70.0;

/// Largest incidence that the estimator takes, degrees: a rig file's 90 means no limit.
const WIDEST_INCIDENCE_DEG: f32 = 89.9;

/// Shortest range that the estimator takes, metres: a rig file's 0 means no limit.
const SHORTEST_M: f32 = 1e-3;

/// A robot as its rig file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// What the estimator needs.
    pub rig: Rig<MAX_SENSORS>,
    /// The sensors' names.
    pub names: Vec<String>,
    /// Whether it takes over what look backs find, where the file says so.
    pub hand_overs: Option<bool>,
}

impl Robot {
    /// Reads a rig file.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML, or a value is missing, unknown or impossible.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let text = input_file::read(file)?;
        Self::parse(file, &text)
    }

    /// Reads a rig file's text; `file` is for messages.
    ///
    /// # Errors
    /// The text is not TOML, or a value is missing, unknown or impossible.
    pub fn parse(file: &Path, text: &str) -> Result<Self, FileError> {
        let toml = TomlFile::new(file, text);
        let keys: keys::File = toml.read()?;
        let drive_key = if keys.wheels.is_some() { "wheels" } else { "odometry" };
        let drive = drive(&toml, keys.wheels, keys.odometry)?;
        let names = names(&toml, &keys.range_sensor)?;
        let rig = Rig {
            drive,
            adc: keys.adc.map(|adc| Adc { bits: adc.bits.get() as u8, vref_v: adc.vref_v.single() }),
            sensors: keys
                .range_sensor
                .iter()
                .enumerate()
                .map(|(i, keys)| sensor(&toml, i, keys))
                .collect::<Result<_, _>>()?,
        };
        let is_analogue = |sensor: &RangeSensor| matches!(sensor.model, RangeModel::Sharp { .. });
        if let (Some(first), None) = (rig.sensors.iter().position(is_analogue), rig.adc) {
            return Err(toml.error("adc", format!("is missing; {} is an analogue sensor", names[first])));
        }
        rig.validate().map_err(|RigError { sensor, key, allowed }| {
            let table = match sensor {
                Some(index) => format!("range_sensor[{index}]"),
                None if ["bits", "vref_v"].contains(&key) => "adc".to_owned(),
                None => drive_key.to_owned(),
            };
            let place = format!("{table}.{key}");
            let is = toml.given(&place).map_or(String::new(), |given| format!("is {given}; it "));
            toml.error(&place, format!("{is}must be {allowed}"))
        })?;
        Ok(Self { rig, names, hand_overs: keys.hand_overs })
    }

    /// The rig file's text for this robot. Angles are rounded to 0.0001 degrees: who needs a replay with the same bits
    /// must itself use what [`Robot::parse`] makes of this text.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        if let Some(hand_overs) = self.hand_overs {
            let _ = writeln!(text, "hand_overs = {hand_overs}\n");
        }
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

fn names(toml: &TomlFile<'_>, sensors: &[keys::Sensor]) -> Result<Vec<String>, FileError> {
    if sensors.is_empty() || sensors.len() > MAX_SENSORS {
        let message = format!("there are {}; there must be 1 to {MAX_SENSORS} [[range_sensor]]", sensors.len());
        return Err(toml.error("range_sensor", message));
    }
    let mut names: Vec<String> = Vec::new();
    for (i, sensor) in sensors.iter().enumerate() {
        let name = sensor.name.as_ref();
        let error = |message: String| Err(toml.error(&format!("range_sensor[{i}].name"), message));
        if names.iter().any(|known| known == name) {
            return error(format!("is {name:?} again; each sensor has its own name"));
        }
        if name.contains([',', '"', '\n', '\r']) {
            return error("holds a comma, quote or line break, which a CSV file cannot carry".into());
        }
        names.push(name.to_owned());
    }
    Ok(names)
}

fn drive(
    toml: &TomlFile<'_>,
    wheels: Option<keys::Wheels>,
    odometry: Option<keys::Odometry>,
) -> Result<DriveModel, FileError> {
    match (wheels, odometry) {
        (Some(_), Some(_)) => Err(toml.error("odometry", "is there beside [wheels]; a robot has one of the two")),
        (None, None) => Err(toml.error("wheels", "is missing; a robot has either [wheels] or [odometry]")),
        (Some(keys), None) => Ok(DriveModel::Wheels {
            track_m: keys.track_m.single(),
            track_sigma: keys.track_sigma.map_or(0.0, |sigma| sigma.single()),
            metres_per_tick: keys.metres_per_tick.single(),
            scale_sigma: keys.scale_sigma.single(),
            noise_m2_per_m: keys.noise_m2_per_m.single(),
        }),
        (None, Some(keys)) => Ok(DriveModel::Odometry {
            scale_sigma: keys.scale_sigma.single(),
            noise_m2_per_m: keys.noise_m2_per_m.single(),
            noise_rad2_per_m: keys.noise_rad2_per_m.single(),
            noise_rad2_per_rad: keys.noise_rad2_per_rad.single(),
            veer_sigma: keys.drift_sigma_deg_per_m.map_or(VEER_SIGMA, |sigma| sigma.single().to_radians()),
        }),
    }
}

fn sensor(toml: &TomlFile<'_>, index: usize, keys: &keys::Sensor) -> Result<RangeSensor, FileError> {
    let place = format!("range_sensor[{index}]");
    let (min_m, max_m) = (keys.min_m.single(), keys.max_m.single());
    if max_m <= min_m {
        let message = format!("is {max_m}; it must be above min_m, which is {min_m}");
        return Err(toml.error(&format!("{place}.max_m"), message));
    }
    let max_incidence_deg = keys.max_incidence_deg.as_ref().map_or(DEFAULT_MAX_INCIDENCE_DEG, Number::single);
    Ok(RangeSensor {
        mount: Mount {
            x_m: keys.x_m.single(),
            y_m: keys.y_m.single(),
            bearing_rad: keys.bearing_deg.single().to_radians(),
        },
        min_m: min_m.max(SHORTEST_M),
        max_m,
        max_incidence_rad: max_incidence_deg.min(WIDEST_INCIDENCE_DEG).to_radians(),
        gain_sigma: keys.gain_sigma.single(),
        model: model(toml, &place, keys)?,
    })
}

fn model(toml: &TomlFile<'_>, place: &str, keys: &keys::Sensor) -> Result<RangeModel, FileError> {
    let present = |names: [(&'static str, bool); 3]| names.into_iter().find(|(_, given)| *given).map(|(name, _)| name);
    let analogue = present([
        ("scale_m", keys.scale_m.is_some()),
        ("exponent", keys.exponent.is_some()),
        ("noise_v", keys.noise_v.is_some()),
    ]);
    let metric = present([("noise_m", keys.noise_m.is_some()), ("noise_rel", keys.noise_rel.is_some()), ("", false)]);
    let at = |key: &str| format!("{place}.{key}");
    match (analogue, metric) {
        (Some(one), Some(other)) => Err(toml.error(
            &at(other),
            format!("is there beside {one}; a sensor is analogue (scale_m, exponent, noise_v) or reports metres (noise_m, noise_rel)"),
        )),
        (Some(_), None) => Ok(RangeModel::Sharp {
            scale_m: single(toml, &at("scale_m"), keys.scale_m.as_ref())?,
            exponent: single(toml, &at("exponent"), keys.exponent.as_ref())?,
            noise_v: single(toml, &at("noise_v"), keys.noise_v.as_ref())?,
        }),
        (None, Some(_)) => {
            let noise_m = single(toml, &at("noise_m"), keys.noise_m.as_ref())?;
            let noise_rel = single(toml, &at("noise_rel"), keys.noise_rel.as_ref())?;
            if noise_m == 0.0 && noise_rel == 0.0 {
                let message = "and noise_rel are both 0; one must be above 0, no sensor is exact";
                return Err(toml.error(&at("noise_m"), message));
            }
            Ok(RangeModel::Metric { noise_m, noise_rel })
        }
        (None, None) => Err(toml.error(
            &at("noise_m"),
            "is missing; a sensor has scale_m, exponent and noise_v (analogue) or noise_m and noise_rel (reports metres)",
        )),
    }
}

/// A number that one kind of sensor must have.
fn single<L: Limits>(toml: &TomlFile<'_>, place: &str, number: Option<&Number<L>>) -> Result<f32, FileError> {
    toml.required(place, number, L::ALLOWED.words).map(Number::single)
}

fn write_drive(text: &mut String, drive: &DriveModel) -> std::fmt::Result {
    match drive {
        DriveModel::Wheels { track_m, track_sigma, metres_per_tick, scale_sigma, noise_m2_per_m } => write!(
            text,
            "[wheels]\ntrack_m = {track_m:?}\ntrack_sigma = {track_sigma:?}\nmetres_per_tick = {metres_per_tick:?}\n\
             scale_sigma = {scale_sigma:?}\nnoise_m2_per_m = {noise_m2_per_m:?}\n"
        ),
        DriveModel::Odometry { scale_sigma, noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, veer_sigma } => {
            write!(
                text,
                "[odometry]\nscale_sigma = {scale_sigma:?}\nnoise_m2_per_m = {noise_m2_per_m:?}\n\
             noise_rad2_per_m = {noise_rad2_per_m:?}\nnoise_rad2_per_rad = {noise_rad2_per_rad:?}\n\
             drift_sigma_deg_per_m = {:?}\n",
                degrees(*veer_sigma)
            )
        }
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
