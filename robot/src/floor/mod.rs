//! The floor job: sweeps a home's floor and comes back to where it started.
//!
//! It goes along everything that stands on the floor first, a finger's breadth from it, which leads it through all rooms; then
//! it sweeps the rest in lanes along the walls' grid, the nearest floor first; then it returns. What it remembers is a picture
//! of the home in cells of 16 cm, which quarters of these were swept, and the points near it of the last seconds.

mod areas;
mod astray;
mod bounds;
mod config;
mod contact;
mod dock;
mod edges;
mod errand;
mod frame;
mod hug;
mod lanes;
mod larger;
mod look;
mod near;
mod overview;
mod phase;
mod place;
mod progress;
mod record;
mod sheet;
mod swept;
mod traction;
mod trail;
mod travel;
mod wave;

use slam_core::{Pose, Rig};

use crate::contact::Insistence;
use crate::pilot::beam::Beam;
use crate::pilot::{PilotConfig, Senses};
use crate::traits::WheelSpeeds;
use areas::Areas;
use astray::Astray;
pub use bounds::{AREAS, AreaKind, BadArea, Bounds, CORNERS};
pub use config::FloorConfig;
use dock::Stage;
use errand::Errand;
use frame::Frame;
use near::Near;
use phase::Phase;
use place::{GIVEN_UP, Place};
use progress::Tally;
pub use progress::{FloorProgress, FloorState};
pub(crate) use record::Notes;
pub use record::{FLOOR_RECORD_BYTES, FloorRecordError};
use sheet::{Axis, QUARTER_M, Sheet};
pub(crate) use swept::BRUSH_M;
use traction::Traction;
use trail::Trail;
use wave::{Aim, Route, Target, Wave};

/// Without new floor for so long a path an edge is done, metres.
const BARREN_M: f32 = 1.0;
/// Share of a path along an edge that counts as such where nothing is to be cleaned: once round a room it leads to where something is.
const ELSEWHERE: f32 = 0.1;
/// Path along an edge that a new quarter is worth, metres: one row of them, 13 a metre, is not enough to go on.
const WORTH_M: f32 = 0.035;
/// The floor job of a robot with at most `S` range sensors.
#[derive(Clone, Debug)]
pub struct FloorJob<const S: usize> {
    config: FloorConfig,
    frame: Frame,
    sheet: Sheet,
    near: Near,
    beams: [Beam; S],
    /// Ranges of the step before, tenths of a millimetre.
    before: [u16; S],
    wave: Wave,
    route: Route,
    phase: Phase,
    /// What goes on after backing off.
    resume: Phase,
    /// When the phase began, microseconds.
    since_us: u64,
    last: Option<Pose>,
    /// Where the job began, in the map frame, and whether the dock is there.
    home: Option<Pose>,
    has_dock: bool,
    errand: Errand,
    astray: Astray,
    /// The battery's mean voltage of late, volts; not a number where it is not measured.
    battery_v: f32,
    traction: Traction<S>,
    /// How often the robot was held since something changed.
    holds: u8,
    trail: Trail,
    path_m: f32,
    /// Path when the phase began, metres.
    begun_m: f32,
    /// How far an edge is still worth going along, metres: new floor adds to it.
    credit_m: f32,
    /// Path when something was beside the robot last, metres.
    beside_m: f32,
    /// Quarters swept since the target was chosen.
    gained: u16,
    /// What the job is after: the target chosen last.
    target: Option<Target>,
    axis: Axis,
    /// Where and when the robot last came on.
    moved: ([f32; 2], u64),
    /// Where the bumper was first pressed of late, metres, and how often since near there.
    struck_m: [f32; 2],
    strikes: u8,
    insistence: Insistence,
    /// To which side it turns away next: 1 counter-clockwise, -1 clockwise.
    turn_sign: i8,
    given_up: heapless::Vec<Place, GIVEN_UP, u8>,
    retries: u8,
    /// Rounds of tries to dock.
    rounds: u8,
    /// How often it left a pocket, and looked for a way through narrow places.
    pockets: u8,
    squeezes: u8,
    /// How often the way to the target was blocked.
    blocked: u8,
    steps: u8,
    /// When the last step was; it wraps.
    stepped_at: u8,
    tally: Tally,
    areas: Areas,
    /// What was written down of it for after a reset is of these cells.
    is_noted: bool,
}

