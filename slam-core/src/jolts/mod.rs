//! Jolts: displacements of the robot that its wheels do not tell. Somebody kicks it, or a door hits it.
//!
//! A jolt shows in readings that miss their walls all at once: a sensor that comes to the end of a wall, to a chair or to a
//! person does so alone. Where several turn from hits to misses together, the readings since are held against the map twice,
//! with the pose as it is and with the displaced one under which they fit best, and none of them is used meanwhile. The
//! robot is taken to be displaced where that is so much likelier that no chance of an hour explains it (a generalised
//! likelihood ratio test for jumps, Willsky and Jones 1976, with the likelihood of readings that may be of anything).

pub mod confirmation;
pub mod recent;
pub mod search;

use crate::jolts::confirmation::{Confirmation, SURE, TRIAL_S};
use crate::jolts::recent::{Moment, Recent, Seen};
use crate::jolts::search::{Displacement, JOLT, STARTS, Scene, WALL_SAYS};
use crate::measurement::data_association::change;
use crate::motion::step::Step;
use crate::report::Outcome;

/// Time between two looks at a sensor, seconds: a robot at walking pace sees another place of the wall by then.
const LOOK_S: f32 = 0.15;

/// Time within a look until every sensor that sees something has been looked at, seconds: two readings of an analogue one.
const WHOLE_S: f32 = 0.08;

/// Chance that a sensor of a displaced robot changes.
const DISPLACED: f32 = 0.6;

/// Log of the odds against a jolt between two looks: one in an hour of driving.
const RARE: f32 = 10.1;

/// Log of the odds of a jolt by sensors that change at once from which on a displacement is looked for, four to one: one sensor of one,
/// where seldom one changes.
const WORTH: f32 = 1.4;

/// The same where searches have taken more than their [`SHARE`] of the time: fifty to one, two sensors of two.
const WORTH_ALWAYS: f32 = 4.0;

/// Share of the time that searches after weak signs may take, for no reading is used meanwhile; and by how much they may be ahead of
/// it, seconds. Where much stands about that is not in the map such signs come often, and tell little.
const SHARE: f32 = 0.02;
const AHEAD_S: f32 = 1.0;

/// What became of the sensors at a look, a bit each.
#[derive(Clone, Copy, Debug, Default)]
struct Look {
    asked: u16,
    hit: u16,
    missed: u16,
}

/// Readings that may be of a displaced robot.
#[derive(Clone, Copy, Debug)]
struct Trial {
    /// Step since which they count.
    onset: u32,
    /// Log of the odds of a jolt by sensors that changed at once.
    told: f32,
    /// For how long, seconds.
    for_s: f32,
    /// The next start of the search.
    start: u16,
    /// The best displacement of this round.
    best: Displacement,
    /// Log odds of the best of this round's others.
    other: f32,
    /// Where the robot was, metres, when the best was found likely enough, and the wait for its confirmation; none until then.
    found: Option<([f32; 2], Confirmation)>,
}

/// What speaks for a jolt, and the search for the displacement.
#[derive(Clone, Debug)]
pub struct Jolts {
    recent: Recent,
    /// Time since this look began, seconds, and its step.
    since_s: f32,
    begun: u32,
    /// How far beams moved in it, and from the last one to it, metres.
    moved_m: f32,
    between_m: f32,
    before: Look,
    now: Look,
    trial: Option<Trial>,
    /// Time that searches took beyond their share, seconds.
    taken_s: f32,
}

impl Jolts {
    /// Nothing was seen.
    pub const NONE: Self = {
        let look = Look { asked: 0, hit: 0, missed: 0 };
        Self {
            recent: Recent::NONE,
            since_s: 0.0,
            begun: 0,
            moved_m: 0.0,
            between_m: 0.0,
            before: look,
            now: look,
            trial: None,
            taken_s: 0.0,
        }
    };

    /// Time goes on by so much, seconds, to the step of this number.
    // Inlined, it costs a step 130 instructions elsewhere.
    #[inline(never)]
    pub fn wait(&mut self, dt_s: f32, step: &Step, number: u32) {
        self.since_s += dt_s;
        self.moved_m += step.beams_moved_m();
        if self.since_s >= LOOK_S {
            (self.since_s, self.begun) = (0.0, number);
            self.between_m = core::mem::take(&mut self.moved_m);
            self.before = core::mem::take(&mut self.now);
        }
        if let Some(trial) = &mut self.trial {
            self.taken_s += dt_s;
            trial.wait(dt_s, step, number);
        }
        if self.taken_s > 0.0 {
            self.taken_s -= SHARE * dt_s;
        }
    }

    /// Whether it is in doubt where the robot is, so that readings are not to be used.
    pub fn is_in_doubt(&self) -> bool {
        self.trial.is_some()
    }

    /// Whether the sensor of this index is to be looked at now.
    pub fn asks(&self, sensor: usize) -> bool {
        self.now.asked & (1 << (sensor & 15)) == 0
    }

