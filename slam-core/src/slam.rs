//! The whole pipeline.

use crate::{Config, Counters, Outcome, Pose, Rig, RigError, Sample, StepReport, report::ReadingReport};

/// A calibration state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Parameter {
    /// Scale of the left wheel.
    ScaleLeft,
    /// Scale of the right wheel.
    ScaleRight,
    /// Factor of the track.
    Track,
    /// Scale of travelled distance.
    ScaleDistance,
    /// Scale of turned angle.
    ScaleTurn,
    /// Gain of the range sensor with this index.
    Gain(u8),
}

/// How a wall is represented in the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WallKind {
    /// rho and theta are states.
    Free,
    /// rho and theta are states; the direction used is the grid's nearest to theta.
    Snapped,
    /// rho is a state; the direction is alpha plus a whole number of quarter turns.
    Grid,
}

/// A wall of the map: the points p with p . (cos beta, sin beta) = rho, from lo to hi along (-sin beta, cos beta).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WallView {
    /// Identifier, never used again after the wall is gone.
    pub id: u16,
    /// Representation.
    pub kind: WallKind,
    /// Signed distance of the line from the origin along its normal, metres.
    pub rho_m: f32,
    /// Direction of the normal, radians.
    pub beta_rad: f32,
    /// Start of the observed extent, metres.
    pub lo_m: f32,
    /// End of the observed extent, metres.
    pub hi_m: f32,
    /// 1-sigma of rho, metres.
    pub sigma_rho_m: f32,
    /// Readings that updated it.
    pub updates: u32,
}

/// The estimator: at most `S` range sensors, `W` walls and `B` buffered outliers.
pub struct Slam<const S: usize, const W: usize, const B: usize> {
    rig: Rig<S>,
    config: Config,
    counters: Counters,
}

/// The estimator as it runs on the robot: 8 range sensors, 64 walls, 128 buffered outliers.
pub type RobotSlam = Slam<8, 64, 128>;

/// The estimator as the workbench runs it: room for other rigs and for 64 free walls.
pub type HostSlam = Slam<16, 64, 128>;

impl<const S: usize, const W: usize, const B: usize> Slam<S, W, B> {
    /// An estimator at the map frame's origin with an empty map.
    ///
    /// # Errors
    /// A value of the rig that cannot be.
    pub fn new(rig: Rig<S>, config: Config) -> Result<Self, RigError> {
        Ok(Self { rig, config, counters: Counters::default() })
    }

    /// Predict, observe, extend the map (report section 3). Never fails: what cannot be used is refused and counted.
    pub fn step(&mut self, sample: &Sample<S>) -> StepReport<S> {
        let _ = (sample, Outcome::Missing, &self.config);
        self.counters.steps += 1;
        StepReport { readings: [ReadingReport::default(); S], births: 0, merges: 0, prunes: 0 }
    }

    /// The rig.
    pub fn rig(&self) -> &Rig<S> {
        &self.rig
    }

    /// The estimated pose in the map frame.
    pub fn pose(&self) -> Pose {
        Pose::default()
    }

    /// Covariance of (x, y, theta): m^2, m rad, rad^2.
    pub fn pose_covariance(&self) -> [[f32; 3]; 3] {
        [[0.0; 3]; 3]
    }

    /// The pose by the motion input alone, with the rig's nominal calibration.
    pub fn dead_reckoning(&self) -> Pose {
        Pose::default()
    }

    /// Direction of the wall grid and its 1-sigma, radians; none before the first grid wall.
    pub fn alpha(&self) -> Option<(f32, f32)> {
        None
    }

    /// The walls of the map.
    pub fn walls(&self) -> impl Iterator<Item = WallView> + '_ {
        core::iter::empty()
    }

    /// Every calibration state with its estimate (a factor, 1 where exact) and 1-sigma.
    pub fn calibration(&self) -> impl Iterator<Item = (Parameter, f32, f32)> + '_ {
        core::iter::empty()
    }

    /// Counts of everything used and refused.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Length of the state vector at present.
    pub fn state_len(&self) -> usize {
        0
    }
}
