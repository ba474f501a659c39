//! The back end beside a filter: what it writes down, when it looks back, and when it hands over.

use slam_core::{NotTaken, Slam, StepReport};

use crate::diary::Diary;
use crate::gains::Gains;
use crate::look_back::{LookBack, Progress};

/// A look back begins after so many keyframes since the one before began: eight metres, about as long as one takes.
const EVERY: u32 = 32;

/// Of keyframes and of groups a look back needs one in so many free: what is written down meanwhile. New keyframes have more
/// groups than old ones, which have been made one with others.
const FREE_KEYFRAMES: usize = 8;
const FREE_GROUPS: usize = 4;

/// Multiply-adds for each millisecond: half of what a Cortex-M4F of 168 MHz can do beside the filter.
const WORK_PER_MS: u32 = 4000;

/// What a robot allows a look back between two steps, microseconds of the above: its estimator's period. A fixed amount, whatever time
/// the processor has, so that the same samples give the same estimates.
pub const STEP_US: u32 = 40_000;

/// A longer time between two steps is no time to work in, microseconds.
const LONGEST_US: u32 = 1_000_000;

/// What the back end did so far. Counts saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Look backs that were done.
    pub done: u32,
    /// That ended without a result: interrupted, nothing to place, or not to be solved.
    pub fruitless: u32,
    /// Look backs that were thrown away, since the filter began anew.
    pub outdated: u32,
}

/// A diary and its look back, of K keyframes, G groups, W walls and the border's sizes B and P.
#[derive(Clone, Debug)]
pub struct BackEnd<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize> {
    diary: Diary<K, G, W>,
    look_back: LookBack<K, W, B, P>,
    /// The filter's, as the diary knows it; none before the first step.
    epoch: Option<u32>,
    /// The keyframe at which the last look back began.
    begun_at: u32,
    is_working: bool,
    tally: Tally,
}

impl<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize> BackEnd<K, G, W, B, P> {
    /// Not begun. Every byte is zero, so that a static of it costs no flash.
    pub const IDLE: Self = Self {
        diary: Diary::IDLE,
        look_back: LookBack::new(),
        epoch: None,
        begun_at: 0,
        is_working: false,
        tally: Tally { done: 0, fruitless: 0, outdated: 0 },
    };

    /// Writes down a filter's last step.
    pub fn record<const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &mut self,
        slam: &Slam<S, WALLS, O, ROWS>,
        report: &StepReport<S>,
    ) {
        let before = self.epoch.replace(slam.epoch());
        if before == self.epoch {
            self.diary.record(slam, report);
        } else if slam.is_elsewhere() && before.map(|epoch| epoch.wrapping_add(1)) == self.epoch {
            self.diary.go_on_elsewhere(&slam.filter_pose());
        } else {
            self.begin_anew(slam);
        }
    }

    /// Hands over to a filter whose last step is written down, if a look back is done: what came of that.
    pub fn hand_over<const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &mut self,
        slam: &mut Slam<S, WALLS, O, ROWS>,
    ) -> Option<Result<(), NotTaken>> {
        if !(self.is_working && self.look_back.is_done()) {
            return None;
        }
        self.is_working = false;
        self.tally.done = self.tally.done.saturating_add(1);
        let taken = self.look_back.hand_over(&mut self.diary, slam, self.epoch.unwrap_or(0));
        if taken.is_ok() {
            self.epoch = Some(slam.epoch());
        }
        Some(taken)
    }

    /// Looks back for the work of so much time, microseconds, where there is anything to look back on.
    pub fn work(&mut self, time_us: u32) {
        let budget = WORK_PER_MS * time_us.min(LONGEST_US) / 1000;
        if !self.is_working {
            self.begin();
        }
        if self.is_working {
            match self.look_back.work(&mut self.diary, budget) {
                Progress::Working | Progress::Done => {}
                Progress::Interrupted | Progress::Nothing | Progress::Unsolvable => {
                    self.tally.fruitless = self.tally.fruitless.saturating_add(1);
                    self.is_working = false;
                }
            }
        }
    }

    /// Whether a look back is under way.
    pub fn is_looking_back(&self) -> bool {
        self.is_working
    }

    /// What it did so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// The diary.
    pub fn diary(&self) -> &Diary<K, G, W> {
        &self.diary
    }

    /// The look back that is under way, or the last one.
    pub fn look_back(&self) -> &LookBack<K, W, B, P> {
        &self.look_back
    }

    fn begin_anew<const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &mut self,
        slam: &Slam<S, WALLS, O, ROWS>,
    ) {
        if self.is_working {
            self.tally.outdated = self.tally.outdated.saturating_add(1);
        }
        self.is_working = false;
        self.begun_at = 0;
        let gains = if slam.config().sensing.calibrate_gains { Gains::of_rig(slam.rig()) } else { Gains::KNOWN };
        self.diary.begin(&slam.rig().drive, gains, slam.filter_pose());
    }

    /// Begins a look back where there is enough new to look at.
    fn begin(&mut self) {
        let newest = self.diary.newest();
        if self.epoch.is_none() || newest.wrapping_sub(self.begun_at) < EVERY {
            return;
        }
        self.begun_at = newest;
        self.diary.make_room(K / FREE_KEYFRAMES, G / FREE_GROUPS);
        self.look_back.begin(&self.diary);
        self.is_working = true;
    }
}
