//! Whether a robot knows where it is in its kept map.
//!
//! ```text
//! Searching -> Probation      the same place in two searches, each at the odds that a claim needs; in the dock, that is expected
//! Probation -> Tracking       readings agree over some path
//! Probation -> Searching      they do not: the claim is revoked
//! Tracking  -> Doubtful       few of the last readings of walls agree
//! Doubtful  -> Tracking       they do again
//! Doubtful  -> Searching      they do not, and the odds that it is elsewhere are those that a claim needs: it is sought near there
//! any       -> Searching      lifted
//! ```

use heapless::Vec;
use slam_core::kept::{Kept, LastPose};
use slam_core::{Elsewhere, Match, Pose, SecondCopy, Slam, StepReport};

use crate::agreement::{Agreement, agreement};
use crate::copy;
use crate::dock::DockTries;
use crate::odds::{self, Displaced, Verdict};
use crate::search::{Hypothesis, Progress, Search};
use crate::{PATH_POINTS, POINTS_M};

/// Path from one search to the next, metres.
const SEARCH_EVERY_M: f32 = 0.5;

/// To begin one takes as long as so many comparisons of two matches, with a full map.
const TO_BEGIN: u32 = 2000;

/// The same to find a second copy to search, where every wall stands askew.
const TO_FIND: u32 = 1500;

/// Logarithm of the odds that a claim needs: 1000 to 1.
pub const CLAIM: f32 = 6.907_755;

/// Path for which a claim can be revoked, metres.
const PROBATION_M: f32 = 3.0;

/// Path for which a doubt lasts at least before the place is given up, metres.
const DOUBT_M: f32 = 1.0;

/// Readings are held against the map once on so much path, metres: a robot that stands sees the same thing again.
const COUNTED_EVERY_M: f32 = 0.05;

/// Path after which it is counted anew, metres. Up to there a 32-bit float keeps steps of a twentieth of a millimetre.
const LONG_M: f32 = 1024.0;

/// What a robot knows of where it is in the kept map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// It does not know: its pose is in the frame of a fresh map.
    Searching,
    /// It claims a place, and may take that back.
    Probation,
    /// It knows.
    Tracking,
    /// Its readings contradict the map.
    Doubtful,
}

impl State {
    /// Whether the pose is claimed in the frame of the kept map.
    pub fn is_located(self) -> bool {
        self != Self::Searching
    }
}

/// What has to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The kept map is to be taken up: the fresh one lies in it like this.
    Found(Match),
    /// The fresh map is to start where the robot stands, in the kept map's dock.
    Docked,
    /// The map has its walls twice: the second copy is to be given up, which lies in the older walls like this.
    Copied(SecondCopy, Match),
    /// What was claimed is wrong or not known any more: a fresh map is to be begun.
    Lost,
}

/// One step of the robot.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Where the robot is in the filter's frame, metres.
    pub position_m: [f32; 2],
    /// How far it went, metres.
    pub travelled_m: f32,
    /// Readings of walls that agreed with the map, and that are grossly off: see [`Step::of`].
    pub readings: [u8; 2],
    /// What speaks for the robot being elsewhere, as its estimator has it.
    pub elsewhere: Elsewhere,
    /// It stands in a dock.
    pub is_docked: bool,
    /// It looks to its map's dock from so far straight in front of it, metres.
    pub before_dock_m: Option<f32>,
}

impl Step {
    /// Of a robot whose estimator reported this of its last step, in which it went so far, metres; with the kept map, if there is one.
    pub fn of<const S: usize, const W: usize, const B: usize, const ROWS: usize>(
        slam: &Slam<S, W, B, ROWS>,
        report: &StepReport<S>,
        travelled_m: f32,
        kept: Option<&dyn Kept>,
    ) -> Self {
        Self {
            position_m: [slam.state_mean(0), slam.state_mean(1)],
            travelled_m,
            readings: kept.map_or([0; 2], |kept| agreement(report, kept.frame().next_id)),
            elsewhere: slam.elsewhere(),
            is_docked: false,
            before_dock_m: slam.before_dock_m(),
        }
    }

    /// Of a robot of which nothing else is known: where it is in the filter's frame and how far it went, metres.
    pub fn moved(position_m: [f32; 2], travelled_m: f32) -> Self {
        let (readings, elsewhere) = ([0; 2], Elsewhere::default());
        Self { position_m, travelled_m, readings, elsewhere, is_docked: false, before_dock_m: None }
    }
}

/// How a fresh map lies in the kept one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Begun {
    /// Anywhere: the robot was carried.
    Anywhere,
    /// It was begun in the kept one's frame, which readings contradicted.
    Contradicted,
    /// It starts in the dock, as the kept one does.
    Docked,
    /// It starts where the robot stood before its power went.
    Stood(LastPose),
}

