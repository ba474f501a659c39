//! The keys of a rig file.

use input_file::{Allowed, Finite, Limits, NotNegative, Number, Positive, Text, Whole};
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct File {
    pub hand_overs: Option<bool>,
    pub wheels: Option<Wheels>,
    pub odometry: Option<Odometry>,
    pub adc: Option<Converter>,
    #[serde(default)]
    pub range_sensor: Vec<Sensor>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Wheels {
    pub track_m: Number<Positive>,
    pub track_sigma: Option<Number<Ratio>>,
    pub metres_per_tick: Number<Positive>,
    pub scale_sigma: Number<Ratio>,
    pub noise_m2_per_m: Number<NotNegative>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Odometry {
    pub scale_sigma: Number<Ratio>,
    pub noise_m2_per_m: Number<NotNegative>,
    pub noise_rad2_per_m: Number<NotNegative>,
    pub noise_rad2_per_rad: Number<NotNegative>,
    pub drift_sigma_deg_per_m: Option<Number<NotNegative>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Converter {
    pub bits: Whole<1, 16>,
    pub vref_v: Number<Positive>,
}

/// An analogue sensor has a curve and noise in volts, one that reports metres has noise in metres.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Sensor {
    pub name: Text,
    pub x_m: Number<Finite>,
    pub y_m: Number<Finite>,
    pub bearing_deg: Number<Bearing>,
    pub min_m: Number<NotNegative>,
    pub max_m: Number<Positive>,
    pub max_incidence_deg: Option<Number<Incidence>>,
    pub gain_sigma: Number<Ratio>,
    pub scale_m: Option<Number<Positive>>,
    pub exponent: Option<Number<Exponent>>,
    pub noise_v: Option<Number<Positive>>,
    pub noise_m: Option<Number<NotNegative>>,
    pub noise_rel: Option<Number<NotNegative>>,
}

/// A relative 1-sigma error.
#[derive(Debug)]
pub(super) struct Ratio;

impl Limits for Ratio {
    const ALLOWED: Allowed =
        Allowed { below_max: true, ..Allowed::within(0.0, 0.5, "a ratio of at least 0 and less than 0.5") };
}

/// A beam's direction, degrees.
#[derive(Debug)]
pub(super) struct Bearing;

impl Limits for Bearing {
    const ALLOWED: Allowed = Allowed::within(-360.0, 360.0, "an angle from -360 to 360");
}

/// The largest incidence, degrees.
#[derive(Debug)]
pub(super) struct Incidence;

impl Limits for Incidence {
    const ALLOWED: Allowed = Allowed { above_min: true, ..Allowed::within(0.0, 90.0, "an angle above 0 and up to 90") };
}

/// The exponent of an analogue sensor's curve.
#[derive(Debug)]
pub(super) struct Exponent;

impl Limits for Exponent {
    const ALLOWED: Allowed = Allowed { below_max: true, ..Allowed::within(-4.0, 0.0, "a number from -4 to below 0") };
}
