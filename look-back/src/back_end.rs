//! The back end beside a filter: what it writes down, when it looks back, and when it hands over.

use core::ops::ControlFlow;

use slam_core::{NotTaken, Slam, StepReport};

use crate::diary::Diary;
use crate::gains::Gains;
use crate::look_back::{LookBack, Progress};

/// A look back begins after so many keyframes since the one before began: eight metres, about as long as one takes.
const EVERY: u32 = 32;

/// Of keyframes, groups and walls a look back needs one in so many free: what is written down meanwhile. New keyframes have more
/// groups than old ones, which have been made one with others. Of keyframes and walls it is twice as many once a look back was
/// interrupted: a robot that is fast goes farther meanwhile.
const FREE_KEYFRAMES: usize = 8;
const FREE_GROUPS: usize = 4;
const FREE_WALLS: usize = 8;

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

/// What it does at present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing: there is too little new to look at.
    Resting,
    /// Makes room in the diary for what is written down meanwhile.
    MakingRoom,
    /// Looks back.
    LookingBack,
    /// Has looked back, and waits for the keyframe that is being written to be closed.
    Closing,
    /// Takes in what was written down meanwhile, that keyframe, too.
    CatchingUp,
    /// Has taken that in, and goes on as soon as a step leaves the time for a hand-over.
    CaughtUp,
    /// Takes in the few steps that this took, the last one, too, before the next one.
    Arriving,
    /// Has something to hand over, before the next step.
    Ready,
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
    phase: Phase,
    /// A look back did not end before the diary was full.
    is_fast: bool,
    tally: Tally,
}

impl<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize> BackEnd<K, G, W, B, P> {
    /// Not begun. Every byte is zero, so that a static of it costs no flash.
    pub const IDLE: Self = Self {
        diary: Diary::IDLE,
        look_back: LookBack::new(),
        epoch: None,
        begun_at: 0,
        phase: Phase::Resting,
        is_fast: false,
        tally: Tally { done: 0, fruitless: 0, outdated: 0 },
    };

