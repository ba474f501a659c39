//! What the robot is made of: its motion input and its range sensors, with their errors.

use core::f32::consts::TAU;
use heapless::Vec;

/// Most range sensors that a rig of any capacity has.
pub const MAX_SENSORS: usize = 16;

/// Where a beam starts and points, in the robot's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mount {
    /// Forward of the axle's centre, metres.
    pub x_m: f32,
    /// Left of the axle's centre, metres.
    pub y_m: f32,
    /// Beam direction, radians counter-clockwise from straight ahead.
    pub bearing_rad: f32,
}

/// How a range sensor turns a distance into what is read, and how noisy that is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RangeModel {
    /// An analogue triangulation sensor (Sharp GP2Y0A family): range = `scale_m` * volts^`exponent`, with noise that is
    /// constant in volts. Sampled by an ADC.
    Sharp {
        /// Range at one volt, metres.
        scale_m: f32,
        /// Power of the voltage; negative.
        exponent: f32,
        /// 1-sigma of the output voltage, volts.
        noise_v: f32,
    },
    /// A sensor that reports metres; the two parts add in quadrature.
    Metric {
        /// 1-sigma, constant part, metres.
        noise_m: f32,
        /// 1-sigma, part proportional to range (a ratio).
        noise_rel: f32,
    },
}

impl RangeModel {
    /// 1-sigma of the noise of a range, both in metres.
    pub fn noise_m(&self, range_m: f32) -> f32 {
        match *self {
            Self::Sharp { scale_m, exponent, noise_v } => {
                let volts = float::powf(range_m / scale_m, 1.0 / exponent);
                (exponent * range_m * noise_v / volts).abs()
            }
            Self::Metric { noise_m, noise_rel } => {
                let proportional_m = noise_rel * range_m;
                float::sqrtf(noise_m * noise_m + proportional_m * proportional_m)
            }
        }
    }
}

/// One range sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RangeSensor {
    /// Where it sits.
    pub mount: Mount,
    /// Shortest range that is a reading, metres.
    pub min_m: f32,
    /// Longest range that is a reading, metres.
    pub max_m: f32,
    /// Largest angle between beam and wall normal at which a reading is trusted, radians.
    pub max_incidence_rad: f32,
    /// 1-sigma of the sensor's constant gain (reported range = gain x true range); zero: known exactly.
    pub gain_sigma: f32,
    /// What it measures with.
    pub model: RangeModel,
}

/// Where motion comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DriveModel {
    /// Differential drive with an encoder on each wheel.
    Wheels {
        /// Distance between the wheels' contact points, metres.
        track_m: f32,
        /// 1-sigma relative error of the track; zero: known exactly.
        track_sigma: f32,
        /// Travel of a wheel per encoder tick, metres.
        metres_per_tick: f32,
        /// 1-sigma relative error of each wheel's `metres_per_tick`; zero: known exactly.
        scale_sigma: f32,
        /// Variance of one wheel's travel per metre travelled, m^2/m.
        noise_m2_per_m: f32,
    },
    /// A dead-reckoned pose, moving in any direction.
    Odometry {
        /// 1-sigma relative error of travelled distance, and of turned angle: one scale for each.
        scale_sigma: f32,
        /// Position variance per metre travelled, each axis, m^2/m.
        noise_m2_per_m: f32,
        /// Heading variance per metre travelled, rad^2/m.
        noise_rad2_per_m: f32,
        /// Heading variance per radian turned, rad^2/rad.
        noise_rad2_per_rad: f32,
        /// 1-sigma of the constant turn that the odometry misses, radians per metre driven forward; zero: there is none.
        veer_sigma: f32,
    },
}

/// What is assumed of the veer where a rig does not say, radians per metre: three degrees, as of wheels
/// that differ by two per cent on a track of 0.4 m. Robots whose logs are in docs/notes/real-logs.md turn by 0.9 and 3.5 degrees a metre.
pub const VEER_SIGMA: f32 = 3.0f32.to_radians();

/// The analogue-to-digital converter behind [`RangeModel::Sharp`] sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Adc {
    /// Resolution; full scale is 2^bits - 1 counts.
    pub bits: u8,
    /// Voltage of full scale, volts.
    pub vref_v: f32,
}

/// The whole robot, with at most `S` range sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig<const S: usize> {
    /// Where motion comes from.
    pub drive: DriveModel,
    /// The converter, needed when any sensor is analogue.
    pub adc: Option<Adc>,
    /// The sensors, in the order of the samples' readings.
    pub sensors: Vec<RangeSensor, S>,
}

/// A value of a [`Rig`], or of a [`Config`](crate::Config), that cannot be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RigError {
    /// Index into [`Rig::sensors`] where a sensor is at fault.
    pub sensor: Option<u8>,
    /// The key, as it is called in a rig file or in the settings.
    pub key: &'static str,
    /// What is allowed.
    pub allowed: &'static str,
}

/// What a value may be, both ends included.
struct Limits {
    from: f32,
    to: f32,
    words: &'static str,
}

impl Limits {
    const fn new(from: f32, to: f32, words: &'static str) -> Self {
        Self { from, to, words }
    }

    /// The check of one value; what is not a number fails it.
    fn check(&self, value: f32, key: &'static str) -> Check {
        ((self.from..=self.to).contains(&value), key, self.words)
    }
}

type Check = (bool, &'static str, &'static str);

