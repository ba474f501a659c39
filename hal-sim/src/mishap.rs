//! What befalls the robot and no encoder tells: it is carried, kicked, held, turned by a rug, or tilted by a sill; and what of it fails.

use crate::body::Body;
use crate::fault::Fault;
use crate::options::SimOptions;
use crate::plan::{Plan, Room};
use crate::pose::Pose2;
use crate::rng::Rng;
use crate::world::World;

/// Somebody lifts the robot, carries it and puts it down. The wheel-drop switches tell that it is off the floor; its sensors
/// see nothing meanwhile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kidnap {
    /// When it is lifted, seconds since the start.
    pub at_s: f64,
    /// How long it is off the floor, seconds.
    pub carried_s: f64,
    /// Where it is put down, in the plan's frame; a free place in one of the plan's rooms, drawn from the seed, where not given.
    pub to: Option<Pose2>,
}

/// Something moves and turns the robot at once, on the floor, its wheels sliding: a kick, a door.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kick {
    /// When, seconds since the start.
    pub at_s: f64,
    /// How far it slides, metres, in a direction drawn from the seed; walls stop it.
    pub slide_m: f64,
    /// How far it turns, radians; to which side is drawn from the seed.
    pub turn_rad: f64,
}

/// A rug: as the robot drives onto it, one wheel climbs the edge before the other, and it turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rug {
    /// Lower corner, metres.
    pub min_m: [f64; 2],
    /// Upper corner, metres.
    pub max_m: [f64; 2],
    /// How far the robot turns over the next [`RUG_EDGE_M`], radians; to which side is drawn from the seed each time.
    pub turn_rad: f64,
}

/// A sill: as the robot drives onto it and off it, a wheel hangs for a moment, and the robot tilts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sill {
    /// Lower corner, metres.
    pub min_m: [f64; 2],
    /// Upper corner, metres.
    pub max_m: [f64; 2],
    /// For how long the wheel hangs each time, seconds. The switch tells at once, and the robot sees nothing meanwhile.
    pub hangs_s: f64,
}

/// Something holds the robot, and its wheels turn on the spot or stand: a cable, a threshold, a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Its wheels are held, too: the motors stall.
    pub is_jammed: bool,
    /// From when, seconds since the start.
    pub at_s: f64,
    /// For how long, seconds.
    pub held_s: f64,
}

/// Travel over which a rug's edge turns the robot, metres.
pub const RUG_EDGE_M: f64 = 0.1;

/// How long a wheel hangs over a sill where nobody says, seconds: over ten centimetres at 0.3 m/s.
pub const HANGS_S: f64 = 0.3;

/// A kick moves the robot in steps of this, metres, so that no wall is jumped over.
const SLIDE_STEP_M: f64 = 0.01;

/// A drawn place has this much room beyond the robot's body, metres.
const MARGIN_M: f64 = 0.02;

/// Draws of a place until a plan counts as full.
const DRAWS: usize = 1000;

/// Everything that befalls a robot in a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mishaps {
    /// Carried.
    pub kidnaps: Vec<Kidnap>,
    /// Kicked.
    pub kicks: Vec<Kick>,
    /// Turned.
    pub rugs: Vec<Rug>,
    /// Tilted.
    pub sills: Vec<Sill>,
    /// Held.
    pub holds: Vec<Hold>,
    /// Parts of it that fail.
    pub faults: Vec<Fault>,
}

/// The mishaps of one drive as they come.
#[derive(Clone, Debug)]
pub(crate) struct Fate {
    mishaps: Mishaps,
    rooms: Vec<Room>,
    places: Rng,
    kicks: Rng,
    rugs: Rng,
    on_rug: Vec<bool>,
    on_sill: Vec<bool>,
    /// A wheel hangs over a sill until then, seconds.
    hangs_until_s: f64,
    /// What was due up to then has befallen the robot, seconds.
    until_s: f64,
    /// What is left of a rug's turn, radians, and how much of it comes a metre.
    turn_left_rad: f64,
    turn_per_m: f64,
}

impl Fate {
    pub(crate) fn new(mishaps: &Mishaps, rooms: &[Room], seed: u64) -> Self {
        Self {
            mishaps: mishaps.clone(),
            rooms: rooms.to_vec(),
            places: Rng::stream(seed, "kidnap", 0),
            kicks: Rng::stream(seed, "kick", 0),
            rugs: Rng::stream(seed, "rug", 0),
            on_rug: vec![false; mishaps.rugs.len()],
            on_sill: vec![false; mishaps.sills.len()],
            hangs_until_s: f64::NEG_INFINITY,
            until_s: f64::NEG_INFINITY,
            turn_left_rad: 0.0,
            turn_per_m: 0.0,
        }
    }

    /// Adds what befalls the robot beyond what the plan had in store.
    pub(crate) fn add(&mut self, more: Mishaps) {
        self.mishaps.kidnaps.extend(more.kidnaps);
        self.mishaps.kicks.extend(more.kicks);
        self.mishaps.holds.extend(more.holds);
        self.mishaps.faults.extend(more.faults);
        self.on_sill.extend(more.sills.iter().map(|_| false));
        self.mishaps.sills.extend(more.sills);
        self.on_rug.extend(more.rugs.iter().map(|_| false));
        self.mishaps.rugs.extend(more.rugs);
    }

