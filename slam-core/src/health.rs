//! Whether the estimator is well: what its readings say of its own estimate, and since when.
//!
//! A filter that took readings for the wrong walls is sure of a wrong answer, and no variance of its own tells. Its readings
//! do: where the pose is right, a beam on a wall of the map mostly meets that wall. Readings of one place say the same, so
//! what counts is by how many more stretches of the path were against the map than for it (a cumulative sum, Page 1954).

use crate::report::{Health, Outcome, Refusal};

/// Readings within such a stretch of the path say one thing, metres: the shortest wall is as long.
const STRETCH_M: f32 = 0.25;

/// So many more stretches against the map than for it are no chance. Among people and open doors up to a third of the
/// stretches are against a good map, and two thirds against a lost one: each is then worth odds of two, and this many two to
/// the twentieth, one false alarm in 260 km. A real drive in offices with people had fourteen, one that was lost 27.
const CONTRADICTED: u8 = 20;

/// Path that it takes at least, metres.
pub const CONTRADICTED_M: f32 = CONTRADICTED as f32 * STRETCH_M;

/// A robot that drives so far, metres, with so many readings of which none fits a wall, has none that it could hold on to.
const SILENT_M: f32 = 20.0;
const SILENT_READINGS: u32 = 200;

/// Heading sigma against the map from which on there is no such thing as a linear estimate, radians.
const DISORIENTED_RAD: f32 = 1.0;

/// So many readings that fit a wall show that the estimator is well again: as many as a wall needs to be drawn.
const RECOVERED: u32 = 20;

/// What speaks for and against the estimate.
#[derive(Clone, Copy, Debug)]
pub struct HealthMonitor {
    health: Health,
    /// Readings of this stretch that fit the wall that they should have met, and that did not.
    used: u16,
    against: u16,
    /// Path at the stretch's start, metres.
    stretch_from_m: f32,
    /// By how many more stretches were against the map than for it.
    sum: u8,
    /// Readings that fit no wall since one last did, and the path then, metres.
    silent: u32,
    silent_from_m: f32,
    /// Readings that fit a wall since the estimator was last unwell.
    fitting: u32,
    /// A variance of this step was not a positive number.
    is_degenerate: bool,
    /// Steps, this one among them, in which the map is still there, where it is of no use any more; none where it is.
    pub(crate) steps_left: u8,
    /// Identifier of the first wall drawn since more stretches were against the map than for it.
    pub(crate) doubted: u16,
}

impl HealthMonitor {
    /// Nothing is known yet.
    pub const NEW: Self = Self {
        health: Health::Well,
        used: 0,
        against: 0,
        stretch_from_m: 0.0,
        sum: 0,
        silent: 0,
        silent_from_m: 0.0,
        fitting: 0,
        is_degenerate: false,
        steps_left: 0,
        doubted: 0,
    };

    /// How the estimator is.
    pub fn health(&self) -> Health {
        self.health
    }

    /// Another map is there, whose next wall has this identifier: nothing is against it yet.
    pub(crate) fn begin_map(&mut self, next_wall: u16) {
        (self.sum, self.steps_left, self.doubted) = (0, 0, next_wall);
    }

    /// Walls from this identifier on are drawn after this step: where nothing is against the map, none is in doubt.
    pub(crate) fn follow(&mut self, next_wall: u16) {
        if self.sum == 0 {
            self.doubted = next_wall;
        }
    }

    /// Takes in what became of a reading, after so long a path.
    pub fn note(&mut self, outcome: &Outcome, path_m: f32) {
        match *outcome {
            Outcome::Updated { .. } => {
                self.used = self.used.saturating_add(1);
                (self.silent, self.silent_from_m) = (0, path_m);
                self.fitting = self.fitting.saturating_add(1);
            }
            Outcome::Gated { .. } => {
                self.against = self.against.saturating_add(1);
                self.silent = self.silent.saturating_add(1);
            }
            Outcome::Unexplained => self.silent = self.silent.saturating_add(1),
            Outcome::Refused(refusal) => self.is_degenerate |= refusal == Refusal::Degenerate,
            Outcome::Missing => {}
        }
    }

    /// What this step shows, after so long a path: why the map is to begin anew, where it is. `heading_variance` is that
    /// against the map, rad^2, where there is one; `is_sound` says whether every variance is one.
    pub fn judge(&mut self, path_m: f32, heading_variance: Option<f32>, is_sound: bool) -> Option<Health> {
        if path_m - self.stretch_from_m > STRETCH_M {
            self.sum = match self.against > self.used {
                true => self.sum.saturating_add(1),
                false if self.used > 0 => self.sum.saturating_sub(1),
                false => self.sum,
            };
            (self.used, self.against, self.stretch_from_m) = (0, 0, path_m);
        }
        let is_disoriented = heading_variance.is_some_and(|variance| variance > DISORIENTED_RAD * DISORIENTED_RAD);
        let cause = if self.is_degenerate || !is_sound {
            Some(Health::Degenerate)
        } else if is_disoriented {
            Some(Health::Disoriented)
        } else if self.sum >= CONTRADICTED {
            Some(Health::Contradicted)
        } else {
            None
        };
        if let Some(health) = cause {
            *self = Self { health, stretch_from_m: path_m, silent_from_m: path_m, ..Self::NEW };
        } else if self.silent >= SILENT_READINGS && path_m - self.silent_from_m > SILENT_M {
            (self.health, self.fitting) = (Health::Unexplained, 0);
        } else if self.fitting >= RECOVERED {
            self.health = Health::Well;
        }
        cause
    }
}