impl Begun {
    /// Where the fresh map's start lies in the frame of the kept one's, and how the robot may be displaced against that; none where it is anywhere.
    fn place_in(self, kept: &dyn Kept) -> Option<(Pose, Displaced)> {
        match self {
            Self::Anywhere => None,
            Self::Contradicted => Some((Pose::ORIGIN, odds::CONTRADICTED)),
            Self::Docked => Some((Pose::ORIGIN, odds::DOCKED)),
            Self::Stood(LastPose { pose, place_m2, heading_rad2 }) => {
                Some((kept.frame().start.inverse().compose(&pose), Displaced::nudged(place_m2, heading_rad2)))
            }
        }
    }
}

/// Keeps track of whether the robot knows where it is.
#[derive(Clone, Debug)]
pub struct Locator {
    state: State,
    path_m: f32,
    since_m: f32,
    next_search_m: f32,
    trail: Vec<[f32; 2], PATH_POINTS>,
    /// Which frame of the filter the trail is in.
    frame: u16,
    search: Search,
    is_searching: bool,
    begun: Begun,
    /// The second copy that the last search was about, and how many states the map had then, and its next wall's identifier.
    copy: Option<(SecondCopy, [u16; 2])>,
    /// What the last search would claim.
    claim: Option<Hypothesis>,
    agreement: Agreement,
    counted_m: f32,
    dock: DockTries,
    verdict: Option<Verdict>,
    times_lost: u16,
}

impl Locator {
    /// Of a robot in this state.
    pub fn new(state: State) -> Self {
        let mut locator = Self {
            state,
            path_m: 0.0,
            since_m: 0.0,
            next_search_m: 0.0,
            trail: Vec::new(),
            frame: 0,
            search: Search::IDLE,
            is_searching: false,
            begun: Begun::Anywhere,
            copy: None,
            claim: None,
            agreement: Agreement::NEW,
            counted_m: 0.0,
            dock: DockTries::NONE,
            verdict: None,
            times_lost: 0,
        };
        locator.restart(state);
        locator
    }

    /// Begins anew in this state, in place.
    pub fn restart(&mut self, state: State) {
        self.state = state;
        (self.path_m, self.since_m, self.counted_m) = (0.0, 0.0, 0.0);
        self.next_search_m = 2.0 * SEARCH_EVERY_M;
        self.trail.clear();
        (self.is_searching, self.begun) = (false, Begun::Anywhere);
        self.dock = DockTries::NONE;
        (self.claim, self.verdict) = (None, None);
        self.agreement = Agreement::NEW;
    }

    /// What the robot knows.
    pub fn state(&self) -> State {
        self.state
    }

    /// How often the robot did not know any more where it was. It saturates.
    pub fn times_lost(&self) -> u16 {
        self.times_lost
    }

    /// What the last search found.
    pub fn verdict(&self) -> Option<&Verdict> {
        self.verdict.as_ref()
    }

    /// Whether a search is under way.
    pub fn is_searching(&self) -> bool {
        self.is_searching
    }

