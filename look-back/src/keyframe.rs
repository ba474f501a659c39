//! A pose that is placed, and the odometry from it to the next.

use slam_core::{Calibration, Pose};

use crate::frame::relative;

/// A new keyframe after so much path, metres.
pub(crate) const SPACING_M: f32 = 0.25;

/// Or so much turning, radians.
const SPACING_RAD: f32 = 0.2;

/// Unit of [`Keyframe::swing`], metres.
const SWING_M: f32 = 1e-4;

/// Unit of a keyframe's age of readings, seconds.
const AGE_S: f32 = 2e-5;

/// No reading is older than a keyframe can hold, seconds.
pub(crate) const OLDEST_S: f32 = AGE_S * i16::MAX as f32;

/// Marks a motion that the odometry did not sense, for the robot was kicked, or held while its wheels turned: what follows is how well it is
/// known, 1-sigma, seven bits of [`UNSENSED_M`] and seven of [`UNSENSED_RAD`], with a bit between them for a jolt.
const UNSENSED: u16 = 0x8000;
const JOLTED: u16 = 0x80;
const UNSENSED_M: f32 = 0.01;
const UNSENSED_RAD: f32 = 0.02;

/// Marks no motion: from where a kept map's frame is to where the map as a whole is in it; and from there on to where parts of it are, with
/// how well that is known, as before.
const HOLDS_MAP: u16 = UNSENSED | JOLTED | 0x7f;
const WHOLE: u16 = 0x7f00;

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
    /// was room; or, marked, how well a motion is known that the odometry did not sense.
    pub swing: u16,
    /// Time that the motion took, milliseconds; saturates, and is then not known.
    pub time_ms: u16,
    /// How old the readings were taken for whose hits are seen from it, in [`AGE_S`].
    pub age: i16,
}

impl Keyframe {
    /// Where a drive begins, or goes on.
    pub fn at(serial: u32, pose: Pose) -> Self {
        Self {
            serial,
            pose,
            motion: Pose::ORIGIN,
            path_m: 0.0,
            turning_rad: 0.0,
            groups: 0,
            swing: 0,
            time_ms: 0,
            age: 0,
        }
    }

    /// Whether the robot is past so much of the way to the next one.
    pub fn is_past(&self, share: f32) -> bool {
        self.path_m >= share * SPACING_M || self.turning_rad >= share * SPACING_RAD
    }

    /// So much time passed on the way to the next one.
    pub fn pass(&mut self, time_s: f32) {
        // Casts to integers saturate.
        self.time_ms = self.time_ms.saturating_add((1e3 * time_s + 0.5) as u16);
    }

    /// The motion to the next one, where the odometry sensed it, and the time that it took, seconds.
    pub fn sensed(&self) -> Option<(Pose, f32)> {
        let is_sensed = self.swing & UNSENSED == 0 || self.is_jolted();
        (is_sensed && self.time_ms < u16::MAX).then(|| (self.motion, 1e-3 * f32::from(self.time_ms)))
    }

    /// How old the readings were taken for whose hits are seen from it, seconds.
    pub fn age_s(&self) -> f32 {
        AGE_S * f32::from(self.age)
    }

    /// Its hits are where readings of that age have them.
    pub fn set_age(&mut self, age_s: f32) {
        self.age = libm::roundf(age_s / AGE_S) as i16;
    }

    /// The map as a whole is seen from the next one.
    pub fn hold_map(&mut self) {
        self.swing = HOLDS_MAP | WHOLE;
    }

    /// A part of the map is seen from the next one: where it is is known this well beside what is seen from here, 1-sigma, metres.
    pub fn hold_part(&mut self, sigma_m: f32) {
        // Rounded up: no part is where it is for certain.
        self.swing = HOLDS_MAP | unsensed([sigma_m + 0.5 * UNSENSED_M, 0.0]);
    }

    /// Whether the map is seen from the next one: the whole, or a part of it.
    pub fn holds_map(&self) -> bool {
        self.swing & HOLDS_MAP == HOLDS_MAP
    }

