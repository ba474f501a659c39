//! Residuals of what was sensed, with their derivatives.

use slam_core::angle::wrap;
use slam_core::{BUILT_TOLERANCE, Calibration, DriveModel, LOOSE_RAD, Pose, SLIP_M2_PER_RAD, SLIP_RUNS, Standing};

use crate::frame::{Frame, dot};
use crate::gains::Gains;
use crate::group::Group;
use crate::keyframe::Keyframe;
use crate::wall::Wall;

/// Residuals of so many sigmas count half (Cauchy).
const HALF_AT: f32 = 2.0;

/// Places in the border: those of a hand-over.
pub use slam_core::hand_over::{ALPHA, DISTANCE, GAINS, POSE as LAST_POSE, TURN, VEER, WALLS};

/// No entry of the border.
const NONE: (usize, f32) = (0, 0.0);

/// What is known exactly is known to this.
const LEAST_SIGMA: f32 = 1e-4;

/// A wall on an exact grid stands on it to this, radians: two millimetres over two metres, and still a weight with which f32 tells
/// the rest.
const EXACT_RAD: f32 = 1e-3;

/// One residual, its weight, and its derivatives by a pose, by the next one, and by entries of the border.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// What is to be nought.
    pub residual: f32,
    /// One over its variance.
    pub weight: f32,
    /// By x, y and theta of the pose.
    pub here: [f32; 3],
    /// By x, y and theta of the next.
    pub next: [f32; 3],
    /// By entries of the border; those of nought count for nothing.
    pub border: [(usize, f32); 3],
}

/// Noise of the odometry and of its calibration.
#[derive(Clone, Copy, Debug)]
pub struct Odometry {
    drive: DriveModel,
    /// Factor of the variance of a logged pose's position, slips included, as the filter learned it.
    pub position_level: f32,
    /// The same of how far counted wheels went.
    pub wheel_level: f32,
    /// Variance of each axis of where a kept map as a whole is, m^2, and of how it is turned, rad^2.
    pub map_variances: [f32; 2],
}

impl Odometry {
    /// Of a drive that is not known yet; every byte is zero.
    pub const NONE: Self = Self {
        drive: DriveModel::Wheels {
            track_m: 0.0,
            track_sigma: 0.0,
            metres_per_tick: 0.0,
            scale_sigma: 0.0,
            noise_m2_per_m: 0.0,
        },
        position_level: 0.0,
        wheel_level: 0.0,
        map_variances: [0.0; 2],
    };

    /// Of a drive, as stated.
    pub fn of(drive: &DriveModel) -> Self {
        Self { drive: *drive, position_level: 1.0, wheel_level: 1.0, map_variances: [0.0; 2] }
    }

    /// Variance of each axis of the position, m^2, and of the heading, rad^2, after a keyframe's motion.
    pub fn variances(&self, key: &Keyframe) -> [f32; 2] {
        if key.holds_whole() {
            return self.map_variances.map(|variance| variance + 1e-8);
        }
        let Keyframe { path_m, turning_rad, .. } = *key;
        let [position_m2, heading_rad2] = match self.drive {
            DriveModel::Wheels { track_m, noise_m2_per_m, .. } => {
                let wheel_m2 = self.wheel_level * noise_m2_per_m * (path_m + 0.5 * track_m * turning_rad);
                [0.5 * wheel_m2, 2.0 * wheel_m2 / (track_m * track_m)]
            }
            DriveModel::Odometry { noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, .. } => [
                self.position_level * (SLIP_RUNS * noise_m2_per_m * path_m + SLIP_M2_PER_RAD * turning_rad),
                noise_rad2_per_m * path_m + noise_rad2_per_rad * turning_rad,
            ],
        };
        // A tenth of a millimetre and of a milliradian: what stands still does so.
        [position_m2 + key.swing_m2() + 1e-8, heading_rad2 + key.unknown_rad2() + 1e-8]
    }

    /// What is known of the calibration beforehand. Wheels that are larger drive farther and turn more: what is known of the
    /// track tells how the scale of turning goes with that of distance.
    pub fn prior(&self, calibration: &Calibration) -> [Row; 3] {
        let Calibration { distance, turn, veer_rad_per_m } = *calibration;
        let row = |residual: f32, sigma: f32, border| {
            let sigma = sigma.max(LEAST_SIGMA);
            Row { residual, weight: 1.0 / (sigma * sigma), here: [0.0; 3], next: [0.0; 3], border }
        };
        let only = |place| [(place, 1.0), NONE, NONE];
        match self.drive {
            DriveModel::Wheels { track_m, track_sigma, scale_sigma, .. } => {
                let both = scale_sigma * core::f32::consts::FRAC_1_SQRT_2;
                [
                    row(distance - 1.0, both, only(DISTANCE)),
                    row(turn - distance, track_sigma, [(TURN, 1.0), (DISTANCE, -1.0), NONE]),
                    row(veer_rad_per_m, 2.0 * both / track_m, only(VEER)),
                ]
            }
            DriveModel::Odometry { scale_sigma, veer_sigma, .. } => [
                row(distance - 1.0, scale_sigma, only(DISTANCE)),
                row(turn - 1.0, scale_sigma, only(TURN)),
                row(veer_rad_per_m, veer_sigma, only(VEER)),
            ],
        }
    }

