//! From travel to a step in the robot's frame, its Jacobian and its noise.
//!
//! Differential drive as in Zunino and Christensen (2001), sec. 2, with the exact arc instead of its chord's direction
//! only, and with the wheels' scales and the track as parameters.

use crate::filter::ekf::MotionJacobian;
use crate::filter::layout::{THETA, X, Y};
use crate::geometry::angle::sin_cos;
use crate::geometry::pose::{Pose, length};
use crate::motion::travel::Travel;
use crate::rig::DriveModel;
use crate::sample::Increment;

/// Distance of a beam's middle from the robot, metres, by which turns move it.
pub const MIDDLE_M: f32 = 0.5;

/// For so long a robot goes on as before, or stands, seconds.
const LIKE_BEFORE_S: f32 = 0.2;

/// What a cleaning robot does in a second, metres and radians.
const FAST_M_S: f32 = 0.5;
const FAST_RAD_S: f32 = 1.0;

/// 1-sigma of a heading that is any: that of all between minus and plus half a turn.
const ANY_RAD: f32 = 1.8138;

/// Calibration factors in use, and where their derivatives go.
#[derive(Clone, Copy, Debug)]
pub struct Factor {
    /// Present value.
    pub value: f32,
    /// State index; none where the factor is known.
    pub state: Option<usize>,
}

/// The calibration factors of a drive model.
#[derive(Clone, Copy, Debug)]
pub struct Factors {
    /// Scale of the left wheel, or of distance.
    pub first: Factor,
    /// Scale of the right wheel, or of turning.
    pub second: Factor,
    /// Factor of the track of wheels; the veer of an odometry, radians per metre forward.
    pub third: Factor,
}

impl Factors {
    /// What is known of them without estimating: factors are 1, and there is no veer.
    pub const fn nominal(drive: &DriveModel) -> Self {
        let known = Factor { value: 1.0, state: None };
        let none = Factor { value: 0.0, state: None };
        let third = if matches!(drive, DriveModel::Wheels { .. }) { known } else { none };
        Self { first: known, second: known, third }
    }
}

/// One step of motion in the robot's frame, with its derivatives and noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Displacement and turn in the robot's frame at the step's start.
    pub increment: Increment,
    /// d(forward, left, turn) by the three factors of [`Factors`].
    pub by_factor: [[f32; 3]; 3],
    /// Covariance of (forward, left, turn).
    pub noise: [[f32; 3]; 3],
    /// Length of the path, metres.
    pub path_m: f32,
}

impl Step {
    /// How far the middle of a beam moved, metres.
    pub fn beams_moved_m(&self) -> f32 {
        self.path_m + MIDDLE_M * self.increment.turn_rad.abs()
    }

    /// What is known of the step after this one, of so many seconds, when its motion is lost: the robot stood or went on as before, so
    /// it is where it was, give or take that much: at least a centimetre and a degree, at most what a cleaning robot does in a fifth of a
    /// second. In the time beyond that it may have done what it can.
    pub fn lost(&self, dt_s: f32) -> Self {
        let beyond_s = (dt_s - LIKE_BEFORE_S).max(0.0);
        let along = self.path_m.clamp(0.01, LIKE_BEFORE_S * FAST_M_S) + beyond_s * FAST_M_S;
        let turn = self.increment.turn_rad.abs().clamp(0.02, LIKE_BEFORE_S * FAST_RAD_S) + beyond_s * FAST_RAD_S;
        let turn = turn.min(ANY_RAD);
        let noise = [[along * along, 0.0, 0.0], [0.0, along * along, 0.0], [0.0, 0.0, turn * turn]];
        Self { noise, path_m: along, ..Self::default() }
    }

    /// How far off the robot is after a motion that was lost, 1-sigma, metres and radians; none of one that was not.
    pub fn lost_by(&self) -> Option<[f32; 2]> {
        let is_lost = self.path_m > 0.0 && self.increment == Increment::default();
        is_lost.then(|| [self.noise[0][0], self.noise[2][2]].map(float::sqrtf))
    }

    /// No motion.
    pub const STILL: Self = Self {
        increment: Increment { forward_m: 0.0, left_m: 0.0, turn_rad: 0.0 },
        by_factor: [[0.0; 3]; 3],
        noise: [[0.0; 3]; 3],
        path_m: 0.0,
    };
}

/// Variance of (x, y, theta) at the start: the map frame's origin is where the robot stands, but an encoder tells only
/// to one tick where that is, then and at any later time. The error, the difference of two uniform ones, does not grow.
pub fn start_variance(drive: &DriveModel) -> [f32; 3] {
    match *drive {
        DriveModel::Wheels { track_m, metres_per_tick, .. } => {
            let wheel = metres_per_tick * metres_per_tick * (1.0 / 6.0);
            [0.5 * wheel, 0.0, 2.0 * wheel / (track_m * track_m)]
        }
        DriveModel::Odometry { .. } => [0.0; 3],
    }
}

