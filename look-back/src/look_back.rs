//! The whole: where everything in a diary is likeliest, worked out in slices.
//!
//! First every group is on the wall that the filter took it for, until walls that turn out to be one have become one; then on
//! the wall that it ended on, in rounds, as the points of a scan are matched (Besl and McKay 1992).

use core::ops::ControlFlow;

use crate::diary::{Diary, FEWEST};
use crate::labels::Labels;
use crate::place::place_wall;
use crate::present::Present;
use crate::rows;
use crate::solve::{Slice, Solver};
use crate::survey::{self, Cursor};
use crate::system::border_len;
use crate::turned::Search;
use crate::twins::Twins;

/// Steps until it is settled, at most, at first and at last, and between two mergers, when it need not be.
const STEPS: u32 = 10;
const STEPS_BETWEEN: u32 = 3;

/// And with the keyframes that came meanwhile, which are near where they belong.
const STEPS_AT_LAST: u32 = 2;

/// Rounds of merging walls that turn out to be one, and of giving groups to the walls that they ended on, at most.
const MERGING_ROUNDS: u32 = 20;
const LABELLING_ROUNDS: u32 = 4;

/// What a step moves that is settled, metres and radians.
const SETTLED: f32 = 3e-4;

/// Multiply-adds of a look at a group, and of a choice.
const SURVEY_COST: u32 = 40;
const CHOICE_COST: u32 = 3;

/// How far a look back is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// There is more to do.
    Working,
    /// The diary holds what was found.
    Done,
    /// The diary changed under it, for it was full; what was found until then stays, and another look back can begin.
    Interrupted,
    /// There is nothing to place: fewer than two keyframes, or no wall.
    Nothing,
    /// The equations have no finite solution; the diary is as it was before that step.
    Unsolvable,
}

/// Which solution this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Last {
    /// One of those that settle walls and labels.
    No,
    /// The last of all that was written down until then.
    Settling,
    /// One more with what was written down meanwhile.
    Latest,
}

#[derive(Clone, Debug)]
enum Stage {
    Idle,
    Place { wall: usize },
    Turn { search: Search },
    Solve,
    Survey { cursor: Cursor },
    Merge,
    Label,
    Invert { row: usize },
    Square { row: usize },
    CatchUp,
    Arrive,
    Ended(Progress),
}

/// What a look back took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Gauss-Newton steps.
    pub steps: u32,
    /// Multiply-adds, about.
    pub cost: u64,
    /// Those of the costliest slice.
    pub costliest: u32,
    /// Pairs of walls made one, in so many rounds.
    pub merging_rounds: u32,
}

/// Places what a diary of K keyframes and W walls holds; B is `border_len(W)`, P is `packed_len(B)`, which the compiler checks.
#[derive(Clone, Debug)]
pub struct LookBack<const K: usize, const W: usize, const B: usize, const P: usize> {
    pub(crate) solver: Solver<K, W, B, P>,
    pub(crate) present: Present,
    labels: Labels<W>,
    twins: Twins,
    stage: Stage,
    /// The diary's when it began.
    revision: u32,
    steps_left: u32,
    mergers_left: u32,
    labellings_left: u32,
    /// Solutions that are left once walls and labels are settled.
    last: Last,
    effort: Effort,
}

impl<const K: usize, const W: usize, const B: usize, const P: usize> Default for LookBack<K, W, B, P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const K: usize, const W: usize, const B: usize, const P: usize> LookBack<K, W, B, P> {
    /// One that has nothing to do.
    pub const fn new() -> Self {
        const { assert!(B == border_len(W) && P == crate::packed_len(B)) };
        Self {
            solver: Solver::NEW,
            present: Present::NONE,
            labels: Labels::NEW,
            twins: Twins::NEW,
            stage: Stage::Idle,
            revision: 0,
            steps_left: 0,
            mergers_left: 0,
            labellings_left: 0,
            last: Last::No,
            effort: Effort { steps: 0, cost: 0, costliest: 0, merging_rounds: 0 },
        }
    }

    /// Begins a look back.
    pub fn begin<const G: usize>(&mut self, diary: &Diary<K, G, W>) {
        self.stage = Stage::Place { wall: 0 };
        self.revision = diary.revision;
        (self.mergers_left, self.labellings_left) = (MERGING_ROUNDS, LABELLING_ROUNDS);
        self.last = Last::No;
        self.effort = Effort::default();
    }

