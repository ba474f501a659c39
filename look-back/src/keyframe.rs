//! A pose that is placed, and the odometry from it to the next.

use slam_core::{Calibration, JOLT, Mishap, Pose};

use crate::frame::relative;

/// A new keyframe after so much path, metres.
pub(crate) const SPACING_M: f32 = 0.25;

/// Or so much turning, radians.
const SPACING_RAD: f32 = 0.2;

/// Unit of [`Keyframe::swing`], metres.
const SWING_M: f32 = 1e-4;

/// Of motions that the odometry did not sense: the robot was held while its wheels turned, or found itself in a kept map; or it was kicked.
const UNKNOWN: u16 = u16::MAX;
const KICKED: u16 = u16::MAX - 1;

/// Of no motion: from where a kept map's frame is to where the map as a whole is in it.
const HOLDS_MAP: u16 = u16::MAX - 2;

/// Variance of where such a motion ends, m^2, and of its turn, rad^2, about what the filter found. A kick is known to the size of what is
/// looked for, as it may have been another one or none; a hold to decimetres, by how far the wheels turned meanwhile. Left open altogether,
/// all that comes later could slide along the walls of before, until what stands beside a wall is taken for the wall.
const KICKED_VARIANCES: [f32; 2] = [JOLT[0] * JOLT[0], JOLT[2] * JOLT[2]];
const UNKNOWN_VARIANCES: [f32; 2] = [0.25, 0.25];

/// A pose that is placed, and the odometry from it to the next.
#[derive(Clone, Copy, Debug)]
pub struct Keyframe {
    /// Which one of the drive's it is.
    pub serial: u32,
    /// In the map.
    pub pose: Pose,
    /// The next one in its frame, as the odometry sensed it, whole turns included; of the last one, the robot.
    pub motion: Pose,
    /// Length of that path, metres.
    pub path_m: f32,
    /// All turning on it, radians, either way.
    pub turning_rad: f32,
    /// Groups seen from it; they follow each other in the diary.
    pub groups: u16,
    /// 1-sigma of where the motion ends by the errors of headings on the way, tenths of a millimetre. Two bytes, for which there
    /// was room; saturates below those that say that the odometry did not sense the motion.
    pub swing: u16,
}

impl Keyframe {
    /// Where a drive begins, or goes on.
    pub fn at(serial: u32, pose: Pose) -> Self {
        Self { serial, pose, motion: Pose::ORIGIN, path_m: 0.0, turning_rad: 0.0, groups: 0, swing: 0 }
    }

    /// Whether the robot is past so much of the way to the next one.
    pub fn is_past(&self, share: f32) -> bool {
        self.path_m >= share * SPACING_M || self.turning_rad >= share * SPACING_RAD
    }

    /// The map as a whole is seen from the next one.
    pub fn hold_map(&mut self) {
        self.swing = HOLDS_MAP;
    }

    /// Whether the map as a whole is seen from the next one.
    pub fn holds_map(&self) -> bool {
        self.swing == HOLDS_MAP
    }

    /// Variance of where the motion ends by the errors of headings on the way, m^2.
    pub fn swing_m2(&self) -> f32 {
        if let Some([position_m2, _]) = self.unsensed() {
            return position_m2;
        }
        let swing_m = SWING_M * f32::from(self.swing);
        swing_m * swing_m
    }

    /// Variance of the motion's turn beyond the odometry's noise, rad^2.
    pub fn unknown_rad2(&self) -> f32 {
        self.unsensed().map_or(0.0, |[_, heading_rad2]| heading_rad2)
    }

    /// Variances of a motion that the odometry did not sense.
    fn unsensed(&self) -> Option<[f32; 2]> {
        match self.swing {
            UNKNOWN => Some(UNKNOWN_VARIANCES),
            KICKED => Some(KICKED_VARIANCES),
            _ => None,
        }
    }

    /// The odometry did not sense how the robot came from here to where it is next.
    pub fn part_from(&mut self, next: &Pose, calibration: &Calibration, by: Option<Mishap>) {
        if self.holds_map() {
            return;
        }
        let Calibration { distance, turn, veer_rad_per_m } = *calibration;
        let Pose { x_m, y_m, theta_rad } = relative(&self.pose, next);
        self.motion = Pose::new(x_m / distance, y_m / distance, theta_rad / turn - veer_rad_per_m * self.path_m);
        self.swing = if by == Some(Mishap::Jolt) { KICKED } else { UNKNOWN };
    }

    /// The way over the next one to that one's next, the two as they lie to each other by the calibration. An error of the heading
    /// on the first swings all of the second, with this variance of the first one's heading; by half of it the first one's end
    /// is off already, as errors are even along the way, which adds where the second goes on in the same direction.
    pub fn over(&self, next: &Self, calibration: &Calibration, heading_rad2: f32) -> Self {
        let Calibration { turn, veer_rad_per_m, .. } = *calibration;
        let turned_rad = turn * (self.motion.theta_rad + veer_rad_per_m * self.path_m);
        let end = Pose::new(self.motion.x_m, self.motion.y_m, turned_rad);
        let Pose { x_m, y_m, .. } = end.compose(&next.motion);
        let arm_m = [x_m - end.x_m, y_m - end.y_m];
        let square_m2 = arm_m[0] * arm_m[0] + arm_m[1] * arm_m[1];
        let onward_m2 = (end.x_m * arm_m[0] + end.y_m * arm_m[1]).max(0.0);
        // Of two that were not sensed the mark of the one that is known less is the greater.
        let unsensed = [self, next].into_iter().filter(|key| key.unsensed().is_some()).map(|key| key.swing).max();
        let swing_m2 = self.swing_m2() + next.swing_m2() + heading_rad2 * (square_m2 + onward_m2);
        Self {
            // Whole turns count: scale and veer are those of all turning.
            motion: Pose { x_m, y_m, theta_rad: self.motion.theta_rad + next.motion.theta_rad },
            path_m: self.path_m + next.path_m,
            turning_rad: self.turning_rad + next.turning_rad,
            swing: unsensed.unwrap_or(((libm::sqrtf(swing_m2) / SWING_M) as u16).min(HOLDS_MAP - 1)),
            ..*self
        }
    }
}