/// sin(h) / h and its derivative, for the half turn h of one step.
fn sinc(h: f32) -> (f32, f32) {
    let h2 = h * h;
    if h2 > 2.0 {
        let (sin, cos) = sin_cos(h);
        return (sin / h, (cos - sin / h) / h);
    }
    // To 2e-5, and far better at the half turns that occur.
    let value = 1.0 - h2 * (1.0 / 6.0 - h2 * (1.0 / 120.0 - h2 * (1.0 / 5040.0)));
    (value, -h * (1.0 / 3.0 - h2 * (1.0 / 30.0 - h2 * (1.0 / 840.0))))
}

/// Least noise of a motion, m^2 or rad^2 per metre or radian, whatever the rig states: 0.03 mm over a metre, less than any wheel has. A
/// robot that goes back to where its position was known exactly would take with it no more than single precision has made of it.
const LEAST_NOISE: f32 = 1e-9;

/// The step that `travel` makes with the factors at hand.
pub fn step(drive: &DriveModel, travel: &Travel, factors: &Factors) -> Step {
    match (drive, travel) {
        (&DriveModel::Wheels { track_m, noise_m2_per_m, .. }, &Travel::Wheels { left_m, right_m }) => {
            let step = wheel_step(track_m, noise_m2_per_m.max(LEAST_NOISE), left_m, right_m, factors);
            // Straight on, the wheels' noise has no part across the way.
            if noise_m2_per_m < LEAST_NOISE { step.noisier(LEAST_NOISE * step.path_m) } else { step }
        }
        (&DriveModel::Odometry { noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, .. }, &Travel::Body(raw)) => {
            let (distance, turn) = (factors.first.value, factors.second.value);
            let (forward_m, left_m) = (distance * raw.forward_m, distance * raw.left_m);
            let path_m = distance * length(raw.forward_m, raw.left_m);
            // Wheels of unequal size turn the robot as it drives; on average it has turned by half of that.
            let veered_rad = factors.third.value * forward_m;
            let position = noise_m2_per_m.max(LEAST_NOISE) * path_m;
            let heading = noise_rad2_per_m.max(LEAST_NOISE) * path_m
                + noise_rad2_per_rad.max(LEAST_NOISE) * (turn * raw.turn_rad).abs();
            Step {
                increment: Increment {
                    forward_m: forward_m - 0.5 * veered_rad * left_m,
                    left_m: left_m + 0.5 * veered_rad * forward_m,
                    turn_rad: turn * raw.turn_rad + veered_rad,
                },
                by_factor: by_factors(raw, factors),
                noise: [[position, 0.0, 0.0], [0.0, position, 0.0], [0.0, 0.0, heading]],
                path_m,
            }
        }
        _ => Step::default(),
    }
}

/// d(forward, left, turn) by the scales of distance and of turning and by the veer, for this motion as the odometry says it.
fn by_factors(raw: Increment, factors: &Factors) -> [[f32; 3]; 3] {
    let Increment { forward_m, left_m, turn_rad } = raw;
    let (distance, veer) = (factors.first.value, factors.third.value);
    // Along the scaled path, and the turn that the veer makes of it.
    let (forward, left, veered_rad) = (distance * forward_m, distance * left_m, veer * distance * forward_m);
    let by_distance = [forward_m - veered_rad * left_m, left_m + veered_rad * forward_m, veer * forward_m];
    let by_veer = [-0.5 * forward * left, 0.5 * forward * forward, forward];
    [by_distance, [0.0, 0.0, turn_rad], by_veer]
}

