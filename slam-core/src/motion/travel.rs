//! From ticks or dead-reckoned increments to checked travel.

use crate::rig::DriveModel;
use crate::sample::{Increment, Motion, Ticks};

/// Largest speed that is believed, metres per second: a faster motion is a broken counter.
const MAX_SPEED_M_S: f32 = 10.0;

/// Longest time over which that limit is taken, seconds: ten metres between two samples are no drive any more.
const MAX_STEP_S: f32 = 1.0;

/// Largest turn between two samples, radians, and in a second, where that is more: who turns farther has a wheel's counter broken, or was
/// logged with a pose that cannot tell which way round it was.
const MAX_TURN_RAD: f32 = core::f32::consts::PI;
const MAX_TURN_RAD_S: f32 = 2.0 * MAX_TURN_RAD;

/// Travel of the two wheels, or a body-frame increment, before calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Travel {
    /// Metres of each wheel.
    Wheels {
        /// Left wheel.
        left_m: f32,
        /// Right wheel.
        right_m: f32,
    },
    /// Motion in the robot's frame.
    Body(Increment),
}

impl Travel {
    /// How far forwards, metres.
    pub fn forward_m(&self) -> f32 {
        match self {
            Self::Wheels { left_m, right_m } => 0.5 * (left_m + right_m),
            Self::Body(i) => i.forward_m,
        }
    }

    /// How far round, radians, for wheels so far apart.
    pub fn turn_rad(&self, drive: &DriveModel) -> f32 {
        match (self, drive) {
            (Self::Wheels { left_m, right_m }, DriveModel::Wheels { track_m, .. }) => (right_m - left_m) / track_m,
            (Self::Wheels { .. }, DriveModel::Odometry { .. }) => 0.0,
            (Self::Body(i), _) => i.turn_rad,
        }
    }

    /// As a motion of the robot's middle; wheels do not go aside.
    pub fn of_body(&self, drive: &DriveModel) -> Increment {
        match self {
            Self::Wheels { .. } => {
                Increment { forward_m: self.forward_m(), left_m: 0.0, turn_rad: self.turn_rad(drive) }
            }
            Self::Body(i) => *i,
        }
    }

    /// What this drive tells of such a motion: the inverse of [`Travel::of_body`].
    pub fn from_body(motion: Increment, drive: &DriveModel) -> Self {
        match drive {
            DriveModel::Wheels { track_m, .. } => {
                let aside_m = 0.5 * track_m * motion.turn_rad;
                Self::Wheels { left_m: motion.forward_m - aside_m, right_m: motion.forward_m + aside_m }
            }
            DriveModel::Odometry { .. } => Self::Body(motion),
        }
    }

    /// The same turn, and the way backwards.
    pub fn reversed(&self) -> Self {
        match *self {
            Self::Wheels { left_m, right_m } => Self::Wheels { left_m: -right_m, right_m: -left_m },
            Self::Body(i) => Self::Body(Increment { forward_m: -i.forward_m, left_m: -i.left_m, ..i }),
        }
    }
}

/// Remembers the last ticks and turns inputs into travel.
#[derive(Clone, Debug, Default)]
pub struct Encoders {
    last: Option<Ticks>,
}

impl Motion {
    /// Whether it is of the drive's kind.
    pub(crate) fn fits(&self, drive: &DriveModel) -> bool {
        matches!(
            (drive, self),
            (DriveModel::Wheels { .. }, Self::Ticks(_)) | (DriveModel::Odometry { .. }, Self::Increment(_))
        )
    }
}

impl Encoders {
    /// Nothing read yet.
    pub const NEW: Self = Self { last: None };

    /// Travel since the last sample, nothing for the first one; none where the input is not a motion of this drive.
    pub fn travel(&mut self, drive: &DriveModel, motion: &Motion, dt_s: f32) -> Option<Travel> {
        let limit_m = MAX_SPEED_M_S * dt_s.clamp(0.01, MAX_STEP_S);
        // Wheels count turns beyond half of one, too.
        let limit_rad = MAX_TURN_RAD.max(MAX_TURN_RAD_S * dt_s.min(MAX_STEP_S));
        match (drive, motion) {
            (DriveModel::Wheels { metres_per_tick, track_m, .. }, Motion::Ticks(now)) => {
                let last = self.last.replace(*now).unwrap_or(*now);
                let left_m = now.left.wrapping_sub(last.left) as f32 * metres_per_tick;
                let right_m = now.right.wrapping_sub(last.right) as f32 * metres_per_tick;
                let possible = left_m.abs() <= limit_m
                    && right_m.abs() <= limit_m
                    && (right_m - left_m).abs() <= limit_rad * track_m;
                possible.then_some(Travel::Wheels { left_m, right_m })
            }
            (DriveModel::Odometry { .. }, Motion::Increment(i)) => {
                let possible =
                    i.forward_m.abs() <= limit_m && i.left_m.abs() <= limit_m && i.turn_rad.abs() <= MAX_TURN_RAD;
                possible.then_some(Travel::Body(*i))
            }
            _ => None,
        }
    }
}
