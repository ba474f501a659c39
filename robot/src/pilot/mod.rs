//! The pilot: drives through a home by what the robot senses and estimates.
//!
//! It keeps a coarse picture of the floor in the estimated frame and always goes to the nearest stretch of wall that it
//! has not been along, which is wall following that knows where it has been; where no such stretch is near, it goes to
//! the nearest edge of unseen space, so that doors are found. When nothing is left it forgets where it has been and
//! begins a new round; where it gets nowhere in twenty rounds, it stands and says that it is stuck. Bumps, cliffs and standing still lead to backing off and to a memory of the place.
//!
//! It takes the pose as it comes: an error of a few centimetres or a jump of ten blur the picture, and passing beams
//! clear it again.

pub(crate) mod beam;
mod config;
mod confinement;
pub(crate) mod memory;
mod patience;
mod route;
pub(crate) mod search;
pub(crate) mod steer;

use slam_core::{Pose, Rig};

use crate::condition::{Battery, Condition};
use crate::contact::{Contacts, Insistence};
use crate::floor::FloorConfig;
use crate::traits::WheelSpeeds;
use beam::{Beam, Passed, draw_beam};
pub use config::PilotConfig;
use confinement::Confinement;
use memory::{Cell, Memory};
use patience::Patience;
use route::Wave;
use search::{Route, Search};

/// What the pilot decides by, at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Senses<const S: usize> {
    /// Time, microseconds since any fixed moment.
    pub time_us: u64,
    /// The estimated pose.
    pub pose: Pose,
    /// Ranges, metres, corrected by the estimated gains, in the rig's order; none where there is no valid reading.
    pub ranges_m: [Option<f32>; S],
    /// Bumper and cliff.
    pub contacts: Contacts,
    /// Battery, charger, wheels that stall.
    pub condition: Condition,
}

/// What the pilot is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Activity {
    /// Nothing is known to go to: straight on, turning away from what is ahead.
    #[default]
    Wandering,
    /// Along walls.
    FollowingWalls,
    /// To the edge of unseen space.
    Exploring,
    /// Backing off from something touched or from a place where it stood still.
    BackingOff,
    /// Turning away after backing off.
    TurningAway,
    /// Standing: it cannot get away from where it is, and tries again once a minute; or its bumper or its cliff sensor tells of something
    /// wherever it backs off to.
    Stuck,
}

impl Activity {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wandering => "wandering",
            Self::FollowingWalls => "along walls",
            Self::Exploring => "exploring",
            Self::BackingOff => "backing off",
            Self::TurningAway => "turning away",
            Self::Stuck => "stuck",
        }
    }
}

/// Backing off ends after this long at the latest, microseconds: a round robot needs no more than a few centimetres to
/// turn away, and what stands behind it may be a chair leg that no beam meets.
const BACK_OFF_US: u64 = 320_000;
/// Turning away ends after this long, microseconds.
const TURN_AWAY_US: u64 = 1_200_000;
/// A stuck robot tries again after this long, microseconds: a chair may have been moved.
const STUCK_US: u64 = 60_000_000;
/// Held up by something ahead for this long, the pilot takes the place to be blocked, microseconds.
const PINCH_US: u64 = 1_000_000;
/// Beams clear obstacles in one of so many steps only: a chair leg is hit by few beams and passed by many.
const CLEARING_STEPS: u8 = 4;
/// Half width of the trail of visited cells, in cells.
const TRAIL: i16 = 2;

/// The pilot of a robot with at most `S` range sensors, with a picture of `N` by `N` cells.
#[derive(Clone, Debug)]
pub struct Pilot<const S: usize, const N: usize = 80> {
    config: PilotConfig,
    memory: Memory<N>,
    search: Search,
    /// What the search is at, while it is under way.
    wave: Option<Wave>,
    beams: [Beam; S],
    route: Option<Route>,
    next_route_us: u64,
    activity: Activity,
    /// When the activity began.
    since_us: u64,
    /// Direction of the next turn away: 1 counter-clockwise, -1 clockwise.
    turn_sign: f32,
    patience: Patience,
    confinement: Confinement,
    insistence: Insistence,
    steps: u8,
    /// When the robot was last told to move.
    moving_us: u64,
    rounds: u16,
    given_up: u16,
    battery: Battery,
}

impl<const S: usize, const N: usize> Pilot<S, N> {
    /// One of zeros, which take no flash: to be prepared.
    pub(crate) const ZEROS: Self = Self {
        config: PilotConfig::ZEROS,
        memory: Memory::ZEROS,
        search: Search::ENDED,
        wave: Some(Wave::Clear),
        beams: [Beam::ZEROS; S],
        route: Some(Route::ZEROS),
        next_route_us: 0,
        activity: Activity::Wandering,
        since_us: 0,
        turn_sign: 0.0,
        patience: Patience::ZEROS,
        confinement: Confinement::NONE,
        insistence: Insistence::NONE,
        steps: 0,
        moving_us: 0,
        rounds: 0,
        given_up: 0,
        battery: Battery::ZERO,
    };

