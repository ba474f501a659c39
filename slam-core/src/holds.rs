//! Holds: the wheels turn and the robot stays where it is. A cable, a threshold, a chair's leg or a hand holds it.
//!
//! The readings of a held robot stay as they are while its wheels say that they must change. Each reading of a sensor that
//! met a wall is held against two predictions: that of a robot that moved along that wall as its wheels say, and that of one
//! that did not move. The log odds of all sensors are summed for as long as they speak for a hold (Page 1954, cumulative
//! sums), and the other way round while the robot is held. Where no wall tells, readings that stay while it should turn do.

pub mod claim;
pub mod frozen;
pub mod outputs;
pub mod stillness;

use crate::filter::density::density;
use crate::filter::ekf::EkfView;
use crate::filter::layout;
use crate::geometry::angle::{sin_cos, wrap};
use crate::geometry::line::Line;
use crate::geometry::pose::{Pose, length};
use crate::holds::claim::{Claim, Correction, Verdict, WORTH};
use crate::holds::stillness::{Held, Stillness, log_odds_of_staying};
use crate::jolts::confirmation::Confirmation;
use crate::jolts::recent::{self, Recent};
use crate::jolts::search::Scene;
use crate::measurement::beam::Beam;
use crate::measurement::data_association::{CHANGES, change};
use crate::measurement::sensor::Sensor;
use crate::motion::step::{MIDDLE_M, Step};
use crate::report::Outcome;
use crate::sensing::latency::Timing;
use crate::sensing::range::{Reading, SURFACE_M};
use crate::walls::map::MapView;

/// How far a beam's middle moves, metres, and for how long, seconds, until a reading is told from the one before: several
/// times what ranges are known to, and what readings of analogue sensors may be older than others.
const LOOK: (f32, f32) = (0.06, 0.15);

/// How far it moves at most, metres, until a hold is found or there is none, until a robot that is held shows it again, and
/// until a wall that was met is another one.
const REACH_M: f32 = 0.5;

/// Share of a motion that wheels get wrong.
const WHEELS: f32 = 0.2;

/// Walls lie to the robot as the filter has it, to this, metres.
const WALLS_M: f32 = 0.01;

/// Least cosine of the incidence on a wall whose reading says something.
const LEAST_COS: f32 = 0.2;

/// What one sensor can say, as log odds: it may be what it sees that goes with the robot, for as long as it does.
const SENSOR_SAYS: f32 = 6.0;

/// Log of the odds against its end from one look to the next: most last for some of them.
const ENDS: f32 = 3.0;

/// Path after which all is forgotten, metres: sums of single precision are good to a tenth of a millimetre until then.
const LONG_M: f32 = 1000.0;

/// What a sensor met.
#[derive(Clone, Copy, Debug)]
struct Met {
    /// The range then and its standard deviation, metres.
    range_m: f32,
    sigma_m: f32,
    /// The wall that it is of; none for a surface that is not in the map.
    wall: Option<MetWall>,
    /// How far beams had moved, metres, and for how long, seconds.
    at: (f32, f32),
}

/// A wall that a sensor met.
#[derive(Clone, Copy, Debug)]
struct MetWall {
    id: u16,
    /// Its unit normal in the frame of the wheels, and its distance from their start along it, metres.
    normal: [f32; 2],
    rho_m: f32,
}

/// What a sensor has said of a hold, as log odds: by the walls that it met before, and by its last reading.
#[derive(Clone, Copy, Debug)]
struct Witness {
    met: Option<Met>,
    before: f32,
    now: f32,
}

/// Where the robot was when its readings last agreed with what it is taken to do.
#[derive(Clone, Copy, Debug)]
struct Moment {
    map: Pose,
    wheels: Pose,
    at_m: f32,
}

/// What is watched.
#[derive(Clone, Copy, Debug)]
enum Watch {
    Nothing,
    /// What readings say since then.
    Since(Moment),
    /// Whether readings of other places confirm this.
    Claim(Claim),
}