    /// Goes on for about `budget` multiply-adds, at least by one slice.
    pub fn work<const G: usize>(&mut self, diary: &mut Diary<K, G, W>, budget: u32) -> Progress {
        let mut spent = 0u32;
        loop {
            match self.next(diary) {
                ControlFlow::Continue(cost) => spent = spent.saturating_add(cost),
                ControlFlow::Break(progress) => return progress,
            }
            if spent >= budget {
                return Progress::Working;
            }
        }
    }

    /// Goes on by one slice: its multiply-adds, or how the look back ended.
    pub(crate) fn next<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> ControlFlow<Progress, u32> {
        match self.stage {
            Stage::Idle => return ControlFlow::Break(Progress::Nothing),
            Stage::Ended(progress) => return ControlFlow::Break(progress),
            _ => {}
        }
        if !self.is_of(diary) {
            self.stage = Stage::Ended(Progress::Interrupted);
            return ControlFlow::Break(Progress::Interrupted);
        }
        let cost = self.slice(diary);
        self.effort.cost += u64::from(cost);
        self.effort.costliest = self.effort.costliest.max(cost);
        ControlFlow::Continue(cost)
    }

    /// Whether this is the diary on which it began, but for what was added since.
    pub(crate) fn is_of<const G: usize>(&self, diary: &Diary<K, G, W>) -> bool {
        self.revision == diary.revision
    }

    /// Once done: takes in the keyframes that were closed since.
    pub(crate) fn catch_up(&mut self) {
        self.stage = Stage::CatchUp;
    }

    /// The same of the one that is being written, as it is: before it is handed over nothing may be added.
    pub(crate) fn arrive(&mut self) {
        self.stage = Stage::Arrive;
    }

    fn slice<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> u32 {
        match &mut self.stage {
            Stage::Place { wall } => {
                let index = *wall;
                *wall += 1;
                if index < W { place_wall(diary, index) } else { self.placed(diary) }
            }
            Stage::Turn { search } => search.take(diary).unwrap_or_else(|| self.begin_solving(diary, STEPS)),
            Stage::Solve => self.solve(diary),
            Stage::Survey { cursor } => match cursor.next(diary) {
                Some((index, frame)) => {
                    if let Some(group) = diary.groups.get(index) {
                        survey::take(&mut diary.walls, &diary.gains.correct(group), &frame);
                    }
                    SURVEY_COST
                }
                None => self.surveyed(diary),
            },
            Stage::Merge => match self.twins.take(diary, &self.solver) {
                Some(cost) => cost,
                None => self.merge(diary),
            },
            Stage::Label => match self.labels.take(diary) {
                Some(cost) => cost,
                None => {
                    self.labels.finish(diary);
                    self.begin_solving(diary, STEPS_BETWEEN)
                }
            },
            Stage::Invert { row } => {
                let at = *row;
                *row += 1;
                if !self.solver.system.invert_row(at) {
                    self.stage = Stage::Square { row: 0 };
                }
                (at * at / 2) as u32
            }
            Stage::Square { row } => {
                let at = *row;
                *row += 1;
                if !self.solver.system.square_row(at) {
                    self.present.begin(diary, &mut self.solver);
                    self.stage = Stage::CatchUp;
                }
                (at * self.solver.system.len().saturating_sub(at)) as u32
            }
            Stage::CatchUp => self.present.go_on(diary, &mut self.solver).unwrap_or_else(|| {
                self.stage = Stage::Ended(Progress::Done);
                0
            }),
            Stage::Arrive => self.present.arrive(diary, &mut self.solver).unwrap_or_else(|| {
                self.stage = Stage::Ended(Progress::Done);
                0
            }),
            Stage::Idle | Stage::Ended(_) => 0,
        }
    }

    /// What follows when every wall has a line.
    fn placed<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> u32 {
        if self.last == Last::No {
            self.stage = Stage::Turn { search: Search::NEW };
            return 1;
        }
        self.begin_solving(diary, if self.last == Last::Latest { STEPS_AT_LAST } else { STEPS })
    }

    fn begin_solving<const G: usize>(&mut self, diary: &mut Diary<K, G, W>, steps: u32) -> u32 {
        let mut hits = [0u32; W];
        // What only the last keyframe sees is not solved for: of a variance of metres f32 loses what is left once more is seen.
        let seen = diary.seen_from_first(diary.keyframes.len().saturating_sub(1)).iter();
        for (wall, group) in seen.filter_map(|group| Some((group.wall()?, group))) {
            if let Some(hits) = hits.get_mut(wall) {
                *hits = hits.saturating_add(u32::from(group.hits));
            }
        }
        // A wall that is new since it began has no line yet.
        let has_line = |wall: usize| diary.walls.get(wall).is_some_and(|wall| wall.is_some_and(|wall| wall.is_placed));
        self.solver.choose(diary, |wall| hits.get(wall).is_some_and(|hits| *hits >= FEWEST) && has_line(wall));
        self.steps_left = steps;
        self.stage = if self.solver.keys() < 2 || hits.iter().all(|hits| *hits < FEWEST) {
            Stage::Ended(Progress::Nothing)
        } else {
            self.solver.begin(diary);
            Stage::Solve
        };
        CHOICE_COST * diary.groups.len() as u32
    }

