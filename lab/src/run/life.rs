//! A robot's map over the drives that it lives through: kept, lost, and found again.
//!
//! A drive that begins in a kept map, or whose robot was lifted, goes on with a fresh map until it finds the kept one around
//! itself; then it takes that up. What the robot does with its flash is done here with a record in memory.

use hal_sim::pose::Pose2;
use kept_map::{Areas, Corner, Record, Writer, rig_hash};
use relocate::{Event, Hypothesis, Locator, State, Step, path_on_grid};
use robot::{AreaCorner, AreaKind, Bounds, Lift};
use slam_core::kept::{Kept, LastPose};
use slam_core::{HostSlam, Rig, StepReport};

use crate::input::rig_file::MAX_SENSORS;

/// A search on the desk is done in the step in which it begins.
const AT_ONCE: u32 = u32::MAX;

/// A place whose odds against the best one are below this is none, natural logarithm: one in a thousand.
const UNLIKELY: f32 = -6.9;

/// Where the robot may be in the kept map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its pose in the kept map's frame.
    pub pose: Pose2,
    /// Share of all the odds that it is there, 0 to 1; the rest is elsewhere.
    pub share: f64,
}

/// What a search found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Searched {
    /// Index of the row after which it ended.
    pub step: usize,
    /// Natural logarithm of the odds of the best place against all others and elsewhere.
    pub log_odds: f32,
    /// The same against the other places only.
    pub against_places: f32,
    /// Walls of the fresh map, and of these those that stand where kept ones do.
    pub walls: [u8; 2],
}

/// A robot's map over what it lives through.
pub struct Life {
    kept: Option<Vec<u8>>,
    locator: Locator,
    rig: u32,
    sequence: u32,
    lift: Lift,
    is_lifted: bool,
    is_docked: bool,
    /// It was lifted, or began somewhere in a kept map.
    was_carried: bool,
    /// Counts the areas that were drawn: with others, the robot is in another world.
    world: u32,
    /// Counts where the fresh map began anew in the dock.
    fresh: u8,
    last: Pose2,
    searches: Vec<Searched>,
    places: Vec<Hypothesis>,
    /// Maps that the estimator itself began anew.
    restarts: u32,
    /// Areas that the user drew, in the frame of the start.
    bounds: Bounds,
}

impl Life {
    /// Of a robot that knows where it is: its start is its map's origin.
    pub fn new(rig: &Rig<MAX_SENSORS>) -> Self {
        Self {
            kept: None,
            locator: Locator::new(State::Tracking),
            rig: rig_hash(rig),
            sequence: 0,
            lift: Lift::NONE,
            is_lifted: false,
            is_docked: false,
            was_carried: false,
            world: 0,
            fresh: 0,
            last: Pose2::default(),
            searches: Vec::new(),
            places: Vec::new(),
            restarts: 0,
            bounds: Bounds::NONE,
        }
    }

    /// These areas, in the frame of the start, are kept with the map from now on.
    pub fn draw_areas(&mut self, bounds: &Bounds) {
        if self.bounds != *bounds {
            self.bounds = bounds.clone();
            self.world += 1;
        }
    }

    /// The robot begins somewhere in this map, a record of this sequence number, or elsewhere.
    pub fn begin_in(&mut self, map: Vec<u8>, sequence: u32) {
        self.sequence = sequence;
        self.kept = Some(map);
        self.was_carried = true;
        self.locator.restart(State::Searching);
    }

    /// Having begun in a map, the robot expects itself where it was in that when its power went.
    pub fn stood(&mut self, last: LastPose) {
        self.locator.stood(last);
    }

    /// Where the robot is if its power goes now; none where it is not sure of that.
    pub fn last_pose(&self, slam: &HostSlam) -> Option<LastPose> {
        let is_sure = self.locator.state() == State::Tracking && !self.is_lifted;
        robot::last_pose(slam).filter(|_| is_sure)
    }

    /// Whether the pose is claimed in the frame of the kept map, or of the drive's start where there is none.
    pub fn is_located(&self) -> bool {
        !self.is_lifted && self.locator.state().is_located()
    }

