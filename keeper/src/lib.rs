//! The map that the robot keeps: found again after a start, saved where the robot stands.
//!
//! ```text
//! start -> Fresh        no record of a robot like this one, or none that it has room for
//! start -> Searching    a record; where the robot was is expected, if that was written down
//! Fresh -> Tracking     the first save
//! any   -> Searching    lifted, or the map is begun anew; where readings contradict it, it is saved before, if the place is sure
//! ```
//!
//! The other states and their ways are those of [`relocate::Locator`]. A map is saved while the place is sure, the motors are off and the
//! wheels stand: erasing a sector stops the processor for up to 0.8 s. That is where the robot is told to stand, and where it is lifted; one
//! that drives is made to stand where its map is about to be forgotten, or is twice what is kept.
#![no_std]
#![forbid(unsafe_code)]

mod last_pose;
mod transfer;

use embedded_storage::nor_flash::NorFlash;
use kept_map::{Corner, Record, Saved, Store, WORTH_M, is_outgrown, rig_hash};
use relocate::{COMPARISONS, Event, Locator, State, Step};
use robot::{AreaCorner, AreaKind, Lift, PoseNotes};
use slam_core::kept::{Kept, KeptFrame};
use slam_core::{Pose, RobotSlam, StepReport};
use wire::{Place, PlaceState, SENSORS};

/// Bytes of a slot: the small sectors of the processor's flash.
pub const SLOT_BYTES: u32 = 16 * 1024;

/// The wheels of a robot that stands turn by less in a step, metres: an encoder's edge may jitter.
const STILL_M: f32 = 0.001;

/// NOR flash that can be read as memory.
pub trait MapFlash: NorFlash {
    /// All of it.
    fn bytes(&self) -> &[u8];
}

/// What the board says of this moment.
#[derive(Clone, Copy, Debug)]
pub struct Circumstances {
    /// A wheel hangs; where it does so for more than a moment, the robot is lifted.
    pub is_lifted: bool,
    /// It stands in its dock.
    pub is_docked: bool,
    /// The robot is told to stand.
    pub stands: bool,
    /// The motors are off and stay so.
    pub is_off: bool,
}

/// The kept map, and whether the robot knows where it is in it.
pub struct Keeper<F> {
    store: Store<F>,
    /// The newest record of a robot like this one.
    saved: Option<Saved>,
    rig: u32,
    locator: Locator,
    lift: Lift,
    is_lifted: bool,
    last: Pose,
    /// Path since the map was saved, metres.
    unsaved_m: f32,
    /// Maps that the estimator began anew.
    restarts: u32,
    world: u32,
    fresh: u8,
    tally: Place,
    incoming: Option<transfer::Incoming>,
    notes: PoseNotes,
}

impl<F: MapFlash> Keeper<F> {
    /// What is in this flash, for this robot. A map of another one, or one that its estimator has no room for, is none.
    pub fn start(flash: F, slam: &RobotSlam) -> Self {
        let (mut store, rig) = (Store::new(flash, SLOT_BYTES), rig_hash(slam.rig()));
        let newest = store.newest();
        let is_own = |saved: &Saved| {
            let record = slot(store.flash(), *saved).and_then(|bytes| Record::parse(bytes).ok());
            record.is_some_and(|record| record.of_rig(rig).is_ok() && slam.suits(&record).is_ok())
        };
        let saved = newest.filter(is_own);
        let state = if saved.is_some() { State::Searching } else { State::Tracking };
        Self {
            store,
            saved,
            rig,
            locator: Locator::new(state),
            lift: Lift::NONE,
            is_lifted: false,
            last: Pose::ORIGIN,
            unsaved_m: 0.0,
            restarts: 0,
            world: 0,
            fresh: 0,
            tally: Place::default(),
            incoming: None,
            notes: PoseNotes::default(),
        }
    }