    /// Whether that is the map as a whole.
    pub fn holds_whole(&self) -> bool {
        self.swing == HOLDS_MAP | WHOLE
    }

    /// Variance of where the motion ends by the errors of headings on the way, m^2.
    pub fn swing_m2(&self) -> f32 {
        if self.holds_map() {
            let sigma_m = UNSENSED_M * f32::from((self.swing & WHOLE) >> 8);
            return sigma_m * sigma_m;
        }
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
        let [of_m, of_rad] = [(self.swing >> 8) & 0x7f, self.swing & 0x7f].map(f32::from);
        let sigmas = [UNSENSED_M * of_m, UNSENSED_RAD * of_rad];
        (self.swing & UNSENSED != 0 && !self.holds_map()).then_some(sigmas.map(|sigma| sigma * sigma))
    }

    /// The odometry did not sense how the robot came from here to where it is next, which is known to a 1-sigma, metres and radians.
    pub fn part_from(&mut self, next: &Pose, calibration: &Calibration, known: [f32; 2]) {
        if self.holds_map() {
            return;
        }
        let Calibration { distance, turn, veer_rad_per_m } = *calibration;
        let Pose { x_m, y_m, theta_rad } = relative(&self.pose, next);
        self.motion = Pose::new(x_m / distance, y_m / distance, theta_rad / turn - veer_rad_per_m * self.path_m);
        self.swing = unsensed(known);
    }

    /// A jolt may have moved the robot on the way to the next one beside what the odometry sensed, by so much, 1-sigma, metres and radians.
    pub fn jolt(&mut self, by: [f32; 2]) {
        if !self.holds_map() {
            self.swing = unsensed(by) | JOLTED;
        }
    }

    /// The odometry's motion on the way was lost: the robot is off by so much, 1-sigma, metres and radians, beside what else is not known.
    pub fn lose(&mut self, [sigma_m, sigma_rad]: [f32; 2]) {
        if self.holds_map() {
            return;
        }
        let position_m2 = self.swing_m2() + sigma_m * sigma_m;
        let heading_rad2 = self.unknown_rad2() + sigma_rad * sigma_rad;
        let jolted = if self.is_jolted() { JOLTED } else { 0 };
        self.swing = unsensed([position_m2, heading_rad2].map(float::sqrtf)) | jolted;
    }

    /// No jolt moved the robot after all, on a way on which one may have.
    pub fn forget_jolt(&mut self) {
        self.swing = 0;
    }

    /// Whether a jolt may have moved the robot on the way to the next one.
    pub fn is_jolted(&self) -> bool {
        self.unsensed().is_some() && self.swing & JOLTED != 0
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
        let is_sensed = self.unsensed().or(next.unsensed()).is_none();
        let swing_m2 = self.swing_m2() + next.swing_m2() + heading_rad2 * (square_m2 + onward_m2);
        Self {
            // Whole turns count: scale and veer are those of all turning.
            motion: Pose { x_m, y_m, theta_rad: self.motion.theta_rad + next.motion.theta_rad },
            path_m: self.path_m + next.path_m,
            turning_rad: self.turning_rad + next.turning_rad,
            time_ms: self.time_ms.saturating_add(next.time_ms),
            swing: if is_sensed {
                ((float::sqrtf(swing_m2) / SWING_M) as u16).min(UNSENSED - 1)
            } else {
                let known = unsensed([swing_m2, self.unknown_rad2() + next.unknown_rad2()].map(float::sqrtf));
                if self.is_jolted() || next.is_jolted() { known | JOLTED } else { known }
            },
            ..*self
        }
    }
}

/// What marks a motion that was not sensed and is known to a 1-sigma, metres and radians; saturates below what marks that a map is held.
fn unsensed([sigma_m, sigma_rad]: [f32; 2]) -> u16 {
    let of_m = libm::roundf(sigma_m / UNSENSED_M).min(126.0) as u16;
    let of_rad = libm::roundf(sigma_rad / UNSENSED_RAD).min(126.0) as u16;
    UNSENSED | of_m << 8 | of_rad
}
