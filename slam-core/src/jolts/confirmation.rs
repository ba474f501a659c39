//! What the last readings say of where the robot is, confirmed by readings of other places.
//!
//! The likeliest of many explanations fits the readings that it was found by in any case. So it has effect only once the robot has
//! gone on, and beams that meet other places say so, too.

use crate::motion::step::Step;

/// Once beams have moved by so much, metres, they meet other places of a wall.
const ELSEWHERE_M: f32 = 0.25;

/// Log of the odds at which something is decided, twenty to one.
pub const SURE: f32 = 3.0;

/// For so long, seconds, readings may say so: a robot at walking pace has seen half a metre of other walls by then.
pub const TRIAL_S: f32 = 2.0;

/// The wait for readings of other places.
#[derive(Clone, Copy, Debug)]
pub struct Confirmation {
    /// Step since which readings count.
    onset: u32,
    moved_m: f32,
    for_s: f32,
}

impl Confirmation {
    /// It was found in the step of this number.
    pub fn since(number: u32) -> Self {
        Self { onset: number, moved_m: 0.0, for_s: 0.0 }
    }

    /// Time goes on by so much, seconds, to the step of this number.
    pub fn wait(&mut self, dt_s: f32, step: &Step, number: u32) {
        self.for_s += dt_s;
        self.moved_m += step.beams_moved_m();
        if self.stands() {
            self.onset = number;
        }
    }

    /// Step since which readings are of other places.
    pub fn onset(&self) -> u32 {
        self.onset
    }

    /// Whether it is confirmed, by the log odds that those readings have for it: more than it `takes`. None while they neither confirm it nor
    /// speak against it at twenty to one, nor the trial is over.
    pub fn verdict(&self, said: f32, takes: f32) -> Option<bool> {
        let is_decided = self.for_s > TRIAL_S || said < -SURE || !self.stands() && said > takes.max(SURE);
        is_decided.then_some(said > takes)
    }

    /// Whether the robot sees no other places, for it stands. Readings of the same places may agree with what was found by them, and not
    /// be right.
    pub fn stands(&self) -> bool {
        self.moved_m <= ELSEWHERE_M
    }
}