    /// A pilot that knows nothing of the home.
    pub fn new(config: PilotConfig, rig: &Rig<S>) -> Self {
        let mut pilot = Self::ZEROS;
        pilot.prepare(config, rig);
        pilot
    }

    /// One of zeros becomes that of this robot, and knows nothing of the home.
    pub(crate) fn prepare(&mut self, config: PilotConfig, rig: &Rig<S>) {
        (self.config, self.beams) = (config, Beam::of_rig(rig));
        self.memory.clear(config.cell_m);
        (self.wave, self.route) = (None, None);
        self.turn_sign = 1.0;
        self.patience = Patience::new();
        self.battery = Battery::UNKNOWN;
    }

    /// The wheel speeds until the next step. A pose that is not finite stops the robot.
    pub fn step(&mut self, senses: &Senses<S>) -> WheelSpeeds {
        let Pose { x_m, y_m, theta_rad } = senses.pose;
        if !(x_m.is_finite() && y_m.is_finite() && theta_rad.is_finite()) {
            return WheelSpeeds::STOP;
        }
        for (beam, range_m) in self.beams.iter_mut().zip(&senses.ranges_m) {
            beam.take(*range_m);
        }
        self.remember(senses);
        let (forward_mps, turn_radps) = self.decide(senses);
        WheelSpeeds::from_twist(forward_mps, turn_radps, self.config.track_m)
    }

    /// Forgets its picture of the home: poses are in another frame from now on.
    pub fn forget(&mut self) {
        self.memory.clear(self.config.cell_m);
        self.route = None;
        self.look_anew();
    }

    /// Takes note of the battery, in each step.
    pub(crate) fn watch_battery(&mut self, condition: &Condition) {
        self.battery.step(condition);
    }

    /// Whether the battery is empty.
    pub(crate) fn is_flat(&self) -> bool {
        self.battery.is_below(FloorConfig::DEFAULT.empty_v)
    }

    /// Stands in a pause, in which somebody may carry it: after it, it looks anew where to go.
    pub(crate) fn stand(&mut self, now_us: u64) {
        self.confinement.forget();
        self.insistence = Insistence::NONE;
        self.patience.renew(now_us);
        (self.activity, self.since_us, self.moving_us) = (Activity::Wandering, now_us, now_us);
        self.look_anew();
    }

    /// What the pilot is doing.
    pub fn activity(&self) -> Activity {
        self.activity
    }

    /// Where the pilot is going, in the estimated frame, metres.
    pub fn target_m(&self) -> Option<[f32; 2]> {
        self.route.map(|route| self.memory.centre_m(route.target))
    }

    /// Rounds completed: how often everything known and reachable had been visited.
    pub fn rounds(&self) -> u16 {
        self.rounds
    }

    /// Targets given up because they could not be reached.
    pub fn given_up(&self) -> u16 {
        self.given_up
    }

    fn remember(&mut self, senses: &Senses<S>) {
        let pose = &senses.pose;
        if self.memory.keep_around(pose) != (0, 0) {
            self.route = None;
            self.look_anew();
        }
        let here = self.memory.cell_at(pose.x_m, pose.y_m);
        if self.memory.visit(here, TRAIL) {
            self.patience.renew(senses.time_us);
        }
        self.memory.stand_on(here);
        self.steps = self.steps.wrapping_add(1);
        let passed = if self.steps.is_multiple_of(CLEARING_STEPS) { Passed::Vanish } else { Passed::Stay };
        for beam in &self.beams {
            if beam.max_m > 0.0 {
                draw_beam(&mut self.memory, beam, pose, &self.config, passed);
            }
        }
    }

    fn decide(&mut self, senses: &Senses<S>) -> (f32, f32) {
        let is_stopped = senses.contacts.any() || senses.condition.is_stalled;
        if is_stopped && !matches!(self.activity, Activity::BackingOff | Activity::Stuck) {
            self.touch(senses);
        }
        self.insistence.step(senses.contacts.touches());
        let elapsed_us = senses.time_us.saturating_sub(self.since_us);
        match self.activity {
            Activity::BackingOff => {
                let gap_m = steer::gap_m(&self.beams, &self.config, true);
                if elapsed_us > BACK_OFF_US && self.insistence.is_for_good() {
                    self.begin(Activity::Stuck, senses);
                } else if elapsed_us > BACK_OFF_US || gap_m < 0.05 {
                    self.begin(Activity::TurningAway, senses);
                }
                (-0.5 * self.config.speed_mps, 0.0)
            }
            Activity::TurningAway => {
                if elapsed_us > TURN_AWAY_US {
                    self.begin(Activity::Wandering, senses);
                    self.look_anew();
                }
                (0.0, 0.7 * self.config.turn_radps * self.turn_sign)
            }
            Activity::Stuck => {
                if elapsed_us > STUCK_US && !self.insistence.is_for_good() {
                    self.confinement.forget();
                    self.begin(Activity::Wandering, senses);
                }
                (0.0, 0.0)
            }
            _ => self.travel(senses),
        }
    }