    /// Whether it is not located and no odometry says how it came where it is.
    pub fn is_carried(&self) -> bool {
        !self.is_located() && self.was_carried
    }

    /// With another number, nothing is any more where it was.
    pub fn world(&self) -> u32 {
        self.world
    }

    /// With another number, the map since the last start or lift begins elsewhere.
    pub fn fresh(&self) -> u8 {
        self.fresh
    }

    /// A corner of the areas in the map, one after the other from step to step; none where there are none, or the robot is not
    /// located.
    pub fn corner(&self, slam: &HostSlam) -> Option<AreaCorner> {
        if !self.is_located() {
            return None;
        }
        let areas = self.areas(slam);
        let of = u8::try_from(areas.corners().count()).ok()?;
        let index = slam.counters().steps.checked_rem(of.into())? as u8;
        let Corner { kind, is_first, at_m } = areas.corners().nth(index.into())?;
        Some(AreaCorner { index, of, kind: *AreaKind::ALL.get(usize::from(kind))?, is_first, at_m })
    }

    /// What every search found.
    pub fn searches(&self) -> &[Searched] {
        &self.searches
    }

    /// Where the last search found that the robot may be, likeliest first; empty while it is located.
    pub fn places(&self, slam: &HostSlam) -> Vec<Place> {
        let (Some(record), Some(last)) = (self.sought(), self.searches.last()) else { return Vec::new() };
        // Odds of the best place against all else are its share's against the rest.
        let share = 1.0 / (1.0 + f64::from(-last.log_odds).exp());
        let first = self.places.first().map_or(0.0, |best| best.score);
        let likely = self.places.iter().filter(|place| place.score - first > UNLIKELY);
        let pose = |place: &Hypothesis| in_kept_map(slam, record.mean(ALPHA), place);
        likely.map(|place| Place { pose: pose(place), share: share * f64::from(place.score - first).exp() }).collect()
    }

