//! Jolts: displacements of the robot that its wheels do not tell. Somebody kicks it, or a door hits it.
//!
//! A jolt shows in readings that miss their walls all at once: a sensor that comes to the end of a wall, to a chair or to a
//! person does so alone. Where several turn from hits to misses together, the readings since are held against the map twice,
//! with the pose as it is and with the displaced one under which they fit best, and none of them is used meanwhile. A robot
//! that saw no wall when it was displaced, or one or two, has nothing to turn: so one is looked for, too, beside the filter that goes on,
//! where half of the last readings fit no wall. The robot is taken to be displaced where that is so much likelier that no chance
//! of an hour explains it (a generalised likelihood ratio test for jumps, Willsky and Jones 1976, with the likelihood of
//! readings that may be of anything).

pub mod confirmation;
pub mod recent;
pub mod search;

use crate::jolts::confirmation::{Confirmation, SURE, TRIAL_S};
use crate::jolts::recent::{Moment, READINGS, Recent, Seen};
use crate::jolts::search::{
    Displacement, ELSE, Improvement, JOLT, Packed, STARTS, STEP_HOLDS, Scene, WALL_SAYS, are_apart,
};
use crate::measurement::data_association::change;
use crate::motion::step::Step;
use crate::report::{Outcome, Refusal};

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

/// What is looked for beside the filter may have been at any look of the last ten seconds: so much likelier, as a logarithm, than at one.
const LONG_AGO: f32 = 4.2;

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
    stage: Stage,
}

/// How far a trial has come.
#[derive(Clone, Copy, Debug)]
enum Stage {
    /// A displacement is looked for, and readings are used meanwhile.
    Aside(Round),
    /// The same, and none is used.
    Searching(Round),
    /// One was found, about the map's origin, and waits for its confirmation.
    Found(Packed, Confirmation),
}