/// Whether the robot is held, and what speaks for it.
#[derive(Clone, Debug)]
pub struct Holds<const S: usize> {
    witnesses: [Witness; S],
    /// The pose by the wheels alone, and the sine and cosine of its heading.
    wheels: Pose,
    heading: (f32, f32),
    /// How far beams moved by them, metres, and for how long, seconds.
    at: (f32, f32),
    watch: Watch,
    stillness: Stillness<S>,
    is_held: bool,
}

impl<const S: usize> Holds<S> {
    /// A robot that moves as its wheels do.
    pub const NONE: Self = Self {
        witnesses: [Witness::NONE; S],
        wheels: Pose::ORIGIN,
        heading: (0.0, 1.0),
        at: (0.0, 0.0),
        watch: Watch::Nothing,
        stillness: Stillness::NONE,
        is_held: false,
    };

    /// Whether the robot stays where it is, whatever its wheels do.
    pub fn is_held(&self) -> bool {
        self.is_held
    }

    /// Forgets what was seen: where the robot is in the map is another place, or the map another one.
    pub fn forget(&mut self) {
        self.begin_anew(self.is_held);
        self.stillness = Stillness::NONE;
    }

    /// The map has the robot here, and no longer there, and every place on its way with it. What readings said still holds.
    pub fn go_with(&mut self, from: &Pose, to: &Pose) {
        let moved = |pose: &Pose| to.compose(&from.inverse().compose(pose));
        match &mut self.watch {
            Watch::Nothing => {}
            Watch::Since(moment) => moment.map = moved(&moment.map),
            Watch::Claim(claim) => claim.correction.pose = moved(&claim.correction.pose),
        }
        self.stillness.go_with(moved);
    }

    /// Whether it is held is known, and walls are to speak anew.
    #[inline(never)]
    fn begin_anew(&mut self, is_held: bool) {
        self.witnesses = [Witness::NONE; S];
        (self.wheels, self.heading, self.at) = (Pose::ORIGIN, (0.0, 1.0), (0.0, 0.0));
        (self.watch, self.is_held) = (Watch::Nothing, is_held);
    }

    /// What these sensors said of readings that stay, a bit each, is forgotten: they stay the same while the robot moves.
    pub fn forget_stillness(&mut self, sensors: u16) {
        if sensors != 0 {
            self.stillness.forget(sensors);
        }
    }

    /// Whether the robot did not turn of late, whatever its wheels said.
    pub fn is_unturned(&self) -> bool {
        self.stillness.is_unturned()
    }

    /// Whether it seems to be held. Until that is confirmed readings are used as before, for most such signs are none of a hold.
    pub fn is_claimed(&self) -> bool {
        matches!(self.watch, Watch::Claim(_))
    }

    /// Follows the wheels by a motion in the robot's frame.
    pub fn follow(&mut self, motion: &Pose, dt_s: f32) {
        let moved_m = length(motion.x_m, motion.y_m) + MIDDLE_M * motion.theta_rad.abs();
        if moved_m > 0.0 {
            self.stillness.follow(motion, moved_m);
            let ((s, c), Pose { x_m, y_m, theta_rad }) = (self.heading, self.wheels);
            let [ahead_m, left_m] = [motion.x_m, motion.y_m];
            let at_m = [x_m + c * ahead_m - s * left_m, y_m + s * ahead_m + c * left_m];
            self.wheels = Pose::new(at_m[0], at_m[1], theta_rad + motion.theta_rad);
            self.heading = sin_cos(self.wheels.theta_rad);
            self.at = (self.at.0 + moved_m, self.at.1 + dt_s);
        }
        if self.at.0 > LONG_M {
            self.forget();
        }
    }