    fn begin(&mut self, activity: Activity, senses: &Senses<S>) {
        self.activity = activity;
        self.since_us = senses.time_us;
    }

    /// Remembers what was touched and backs off from it.
    fn touch(&mut self, senses: &Senses<S>) {
        let Contacts { bump_left, bump_right, .. } = senses.contacts;
        // Each half of the bumper covers an eighth of a turn; both at once: head on, or a cliff.
        self.block_towards(f32::from(i8::from(bump_left) - i8::from(bump_right)) * 0.6, senses);
        if bump_left != bump_right {
            self.turn_sign = if bump_left { -1.0 } else { 1.0 };
        }
        self.begin(Activity::BackingOff, senses);
    }

    /// Remembers something touching the body in this direction (radians from straight ahead).
    fn block_towards(&mut self, bearing_rad: f32, senses: &Senses<S>) {
        let reach_m = self.config.radius_m + 0.45 * self.config.cell_m;
        let (s, c) = slam_core::angle::sin_cos(bearing_rad);
        let [x_m, y_m] = senses.pose.transform([reach_m * c, reach_m * s]);
        self.memory.block(self.memory.cell_at(x_m, y_m));
    }

    fn travel(&mut self, senses: &Senses<S>) -> (f32, f32) {
        let pose = &senses.pose;
        self.look_for_route(senses);
        if self.activity == Activity::Stuck {
            return (0.0, 0.0);
        }
        let is_there = |route: &Route| route.target == self.memory.cell_at(pose.x_m, pose.y_m);
        let route = match (self.route, self.wave) {
            (None, None) => return self.wander(),
            // It will soon know where to go.
            (None, Some(_)) => return (0.0, 0.0),
            (Some(route), Some(_)) if is_there(&route) => return (0.0, 0.0),
            (Some(route), _) => route,
        };
        if self.patience.is_over(senses.time_us) {
            self.give_up(route, senses);
            return (0.0, 0.0);
        }
        let command = steer::towards(self.way_point_m(&route, pose), pose, &self.beams, &self.config);
        self.watch_pinch(command, senses);
        command
    }

    /// Where the way is blocked by something that the picture does not show, it is put into the picture.
    fn watch_pinch(&mut self, (forward_mps, turn_radps): (f32, f32), senses: &Senses<S>) {
        if forward_mps > 0.1 * self.config.speed_mps || turn_radps.abs() > 0.5 * self.config.turn_radps {
            self.moving_us = senses.time_us;
        }
        if senses.time_us.saturating_sub(self.moving_us) > PINCH_US {
            self.moving_us = senses.time_us;
            self.block_towards(0.0, senses);
            if let Some(Route { count: 1.., first: [next, ..], .. }) = self.route {
                self.memory.block(next);
            }
            self.look_anew();
        }
    }

    /// The farthest of the path's first cells that can be reached in a straight line.
    fn way_point_m(&self, route: &Route, pose: &Pose) -> [f32; 2] {
        let cells = &route.first[..route.count.min(route.first.len())];
        let straight = |cell: &&Cell| self.is_straight(pose, **cell);
        let cell = cells.iter().rev().find(straight).or(cells.first()).copied().unwrap_or(route.target);
        self.memory.centre_m(cell)
    }

    fn is_straight(&self, pose: &Pose, to: Cell) -> bool {
        let [x_m, y_m] = self.memory.centre_m(to);
        (1..=6).all(|step| {
            let share = step as f32 / 6.0;
            let cell = self.memory.cell_at(pose.x_m + share * (x_m - pose.x_m), pose.y_m + share * (y_m - pose.y_m));
            search::is_passable(&self.memory, cell)
        })
    }

    fn give_up(&mut self, route: Route, senses: &Senses<S>) {
        if self.confinement.attempt(&senses.pose, self.config.radius_m) {
            self.begin(Activity::Stuck, senses);
            return;
        }
        self.given_up = self.given_up.saturating_add(1);
        self.memory.visit(route.target, 1);
        self.route = None;
        self.patience.renew(senses.time_us);
        self.turn_sign = -self.turn_sign;
        self.begin(Activity::BackingOff, senses);
    }

    fn wander(&self) -> (f32, f32) {
        if steer::gap_m(&self.beams, &self.config, false) < 0.15 {
            (0.0, 0.7 * self.config.turn_radps * self.turn_sign)
        } else {
            (0.6 * self.config.speed_mps, 0.0)
        }
    }
}

#[cfg(test)]
mod tests;
