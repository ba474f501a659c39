//! Whether the estimator is well: what its readings say of its own estimate, and since when.
//!
//! A filter that took readings for the wrong walls is sure of a wrong answer, and no variance of its own tells. Its readings
//! do: where the pose is right, a beam on a wall of the map mostly meets that wall. What counts is how much likelier the readings
//! of the last metres are of a robot that is elsewhere (a cumulative sum, Page 1954). Readings are independent only where they are of
//! other things: what stands before a wall, or where one was, says so once, however often a robot that sweeps beside it comes by.

mod sightings;

use crate::health::sightings::{PLACE_M, Sight, Sightings};
use crate::report::{Health, Outcome, Refusal};

/// Readings within such a stretch of their beams' way say one thing, metres: as long as a place of a wall.
const STRETCH_M: f32 = PLACE_M;

/// What is seen in place of a wall is mostly as wide as three stretches: each says a third.
const OF_ITS_OWN: f32 = 1.0 / 3.0;

/// Share of the walls that a robot meets which fit although it is elsewhere: those along which it is off, and chance. Of the others one half
/// is seen before its place, the other behind.
const FIT_ELSEWHERE: f32 = 0.2;
const MISS_ELSEWHERE: f32 = 0.5 * (1.0 - FIT_ELSEWHERE);

/// Share of the walls that a robot meets which are hidden (by people, things, doors), and which are not there any more, before any
/// was met, and where each may come to.
const HIDDEN: f32 = 0.2;
const GONE: f32 = 0.1;
const HIDDEN_RANGE: [f32; 2] = [0.05, 0.5];
const GONE_RANGE: [f32; 2] = [0.03, 0.4];

/// They are the home's: what is known beforehand is worth so many walls, each in a stretch, as are met in ten metres; what was met last
/// counts most, in some fifty.
const BEFOREHAND: f32 = 200.0;
const REMEMBERED: f32 = 1000.0;

/// Log of the odds that the robot is elsewhere from which on walls drawn since anything spoke for that say nothing, ten to one: a robot
/// that is elsewhere draws the home a second time, and everything fits that.
const DOUBTED: f32 = 2.3;

/// Log of the odds that are no chance, two to the twentieth: with a stretch for each trial one false alarm in 260 km.
const CONTRADICTED: f32 = 13.9;

/// Path within which readings have contradicted a map, metres, where two walls are about.
pub const CONTRADICTED_M: f32 = 5.0;

/// A robot that drives so far, metres, with so many readings of which none fits a wall, has none that it could hold on to.
const SILENT_M: f32 = 20.0;
const SILENT_READINGS: u32 = 200;

/// Heading sigma against the map from which on there is no such thing as a linear estimate, radians.
const DISORIENTED_RAD: f32 = 1.0;

/// So many readings that fit a wall show that the estimator is well again: as many as a wall needs to be drawn.
const RECOVERED: u32 = 20;

/// Which readings of a step are told apart by the place of the wall that they met: each where beams move by an eighth of a place or more in
/// a step, one in four else, for no place is missed by those either and a step takes less.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    number: u32,
    others: u32,
}

impl Asked {
    /// Those of the step of this number, in which beams move by so much, metres.
    pub fn in_step(number: u32, moved_m: f32) -> Self {
        Self { number, others: if moved_m < PLACE_M / 8.0 { 3 } else { 0 } }
    }

    /// This place along a wall, metres, where this sensor's is one.
    pub fn of(self, index: usize, along_m: f32) -> Option<f32> {
        ((index as u32 ^ self.number) & self.others == 0).then_some(along_m)
    }
}

/// What speaks for the robot being elsewhere than its pose says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Elsewhere {
    /// Log of the odds, by what the readings of the last metres found of the map's walls; zero where nothing speaks for it. From 13.9 on the
    /// map is given up.
    pub log_odds: f32,
    /// Identifier of the first wall drawn since, from odds of ten to one on.
    pub since: Option<u16>,
}