/// A search from every start.
#[derive(Clone, Copy, Debug)]
struct Round {
    /// Number of starts that were searched from.
    starts: u8,
    /// The search from the next one, and last from the best.
    improvement: Improvement,
    /// The best displacement so far, and the log of its odds.
    best: ([f32; 3], f32),
    /// Log odds of the best of the others.
    other: f32,
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
    /// Whether the last readings fitted a wall, a bit each, the last one lowest.
    fitted: u32,
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
            fitted: u32::MAX,
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
        if let Some(trial) = &mut self.trial
            && !trial.is_aside()
        {
            self.taken_s += dt_s;
            trial.wait(dt_s, step, number);
        }
        if self.taken_s > 0.0 {
            self.taken_s -= SHARE * dt_s;
        }
    }

    /// Whether it is in doubt where the robot is, so that readings are not to be used.
    pub fn is_in_doubt(&self) -> bool {
        self.trial.as_ref().is_some_and(|trial| !trial.is_aside())
    }

    /// Whether the sensor of this index is to be looked at now.
    pub fn asks(&self, sensor: usize) -> bool {
        self.now.asked & (1 << (sensor & 15)) == 0
    }

    /// Takes in a reading of the sensor of this index and what became of it.
    pub fn note(&mut self, sensor: usize, seen: Seen, outcome: &Outcome) {
        let bit = 1 << (sensor & 15);
        self.now.asked |= bit;
        // A reading that is folded back says nothing of where the robot is.
        if !matches!(outcome, Outcome::Refused(Refusal::FoldBack)) {
            self.recent.push(seen);
        }
        match outcome {
            Outcome::Updated { .. } => self.now.hit |= bit,
            Outcome::Gated { .. } => self.now.missed |= bit,
            _ => {}
        }
        if let Outcome::Updated { .. } | Outcome::Gated { .. } | Outcome::Unexplained = outcome {
            self.fitted = self.fitted << 1 | u32::from(matches!(outcome, Outcome::Updated { .. }));
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
        (told > self.worth()).then(|| Trial::new(self.begun, told, Stage::Searching(Round::NEW)))
    }

    /// A reason to look for one beside the filter: half of the last readings fit no wall.
    fn misfit(&self) -> Option<Trial> {
        (2 * self.misfits() > READINGS as u32)
            .then(|| Trial::new(self.recent.oldest(), LONG_AGO, Stage::Aside(Round::NEW)))
    }

    /// Number of the last readings that fit no wall.
    fn misfits(&self) -> u32 {
        READINGS as u32 - (self.fitted & ((1 << READINGS) - 1)).count_ones()
    }

    /// Share of the last readings that fit no wall, by the rule of succession, and what it is elsewhere at least. Among people or things that are
    /// in no map a robot that is not displaced has nothing but such readings.
    pub fn others(&self) -> f32 {
        ((self.misfits() + 1) as f32 / (READINGS + 2) as f32).max(ELSE)
    }

    /// Log of the odds by sensors that change at once from which on a displacement is looked for now.
    fn worth(&self) -> f32 {
        if self.taken_s > AHEAD_S { WORTH_ALWAYS } else { WORTH }
    }

    /// Goes on with the search where there is reason to, by what a step that has time for so many turns can do. The displacement, once it is likely enough, and once
    /// readings that it was not looked for in say so, too. No reading `updated` the state in this step, or some did.
    pub fn search(&mut self, scene: &Scene, moment: &Moment, updated: bool, turns: usize) -> Option<Displacement> {
        if self.trial.as_ref().is_none_or(Trial::is_aside)
            && let Some(trial) = self.suspect()
        {
            self.trial = Some(trial);
            return None;
        }
        // A step that updates with readings does not search, and one that searches does so once: each costs what it can.
        if updated {
            return None;
        }
        if self.trial.is_none() {
            self.trial = self.misfit();
        }
        let trial = self.trial.as_mut()?;
        let at_m = [moment.map.x_m, moment.map.y_m];
        let readings = self.recent.since(trial.counts_from(), moment);
        let round = match &mut trial.stage {
            Stage::Found(best, confirmation) => {
                let mut found = best.displacement();
                found.about(at_m);
                let said = scene.said_of(&readings, &found);
                // With those that it was found by, as many as would do if one sensor were deceived.
                let takes = RARE + SURE + WALL_SAYS - found.log_odds - trial.told;
                // A robot that stands will not see other places, and where even the same ones speak against it, it is not so.
                let is_so = confirmation.verdict(said, takes.max(0.0))? || confirmation.stands() && said >= -SURE;
                self.give_up();
                return is_so.then_some(found);
            }
            Stage::Aside(round) | Stage::Searching(round) => round,
        };
        let mut found = scene.go_on(&readings, &mut round.improvement, &JOLT, STEP_HOLDS * turns)?;
        if usize::from(round.starts) < STARTS {
            round.rank(&found);
            return None;
        }
        // The best, with the readings of the last steps.
        let log_odds = found.log_odds + trial.told;
        let is_sure = log_odds > RARE + SURE && found.log_odds > round.other + SURE && are_apart(&found.by, &[0.0; 3]);
        *round = Round::NEW;
        if is_sure {
            found.about(at_m.map(|at_m| -at_m));
            trial.stage = Stage::Found(Packed::of(&found), Confirmation::since(trial.onset));
        } else if trial.is_aside() || trial.for_s > TRIAL_S || log_odds < SURE {
            self.give_up();
        }
        None
    }

    /// Ends the search, if there is one.
    fn give_up(&mut self) {
        if self.is_in_doubt() {
            self.now = Look::default();
        }
        self.trial = None;
    }

    /// The readings of the last moments.
    pub fn recent(&self) -> &Recent {
        &self.recent
    }
}

impl Trial {
    /// Readings count since this step, and sensors told so much of it.
    fn new(onset: u32, told: f32, stage: Stage) -> Self {
        Self { onset, told, for_s: 0.0, stage }
    }

    /// Whether readings are used meanwhile.
    fn is_aside(&self) -> bool {
        matches!(self.stage, Stage::Aside(_))
    }

    /// Step since which readings say something.
    fn counts_from(&self) -> u32 {
        match &self.stage {
            Stage::Found(_, confirmation) => confirmation.onset(),
            Stage::Aside(_) | Stage::Searching(_) => self.onset,
        }
    }

    /// Time goes on.
    fn wait(&mut self, dt_s: f32, step: &Step, number: u32) {
        match &mut self.stage {
            Stage::Found(_, confirmation) => confirmation.wait(dt_s, step, number),
            Stage::Aside(_) | Stage::Searching(_) => self.for_s += dt_s,
        }
    }
}

impl Round {
    /// None was searched from.
    const NEW: Self = Self {
        starts: 0,
        improvement: Improvement::from([0.0; 3]),
        best: ([0.0; 3], f32::NEG_INFINITY),
        other: f32::NEG_INFINITY,
    };

    /// Keeps the best displacement, and how likely the best of the others is. On with the next start, and last with the best.
    fn rank(&mut self, found: &Displacement) {
        let (found, best) = ((found.by, found.log_odds), self.best);
        let [better, worse] = if found.1 > best.1 { [found, best] } else { [best, found] };
        if are_apart(&better.0, &worse.0) {
            self.other = self.other.max(worse.1);
        }
        self.best = better;
        self.starts += 1;
        self.improvement = Improvement::from_start(self.starts.into()).unwrap_or(Improvement::from(better.0));
    }
}
