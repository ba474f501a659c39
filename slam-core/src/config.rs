//! How the estimator works: one type whose defaults work.

use crate::rig::{RangeModel, Rig};

/// Which kinds of wall the map may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WallPolicy {
    /// Every wall is a free line (rho, theta): the report's section 3.1.
    Free,
    /// Every wall is a line (rho, theta) whose direction is snapped to the grid (report 3.2, eqs. 2-4).
    Snapped {
        /// Also move theta_i with the innovation, dh/dtheta_i = dh/dalpha, as eq. 5 can be read; otherwise
        /// dh/dtheta_i = 0, which is what beta(alpha) in eq. 3 gives.
        theta_moves: bool,
    },
    /// Walls on the grid have rho alone; lines that the data put off the grid are free.
    #[default]
    Grid,
    /// The same, but a wall on the grid may stand off its direction by half a degree, as built walls do: (rho, theta).
    NearGrid,
}

/// How outliers are grouped into candidate walls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Clustering {
    /// Readings of one sensor that follow each other.
    #[default]
    BySensor,
    /// Density-based over all sensors (Ester et al. 1996).
    Dbscan,
}

/// At which estimates the models are differentiated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Linearisation {
    /// The latest ones: the plain extended Kalman filter, as in the report.
    Latest,
    /// The pose as each step predicted it and the grid's direction as it was founded (Huang, Mourikis and Roumeliotis
    /// 2010).
    #[default]
    FirstEstimates,
}

/// What holds the map frame once the robot has left its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MapFrame {
    /// The start pose. What is learned of the first turns moves the map.
    #[default]
    Start,
    /// The walls. What is learned of the first turns moves the start pose.
    Walls,
}

/// Settings of the estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Wall kinds.
    pub walls: WallPolicy,
    /// Outlier clustering.
    pub clustering: Clustering,
    /// Estimate sensor gains whose prior sigma is not zero.
    pub calibrate_gains: bool,
    /// Estimate wheel scales or odometry scales whose prior sigma is not zero.
    pub calibrate_scales: bool,
    /// Estimate the track where its prior sigma is not zero.
    pub calibrate_track: bool,
    /// Association gate: largest squared innovation over its variance (chi-square with one degree of freedom).
    pub gate: f32,
    /// At which estimates the models are differentiated.
    pub linearisation: Linearisation,
    /// Readings of one stretch of wall repeat its surface's error, where the sensor reports metres.
    pub repeats: bool,
    /// How far the surfaces of walls are from planes, 1-sigma, metres, beyond the roughness of plaster.
    pub relief_m: f32,
    /// What holds the map frame.
    pub frame: MapFrame,
    /// A reading near a wall may be of something else: it counts by the odds that it is the wall's.
    pub clutter: bool,
    /// Estimate how late the readings of sensors that report metres are.
    pub calibrate_latency: bool,
    /// Dead reckoning that comes as a pose slips in runs and in turns, beyond the noise that the rig states.
    pub slip: bool,
    /// The scales of dead reckoning that comes as a pose multiply its mean over a second, which has less noise.
    pub mean_travel: bool,
    /// Learn from the innovations how large the noise is, where sensors report metres.
    pub learn_noise: bool,
}

/// The relief of built walls, metres: door frames, skirting boards, panels. In the Freiburg offices a laser's readings lie
/// 2.2 cm from the line of their wall (docs/notes/real-logs.md), whatever the incidence; a good centimetre is the laser's own.
pub const BUILT_RELIEF_M: f32 = 0.015;

impl Config {
    /// For rooms as they are built, where there is room for two states a wall.
    pub fn real_rooms() -> Self {
        Self {
            walls: WallPolicy::NearGrid,
            relief_m: BUILT_RELIEF_M,
            frame: MapFrame::Walls,
            clutter: true,
            calibrate_latency: true,
            slip: true,
            mean_travel: true,
            learn_noise: true,
            ..Self::default()
        }
    }

    /// What suits the sensors: those that report metres see how walls stand off the grid, which the noise of an analogue
    /// one hides.
    pub fn for_rig<const S: usize>(rig: &Rig<S>) -> Self {
        let sees_it = rig.sensors.iter().any(|sensor| matches!(sensor.model, RangeModel::Metric { .. }));
        if sees_it { Self::real_rooms() } else { Self::default() }
    }
}

impl Default for Config {
    fn default() -> Self {
        Self {
            walls: WallPolicy::default(),
            clustering: Clustering::default(),
            calibrate_gains: true,
            calibrate_scales: true,
            calibrate_track: true,
            // 99.9 % of a chi-square distribution with one degree of freedom.
            gate: 10.83,
            linearisation: Linearisation::default(),
            repeats: true,
            relief_m: 0.0,
            frame: MapFrame::default(),
            clutter: false,
            calibrate_latency: false,
            slip: false,
            mean_travel: false,
            learn_noise: false,
        }
    }
}