    /// Takes in a step of the estimator; true where the motors have to be held off for a save. Its variables are on the stack only while
    /// it runs, not beside those of a step.
    #[inline(never)]
    pub fn step(&mut self, slam: &mut RobotSlam, report: &StepReport<SENSORS>, now: Circumstances) -> bool {
        let now = Circumstances { is_lifted: self.lift.step(now.is_lifted), ..now };
        let reckoned = slam.dead_reckoning();
        let travelled_m = slam_core::pose::length(reckoned.x_m - self.last.x_m, reckoned.y_m - self.last.y_m);
        self.last = reckoned;
        self.unsaved_m += travelled_m;
        let receives = self.receives(now);
        let is_saving = !receives && self.is_worth_saving(slam, now);
        // Whoever has the robot in hands may turn its wheels.
        let is_waiting = is_saving && !(now.is_off && (now.is_lifted || travelled_m < STILL_M));
        if is_saving && !is_waiting {
            self.save(slam);
        }
        if !is_waiting {
            self.lift(slam, now);
        }
        let restarts = core::mem::replace(&mut self.restarts, slam.counters().restarts);
        if !self.is_lifted {
            if now.is_docked && self.is_located() {
                slam.stands_in_dock();
            }
            if restarts != self.restarts && self.saved.is_some() {
                self.locator.lost();
                self.unsaved_m = 0.0;
            } else if !slam.is_about_to_forget() {
                self.locate(slam, report, travelled_m, now.is_docked);
            } else if is_waiting {
                slam.put_off_forgetting();
            } else if self.saved.is_some() {
                self.locator.contradicted();
                self.begin_fresh(slam);
            }
        }
        receives || is_waiting
    }

    /// The map was begun anew at someone's wish.
    pub fn began_anew(&mut self) {
        self.locator.restart(if self.saved.is_some() { State::Searching } else { State::Tracking });
        self.unsaved_m = 0.0;
        self.last = Pose::ORIGIN;
        self.fresh = self.fresh.wrapping_add(1);
        self.world = self.world.wrapping_add(u32::from(self.saved.is_none()));
    }

    /// Whether the pose is in the frame of the kept map, or of the start where none is kept.
    pub fn is_located(&self) -> bool {
        self.locator.state().is_located() && !self.is_lifted
    }

    /// Check sum of the kept map, which tells it from every other one; none where none is kept.
    pub fn kept(&mut self) -> Option<u32> {
        Record::check_sum(slot(self.store.flash(), self.saved?)?)
    }

    /// With another number, nothing is any more where it was: another map is kept, or none is and the robot was carried or began
    /// anew.
    pub fn world(&self) -> u32 {
        self.world
    }

    /// With another number, the map since the last start or lift begins elsewhere: in the dock, or where the robot was when somebody wished it
    /// begun anew.
    pub fn fresh(&self) -> u8 {
        self.fresh
    }

    /// A corner of the areas in the kept map, one after the other from step to step; none where there are none.
    pub fn corner(&mut self, step: u32) -> Option<AreaCorner> {
        let record = self.record()?;
        let of = u8::try_from(record.corners().count()).ok()?;
        let index = step.checked_rem(of.into())? as u8;
        let Corner { kind, is_first, at_m } = record.corners().nth(index.into())?;
        Some(AreaCorner { index, of, kind: *AreaKind::ALL.get(usize::from(kind))?, is_first, at_m })
    }

    /// The flash.
    pub fn flash(&mut self) -> &mut F {
        self.store.flash()
    }

    /// What it is about, for the telemetry.
    pub fn place(&self) -> Place {
        let state = match self.locator.state() {
            _ if self.saved.is_none() => PlaceState::Fresh,
            State::Searching => PlaceState::Searching,
            State::Probation => PlaceState::Probation,
            State::Tracking => PlaceState::Tracking,
            State::Doubtful => PlaceState::Doubtful,
        };
        let log_odds = self.locator.verdict().map(|verdict| verdict.log_odds);
        let lost = self.locator.times_lost().into();
        Place { state, sequence: self.saved.map_or(0, |saved| saved.sequence), lost, log_odds, ..self.tally }
    }