impl<const S: usize> FloorJob<S> {
    /// One that knows nothing, not even the robot: to be begun.
    pub(crate) const BLANK: Self = Self {
        config: FloorConfig::DEFAULT,
        frame: Frame::MAP,
        sheet: Sheet::new(),
        near: Near::new(),
        beams: [Beam::NONE; S],
        before: [u16::MAX; S],
        wave: Wave::new(),
        route: Route::new(),
        phase: Phase::Seek { to_m: None },
        resume: Phase::Seek { to_m: None },
        since_us: 0,
        last: None,
        home: None,
        has_dock: false,
        errand: Errand::FIRST,
        astray: Astray::NEW,
        battery_v: f32::NAN,
        traction: Traction::new(),
        holds: 0,
        trail: Trail::new(),
        path_m: 0.0,
        begun_m: 0.0,
        credit_m: 0.0,
        beside_m: 0.0,
        gained: 0,
        target: None,
        axis: Axis::X,
        moved: ([f32::INFINITY; 2], 0),
        struck_m: [f32::INFINITY; 2],
        strikes: 0,
        insistence: Insistence::NONE,
        turn_sign: 1,
        given_up: heapless::Vec::new(),
        retries: 0,
        rounds: 0,
        pockets: 0,
        squeezes: 0,
        blocked: 0,
        steps: 0,
        stepped_at: 0,
        tally: Tally::new(),
        areas: Areas::NONE,
        is_noted: false,
    };

    /// A job about to begin where the robot is: that is home.
    pub fn new(config: FloorConfig, rig: &Rig<S>) -> Self {
        let mut job = Self::BLANK;
        job.prepare(config, Beam::of_rig(rig));
        job
    }

    /// Begins anew where the robot is: that is home now. The memory is written where it lies; no second one is needed for it.
    pub fn begin_anew(&mut self) {
        let (config, beams) = (self.config, self.beams);
        *self = Self::BLANK;
        self.prepare(config, beams);
    }

    /// A blank job becomes that of a robot with these beams.
    pub(crate) fn prepare(&mut self, config: FloorConfig, beams: [Beam; S]) {
        let drive = PilotConfig { cell_m: 2.0 * QUARTER_M, ..config.drive };
        self.config = FloorConfig { drive, ..config };
        self.beams = beams;
    }

    /// The direction of the walls' grid in the map frame (radians) is known: lanes run along it from now on.
    pub fn align(&mut self, grid_rad: f32) {
        if let Some(turned_rad) = self.frame.align(grid_rad) {
            self.sheet.clear();
            self.near.turn(turned_rad);
            self.trail = Trail::new();
            self.tally.clear();
            self.last = None;
            self.rename_cells();
        }
    }

    /// The robot goes on in another map, where this pose of the map so far is that one: what was swept and what stands there stays.
    pub(crate) fn go_on_in(&mut self, before: &Pose, now: &Pose) {
        self.frame.go_on(before, now);
    }

    /// What it is doing.
    pub fn state(&self) -> FloorState {
        match self.phase {
            Phase::Seek { .. } | Phase::Edge { .. } => FloorState::Edge,
            Phase::Lane(_) | Phase::Enter { .. } => FloorState::Lane,
            Phase::Plan { .. } | Phase::Trace { .. } => FloorState::Planning,
            Phase::Transit { aim: Aim::Place(_), .. } | Phase::Home => FloorState::Return,
            Phase::Transit { aim: Aim::Exit(_), .. } if !self.errand.is_to_sweep() => FloorState::Return,
            Phase::Transit { .. } if self.retries > 0 => FloorState::Retry,
            Phase::Transit { .. } => FloorState::Transit,
            Phase::Back | Phase::Turn { .. } | Phase::Retreat { .. } => FloorState::BackingOff,
            Phase::Undock => FloorState::Undocking,
            Phase::Dock { stage: Stage::Staging | Stage::BackingOut, .. } => FloorState::Staging,
            Phase::Dock { stage: Stage::Aligning, .. } => FloorState::Aligning,
            Phase::Dock { stage: Stage::Approaching, .. } => FloorState::Approaching,
            Phase::Dock { stage: Stage::Pressing, .. } => FloorState::Pressing,
            Phase::Charge => FloorState::Charging,
            Phase::Wait { .. } => FloorState::Waiting,
            Phase::Paused => FloorState::Paused,
            Phase::Lost { .. } => FloorState::Lost,
            Phase::Held => FloorState::Held,
            Phase::Touched { .. } => FloorState::Touched,
            Phase::Blind => FloorState::Blind,
            Phase::Over { is_home } if self.is_flat(is_home) => FloorState::Flat,
            Phase::Over { is_home: true } if self.areas.missed != 0 => FloorState::Unreached,
            Phase::Over { is_home: true } => FloorState::Done,
            Phase::Over { is_home: false } => FloorState::Away,
        }
    }

    /// How far it is.
    pub fn progress(&self) -> FloorProgress {
        FloorProgress { missed: self.areas.missed, ..self.tally.progress(self.state()) }
    }

