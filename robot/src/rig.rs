//! The robot that this project builds, as its estimator knows it, with either kind of range sensor.

use core::f32::consts::FRAC_1_SQRT_2;
use heapless::Vec;
use slam_core::{Adc, DriveModel, Mount, RangeModel, RangeSensor, Rig};

/// Bearings of the range sensors, degrees counter-clockwise from straight ahead, in their order.
pub const BEARINGS_DEG: [f32; 8] = [0.0, 45.0, 90.0, 135.0, 180.0, -135.0, -90.0, -45.0];

/// A robot that the firmware's tasks are built for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuiltIn {
    /// [`default_rig`].
    #[default]
    Sharp,
    /// [`time_of_flight_rig`].
    TimeOfFlight,
}

impl BuiltIn {
    /// Every one.
    pub const ALL: [Self; 2] = [Self::Sharp, Self::TimeOfFlight];

    /// What it is called on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sharp => "sharp",
            Self::TimeOfFlight => "time-of-flight",
        }
    }

    /// What its estimator knows of it.
    pub fn rig<const S: usize>(self) -> Rig<S> {
        match self {
            Self::Sharp => default_rig(),
            Self::TimeOfFlight => time_of_flight_rig(),
        }
    }
}

/// The wheels of both robots.
const WHEELS: DriveModel = DriveModel::Wheels {
    track_m: 0.235,
    track_sigma: 0.0,
    metres_per_tick: 0.000_445,
    scale_sigma: 0.005,
    noise_m2_per_m: 1e-5,
};

/// Cosine and sine of the eight multiples of 45 degrees, as rounded to f32: a table, since `libm` computes them in f64,
/// which the Cortex-M4F has only in software, 8 KB of it.
const EIGHTH_TURNS: [[f32; 2]; 8] = [
    [1.0, 0.0],
    [FRAC_1_SQRT_2, FRAC_1_SQRT_2],
    [-4.371_139e-8, 1.0],
    [-FRAC_1_SQRT_2, FRAC_1_SQRT_2],
    [-1.0, -8.742_278e-8],
    [-FRAC_1_SQRT_2, -FRAC_1_SQRT_2],
    [-4.371_139e-8, -1.0],
    [FRAC_1_SQRT_2, -FRAC_1_SQRT_2],
];

/// A sensor that looks outward from a ring about the robot's centre, its bearing a multiple of 45 degrees.
fn on_ring(radius_m: f32, bearing_deg: f32) -> Mount {
    let [cos, sin] = EIGHTH_TURNS[(bearing_deg / 45.0) as i32 as usize % 8];
    Mount { x_m: radius_m * cos, y_m: radius_m * sin, bearing_rad: bearing_deg.to_radians() }
}

/// A round cleaning robot (radius 0.17 m) with eight Sharp infrared sensors on a ring of 6 cm on its top deck.
///
/// Eighth turns: beside a wall, three sensors (45, 90 and 135 degrees from the heading) see it at once, far enough apart
/// to give its direction before the robot has moved; whatever the heading, at least two of the eight meet each wall
/// under 45 degrees. The ring is as small as eight sensors of 45 mm allow: of the 0.15 m in which a sensor is blind or
/// folds back, 0.11 m lie over the robot's own body, and only 4 cm in front of the bumper are lost.
///
/// With room for fewer than eight sensors, the rig has the first ones.
pub fn default_rig<const S: usize>() -> Rig<S> {
    let mut sensors = Vec::new();
    for bearing_deg in BEARINGS_DEG.into_iter().take(S) {
        let mount = on_ring(0.06, bearing_deg);
        let sensor = RangeSensor {
            mount,
            min_m: 0.155,
            max_m: 1.5,
            max_incidence_rad: 70_f32.to_radians(),
            gain_sigma: 0.01,
            model: RangeModel::Sharp { scale_m: 0.60374, exponent: -1.16, noise_v: 0.012 },
        };
        // At most S are taken: it always fits.
        let _ = sensors.push(sensor);
    }
    Rig { drive: WHEELS, adc: Some(Adc { bits: 12, vref_v: 3.3 }), sensors }
}

/// Bearings of the range sensors of [`time_of_flight_rig`], degrees counter-clockwise from straight ahead, in their order.
pub const FOUR_BEARINGS_DEG: [f32; 4] = [0.0, 90.0, 180.0, -90.0];

/// The same robot with four sensors that report metres, ahead, to both sides and back, on a ring of 10 cm: modules that
/// measure the light's time of flight, with their noise of a centimetre and a hundredth of the range, up to 2 m.
///
/// With room for fewer than four sensors, the rig has the first ones.
pub fn time_of_flight_rig<const S: usize>() -> Rig<S> {
    let mut sensors = Vec::new();
    for bearing_deg in FOUR_BEARINGS_DEG.into_iter().take(S) {
        let mount = on_ring(0.1, bearing_deg);
        let sensor = RangeSensor {
            mount,
            min_m: 0.04,
            max_m: 2.0,
            max_incidence_rad: 60_f32.to_radians(),
            gain_sigma: 0.01,
            model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.01 },
        };
        // At most S are taken: it always fits.
        let _ = sensors.push(sensor);
    }
    Rig { drive: WHEELS, adc: None, sensors }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensors_look_outward_from_their_ring() {
        let rigs = [(0.06, default_rig::<8>()), (0.1, time_of_flight_rig::<8>())];
        for (radius_m, rig) in rigs {
            for mount in rig.sensors.iter().map(|sensor| sensor.mount) {
                let expected =
                    [libm::cosf(mount.bearing_rad), libm::sinf(mount.bearing_rad)].map(|part| radius_m * part);
                assert_eq!([mount.x_m, mount.y_m], expected, "{} rad", mount.bearing_rad);
            }
        }
    }
}
