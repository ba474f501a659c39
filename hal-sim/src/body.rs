//! Differential drive: duty to wheel speed, wheel speed to motion, motion stopped by walls.

use slam_core::DriveModel;

use crate::options::SimOptions;
use crate::pose::Pose2;
use crate::rng::Rng;
use crate::world::World;
use robot::{Contacts, Duty};

/// What the drive really is, as against what the rig says: factors, 1 where the rig is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueDrive {
    /// True travel per nominal travel of the left wheel.
    pub scale_left: f64,
    /// True travel per nominal travel of the right wheel.
    pub scale_right: f64,
    /// True track per nominal track.
    pub track: f64,
}

/// The nominal figures of a wheeled rig.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wheels {
    pub track_m: f64,
    pub metres_per_tick: f64,
    noise_m2_per_m: f64,
    scale_sigma: f64,
    track_sigma: f64,
}

impl Wheels {
    pub(crate) fn of(drive: &DriveModel) -> Self {
        match *drive {
            DriveModel::Wheels { track_m, track_sigma, metres_per_tick, scale_sigma, noise_m2_per_m } => Self {
                track_m: track_m.into(),
                metres_per_tick: metres_per_tick.into(),
                noise_m2_per_m: noise_m2_per_m.into(),
                scale_sigma: scale_sigma.into(),
                track_sigma: track_sigma.into(),
            },
            // The rig says how wrong the dead-reckoned pose is, and nothing of wheels: exact ones, as far apart as the default
            // robot's, with encoders too fine to matter.
            DriveModel::Odometry { .. } => {
                Self { track_m: 0.235, metres_per_tick: 1e-5, noise_m2_per_m: 0.0, scale_sigma: 0.0, track_sigma: 0.0 }
            }
        }
    }

    pub(crate) fn draw(&self, options: &SimOptions, seed: u64) -> TrueDrive {
        let factor = |purpose: &str, sigma: f64| {
            (1.0 + options.error_ratio * sigma * Rng::stream(seed, purpose, 0).gaussian()).clamp(0.5, 1.5)
        };
        let unequal = 0.5 * options.drive.drift_rad_per_m * self.track_m;
        TrueDrive {
            scale_left: factor("scale-left", self.scale_sigma) - unequal,
            scale_right: factor("scale-right", self.scale_sigma) + unequal,
            track: factor("track", self.track_sigma),
        }
    }
}

/// The moving robot.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub pose: Pose2,
    pub contacts: Contacts,
    /// Its wheels turn and do not move it.
    pub is_held: bool,
    /// Its wheels cannot turn.
    pub is_jammed: bool,
    wheels: Wheels,
    truth: TrueDrive,
    speed_mps: [f64; 2],
    turned_m: [f64; 2],
    slip_left_m: [f64; 2],
    /// Travel that certainly meets nothing: spares the search for walls.
    free_travel_m: f64,
    noise: [Rng; 2],
    slips: Rng,
}

/// Contact is felt a little before the body is stopped, as a bumper's skirt does.
const BUMPER_TRAVEL_M: f64 = 0.003;

impl Body {
    pub(crate) fn new(pose: Pose2, wheels: Wheels, truth: TrueDrive, seed: u64) -> Self {
        Self {
            pose,
            contacts: Contacts::default(),
            is_held: false,
            is_jammed: false,
            wheels,
            truth,
            speed_mps: [0.0; 2],
            turned_m: [0.0; 2],
            slip_left_m: [0.0; 2],
            free_travel_m: 0.0,
            noise: [Rng::stream(seed, "wheel-noise", 0), Rng::stream(seed, "wheel-noise", 1)],
            slips: Rng::stream(seed, "slip", 0),
        }
    }

    /// Encoder counts of both wheels since the start.
    pub(crate) fn ticks(&self) -> [i64; 2] {
        self.turned_m.map(|turned_m| libm::floor(turned_m / self.wheels.metres_per_tick) as i64)
    }

    /// Travel of both wheels since the start as their encoders count it, metres.
    pub(crate) fn counted_m(&self) -> [f64; 2] {
        self.ticks().map(|ticks| ticks as f64 * self.wheels.metres_per_tick)
    }