fn wheel_step(track_m: f32, noise_m2_per_m: f32, left_m: f32, right_m: f32, factors: &Factors) -> Step {
    let track_m = track_m * factors.third.value;
    let (left, right) = (factors.first.value * left_m, factors.second.value * right_m);
    let distance = 0.5 * (left + right);
    let turn = (right - left) / track_m;
    // The chord of the arc: length distance * sinc(turn / 2), direction turn / 2.
    let (sin, cos) = sin_cos(0.5 * turn);
    let (chord, chord_slope) = sinc(0.5 * turn);
    let (forward_m, left_m_body) = (distance * chord * cos, distance * chord * sin);
    // Derivatives of (forward, left, turn) by distance and by turn.
    let by_distance = [chord * cos, chord * sin, 0.0];
    let by_turn =
        [0.5 * distance * (chord_slope * cos - chord * sin), 0.5 * distance * (chord_slope * sin + chord * cos), 1.0];
    let mut by_left = [0.0; 3];
    let mut by_right = [0.0; 3];
    for i in 0..3 {
        by_left[i] = 0.5 * by_distance[i] - by_turn[i] / track_m;
        by_right[i] = 0.5 * by_distance[i] + by_turn[i] / track_m;
    }
    let (left_variance, right_variance) = (noise_m2_per_m * left.abs(), noise_m2_per_m * right.abs());
    let mut noise = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            noise[i][j] = left_variance * by_left[i] * by_left[j] + right_variance * by_right[i] * by_right[j];
        }
    }
    let by_track = by_turn.map(|d| -d * turn / factors.third.value);
    Step {
        increment: Increment { forward_m, left_m: left_m_body, turn_rad: turn },
        by_factor: [by_left.map(|d| d * left_m), by_right.map(|d| d * right_m), by_track],
        noise,
        path_m: distance.abs(),
    }
}

/// Time for which wheels keep their speed, seconds: a small gear motor's time constant is 50 to 100 ms.
pub const STEADY_S: f32 = 0.1;

/// Slips come in runs: over ten seconds they add up to so many times the variance that steps of a second have. From the dead
/// reckoning of olsson-demo, held against a path on which all its passes agree (docs/notes/real-logs.md).
pub const SLIP_RUNS: f32 = 4.0;

/// Variance of each axis that sliding in a turn adds, m^2 per radian: a point of rotation four centimetres off. From the same
/// log.
pub const SLIP_M2_PER_RAD: f32 = 2e-3;

impl Step {
    /// With the noise of the position that real floors add to what a rig states.
    pub fn slipping(self) -> Self {
        let stated_m2 = self.noise[0][0].max(self.noise[1][1]);
        self.noisier((SLIP_RUNS - 1.0) * stated_m2 + SLIP_M2_PER_RAD * self.increment.turn_rad.abs())
    }

    /// With more noise of the position, the same along each axis, m^2.
    fn noisier(mut self, by_m2: f32) -> Self {
        self.noise[0][0] += by_m2;
        self.noise[1][1] += by_m2;
        self
    }

    /// With what an arc leaves out where the wheels could change their speeds between two samples: a robot that turned before
    /// it drove, or after, ends beside the arc, by half of the turn seen from where it was.
    pub fn unsteady(mut self, dt_s: f32) -> Self {
        let share = 1.0 - STEADY_S / dt_s;
        if share > 0.0 {
            let (s, c) = sin_cos(0.5 * self.increment.turn_rad);
            let aside_m = share * self.path_m * s;
            let across = [-aside_m * s, aside_m * c];
            for (row, a) in self.noise.iter_mut().zip(across) {
                for (entry, b) in row.iter_mut().zip(across) {
                    *entry += a * b;
                }
            }
        }
        self
    }

    /// The pose that this step leads to.
    pub fn applied_to(&self, pose: &Pose) -> Pose {
        let i = self.increment;
        pose.compose(&Pose { x_m: i.forward_m, y_m: i.left_m, theta_rad: i.turn_rad })
    }

    /// The pose Jacobian and noise in the map frame, for a robot whose heading at the step's start has this sine and
    /// cosine.
    pub fn in_map(&self, (sin, cos): (f32, f32), factors: &Factors) -> (MotionJacobian, [[f32; 3]; 3]) {
        let rotate = |v: [f32; 3]| [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1], v[2]];
        let moved = rotate([self.increment.forward_m, self.increment.left_m, 0.0]);
        let mut jacobian = MotionJacobian::default();
        jacobian[X][X] = 1.0;
        jacobian[Y][Y] = 1.0;
        jacobian[THETA][THETA] = 1.0;
        jacobian[X][THETA] = -moved[1];
        jacobian[Y][THETA] = moved[0];
        for (factor, derivative) in [factors.first, factors.second, factors.third].iter().zip(self.by_factor) {
            let derivative = rotate(derivative);
            for (row, d) in jacobian.iter_mut().zip(derivative) {
                if let Some(entry) = factor.state.and_then(|i| row.get_mut(i)) {
                    *entry = d;
                }
            }
        }
        // R Q R^T: first the rows, then the columns.
        let half = [rotate(self.noise[0]), rotate(self.noise[1]), rotate(self.noise[2])];
        let mut noise = [[0.0; 3]; 3];
        for i in 0..3 {
            let column = rotate([half[0][i], half[1][i], half[2][i]]);
            for j in 0..3 {
                noise[j][i] = column[j];
            }
        }
        (jacobian, noise)
    }
}
