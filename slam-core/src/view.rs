//! What the estimator shows of itself.

use crate::config::Config;
use crate::filter::layout::{self, ALPHA};
use crate::geometry::angle::sin_cos;
use crate::geometry::pose::Pose;
use crate::health::Elsewhere;
use crate::motion::Slip;
use crate::report::{Counters, Health, StepReport};
use crate::rig::{DriveModel, Rig};
use crate::sensing::latency::Timing;
use crate::slam::Slam;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::Displaced;
use crate::walls::wall::{Direction, WallKind, WallPolicy};
use nalgebra::Matrix3;

/// How a wall stands to the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Standing {
    /// Not told.
    #[default]
    Unknown,
    /// In a direction of its own.
    Off,
    /// Along its direction that is so many quarter turns from alpha, give or take what such walls may stand off it.
    Near(u8),
    /// On that direction exactly.
    Exact(u8),
}

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
    /// Turn that the odometry misses, radians per metre driven forward.
    Veer,
    /// Gain of the range sensor with this index.
    Gain(u8),
}

/// Where the robot is, in the map frame.
///
/// Where walls hold that frame (`MapFrame::Walls`), how the start pose lies in it ([`Slam::start_pose`]) is a choice and
/// has no error of its own: what differs from the truth is the truth, moved by the start pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Position and heading.
    pub pose: Pose,
    /// Covariance of (x, y, theta): m^2, m rad, rad^2.
    pub covariance: Matrix3<f32>,
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
    /// Direction of the normal, radians. It points away from the side that the wall was seen from.
    pub beta_rad: f32,
    /// Start of the observed extent, metres.
    pub lo_m: f32,
    /// End of the observed extent, metres.
    pub hi_m: f32,
    /// 1-sigma of rho, metres, about the origin of the filter's frame: where walls hold the map's, without how the one lies to the other.
    pub sigma_rho_m: f32,
    /// Readings that updated it.
    pub updates: u32,
}

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// The rig.
    pub fn rig(&self) -> &Rig<S> {
        &self.rig
    }

    /// Identifier of the wall with this number, and how it stands to the grid, where the filter decides that wall by wall
    /// ([`WallPolicy::Grid`]). None past the last.
    pub fn standing(&self, number: usize) -> Option<(u16, Standing)> {
        let wall = self.map.walls().get(number).filter(|_| self.config.walls.policy == WallPolicy::Grid)?;
        let standing = match wall.direction {
            Direction::Grid(quarter) => Standing::Exact(quarter),
            Direction::NearGrid(_, quarter) | Direction::Built(_, quarter) => Standing::Near(quarter),
            Direction::Free(_) | Direction::Snapped(_) => Standing::Off,
        };
        Some((wall.id, standing))
    }

    /// The settings.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The estimated pose in the map frame.
    pub fn pose(&self) -> Pose {
        self.map.pose_in_map(&layout::pose(&self.ekf))
    }

    /// Where the robot started, in the map frame: its origin, until walls hold that.
    pub fn start_pose(&self) -> Pose {
        self.map.start
    }

    /// The estimated pose and its covariance, both in the map frame.
    pub fn estimate(&self) -> Estimate {
        let covariance = layout::pose_covariance(&self.ekf);
        let from_start = self.map.anchor.map_or(covariance, |anchor| {
            let known = anchor.whole_covariance(&self.ekf, &self.drive.states);
            anchor.covariance_beyond(&known, &layout::pose(&self.ekf), &covariance)
        });
        Estimate { pose: self.pose(), covariance: Matrix3::from(self.map.covariance_in_map(from_start)) }
    }

    /// Changes whenever the map as a whole is another one: poses and walls of another epoch lie elsewhere, and identifiers of
    /// walls that were found to be one are gone. So it does when the map is begun anew, with
    /// the estimator or where this was unwell, and when the filter's frame is another one.
    pub fn epoch(&self) -> u32 {
        self.map.epoch()
    }

    /// How the robot came to be elsewhere, where the map is that of the epoch before this one and it was found elsewhere in it.
    pub fn displaced(&self) -> Option<Displaced> {
        self.map.displaced()
    }

    /// The estimated pose in the filter's frame, which the map frame and the anchor do not move.
    pub fn filter_pose(&self) -> Pose {
        layout::pose(&self.ekf)
    }

    /// The direction of the grid in the filter's frame, radians; none before there is one.
    pub fn filter_alpha(&self) -> Option<f32> {
        self.map.has_grid.then(|| self.ekf.mean(ALPHA))
    }

    /// The odometry of the last step: what it sensed, with the rig's nominal calibration, before it is calibrated. Where earlier ones
    /// turn out to have been driven the other way, by what they were, too.
    pub fn last_motion(&self) -> Pose {
        self.drive.last_motion
    }

    /// How far off the robot is, 1-sigma, metres and radians, where the motion of the last step was lost.
    pub fn lost_motion(&self) -> Option<[f32; 2]> {
        self.drive.step.lost_by()
    }

    /// Factor of the variance of the position in motion, as it was learned: of what the rig states and slips add to it.
    pub fn position_level(&self) -> f32 {
        self.levels.position.factor()
    }

    /// Factor of the variance of how far counted wheels went, as it was learned; one where it is not.
    pub fn wheel_level(&self) -> f32 {
        if self.config.motion.slip == Slip::Learned { self.slippage.factor() } else { 1.0 }
    }

    /// Factor of the variance of analogue outputs, as it was learned: of what the rig states.
    pub fn output_level(&self) -> f32 {
        self.output_noise.factor()
    }

    /// Whether something holds the robot, so that its wheels turn and it stays where it is.
    pub fn is_held(&self) -> bool {
        self.holds.is_held()
    }

    /// The pose by the motion input alone, with the rig's nominal calibration.
    pub fn dead_reckoning(&self) -> Pose {
        self.drive.nominal
    }

    /// Direction of the wall grid and its 1-sigma, radians; none before the first grid wall.
    pub fn alpha(&self) -> Option<(f32, f32)> {
        self.map.has_grid.then(|| {
            (self.ekf.mean(ALPHA) + self.map.origin().map_or(0.0, |origin| origin.theta_rad), self.sigma(ALPHA))
        })
    }

    fn sigma(&self, i: usize) -> f32 {
        float::sqrtf(self.ekf.covariance(i, i).max(0.0))
    }

    /// The walls of the map.
    pub fn walls(&self) -> impl Iterator<Item = WallView> + '_ {
        let grid = ManhattanFrame::of(&self.ekf);
        self.map.walls().iter().map(move |wall| {
            let (line, origin_m) = self.map.in_map(&wall.line(&self.ekf, &grid));
            WallView {
                id: wall.id,
                kind: wall.kind(),
                rho_m: line.rho_m,
                beta_rad: line.beta_rad,
                lo_m: wall.lo_m + origin_m,
                hi_m: wall.hi_m + origin_m,
                sigma_rho_m: self.sigma(wall.rho()),
                updates: wall.updates,
            }
        })
    }

    /// Every calibration state with its estimate (a factor, 1 where exact, or the veer) and 1-sigma.
    pub fn calibration(&self) -> impl Iterator<Item = (Parameter, f32, f32)> + '_ {
        let drive = match self.rig.drive {
            DriveModel::Wheels { .. } => [Parameter::ScaleLeft, Parameter::ScaleRight, Parameter::Track],
            DriveModel::Odometry { .. } => [Parameter::ScaleDistance, Parameter::ScaleTurn, Parameter::Veer],
        };
        let drive = drive.into_iter().zip(self.drive.states.in_order());
        let gains = self.sensors.iter().enumerate().map(|(i, sensor)| (Parameter::Gain(i as u8), sensor.gain_state()));
        drive.chain(gains).filter_map(|(parameter, state)| state.map(|i| (parameter, self.ekf.mean(i), self.sigma(i))))
    }

    /// Gain of the range sensor with this index as it is estimated: reported = gain x true range.
    pub fn gain(&self, sensor: usize) -> f32 {
        self.sensors.get(sensor).map_or(1.0, |sensor| sensor.gain(&self.ekf))
    }

    /// Whether the range sensor with this index is frozen: its output stays the same, whatever the robot does. Its readings are
    /// refused until it changes again.
    pub fn is_frozen(&self, sensor: usize) -> bool {
        self.frozen.is_frozen(sensor)
    }

    /// The range sensors that are frozen, a bit each, in the rig's order.
    pub fn frozen_sensors(&self) -> u16 {
        self.frozen.sensors()
    }

    /// How old the readings of the [late sensors](Self::late_sensors) are, and its 1-sigma, seconds; none where it is not estimated.
    pub fn latency(&self) -> Option<(f32, f32)> {
        self.latency.state.map(|i| (self.ekf.mean(i), self.sigma(i)))
    }

    /// The range sensors whose readings' age is [`Slam::latency`], a bit each, in the rig's order: those that report metres, or the
    /// analogue ones where there are none.
    pub fn late_sensors(&self) -> u16 {
        let late = self.rig.sensors.iter().enumerate().filter(|(_, sensor)| self.latency.of(&sensor.model).is_some());
        late.fold(0, |bits, (i, _)| bits | 1 << i)
    }

    /// What speaks for the robot being elsewhere than its pose says.
    pub fn elsewhere(&self) -> Elsewhere {
        self.monitor.elsewhere()
    }

    /// How the estimator is.
    pub fn health(&self) -> Health {
        self.monitor.health()
    }

    /// 1-sigma of how far the moment of a row's readings is from that of its motion, beside the latency, seconds; none where
    /// it is not estimated.
    pub fn stamp_sigma(&self) -> Option<f32> {
        self.latency.stamps.sigma_s()
    }

    /// Counts of everything used and refused.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Estimate of state `i`, in the filter's frame.
    pub fn state_mean(&self, i: usize) -> f32 {
        self.ekf.mean(i)
    }

    /// Covariance of the states `i` and `j`, in the filter's frame.
    pub fn state_covariance(&self, i: usize, j: usize) -> f32 {
        self.ekf.covariance(i, j)
    }

    /// Length of the state vector at present.
    pub fn state_len(&self) -> usize {
        self.ekf.len()
    }

    /// Where the beams ended, with the pose after the step.
    pub(crate) fn place_hits(&self, dt_s: f32, report: &mut StepReport<S>) {
        let pose = layout::pose(&self.ekf);
        let heading = sin_cos(pose.theta_rad);
        let timing = Timing { dt_s, step: &self.drive.step, latency: &self.latency };
        for ((limits, state), reading) in self.rig.sensors.iter().zip(&self.sensors).zip(&mut report.readings) {
            let beam = state.mount_then(&limits.model, &timing, &self.ekf).beam([pose.x_m, pose.y_m], heading);
            reading.hit_m = reading.range_m.map(|range_m| self.map.point_in_map(beam.at(range_m)));
        }
    }
}