    /// The newest record.
    fn record(&mut self) -> Option<Record<'_>> {
        Record::whole(slot(self.store.flash(), self.saved?)?).ok()
    }

    /// Whether it is beyond doubt where the robot is.
    fn is_sure(&self) -> bool {
        self.locator.state() == State::Tracking && !self.is_lifted
    }

    /// Whether the map is to be saved now: where there is enough to save and the robot stands, or is lifted, or has mapped far more than is kept;
    /// or the map is about to be forgotten and the robot could find itself in it.
    fn is_worth_saving(&mut self, slam: &RobotSlam, now: Circumstances) -> bool {
        let frame = slam.frame();
        if !self.is_sure() || frame.walls == 0 {
            return false;
        }
        let is_last = slam.is_about_to_forget() && frame.has_grid;
        let is_worth = (now.stands || now.is_lifted) && self.unsaved_m >= WORTH_M;
        is_last || is_worth || self.is_outgrown(&frame)
    }

    /// Whether it makes a stop to save. None where a save failed: it would try again and again.
    fn is_outgrown(&mut self, frame: &KeptFrame) -> bool {
        let unsaved_m = self.unsaved_m;
        self.tally.failed == 0 && is_outgrown(self.record().map(|record| record.frame()), frame, unsaved_m)
    }

    fn save(&mut self, slam: &RobotSlam) {
        // After a failure it is tried again when there is more to save.
        self.unsaved_m = 0.0;
        match self.store.save(slam, self.rig) {
            Ok(saved) => {
                self.saved = Some(saved);
                self.tally.saves = self.tally.saves.saturating_add(1);
            }
            Err(_) => self.tally.failed = self.tally.failed.saturating_add(1),
        }
    }

    /// A robot that is lifted does not know where it is set down. The guard has cut its motors.
    fn lift(&mut self, slam: &mut RobotSlam, now: Circumstances) {
        let was_lifted = core::mem::replace(&mut self.is_lifted, now.is_lifted);
        if was_lifted == now.is_lifted {
            return;
        }
        if now.is_lifted {
            slam.release();
        }
        match (now.is_lifted, self.saved) {
            (true, Some(_)) => self.lose(slam),
            (true, None) => slam.restart_elsewhere(),
            // What the wheels turned in the air is no motion.
            (false, _) => slam.restart_map(),
        }
        self.world = self.world.wrapping_add(u32::from(self.saved.is_none()));
        self.restarts = slam.counters().restarts;
    }

    /// The robot does not know where it is from now on.
    fn lose(&mut self, slam: &mut RobotSlam) {
        self.locator.lost();
        self.begin_fresh(slam);
    }

    /// Begins a fresh map, with the calibration as it is known.
    fn begin_fresh(&mut self, slam: &mut RobotSlam) {
        self.unsaved_m = 0.0;
        slam.restart_map();
        self.restarts = slam.counters().restarts;
    }

    #[inline(never)]
    fn locate(&mut self, slam: &mut RobotSlam, report: &StepReport<SENSORS>, travelled_m: f32, is_docked: bool) {
        let Self { store, saved, locator, .. } = self;
        // A map that it has made itself since its start, as far as it goes, is no reason to doubt where it is.
        let is_in_it = self.tally.found > 0 || locator.state() == State::Searching;
        let bytes = saved.filter(|_| is_in_it).and_then(|saved| slot(store.flash(), saved));
        let record = bytes.and_then(|bytes| Record::whole(bytes).ok());
        let kept = record.as_ref().map(|record| record as &dyn Kept);
        let step = Step { is_docked, ..Step::of(slam, report, travelled_m, kept) };
        match locator.step(&*slam, kept, &step, COMPARISONS) {
            Some(Event::Found(found)) => {
                if record.is_some_and(|record| slam.take_up(&record, &found).is_ok()) {
                    self.tally.found = self.tally.found.saturating_add(1);
                    self.unsaved_m = 0.0;
                } else {
                    self.lose(slam);
                }
            }
            Some(Event::Docked) => {
                if slam.begin_in_dock() {
                    self.fresh = self.fresh.wrapping_add(1);
                }
                self.restarts = slam.counters().restarts;
            }
            Some(Event::Copied(copy, found)) => {
                // A copy whose walls went in this step is found again.
                let _ = slam.give_up_copy(&copy, &found);
            }
            Some(Event::Lost) => self.begin_fresh(slam),
            None => {}
        }
    }
}

/// The bytes of a slot.
fn slot<F: MapFlash>(flash: &F, saved: Saved) -> Option<&[u8]> {
    let from = saved.slot as usize * SLOT_BYTES as usize;
    flash.bytes().get(from..from + SLOT_BYTES as usize)
}