    /// Takes in a reading and what became of it.
    pub fn note(
        &mut self,
        sensor: &Sensor,
        reading: &Reading,
        timing: &Timing,
        (ekf, map): (&EkfView, &MapView),
        outcome: &Outcome,
    ) {
        let gain = sensor.state.gain(ekf);
        let (range_m, sigma_m) = (reading.range_m / gain, reading.sigma_m());
        self.stillness.note(sensor, range_m, sigma_m);
        if self.is_claimed() {
            return;
        }
        let Some(witness) = self.witnesses.get_mut(sensor.index) else { return };
        let wall = match outcome {
            Outcome::Updated { wall, innovation_m, .. } => Some((*wall, *innovation_m)),
            _ => None,
        };
        let is_other = |met: &Met| met.wall.is_some_and(|met| wall.is_some_and(|(id, _)| id != met.id));
        let is_too_soon = |met: &Met| self.at.0 - met.at.0 < LOOK.0 || self.at.1 - met.at.1 < LOOK.1;
        if witness.met.as_ref().is_some_and(|met| !is_other(met) && is_too_soon(met)) {
            return;
        }
        let mount = sensor.state.mount_then(&sensor.limits.model, timing, ekf);
        let beam = mount.beam([self.wheels.x_m, self.wheels.y_m], self.heading);
        if let Some(met) = &witness.met {
            let moved_m = self.at.0 - met.at.0;
            if is_other(met) {
                witness.now = 0.0;
            } else if moved_m > REACH_M {
                *witness = Witness::NONE;
            } else {
                let span_m = sensor.limits.span_m();
                witness.now = met.log_odds(&beam, range_m, sigma_m, moved_m, span_m);
            }
        }
        let before = witness.says();
        let mut met = Met { range_m, sigma_m, wall: None, at: self.at };
        if let Some((id, innovation_m)) = wall {
            let Some(wall) = map.walls().iter().find(|other| other.id == id) else { return };
            let (s, c) = sin_cos(wrap(wall.beta_rad(ekf) + self.wheels.theta_rad - ekf.mean(layout::THETA)));
            let normal = [c, s];
            // Where the filter expected the wall, which is better known than by one reading.
            (met.range_m, met.sigma_m) = ((reading.range_m - innovation_m) / gain, WALLS_M);
            let [hit_x, hit_y] = beam.at(met.range_m);
            met.wall = Some(MetWall { id, normal, rho_m: hit_x * normal[0] + hit_y * normal[1] });
        } else if witness.met.is_some_and(|met| met.wall.is_some()) {
            // The wall is waited for.
            return;
        }
        *witness = Witness { met: Some(met), before, now: 0.0 };
    }

    /// Takes in that a sensor sees nothing within its reach.
    pub fn note_absence(&mut self, sensor: &Sensor) {
        self.stillness.note_absence(sensor);
    }

    /// Judges by all readings so far, with the pose after the last of them, in the step of this number. That the robot is held has
    /// to be confirmed; one that is held and says so no more is not.
    pub fn judge(&mut self, map: Pose, number: u32) -> Option<Correction> {
        self.stillness.settle(map);
        if let Some(Held { pose, in_doubt }) = self.stillness.held_at().filter(|_| !self.is_held) {
            self.begin_anew(true);
            return Some(Correction { pose, in_doubt, is_held: true });
        }
        if self.is_claimed() {
            return None;
        }
        let said: f32 = self.witnesses.iter().map(Witness::says).sum();
        self.settle(said);
        let now = Moment { map, wheels: self.wheels, at_m: self.at.0 };
        let moment = if let Watch::Since(moment) = self.watch { moment } else { now };
        let since_m = now.at_m - moment.at_m;
        let agrees = if self.is_held { said > 0.0 } else { said <= 0.0 };
        let moment = if agrees && since_m > LOOK.0 { now } else { moment };
        self.watch = Watch::Since(moment);
        let has_changed = if self.is_held {
            !self.stillness.is_still() && (said < -ENDS || since_m > REACH_M && !agrees)
        } else {
            said > WORTH
        };
        if !has_changed {
            if since_m > REACH_M {
                self.begin_anew(self.is_held);
            }
            return None;
        }
        let moved = moment.wheels.inverse().compose(&self.wheels);
        let from = if self.is_held { map } else { moment.map };
        let to = from.compose(&moved);
        // Half of it was driven, give or take the other half.
        let in_doubt = [to.x_m - from.x_m, to.y_m - from.y_m, moved.theta_rad].map(|moved| 0.5 * moved);
        if self.is_held {
            self.begin_anew(false);
            self.stillness = Stillness::NONE;
            return Some(Correction { pose: to, in_doubt, is_held: false });
        }
        let begun = self.stillness.begun(since_m + 0.5 * REACH_M);
        let Held { pose, in_doubt } = begun.unwrap_or(Held { pose: from, in_doubt });
        let correction = Correction { pose, in_doubt, is_held: true };
        self.watch = Watch::Claim(Claim { correction, confirmation: Confirmation::since(number) });
        None
    }