    /// Moves for `period_s` with this duty.
    pub(crate) fn advance(&mut self, duty: Duty, period_s: f64, world: &World, options: &SimOptions) {
        let drive = &options.drive;
        let share = 1.0 - libm::exp(-period_s / drive.lag_s.max(1e-6));
        let mut travel_m = [0.0; 2];
        let factors = [self.truth.scale_left, self.truth.scale_right];
        for (wheel, duty) in [duty.left, duty.right].into_iter().enumerate() {
            let duty = f64::from(duty).clamp(-1.0, 1.0);
            let steady_mps = if duty.abs() < drive.dead_duty { 0.0 } else { duty * drive.full_speed_mps };
            self.speed_mps[wheel] += share * (steady_mps - self.speed_mps[wheel]);
            if self.is_jammed {
                self.speed_mps[wheel] = 0.0;
            }
            let turned_m = self.speed_mps[wheel] * period_s;
            self.turned_m[wheel] += turned_m;
            let noise_m = libm::sqrt(self.wheels.noise_m2_per_m * turned_m.abs()) * self.noise[wheel].gaussian();
            let rolled_m = turned_m * factors[wheel] + noise_m;
            travel_m[wheel] = rolled_m - self.slipped(wheel, turned_m, options);
        }
        if self.is_held {
            return;
        }
        self.roll(travel_m);
        self.free_travel_m -= 0.5 * (travel_m[0] + travel_m[1]).abs();
        self.collide(world, options);
    }

    /// Puts the body down elsewhere.
    pub(crate) fn put(&mut self, pose: Pose2) {
        self.pose = pose;
        self.free_travel_m = 0.0;
    }

    /// Pushes the body by so much; what it runs into stops it.
    pub(crate) fn slide(&mut self, by_m: [f64; 2], world: &World, options: &SimOptions) {
        self.put(Pose2 { x_m: self.pose.x_m + by_m[0], y_m: self.pose.y_m + by_m[1], ..self.pose });
        self.collide(world, options);
    }

    /// The part of this travel that a slipping wheel loses.
    fn slipped(&mut self, wheel: usize, turned_m: f64, options: &SimOptions) -> f64 {
        let drive = &options.drive;
        if drive.slips_per_m <= 0.0 {
            return 0.0;
        }
        if self.slips.unit() < 0.5 * drive.slips_per_m * turned_m.abs() {
            // A log-normal length of this mean.
            let tail = drive.slip_tail;
            let uneven = if tail > 0.0 { libm::exp(tail * (self.slips.gaussian() - 0.5 * tail)) } else { 1.0 };
            self.slip_left_m[wheel] = drive.slip_m * uneven;
        }
        let lost_m = self.slip_left_m[wheel].min(turned_m.abs());
        self.slip_left_m[wheel] -= lost_m;
        lost_m * if turned_m < 0.0 { -1.0 } else { 1.0 }
    }

    fn roll(&mut self, travel_m: [f64; 2]) {
        let forward_m = 0.5 * (travel_m[0] + travel_m[1]);
        let turn_rad = (travel_m[1] - travel_m[0]) / (self.wheels.track_m * self.truth.track);
        let (s, c) = libm::sincos(self.pose.theta_rad + 0.5 * turn_rad);
        self.pose =
            Pose2::new(self.pose.x_m + forward_m * c, self.pose.y_m + forward_m * s, self.pose.theta_rad + turn_rad);
    }

    /// Pushes the body out of what it ran into (the wheels go on turning: they slip) and sets the bumper.
    fn collide(&mut self, world: &World, options: &SimOptions) {
        let felt_m = options.body_radius_m + BUMPER_TRAVEL_M;
        if world.is_static() && self.free_travel_m > 0.0 {
            return;
        }
        self.contacts.bump_left = false;
        self.contacts.bump_right = false;
        for _ in 0..4 {
            let centre_m = [self.pose.x_m, self.pose.y_m];
            let Some(touch) = world.touch(centre_m, felt_m) else { break };
            let [ahead, left] = Pose2::new(0.0, 0.0, self.pose.theta_rad).inverse_transform(touch.away);
            // The touched thing lies against `away`: ahead of the robot when `ahead` is negative.
            if ahead < -0.2 {
                self.contacts.bump_left |= left < 0.25;
                self.contacts.bump_right |= left > -0.25;
            }
            let depth_m = touch.depth_m - BUMPER_TRAVEL_M;
            if depth_m <= 0.0 {
                break;
            }
            self.pose.x_m += depth_m * touch.away[0];
            self.pose.y_m += depth_m * touch.away[1];
        }
        self.free_travel_m = world.clearance_m([self.pose.x_m, self.pose.y_m]) - felt_m - 1e-6;
    }
}