    /// Whether it is over.
    pub fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over { .. })
    }

    /// The wheel speeds until the next step. A pose that is not finite stops the robot.
    pub fn step(&mut self, senses: &Senses<S>) -> WheelSpeeds {
        let pose = self.frame.pose(&senses.pose);
        self.tally.step(&self.sheet, self.state(), senses.time_us);
        if !(pose.x_m.is_finite() && pose.y_m.is_finite() && pose.theta_rad.is_finite()) {
            return WheelSpeeds::STOP;
        }
        self.watch_battery(&senses.condition, senses.time_us);
        self.insistence.step(senses.contacts.touches() && self.phase.gets_away());
        if !self.is_located(senses) {
            return self.find_oneself(senses);
        }
        if self.home.is_none() {
            self.home = Some(senses.pose);
            self.has_dock = senses.condition.is_charging;
            if self.has_dock && self.phase != Phase::Paused {
                self.begin(Phase::Undock, senses.time_us);
            }
        }
        self.watch_jumps(&pose, senses.time_us);
        let is_renamed = self.look(senses, &pose);
        self.sweep(&pose, senses.time_us);
        self.last = Some(pose);
        if is_renamed {
            // A step of its own: it takes long as it is.
            return WheelSpeeds::STOP;
        }
        let (forward_mps, turn_radps) = self.act(senses, &pose);
        WheelSpeeds::from_twist(forward_mps, turn_radps, self.config.drive.track_m)
    }

    fn sweep(&mut self, pose: &Pose, time_us: u64) {
        let last = self.last.unwrap_or(*pose);
        let step_m = slam_core::pose::length(pose.x_m - last.x_m, pose.y_m - last.y_m);
        self.path_m += step_m;
        self.areas.drive(step_m);
        let new = self.sheet.sweep(pose);
        self.gained = self.gained.saturating_add(new);
        self.tally.add(new);
        if !matches!(self.phase, Phase::Retreat { .. }) {
            self.trail.step([pose.x_m, pose.y_m]);
        }
        if let Phase::Lane(lane) = self.phase {
            self.trail.correct(lane.jump_m(&last, pose));
        }
        if self.traction.step(&self.beams, step_m) {
            self.holds = 0;
        }
        let spent_m = if self.areas.is_elsewhere { ELSEWHERE * step_m } else { step_m };
        // On the way home an edge leads past what bars it, whatever there is to sweep.
        let earned_m = if self.errand.is_to_sweep() { WORTH_M * f32::from(new) } else { 0.0 };
        self.credit_m = (self.credit_m - spent_m + earned_m).min(self.credit_m.max(self.barren_m()));
        let ([x_m, y_m], _) = self.moved;
        if slam_core::pose::length(pose.x_m - x_m, pose.y_m - y_m) > 0.05 {
            self.moved = ([pose.x_m, pose.y_m], time_us);
        }
    }

    fn begin(&mut self, phase: Phase, time_us: u64) {
        self.begun_m = self.path_m;
        self.phase = phase;
        self.since_us = time_us;
        self.moved.1 = time_us;
    }

    fn act(&mut self, senses: &Senses<S>, pose: &Pose) -> (f32, f32) {
        let now_us = senses.time_us;
        if let Some(command) = self.phase.is_sweeping().then(|| self.answer(senses, pose)).flatten() {
            return command;
        }
        match self.phase {
            Phase::Over { .. } | Phase::Paused | Phase::Lost { .. } => (0.0, 0.0),
            Phase::Held => self.stay_held(now_us),
            Phase::Blind => self.stay_blind(now_us),
            Phase::Touched { by } => self.stay_touched(by, senses),
            Phase::Back => self.back(senses, pose),
            Phase::Turn { sign } => self.turn_away(sign, now_us),
            Phase::Retreat { left_m } => self.retreat(left_m, pose, now_us),
            Phase::Seek { to_m } => self.seek(to_m, pose, now_us),
            Phase::Edge { side } => self.edge(side, pose, now_us),
            Phase::Plan { aim, escape, begun } => self.search(aim, escape, begun, pose, now_us),
            Phase::Trace { target, aim } => self.trace(target, aim, now_us),
            Phase::Transit { target, aim } => self.transit(target, aim, pose, now_us),
            Phase::Enter { lane, at_m } => self.enter(lane, at_m, pose, now_us),
            Phase::Lane(lane) => self.follow_lane(lane, pose, now_us),
            Phase::Home => self.go_home(pose, now_us),
            Phase::Dock { stage, tries } => self.dock_step(stage, tries, senses, pose),
            Phase::Undock => self.undock(now_us),
            Phase::Charge => self.charge(&senses.condition, now_us),
            Phase::Wait { is_told } => self.wait(is_told, now_us),
        }
    }
}

#[cfg(test)]
mod tests;