    /// Takes in a reading of the sensor of this index and what became of it.
    pub fn note(&mut self, sensor: usize, seen: Seen, outcome: &Outcome) {
        self.recent.push(seen);
        let bit = 1 << (sensor & 15);
        self.now.asked |= bit;
        match outcome {
            Outcome::Updated { .. } => self.now.hit |= bit,
            Outcome::Gated { .. } => self.now.missed |= bit,
            _ => {}
        }
    }

    /// Whether every sensor had time for a new reading since this look began: one that holds its readings has one in 48 ms.
    fn is_whole(&self) -> bool {
        self.since_s >= WHOLE_S
    }

    /// Log of the odds of a jolt since the last look, by how many of its sensors changed.
    fn told(&self) -> f32 {
        let (usual, after) = (change(self.between_m + self.moved_m), DISPLACED);
        let (before, now) = (&self.before, &self.now);
        let kept = (before.hit & now.hit | before.missed & now.missed).count_ones();
        let changed = (before.hit & !now.hit | before.missed & !now.missed).count_ones();
        changed as f32 * libm::logf(after / usual) + kept as f32 * libm::logf((1.0 - after) / (1.0 - usual))
    }

    /// A reason to look for a displacement: sensors that changed at once, with one that misses its wall now among them.
    fn suspect(&self) -> Option<Trial> {
        if self.before.hit & self.now.missed == 0 || !self.is_whole() {
            return None;
        }
        let told = self.told();
        let trial = Trial {
            onset: self.begun,
            told,
            for_s: 0.0,
            start: 0,
            best: Displacement::start(0),
            other: f32::NEG_INFINITY,
            found: None,
        };
        (told > self.worth()).then_some(trial)
    }

    /// Log of the odds by sensors that change at once from which on a displacement is looked for now.
    fn worth(&self) -> f32 {
        if self.taken_s > AHEAD_S { WORTH_ALWAYS } else { WORTH }
    }

    /// Goes on with the search where there is reason to: one of its starts a step. The displacement, once it is likely enough, and once
    /// readings that it was not looked for in say so, too.
    pub fn search(&mut self, scene: &Scene, moment: &Moment) -> Option<Displacement> {
        // A step that updates with readings does not search, and one that searches does so once: each costs what it can.
        let Some(trial) = &mut self.trial else {
            self.trial = self.suspect();
            return None;
        };
        if let Some(([x_m, y_m], confirmation)) = trial.found {
            let found = trial.best.seen_from([moment.map.x_m - x_m, moment.map.y_m - y_m]);
            let readings = self.recent.since(confirmation.onset(), moment);
            let said = scene.said_of(&readings, &found);
            // With those that it was found by, as many as would do if one sensor were deceived.
            let takes = RARE + SURE + WALL_SAYS - found.log_odds - trial.told;
            // A robot that stands will not see other places, and where even the same ones speak against it, it is not so.
            let is_so = confirmation.verdict(said, takes.max(0.0))? || confirmation.stands() && said >= -SURE;
            self.give_up();
            return is_so.then_some(found);
        }
        let readings = self.recent.since(trial.onset, moment);
        let is_late = trial.for_s > TRIAL_S;
        if usize::from(trial.start) < STARTS {
            trial.rank(scene.improve(&readings, &Displacement::start(trial.start.into()), &JOLT));
            trial.start += 1;
            return None;
        }
        // With the readings of the last steps.
        let best = core::mem::replace(&mut trial.best, Displacement::start(0));
        let best = scene.improve(&readings, &best, &JOLT);
        let other = core::mem::replace(&mut trial.other, f32::NEG_INFINITY);
        trial.start = 0;
        let log_odds = best.log_odds + trial.told;
        let is_sure = log_odds > RARE + SURE && best.log_odds > other + SURE && best.is_apart_from(&Displacement::NONE);
        if is_sure {
            trial.best = best;
            trial.found = Some(([moment.map.x_m, moment.map.y_m], Confirmation::since(trial.onset)));
        } else if is_late || log_odds < SURE {
            self.give_up();
        }
        None
    }

    /// Ends the search, if there is one.
    fn give_up(&mut self) {
        self.trial = None;
        self.now = Look::default();
    }

    /// The readings of the last moments.
    pub fn recent(&self) -> &Recent {
        &self.recent
    }
}

impl Trial {
    /// Time goes on.
    fn wait(&mut self, dt_s: f32, step: &Step, number: u32) {
        match &mut self.found {
            Some((_, confirmation)) => confirmation.wait(dt_s, step, number),
            None => self.for_s += dt_s,
        }
    }

    /// Keeps the best displacement of this round, and how likely the best of the others is.
    fn rank(&mut self, found: Displacement) {
        let best = self.best;
        let [better, worse] = if found.log_odds > best.log_odds { [found, best] } else { [best, found] };
        if better.is_apart_from(&worse) {
            self.other = self.other.max(worse.log_odds);
        }
        self.best = better;
    }
}