/// The limits are those of anything that drives through rooms, a decade and more beyond each: what is outside is another unit
/// or a slip of the pen, and ends in numbers that f32 cannot hold.
const TRACK_M: Limits = Limits::new(0.01, 10.0, "a number from 0.01 to 10");
const TICK_M: Limits = Limits::new(1e-7, 0.1, "a number from 1e-7 to 0.1");
const NOISE_PER_M: Limits = Limits::new(0.0, 1.0, "a number from 0 to 1");
const VEER_PER_M: Limits = Limits::new(0.0, TAU, "a number from 0 to 360");
const VREF_V: Limits = Limits::new(0.1, 50.0, "a number from 0.1 to 50");
const MOUNT_M: Limits = Limits::new(-10.0, 10.0, "a number from -10 to 10");
const BEARING_RAD: Limits = Limits::new(-TAU, TAU, "a number from -360 to 360");
const MIN_M: Limits = Limits::new(1e-3, 100.0, "a number from 0.001 to 100");
const SCALE_M: Limits = Limits::new(1e-3, 100.0, "a number from 0.001 to 100");
const NOISE_V: Limits = Limits::new(1e-5, 10.0, "a number from 1e-5 to 10");
const NOISE_M: Limits = Limits::new(0.0, 10.0, "a number from 0 to 10");
const NOISE_REL: Limits = Limits::new(0.0, 1.0, "a number from 0 to 1");

/// A relative 1-sigma: an error of a half is no calibration error any more.
fn relative(value: f32, key: &'static str) -> Check {
    ((0.0..0.5).contains(&value), key, "a number of at least 0 and less than 0.5")
}

impl<const S: usize> Rig<S> {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value that cannot be, with the key it has in a rig file.
    pub fn validate(&self) -> Result<(), RigError> {
        first_failure(None, &self.drive.checks())?;
        if let Some(adc) = &self.adc {
            let checks = [
                ((1..=16).contains(&adc.bits), "bits", "a whole number from 1 to 16"),
                VREF_V.check(adc.vref_v, "vref_v"),
            ];
            first_failure(None, &checks)?;
        }
        for (i, sensor) in self.sensors.iter().enumerate() {
            let analogue_without_adc = matches!(sensor.model, RangeModel::Sharp { .. }) && self.adc.is_none();
            first_failure(Some(i as u8), &[(!analogue_without_adc, "adc", "a section, for analogue sensors")])?;
            first_failure(Some(i as u8), &sensor.checks())?;
        }
        Ok(())
    }
}

fn first_failure(sensor: Option<u8>, checks: &[Check]) -> Result<(), RigError> {
    match checks.iter().find(|(passed, ..)| !passed) {
        Some(&(_, key, allowed)) => Err(RigError { sensor, key, allowed }),
        None => Ok(()),
    }
}

impl DriveModel {
    fn checks(&self) -> [Check; 5] {
        match *self {
            Self::Wheels { track_m, track_sigma, metres_per_tick, scale_sigma, noise_m2_per_m } => [
                TRACK_M.check(track_m, "track_m"),
                relative(track_sigma, "track_sigma"),
                TICK_M.check(metres_per_tick, "metres_per_tick"),
                relative(scale_sigma, "scale_sigma"),
                NOISE_PER_M.check(noise_m2_per_m, "noise_m2_per_m"),
            ],
            Self::Odometry { scale_sigma, noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, veer_sigma } => [
                relative(scale_sigma, "scale_sigma"),
                NOISE_PER_M.check(noise_m2_per_m, "noise_m2_per_m"),
                NOISE_PER_M.check(noise_rad2_per_m, "noise_rad2_per_m"),
                NOISE_PER_M.check(noise_rad2_per_rad, "noise_rad2_per_rad"),
                VEER_PER_M.check(veer_sigma, "drift_sigma_deg_per_m"),
            ],
        }
    }
}

impl RangeSensor {
    /// Length of its beam on which it sees something, metres.
    pub fn span_m(&self) -> f32 {
        self.max_m - self.min_m
    }

    fn checks(&self) -> [Check; 8] {
        let model = match self.model {
            RangeModel::Sharp { scale_m, exponent, noise_v } => [
                SCALE_M.check(scale_m, "scale_m"),
                ((-4.0..=-0.25).contains(&exponent), "exponent", "a number from -4 to -0.25"),
                NOISE_V.check(noise_v, "noise_v"),
            ],
            RangeModel::Metric { noise_m, noise_rel } => [
                NOISE_M.check(noise_m, "noise_m"),
                NOISE_REL.check(noise_rel, "noise_rel"),
                (noise_m + noise_rel > 0.0, "noise_m", "greater than 0 where noise_rel is 0"),
            ],
        };
        let right_angle = core::f32::consts::FRAC_PI_2;
        let incidence = self.max_incidence_rad > 0.0 && self.max_incidence_rad < right_angle;
        let max_m = self.max_m > self.min_m && self.max_m <= MIN_M.to;
        [
            MOUNT_M.check(self.mount.x_m, "x_m"),
            MOUNT_M.check(self.mount.y_m, "y_m"),
            BEARING_RAD.check(self.mount.bearing_rad, "bearing_deg"),
            MIN_M.check(self.min_m, "min_m"),
            (max_m, "max_m", "a number greater than min_m, at most 100"),
            (incidence, "max_incidence_deg", "a number between 0 and 90"),
            relative(self.gain_sigma, "gain_sigma"),
            model.into_iter().find(|(passed, ..)| !passed).unwrap_or((true, "", "")),
        ]
    }
}