    /// Writes down a filter's last step.
    pub fn record<const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &mut self,
        slam: &Slam<S, WALLS, O, ROWS>,
        report: &StepReport<S>,
    ) {
        if self.phase == Phase::Resting {
            self.diary.odometry.position_level = slam.position_level();
            self.diary.odometry.wheel_level = slam.wheel_level();
        }
        let before = self.epoch.replace(slam.epoch());
        if before == self.epoch {
            self.diary.record(slam, report, self.phase == Phase::Closing);
            match self.phase {
                Phase::Closing | Phase::CaughtUp => {
                    self.look_back.catch_up();
                    self.phase = Phase::CatchingUp;
                }
                // It is of the step before.
                Phase::Arriving | Phase::Ready => self.end_without_result(),
                _ => {}
            }
        } else if let Some(displaced) = slam.displaced()
            && before.map(|epoch| epoch.wrapping_add(1)) == self.epoch
        {
            self.diary.go_on_elsewhere(&slam.filter_pose(), displaced);
        } else {
            self.begin_anew(slam);
        }
    }

    /// Hands over to a filter whose last step is written down, if a look back has caught up with it: what came of that. Comes between
    /// the work after a step and the next step.
    pub fn hand_over<const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &mut self,
        slam: &mut Slam<S, WALLS, O, ROWS>,
    ) -> Option<Result<(), NotTaken>> {
        if self.phase != Phase::Ready {
            return None;
        }
        self.phase = Phase::Resting;
        self.tally.done = self.tally.done.saturating_add(1);
        let taken = self.look_back.hand_over(&mut self.diary, slam, self.epoch.unwrap_or(0));
        if taken.is_ok() {
            self.epoch = Some(slam.epoch());
        }
        Some(taken)
    }

    /// Looks back for the work of so much time, microseconds, where there is anything to look back on.
    pub fn work(&mut self, time_us: u32) {
        self.work_by(time_us, Self::slice);
    }

    /// The same, slice by slice as somebody has them done who measures them.
    pub fn work_by(&mut self, time_us: u32, mut slice: impl FnMut(&mut Self) -> Option<u32>) {
        let (budget, mut spent) = (WORK_PER_MS * time_us.min(LONGEST_US) / 1000, 0u32);
        while spent < self.most(budget) {
            let Some(cost) = slice(self) else { return };
            spent = spent.saturating_add(cost);
        }
    }

    /// Until so much of a step's budget is spent it goes on.
    fn most(&self, budget: u32) -> u32 {
        match self.phase {
            // A hand-over follows, which takes about as long as half of it.
            Phase::CaughtUp => budget / 2,
            // What the last steps saw is little, and taken in before the next one, whatever time is left.
            Phase::Arriving => u32::MAX,
            _ => budget,
        }
    }

    /// Goes on by the least that cannot be divided: its multiply-adds; none where there is nothing to do before the next step.
    pub fn slice(&mut self) -> Option<u32> {
        match self.phase {
            Phase::Resting => {
                let newest = self.diary.newest();
                if self.epoch.is_none() || newest.wrapping_sub(self.begun_at) < EVERY {
                    return None;
                }
                self.begun_at = newest;
                self.phase = Phase::MakingRoom;
                Some(0)
            }
            Phase::MakingRoom => {
                let times = 1 + usize::from(self.is_fast);
                let made = self.diary.follow_age().or_else(|| {
                    self.diary.make_some_room(times * K / FREE_KEYFRAMES, G / FREE_GROUPS, times * W / FREE_WALLS)
                });
                if made.is_none() {
                    self.look_back.begin(&self.diary);
                    self.phase = Phase::LookingBack;
                }
                Some(made.unwrap_or(0))
            }
            Phase::LookingBack | Phase::CatchingUp | Phase::Arriving => match self.look_back.next(&mut self.diary) {
                ControlFlow::Continue(cost) => Some(cost),
                ControlFlow::Break(progress) => {
                    self.end(progress);
                    Some(0)
                }
            },
            Phase::CaughtUp => {
                self.look_back.arrive();
                self.phase = Phase::Arriving;
                Some(0)
            }
            Phase::Closing | Phase::Ready => None,
        }
    }

    /// Whether a look back is under way, or was not handed over yet.
    pub fn is_looking_back(&self) -> bool {
        self.phase != Phase::Resting
    }

    /// Whether a hand-over may come before the next step.
    pub fn is_catching_up(&self) -> bool {
        self.phase == Phase::CatchingUp
    }

    /// Whether there is something to hand over.
    pub fn is_ready(&self) -> bool {
        self.phase == Phase::Ready
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
        if self.is_looking_back() {
            self.tally.outdated = self.tally.outdated.saturating_add(1);
        }
        self.phase = Phase::Resting;
        self.begun_at = 0;
        let gains = if slam.config().sensing.calibrate_gains { Gains::of_rig(slam.rig()) } else { Gains::KNOWN };
        self.diary.begin(&slam.rig().drive, gains, slam.filter_pose());
        self.diary.begin_in(slam, &slam.filter_pose());
        self.diary.begin_at_age(slam);
    }

    /// What follows when a look back has ended.
    fn end(&mut self, progress: Progress) {
        match (progress, self.phase) {
            (Progress::Done, Phase::LookingBack) => self.phase = Phase::Closing,
            (Progress::Done, Phase::CatchingUp) => self.phase = Phase::CaughtUp,
            (Progress::Done, _) => self.phase = Phase::Ready,
            _ => {
                self.is_fast |= progress == Progress::Interrupted;
                self.end_without_result();
            }
        }
    }

    fn end_without_result(&mut self) {
        self.tally.fruitless = self.tally.fruitless.saturating_add(1);
        self.phase = Phase::Resting;
    }
}