/// What speaks for and against the estimate.
#[derive(Clone, Copy, Debug)]
pub struct HealthMonitor {
    health: Health,
    /// Walls of this stretch, a bit each, that readings fitted, that hid behind something nearer, and that beams went through.
    fitted: u32,
    hidden: u32,
    passed: u32,
    /// Those of which something was seen in it that is not what was last seen there.
    news: u32,
    sightings: Sightings,
    /// How far beams have moved in it, metres.
    moved_m: f32,
    /// Share of walls that are hidden, and that beams go through, where the robot is where the filter has it.
    usual: [f32; 2],
    /// So many walls, each in a stretch, have said so.
    met: f32,
    /// Log of the odds that it is elsewhere.
    odds: f32,
    /// Readings that fit no wall since one last did, and the path then, metres.
    silent: u32,
    silent_from_m: f32,
    /// Readings that fit a wall since the estimator was last unwell.
    fitting: u32,
    /// A variance of this step was not a positive number.
    is_degenerate: bool,
    /// Steps, this one among them, in which the map is still there, where it is of no use any more; none where it is.
    pub(crate) steps_left: u8,
    /// Identifier of the first wall drawn since something spoke for the robot being elsewhere.
    pub(crate) doubted: u16,
    /// Identifier of the first wall that says nothing; kept, so that it is not worked out for each reading.
    unheard: u16,
}

impl HealthMonitor {
    /// Nothing is known yet.
    pub const NEW: Self = Self {
        health: Health::Well,
        fitted: 0,
        hidden: 0,
        passed: 0,
        news: 0,
        sightings: Sightings::NONE,
        moved_m: 0.0,
        usual: [HIDDEN, GONE],
        met: BEFOREHAND,
        odds: 0.0,
        silent: 0,
        silent_from_m: 0.0,
        fitting: 0,
        is_degenerate: false,
        steps_left: 0,
        doubted: 0,
        unheard: 0,
    };

    /// How the estimator is.
    pub fn health(&self) -> Health {
        self.health
    }

    /// Another map is there, whose next wall has this identifier: nothing is against it yet.
    pub(crate) fn begin_map(&mut self, next_wall: u16) {
        (self.odds, self.steps_left, self.doubted, self.unheard) = (0.0, 0, next_wall, next_wall);
    }

    /// Walls from this identifier on are drawn after this step: where nothing is against the map, none is in doubt.
    pub(crate) fn follow(&mut self, next_wall: u16) {
        if self.odds == 0.0 {
            self.doubted = next_wall;
        }
        self.unheard = self.elsewhere().since.unwrap_or(next_wall);
    }

    /// What speaks for the robot being elsewhere than the filter has it.
    pub(crate) fn elsewhere(&self) -> Elsewhere {
        Elsewhere { log_odds: self.odds, since: (self.odds >= DOUBTED).then_some(self.doubted) }
    }

    /// A beam that should have met this wall, at so far along it where that is told, metres, found this. Walls that share a bit say one
    /// thing.
    fn see(&mut self, wall: u16, along_m: Option<f32>, sight: Sight) {
        if self.unheard.wrapping_sub(wall) as i16 <= 0 {
            return;
        }
        let bit = 1 << (wall & 31);
        match sight {
            Sight::Fits => self.fitted |= bit,
            Sight::Hidden => self.hidden |= bit,
            Sight::Passed => self.passed |= bit,
        }
        if along_m.is_some_and(|along_m| self.sightings.is_new(wall, along_m, sight)) {
            self.news |= bit;
        }
    }

    /// A beam found nothing where it should have met this wall, if any, at so far along it, metres.
    pub(crate) fn note_absence(&mut self, wall: Option<(u16, f32)>) {
        if let Some((wall, along_m)) = wall {
            self.see(wall, Some(along_m), Sight::Passed);
        }
    }