    /// The kept map that the robot looks for itself in; none while it is located, or has none.
    pub fn sought(&self) -> Option<Record<'_>> {
        Record::whole(self.kept.as_deref().filter(|_| !self.is_located())?).ok()
    }

    /// How often a place was given up.
    pub fn lost(&self) -> usize {
        self.locator.times_lost().into()
    }

    /// The record that the robot would keep now; none without a map.
    pub fn record(&self, slam: &HostSlam) -> Option<Vec<u8>> {
        if self.is_located() { self.record_of(slam) } else { self.kept.clone() }
    }

    fn record_of(&self, slam: &HostSlam) -> Option<Vec<u8>> {
        let mut bytes = Vec::new();
        let areas = self.areas(slam);
        let writer = Writer::new(slam, self.sequence + 1, self.rig).with_areas(&areas);
        writer.bytes(|piece| bytes.extend_from_slice(piece));
        (slam.frame().walls > 0).then_some(bytes)
    }

    /// The areas that the map is kept with, in its frame: those of the map before where none were drawn.
    fn areas(&self, slam: &HostSlam) -> Areas {
        let kept = self.kept.as_deref().and_then(|kept| Record::whole(kept).ok());
        if let Some(kept) = kept.filter(|_| self.bounds.is_empty()) {
            return kept.areas();
        }
        let in_map = self.bounds.seen_from(&slam.start_pose().inverse());
        let mut areas = Areas::NONE;
        for (number, kind) in (0..).zip(AreaKind::ALL) {
            for corners in in_map.areas(kind) {
                // A map has room for as many as a plan may have.
                let _ = areas.add(number, corners);
            }
        }
        areas
    }

    /// Takes in what the charging contact says of the step that comes next.
    pub fn dock(&mut self, is_docked: bool) {
        self.is_docked = is_docked;
    }

    /// Takes in whether the wheel-drop switches say that a wheel hangs.
    pub fn lift(&mut self, slam: &mut HostSlam, hangs: bool) {
        let is_lifted = self.lift.step(hangs);
        if is_lifted && !self.is_lifted {
            self.kept = self.record(slam).or_else(|| self.kept.take());
            self.was_carried = true;
            self.locator.lost();
            self.begin_anew(slam);
        } else if self.is_lifted && !is_lifted {
            // What the wheels turned in the air is no motion.
            slam.restart_map();
        }
        self.is_lifted = is_lifted;
    }

    /// Begins a fresh map, with the calibration as it is known: what was found out in another one's frame is of no use.
    fn begin_anew(&mut self, slam: &mut HostSlam) {
        self.places.clear();
        slam.restart_map();
        self.restarts = slam.counters().restarts;
    }

    /// The map that its readings contradict is kept, and the robot looks for itself in it. A robot that was not sure that it is in
    /// the kept map keeps that one as it was; a map without a grid is none to find oneself in.
    fn keep_contradicted(&mut self, slam: &mut HostSlam) -> bool {
        if self.locator.state() == State::Tracking && slam.frame().has_grid {
            self.kept = self.record_of(slam).or_else(|| self.kept.take());
        }
        if self.kept.is_some() {
            self.locator.contradicted();
            self.begin_anew(slam);
        }
        false
    }

    /// Takes in a step of the estimator, the row of this index; true where the robot is in another map, or elsewhere in its own.
    pub fn step(&mut self, slam: &mut HostSlam, report: &StepReport<MAX_SENSORS>, index: usize) -> bool {
        let restarts = core::mem::replace(&mut self.restarts, slam.counters().restarts);
        if self.is_lifted {
            return false;
        }
        if self.is_docked && self.is_located() {
            slam.stands_in_dock();
        }
        if slam.counters().restarts != restarts && self.kept.is_some() {
            self.locator.lost();
            self.places.clear();
            return false;
        }
        if slam.is_about_to_forget() {
            return self.keep_contradicted(slam);
        }
        let reckoned: Pose2 = slam.dead_reckoning().into();
        let moved = self.last.relative(&reckoned);
        self.last = reckoned;
        let travelled_m = moved.x_m.hypot(moved.y_m) as f32;
        let record = self.kept.as_deref().and_then(|kept| Record::whole(kept).ok());
        let kept = record.as_ref().map(|record| record as &dyn Kept);
        let step = Step { is_docked: self.is_docked, ..Step::of(slam, report, travelled_m, kept) };
        let before = self.locator.verdict().copied();
        let event = self.locator.step(&*slam, kept, &step, AT_ONCE);
        if let Some(verdict) = self.locator.verdict().filter(|verdict| before.as_ref() != Some(verdict)) {
            let [x, y] = verdict.best.matched;
            self.places = self.locator.hypotheses().to_vec();
            self.searches.push(Searched {
                step: index,
                log_odds: verdict.log_odds,
                against_places: verdict.others,
                walls: [verdict.walls, x + y],
            });
        }
        match event {
            Some(Event::Found(found)) => {
                if record.is_some_and(|record| slam.take_up(&record, &found).is_ok()) {
                    return true;
                }
                self.locator.lost();
                self.begin_anew(slam);
            }
            Some(Event::Docked) => {
                let is_new_frame = slam.begin_in_dock();
                self.fresh = self.fresh.wrapping_add(is_new_frame.into());
                self.restarts = slam.counters().restarts;
                self.places.clear();
                return is_new_frame;
            }
            Some(Event::Copied(copy, found)) => return slam.give_up_copy(&copy, &found).is_ok(),
            Some(Event::Lost) => self.begin_anew(slam),
            None => {}
        }
        false
    }
}

/// The state that is the grid's direction.
const ALPHA: usize = 3;

/// Where the robot is in the kept map, whose grid has this direction (radians), if its fresh one lies there like this.
fn in_kept_map(slam: &HostSlam, kept_rad: f32, place: &Hypothesis) -> Pose2 {
    let (pose, fresh_rad) = (slam.filter_pose(), slam.state_mean(ALPHA));
    let quarters = f64::from(place.quarters) * core::f64::consts::FRAC_PI_2;
    let [x_m, y_m] = path_on_grid([pose.x_m, pose.y_m], fresh_rad).map(f64::from);
    let on_grid = Pose2::new(x_m, y_m, f64::from(pose.theta_rad - fresh_rad));
    let shift = Pose2::new(place.shift_m[0].into(), place.shift_m[1].into(), quarters);
    Pose2::new(0.0, 0.0, kept_rad.into()).compose(&shift).compose(&on_grid)
}