    fn solve<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> u32 {
        let (cost, slice) = self.solver.slice(diary);
        match slice {
            Slice::More => {}
            Slice::Unsolvable => self.stage = Stage::Ended(Progress::Unsolvable),
            Slice::Moved(largest) => {
                self.effort.steps += 1;
                self.steps_left = self.steps_left.saturating_sub(1);
                if largest < SETTLED || self.steps_left == 0 {
                    survey::begin(&mut diary.walls);
                    self.stage = Stage::Survey { cursor: Cursor::START };
                } else {
                    self.solver.begin(diary);
                }
            }
        }
        cost
    }

    fn surveyed<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> u32 {
        match self.last {
            Last::No => {
                self.twins = Twins::NEW;
                self.stage = Stage::Merge;
            }
            Last::Settling => self.solve_last(Last::Latest),
            Last::Latest => {
                let last = self.solver.keys().checked_sub(1).and_then(|last| diary.keyframes.get(last));
                diary.placed = last.map_or(0, |key| key.serial);
                self.stage = Stage::Invert { row: 0 };
            }
        }
        1
    }

    /// Unites what is one; where nothing is, or not for ever, goes on to the labels or to the last solution.
    fn merge<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> u32 {
        let cost = CHOICE_COST * diary.groups.len() as u32;
        if self.mergers_left > 0 && self.twins.unite(diary) {
            self.mergers_left -= 1;
            self.effort.merging_rounds += 1;
            return cost + self.begin_solving(diary, STEPS_BETWEEN);
        }
        let is_settled = self.labellings_left < LABELLING_ROUNDS && self.labels.changed == 0;
        if self.labellings_left > 0 && !is_settled {
            self.labellings_left -= 1;
            self.labels = Labels::NEW;
            self.stage = Stage::Label;
            return cost;
        }
        self.solve_last(Last::Settling);
        cost
    }

    /// Solves what is in the diary by now, with the lines of walls that are new in it.
    fn solve_last(&mut self, last: Last) {
        self.last = last;
        self.stage = Stage::Place { wall: 0 };
    }

    /// Whether it has a result.
    pub fn is_done(&self) -> bool {
        matches!(self.stage, Stage::Ended(Progress::Done))
    }

    /// What the look back took until now.
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Covariance of two unknowns, in their units, once it is done; none where a wall was not placed. Their means are the diary's.
    /// Together these are the state of a filter at the last keyframe that was placed, or of the present once it was handed over.
    pub fn covariance(&self, one: Unknown, other: Unknown) -> Option<f32> {
        let (one, other) = (self.place(one)?, self.place(other)?);
        Some(self.solver.system.covariance(one, other))
    }

    /// Whether f32 told every unknown of the last step from nothing: only then is their covariance one.
    pub fn is_positive(&self) -> bool {
        self.solver.system.held == 0
    }

    fn place(&self, unknown: Unknown) -> Option<usize> {
        match unknown {
            Unknown::Distance => Some(rows::DISTANCE),
            Unknown::Turn => Some(rows::TURN),
            Unknown::Veer => Some(rows::VEER),
            Unknown::Alpha => Some(rows::ALPHA),
            Unknown::X => Some(rows::LAST_POSE),
            Unknown::Y => Some(rows::LAST_POSE + 1),
            Unknown::Theta => Some(rows::LAST_POSE + 2),
            Unknown::Offset(wall) => self.solver.place(wall),
            Unknown::Direction(wall) => Some(self.solver.place(wall)? + 1),
        }
    }
}

/// What a look back finds beside the earlier poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Scale of distance.
    Distance,
    /// Scale of turning.
    Turn,
    /// Veer, radians per metre.
    Veer,
    /// Direction of the grid, radians.
    Alpha,
    /// The last pose's x, metres.
    X,
    /// Its y, metres.
    Y,
    /// Its heading, radians.
    Theta,
    /// Offset of the wall with this number at the middle of its extent, metres.
    Offset(usize),
    /// Its direction, radians.
    Direction(usize),
}