    /// Takes in what became of a reading, after so long a path, and how far along the wall that its outcome names it was due, metres, where
    /// that is [`Asked`] for.
    pub fn note(&mut self, outcome: &Outcome, path_m: f32, along_m: Option<f32>) {
        match *outcome {
            Outcome::Updated { wall, .. } => {
                self.see(wall, along_m, Sight::Fits);
                (self.silent, self.silent_from_m) = (0, path_m);
                self.fitting = self.fitting.saturating_add(1);
            }
            Outcome::Gated { wall, innovation_m, .. } => {
                let sight = if innovation_m < 0.0 { Sight::Hidden } else { Sight::Passed };
                self.see(wall, along_m, sight);
                self.silent = self.silent.saturating_add(1);
            }
            Outcome::Unexplained => self.silent = self.silent.saturating_add(1),
            Outcome::Refused(refusal) => self.is_degenerate |= refusal == Refusal::Degenerate,
            Outcome::Missing => {}
        }
    }

    /// What this stretch says for the robot being elsewhere: each wall with readings of one kind, where they are of other things.
    fn weigh(&mut self) {
        let [f, h, p] = [self.fitted, self.hidden, self.passed];
        let of_one_kind = [f & !(h | p), h & !(f | p), p & !(f | h)];
        let [fitted, hidden, passed] = of_one_kind.map(|of| (of & self.news).count_ones() as f32);
        let [hides, passes] = self.usual;
        let says = hidden * libm::logf(MISS_ELSEWHERE / hides)
            + passed * libm::logf(MISS_ELSEWHERE / passes)
            + fitted * libm::logf(FIT_ELSEWHERE / (1.0 - hides - passes));
        self.odds = (self.odds + OF_ITS_OWN * says).max(0.0);
        let [fitted, hidden, passed] = of_one_kind.map(|of| of.count_ones() as f32);
        let met = fitted + hidden + passed;
        self.met = (self.met + met).min(REMEMBERED);
        let learned =
            |usual: f32, of: f32, [least, most]: [f32; 2]| (usual + (of - met * usual) / self.met).max(least).min(most);
        self.usual = [learned(hides, hidden, HIDDEN_RANGE), learned(passes, passed, GONE_RANGE)];
        (self.fitted, self.hidden, self.passed, self.news, self.moved_m) = (0, 0, 0, 0, 0.0);
    }

    /// The path is counted anew from what it is by now, metres.
    pub fn count_anew(&mut self, path_m: f32) {
        self.silent_from_m -= path_m;
    }

    /// What this step shows, after so long a path, in which beams moved by so much, metres: why the map is to begin anew, where it is.
    /// `heading_variance` is that against the map, rad^2, where there is one; `is_sound` says whether every variance is one.
    pub fn judge(
        &mut self,
        path_m: f32,
        moved_m: f32,
        heading_variance: Option<f32>,
        is_sound: bool,
    ) -> Option<Health> {
        self.moved_m += moved_m;
        if self.moved_m > STRETCH_M {
            self.weigh();
        }
        let is_disoriented = heading_variance.is_some_and(|variance| variance > DISORIENTED_RAD * DISORIENTED_RAD);
        let cause = if self.is_degenerate || !is_sound {
            Some(Health::Degenerate)
        } else if is_disoriented {
            Some(Health::Disoriented)
        } else if self.odds >= CONTRADICTED {
            Some(Health::Contradicted)
        } else {
            None
        };
        if let Some(health) = cause {
            *self = Self { health, usual: self.usual, met: self.met, silent_from_m: path_m, ..Self::NEW };
        } else if self.silent >= SILENT_READINGS && path_m - self.silent_from_m > SILENT_M {
            (self.health, self.fitting) = (Health::Unexplained, 0);
        } else if self.fitting >= RECOVERED {
            self.health = Health::Well;
        }
        cause
    }
}
