//! A pose that is placed, and the odometry from it to the next.

use slam_core::{Calibration, Pose};

use crate::frame::relative;

/// A new keyframe after so much path, metres.
pub(crate) const SPACING_M: f32 = 0.25;

/// Or so much turning, radians.
const SPACING_RAD: f32 = 0.2;

/// Unit of [`Keyframe::swing`], metres.
const SWING_M: f32 = 1e-4;

/// Of a motion that the odometry did not sense: the robot was kicked, or held while its wheels turned.
const UNKNOWN: u16 = u16::MAX;

/// Of no motion: from where a kept map's frame is to where the map as a whole is in it.
const HOLDS_MAP: u16 = u16::MAX - 1;

/// Variance of where it ends, m^2, and of its turn, rad^2, about what the filter found: half a metre and half a radian, twice the size of
/// what is looked for (`slam_core::JOLT`). Left open altogether, all that comes later could slide along the walls of before.
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
    /// was room; saturates below the two that say that the odometry did not sense the motion.
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
        if self.swing == UNKNOWN {
            return UNKNOWN_VARIANCES[0];
        }
        let swing_m = SWING_M * f32::from(self.swing);
        swing_m * swing_m
    }

    /// Variance of the motion's turn beyond the odometry's noise, rad^2.
    pub fn unknown_rad2(&self) -> f32 {
        if self.swing == UNKNOWN { UNKNOWN_VARIANCES[1] } else { 0.0 }
    }

    /// The odometry did not sense how the robot came from here to where it is next.
    pub fn part_from(&mut self, next: &Pose, calibration: &Calibration) {
        if self.holds_map() {
            return;
        }
        let Calibration { distance, turn, veer_rad_per_m } = *calibration;
        let Pose { x_m, y_m, theta_rad } = relative(&self.pose, next);
        self.motion = Pose::new(x_m / distance, y_m / distance, theta_rad / turn - veer_rad_per_m * self.path_m);
        self.swing = UNKNOWN;
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
        let is_unknown = self.swing == UNKNOWN || next.swing == UNKNOWN;
        let swing_m2 = self.swing_m2() + next.swing_m2() + heading_rad2 * (square_m2 + onward_m2);
        Self {
            // Whole turns count: scale and veer are those of all turning.
            motion: Pose { x_m, y_m, theta_rad: self.motion.theta_rad + next.motion.theta_rad },
            path_m: self.path_m + next.path_m,
            turning_rad: self.turning_rad + next.turning_rad,
            swing: if is_unknown { UNKNOWN } else { ((libm::sqrtf(swing_m2) / SWING_M) as u16).min(HOLDS_MAP - 1) },
            ..*self
        }
    }
}
