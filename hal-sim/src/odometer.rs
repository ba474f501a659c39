//! Dead-reckoned poses, as a robot's driver publishes them: at a rate of its own, by the nominal wheels, with the errors that an
//! `[odometry]` rig states.

use slam_core::{DriveModel, Increment};

use crate::options::SimOptions;

use crate::pose::Pose2;
use crate::rng::Rng;

/// What a dead-reckoned pose gets wrong, by its rig.
#[derive(Clone, Debug)]
struct Errors {
    /// True distance and true turn per reported one.
    scale: [f64; 2],
    noise_m2_per_m: f64,
    noise_rad2_per_m: f64,
    noise_rad2_per_rad: f64,
    noise: Rng,
}

impl Errors {
    /// Drawn by what the rig states; none where it has wheels, whose own errors are enough.
    fn draw(drive: &DriveModel, options: &SimOptions, seed: u64) -> Option<Self> {
        let DriveModel::Odometry { scale_sigma, noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, .. } = *drive
        else {
            return None;
        };
        let sigma = options.error_ratio * f64::from(scale_sigma);
        let factor = |purpose: &str| (1.0 + sigma * Rng::stream(seed, purpose, 0).gaussian()).clamp(0.5, 1.5);
        Some(Self {
            scale: [factor("scale-distance"), factor("scale-turn")],
            noise_m2_per_m: noise_m2_per_m.into(),
            noise_rad2_per_m: noise_rad2_per_m.into(),
            noise_rad2_per_rad: noise_rad2_per_rad.into(),
            noise: Rng::stream(seed, "odometry-noise", 0),
        })
    }

    /// What is reported of a step: forward and left, metres, and turn, radians.
    fn report(&mut self, forward_m: f64, turn_rad: f64) -> [f64; 3] {
        let position_m = libm::sqrt(self.noise_m2_per_m * forward_m.abs());
        let heading_rad =
            libm::sqrt(self.noise_rad2_per_m * forward_m.abs() + self.noise_rad2_per_rad * turn_rad.abs());
        [
            forward_m / self.scale[0] + position_m * self.noise.gaussian(),
            position_m * self.noise.gaussian(),
            turn_rad / self.scale[1] + heading_rad * self.noise.gaussian(),
        ]
    }
}

/// What publishes the wheels' pose.
#[derive(Clone, Debug)]
pub(crate) struct Odometer {
    /// None: as soon as it changes.
    period_s: Option<f64>,
    next_s: f64,
    errors: Option<Errors>,
    track_m: f64,
    /// By the encoders, now.
    pose: Pose2,
    turned_m: [f64; 2],
    /// As published last.
    latest: Pose2,
    /// What the last sample had.
    given: Pose2,
}

impl Odometer {
    /// Standing at its origin, in a random phase; none where samples have ticks.
    pub(crate) fn new(drive: &DriveModel, track_m: f64, options: &SimOptions, seed: u64) -> Option<Self> {
        let errors = Errors::draw(drive, options, seed);
        if errors.is_none() && options.odometry_hz.is_none() {
            return None;
        }
        let period_s = options.odometry_hz.map(|rate_hz| 1.0 / rate_hz);
        let next_s = period_s.unwrap_or(0.0) * Rng::stream(seed, "odometry-phase", 0).unit();
        let still = Pose2::default();
        Some(Self { period_s, next_s, errors, track_m, pose: still, turned_m: [0.0; 2], latest: still, given: still })
    }

    /// True distance and true turn per reported one, beyond what the wheels get wrong.
    pub(crate) fn scale(&self) -> [f64; 2] {
        self.errors.as_ref().map_or([1.0; 2], |errors| errors.scale)
    }

    /// The pose that the last sample had.
    pub(crate) fn given(&self) -> Pose2 {
        self.given
    }

    /// Takes in the encoders' travel since the start, metres, and publishes what is due.
    pub(crate) fn advance(&mut self, time_s: f64, turned_m: [f64; 2]) {
        let [left_m, right_m] = [0, 1].map(|wheel| turned_m[wheel] - self.turned_m[wheel]);
        self.turned_m = turned_m;
        let (forward_m, turn_rad) = (0.5 * (left_m + right_m), (right_m - left_m) / self.track_m);
        let [forward_m, left_m, turn_rad] = match &mut self.errors {
            Some(errors) => errors.report(forward_m, turn_rad),
            None => [forward_m, 0.0, turn_rad],
        };
        let (s, c) = libm::sincos(self.pose.theta_rad + 0.5 * turn_rad);
        self.pose = Pose2::new(
            self.pose.x_m + forward_m * c - left_m * s,
            self.pose.y_m + forward_m * s + left_m * c,
            self.pose.theta_rad + turn_rad,
        );
        match self.period_s {
            None => self.latest = self.pose,
            Some(period_s) if time_s >= self.next_s => {
                self.latest = self.pose;
                self.next_s += period_s * libm::floor(1.0 + (time_s - self.next_s) / period_s);
            }
            Some(_) => {}
        }
    }

    /// Motion from the pose that the last sample had to the one published last.
    pub(crate) fn take(&mut self) -> Increment {
        let moved = self.given.relative(&self.latest);
        self.given = self.latest;
        Increment { forward_m: moved.x_m as f32, left_m: moved.y_m as f32, turn_rad: moved.theta_rad as f32 }
    }
}