    /// Goes on with the confirmation where the robot seems to be held, for as long as no reading changes.
    pub fn confirm(&mut self, scene: &Scene, recent: &Recent, moment: &recent::Moment) -> Option<Correction> {
        let Watch::Claim(claim) = &self.watch else { return None };
        if self.stillness.is_changed() {
            self.begin_anew(false);
            return None;
        }
        let Verdict { is_held, found } = claim.verdict(scene, recent, moment, self.stillness.is_witnessed())?;
        self.begin_anew(is_held);
        found
    }

    /// Time goes on by so much, seconds, to the step of this number.
    pub fn wait(&mut self, dt_s: f32, step: &Step, number: u32) {
        if let Watch::Claim(claim) = &mut self.watch {
            claim.confirmation.wait(dt_s, step, number);
        }
    }

    /// What was said before tells no more where all of it speaks for what the robot is taken to do.
    fn settle(&mut self, said: f32) {
        if !self.is_held && said < -ENDS {
            self.witnesses = [Witness::NONE; S];
        } else if self.is_held && said >= 0.0 || !self.is_held && said <= 0.0 {
            for witness in &mut self.witnesses {
                witness.before = 0.0;
            }
        }
    }
}

impl Witness {
    const NONE: Self = Self { met: None, before: 0.0, now: 0.0 };

    fn says(&self) -> f32 {
        (self.before + self.now).clamp(-SENSOR_SAYS, SENSOR_SAYS)
    }
}

impl Met {
    /// Log odds of a robot that did not move against one that moved as its wheels say, by a range since.
    fn log_odds(&self, beam: &Beam, range_m: f32, sigma_m: f32, moved_m: f32, span_m: f32) -> f32 {
        let (off_m, noise_m2) =
            (range_m - self.range_m, self.sigma_m * self.sigma_m + sigma_m * sigma_m + SURFACE_M * SURFACE_M);
        let likelihood = |off_m, variance_m2, other| (1.0 - other) * density(off_m, variance_m2) + other / span_m;
        let stays = likelihood(off_m, noise_m2, CHANGES.0);
        let Some(wall) = &self.wall else {
            // What is not known to lie across the way may lie along it: its range may stay, but not change.
            let moves = likelihood(off_m, noise_m2 + moved_m * moved_m, CHANGES.0);
            return libm::logf(stays / moves).min(0.0);
        };
        let line = Line { rho_m: wall.rho_m, beta_rad: 0.0, normal: wall.normal };
        if beam.cos_incidence(&line) < LEAST_COS {
            return 0.0;
        }
        let change_m = beam.predict(&line).range_m - self.range_m;
        let wheels_m = WHEELS * change_m;
        let moves = likelihood(off_m - change_m, noise_m2 + wheels_m * wheels_m, change(moved_m));
        log_odds_of_staying(stays, moves)
    }
}