    /// The motion from a keyframe to the next. Where it ends the robot slipped to: a stretch on which nothing was sensed says
    /// nothing of the scale. With the motion over its scale beside what was sensed, each would draw the scale up by the square
    /// of what the walls say it moved. A turn's noise is the odometry's. A jolt has long tails: somebody who walks into a
    /// robot pushes it farther than a foot does.
    pub fn rows(&self, key: &Keyframe, next: &Pose, calibration: &Calibration) -> [Row; 3] {
        let Calibration { distance, turn, veer_rad_per_m } = *calibration;
        let [position_m2, heading_rad2] = self.variances(key);
        let frame = Frame::of(&key.pose);
        let [forward, left] = frame.turn_back([next.x_m - key.pose.x_m, next.y_m - key.pose.y_m]);
        let [c, s] = frame.turn([1.0, 0.0]);
        let row = |residual, weight, here, next, border| Row { residual, weight, here, next, border };
        let by_scale = |sensed: f32| [(DISTANCE, -sensed), NONE, NONE];
        let sensed_rad = key.motion.theta_rad + veer_rad_per_m * key.path_m;
        let heading = wrap(next.theta_rad - key.pose.theta_rad - turn * sensed_rad) / turn;
        let [ahead_m, aside_m] = [forward - distance * key.motion.x_m, left - distance * key.motion.y_m];
        let robust = if key.is_jolted() {
            let square = (ahead_m * ahead_m + aside_m * aside_m) / position_m2 + heading * heading / heading_rad2;
            cauchy(square)
        } else {
            1.0
        };
        let weight = robust / position_m2;
        let by_turn = [(TURN, -(sensed_rad + heading) / turn), (VEER, -key.path_m), NONE];
        [
            row(ahead_m, weight, [-c, -s, left], [c, s, 0.0], by_scale(key.motion.x_m)),
            row(aside_m, weight, [s, -c, -forward], [-s, c, 0.0], by_scale(key.motion.y_m)),
            row(heading, robust / heading_rad2, [0.0, 0.0, -1.0 / turn], [0.0, 0.0, 1.0 / turn], by_turn),
        ]
    }
}

/// Robust weight of a residual of so many sigmas, squared.
fn cauchy(square: f32) -> f32 {
    1.0 / (1.0 + square / (HALF_AT * HALF_AT))
}

/// A group of hits on a wall whose offset is at `place` in the border: how far the mean is before the wall, and how the hits
/// are turned against it. The two say of pose and wall what all the hits say one by one, for their cross terms vanish about
/// the mean; the robust weight is the group's.
/// A gain that is larger puts the mean nearer to where the beams began, by a share of the range that should have been read: times the
/// noise of the range that was, every group would draw the gains up, and walls and odometry's scale down with them.
pub fn of_group(group: &Group, gains: &Gains, pose: &Pose, frame: &Frame, wall: &Wall, place: usize) -> [Row; 2] {
    let line = wall.line();
    let group = gains.correct(group);
    let way = frame.turn([group.mean_m[0] - group.from_m[0], group.mean_m[1] - group.from_m[1]]);
    let offset = group.offset(frame, &line);
    let by_gain = match gains.of(group.sensor()) {
        Some((number, gain)) => (GAINS + number, (dot(line.normal, way) - offset.behind_m) / gain),
        None => NONE,
    };
    let ([nx, ny], [tx, ty]) = (line.normal, line.tangent());
    let robust = cauchy(offset.square);
    let by_heading = tx * (offset.mean_m[0] - pose.x_m) + ty * (offset.mean_m[1] - pose.y_m);
    let apart = Row {
        residual: -offset.behind_m,
        weight: robust * group.weight,
        here: [-nx, -ny, by_heading],
        next: [0.0; 3],
        border: [(place, 1.0), (place + 1, wall.anchor_m - offset.along_m), by_gain],
    };
    let is_long = offset.along > 1e-9 * group.weight;
    let turned = Row {
        residual: if is_long { -offset.cross / offset.along } else { 0.0 },
        weight: robust * offset.along,
        here: [0.0, 0.0, 1.0],
        next: [0.0; 3],
        border: [(place + 1, -1.0), NONE, NONE],
    };
    [apart, turned]
}

/// How a wall is tied to the grid: where the filter decides that wall by wall, as the filter has it, for one that was turned on its own
/// would be turned back as it is handed over; else as built walls stand. None where it has a direction of its own.
pub fn of_grid(wall: &Wall, alpha_rad: f32, place: usize) -> Option<Row> {
    let (residual, tolerance_rad) = match wall.told {
        Standing::Near(quarter) => (wrap(wall.beta_rad - grid_rad(alpha_rad, quarter)), LOOSE_RAD),
        Standing::Exact(quarter) => (wrap(wall.beta_rad - grid_rad(alpha_rad, quarter)), EXACT_RAD),
        Standing::Unknown if wall.on_grid => (off_grid(wall.beta_rad, alpha_rad), BUILT_TOLERANCE),
        Standing::Off | Standing::Unknown => return None,
    };
    Some(Row {
        residual,
        weight: 1.0 / (tolerance_rad * tolerance_rad),
        here: [0.0; 3],
        next: [0.0; 3],
        border: [(place + 1, 1.0), (ALPHA, -1.0), NONE],
    })
}

/// The grid's direction that is so many quarter turns from alpha.
pub fn grid_rad(alpha_rad: f32, quarter: u8) -> f32 {
    alpha_rad + f32::from(quarter) * core::f32::consts::FRAC_PI_2
}

/// Angle from the nearest direction of the grid.
pub fn off_grid(beta_rad: f32, alpha_rad: f32) -> f32 {
    beta_rad - alpha_rad - quarters(beta_rad, alpha_rad) * core::f32::consts::FRAC_PI_2
}

/// Quarter turns from alpha to the grid's direction that is nearest.
pub fn quarters(beta_rad: f32, alpha_rad: f32) -> f32 {
    libm::roundf((beta_rad - alpha_rad) / core::f32::consts::FRAC_PI_2)
}