    /// The hypotheses of the last search, best first; those of the present one while it goes on.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        self.search.hypotheses()
    }

    /// Takes in a step of the robot with its map, the one that it is to find itself in if there is one, and about how many comparisons
    /// of two matches may be made now. Where there is something to do, it is taken for done.
    pub fn step(&mut self, own: &dyn Kept, kept: Option<&dyn Kept>, step: &Step, comparisons: u32) -> Option<Event> {
        self.count(step.travelled_m);
        self.dock.step(step.is_docked, step.before_dock_m);
        let Some(kept) = kept else { return self.watch(own, step.elsewhere.since, comparisons) };
        if self.state == State::Searching {
            if step.is_docked && kept.frame().has_dock && self.begun != Begun::Docked {
                self.restart(State::Searching);
                self.begun = Begun::Docked;
                return Some(Event::Docked);
            }
            let frame = own.frame().number;
            if core::mem::replace(&mut self.frame, frame) != frame {
                // Another frame.
                self.trail.clear();
            }
            self.remember(step.position_m);
            let found = self.work(own, kept, comparisons)?;
            self.become_state(State::Probation);
            return Some(Event::Found(found));
        }
        if self.path_m - self.counted_m > COUNTED_EVERY_M {
            self.counted_m = self.path_m;
            self.agreement.take(step.readings);
        }
        let for_m = self.path_m - self.since_m;
        match self.state {
            State::Probation if self.agreement.is_poor() => return Some(self.lost()),
            State::Probation if for_m > PROBATION_M => self.become_state(State::Tracking),
            State::Tracking if self.agreement.is_poor() => self.become_state(State::Doubtful),
            State::Doubtful if self.agreement.is_good() => self.become_state(State::Tracking),
            // Much that hides walls is no reason to give them up, where it has been there all the time.
            State::Doubtful if for_m > DOUBT_M && step.elsewhere.log_odds > CLAIM => return Some(self.contradicted()),
            _ => {}
        }
        self.watch(own, step.elsewhere.since, comparisons)
    }

    /// Adds to the path. Once it has become long it is counted from here: a long sum swallows small terms.
    fn count(&mut self, travelled_m: f32) {
        self.path_m += travelled_m;
        if self.path_m > LONG_M {
            let so_far_m = core::mem::take(&mut self.path_m);
            for mark_m in [&mut self.since_m, &mut self.next_search_m, &mut self.counted_m] {
                *mark_m -= so_far_m;
            }
        }
    }

    /// Looks for a second copy of the walls in the robot's own map, which may be what was drawn since the wall of an identifier.
    fn watch(&mut self, own: &dyn Kept, doubted: Option<u16>, mut comparisons: u32) -> Option<Event> {
        if !self.is_searching && self.path_m < self.next_search_m {
            return None;
        }
        let frame = own.frame();
        let size = [frame.states, frame.next_id];
        if !self.is_searching {
            self.next_search_m = self.path_m + SEARCH_EVERY_M;
            self.copy = copy::find(own, doubted).map(|copy| (copy, size));
            let begun = self.copy.and_then(|(copy, _)| {
                let [fewer, more] = copy::parts(own, &copy)?;
                Some(self.search.begin_displaced(&fewer, &more, copy::begins_m(own, &copy)))
            });
            self.is_searching = begun == Some(true);
            if !self.is_searching {
                self.claim = None;
                return None;
            }
            comparisons = comparisons.saturating_sub(TO_FIND + TO_BEGIN);
        }
        let (copy, begun) = self.copy?;
        // States that moved are not those that the search began with.
        let parts = copy::parts(own, &copy).filter(|_| begun == size);
        let Some(parts) = parts else {
            self.is_searching = false;
            return None;
        };
        if self.search.work(&parts[1], comparisons) == Progress::Working {
            return None;
        }
        self.is_searching = false;
        // A robot whose home is in its map twice is elsewhere in it.
        let found = self.judge(&self.search.verdict()?, self.dock.log_odds())?;
        (self.claim, self.dock) = (None, DockTries::NONE);
        let found = copy::in_older(&parts, found);
        Some(Event::Copied(copy::with_those_between(&copy, &found), found))
    }

    /// The robot does not know any more where it is: it was lifted.
    pub fn lost(&mut self) -> Event {
        self.times_lost = self.times_lost.saturating_add(self.state.is_located().into());
        self.restart(State::Searching);
        Event::Lost
    }

    /// The same of a robot whose readings contradict its map, in whose frame it goes on.
    pub fn contradicted(&mut self) -> Event {
        let event = self.lost();
        self.begun = Begun::Contradicted;
        event
    }

    /// A robot that was switched on begins to look for itself. When its power went it stood here, as far as it knew.
    pub fn stood(&mut self, last: LastPose) {
        self.restart(State::Searching);
        self.begun = Begun::Stood(last);
    }

    fn become_state(&mut self, state: State) {
        if state == State::Probation {
            self.agreement = Agreement::NEW;
            self.claim = None;
        }
        self.state = state;
        self.since_m = self.path_m;
    }

    /// Keeps a point of the path, in place of the oldest where there is no room.
    fn remember(&mut self, [x, y]: [f32; 2]) {
        let is_far = |last: &[f32; 2]| slam_core::pose::length(last[0] - x, last[1] - y) > POINTS_M;
        if !self.trail.last().is_none_or(is_far) {
            return;
        }
        if self.trail.is_full() {
            self.trail.remove(0);
        }
        let _ = self.trail.push([x, y]);
    }

    /// Goes on with the search, or begins one where it is time.
    fn work(&mut self, own: &dyn Kept, kept: &dyn Kept, mut comparisons: u32) -> Option<Match> {
        if !self.is_searching && self.path_m >= self.next_search_m {
            self.next_search_m = self.path_m + SEARCH_EVERY_M;
            self.is_searching = self.search.begin(own, kept, &self.trail);
            if let Some((start, by)) = self.begun.place_in(kept) {
                self.search.expect_near([own, kept], &start, by);
            }
            comparisons = comparisons.saturating_sub(TO_BEGIN);
        }
        if !self.is_searching || self.search.work(kept, comparisons) == Progress::Working {
            return None;
        }
        self.is_searching = false;
        self.verdict = self.search.verdict();
        self.judge(&self.verdict?, 0.0)
    }

    /// Whether a place can be claimed, where so much besides speaks for it: the search before found it, too.
    fn judge(&mut self, verdict: &Verdict, besides: f32) -> Option<Match> {
        let sure = (verdict.log_odds + besides >= CLAIM).then_some(verdict.best);
        let before = core::mem::replace(&mut self.claim, sure);
        sure.filter(|best| before.is_some_and(|before| before.is_same_place(best)))?.to_match()
    }
}
