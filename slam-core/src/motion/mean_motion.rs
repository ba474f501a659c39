//! Motion as it goes on: an average over the last while.
//!
//! The noise of one short step's dead reckoning is a good part of the step. Where the motion multiplies what is to be
//! estimated, a scale or the age of readings, that noise draws the estimate to zero: the filter would be sure that motion
//! was seen that is not there (errors in variables; Fuller 1987, sec. 1.1). An average has less of it.

use crate::sample::Increment;

/// Motion in the robot's frame, per second.
#[derive(Clone, Copy, Debug)]
pub struct MeanMotion(Increment);

impl MeanMotion {
    /// Standing.
    pub const STILL: Self = Self(Increment { forward_m: 0.0, left_m: 0.0, turn_rad: 0.0 });

    /// Takes in the motion of a step; what is older than `memory_s` fades.
    pub fn follow(&mut self, moved: Increment, dt_s: f32, memory_s: f32) {
        if dt_s <= 0.0 {
            return;
        }
        let weight = (dt_s / memory_s).min(1.0);
        let follow = |mean: &mut f32, moved: f32| *mean += weight * (moved / dt_s - *mean);
        follow(&mut self.0.forward_m, moved.forward_m);
        follow(&mut self.0.left_m, moved.left_m);
        follow(&mut self.0.turn_rad, moved.turn_rad);
    }

    /// The motion of a step as those before it tell, whose noise is another: of a step that is longer than the memory for that long, and
    /// as it was `moved` for the rest. A long step has little noise for its length, and those before say little of it.
    pub fn expected(&self, moved: Increment, dt_s: f32, memory_s: f32) -> Increment {
        if dt_s <= memory_s {
            return self.over(dt_s);
        }
        let (before, share) = (self.over(memory_s), 1.0 - memory_s / dt_s);
        Increment {
            forward_m: before.forward_m + share * moved.forward_m,
            left_m: before.left_m + share * moved.left_m,
            turn_rad: before.turn_rad + share * moved.turn_rad,
        }
    }

    /// The motion of so many seconds of this motion.
    pub fn over(&self, time_s: f32) -> Increment {
        let Increment { forward_m, left_m, turn_rad } = self.0;
        Increment { forward_m: time_s * forward_m, left_m: time_s * left_m, turn_rad: time_s * turn_rad }
    }
}
