//! What the robot is made of: its motion input and its range sensors, with their errors.

use heapless::Vec;

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
    },
}

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

/// A value of a [`Rig`] that cannot be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RigError {
    /// Index into [`Rig::sensors`] where a sensor is at fault.
    pub sensor: Option<u8>,
    /// The key, as it is called in a rig file.
    pub key: &'static str,
    /// What is allowed.
    pub allowed: &'static str,
}