    /// From now on the robot, which is here, is in this plan: its rooms, rugs and sills. What is due at a time stays so.
    pub(crate) fn furnish(&mut self, plan: &Plan, here: &Pose2) {
        self.rooms.clone_from(&plan.rooms);
        self.mishaps.rugs.clone_from(&plan.mishaps.rugs);
        self.mishaps.sills.clone_from(&plan.mishaps.sills);
        self.on_rug = self.mishaps.rugs.iter().map(|rug| is_within(here, rug.min_m, rug.max_m)).collect();
        self.on_sill = self.mishaps.sills.iter().map(|sill| is_within(here, sill.min_m, sill.max_m)).collect();
    }

    /// Whether nothing ever happens.
    pub(crate) fn is_kind(&self) -> bool {
        self.mishaps == Mishaps::default()
    }

    /// Before a step of the physics that ends at `end_s`: what the wheels can do in it.
    pub(crate) fn hold(&self, body: &mut Body, end_s: f64) {
        let during = |from_s: f64, for_s: f64| (from_s..from_s + for_s).contains(&end_s);
        let is_carried = self.mishaps.kidnaps.iter().any(|kidnap| during(kidnap.at_s, kidnap.carried_s));
        body.contacts.lifted = is_carried || end_s < self.hangs_until_s;
        let mut holds = self.mishaps.holds.iter().filter(|hold| during(hold.at_s, hold.held_s)).peekable();
        body.is_held = holds.peek().is_some() || is_carried;
        body.is_jammed = holds.any(|hold| hold.is_jammed);
    }

    /// After that step, which began at `before`: what moved the robot besides its wheels.
    pub(crate) fn befall(&mut self, body: &mut Body, before: &Pose2, end_s: f64, world: &World, options: &SimOptions) {
        // From where the last step ended: time is set to the samples', and a step's own begin would leave gaps.
        let begin_s = core::mem::replace(&mut self.until_s, end_s);
        let now = |at_s: f64| begin_s < at_s && at_s <= end_s;
        for kidnap in &self.mishaps.kidnaps {
            if now(kidnap.at_s + 0.5 * kidnap.carried_s) {
                let place = kidnap.to.or_else(|| free_place(&self.rooms, &mut self.places, world, options));
                body.put(place.unwrap_or(body.pose));
            }
        }
        for kick in &self.mishaps.kicks {
            if now(kick.at_s) {
                let (s, c) = libm::sincos(self.kicks.uniform(0.0, core::f64::consts::TAU));
                let steps = libm::ceil(kick.slide_m / SLIDE_STEP_M).max(1.0);
                let step_m = kick.slide_m / steps;
                body.put(Pose2 { theta_rad: body.pose.theta_rad + sign(&mut self.kicks) * kick.turn_rad, ..body.pose });
                for _ in 0..steps as usize {
                    body.slide([step_m * c, step_m * s], world, options);
                }
            }
        }
        self.turn_on_rugs(body, before);
        for (sill, was_on) in self.mishaps.sills.iter().zip(&mut self.on_sill) {
            let is_on = is_within(&body.pose, sill.min_m, sill.max_m);
            if core::mem::replace(was_on, is_on) != is_on {
                self.hangs_until_s = end_s + sill.hangs_s;
            }
        }
    }

    /// Parts that fail.
    pub(crate) fn faults(&self) -> &[Fault] {
        &self.mishaps.faults
    }

    fn turn_on_rugs(&mut self, body: &mut Body, before: &Pose2) {
        let Pose2 { x_m, y_m, theta_rad } = body.pose;
        for (rug, was_on) in self.mishaps.rugs.iter().zip(&mut self.on_rug) {
            let is_on = is_within(&body.pose, rug.min_m, rug.max_m);
            if is_on && !*was_on {
                self.turn_left_rad = sign(&mut self.rugs) * rug.turn_rad;
                self.turn_per_m = rug.turn_rad.abs() / RUG_EDGE_M;
            }
            *was_on = is_on;
        }
        let most_rad = self.turn_per_m * libm::hypot(x_m - before.x_m, y_m - before.y_m);
        let turn_rad = self.turn_left_rad.clamp(-most_rad, most_rad);
        self.turn_left_rad -= turn_rad;
        body.pose.theta_rad = theta_rad + turn_rad;
    }
}

/// Whether the axle is within a rectangle.
fn is_within(pose: &Pose2, min_m: [f64; 2], max_m: [f64; 2]) -> bool {
    (min_m[0]..=max_m[0]).contains(&pose.x_m) && (min_m[1]..=max_m[1]).contains(&pose.y_m)
}

/// Left or right, each as likely.
fn sign(rng: &mut Rng) -> f64 {
    if rng.unit() < 0.5 { -1.0 } else { 1.0 }
}

/// A place in one of the rooms where the robot's body has room, and a heading; none where there is none.
pub fn free_place(rooms: &[Room], rng: &mut Rng, world: &World, options: &SimOptions) -> Option<Pose2> {
    (0..DRAWS).find_map(|_| {
        let room = rooms.get((rng.unit() * rooms.len() as f64) as usize)?;
        let [x_m, y_m] = [0, 1].map(|axis| rng.uniform(room.min_m[axis], room.max_m[axis]));
        let theta_rad = rng.uniform(-core::f64::consts::PI, core::f64::consts::PI);
        let is_free = world.is_inside([x_m, y_m]) && world.clearance_m([x_m, y_m]) > options.body_radius_m + MARGIN_M;
        is_free.then(|| Pose2::new(x_m, y_m, theta_rad))
    })
}
