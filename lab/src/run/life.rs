//! A robot's map over the drives that it lives through: kept, lost, and found again.
//!
//! A drive that begins in a kept map, or whose robot was lifted, goes on with a fresh map until it finds the kept one around
//! itself; then it takes that up. What the robot does with its flash is done here with a record in memory.

use hal_sim::pose::Pose2;
use kept_map::{Record, Writer, rig_hash};
use relocate::{Event, Locator, State, Step};
use slam_core::kept::Kept;
use slam_core::{HostSlam, Outcome, Rig, StepReport};

use crate::input::rig_file::MAX_SENSORS;

/// A search on the desk is done at once.
const WITHOUT_END: usize = usize::MAX;

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
    is_lifted: bool,
    frames: usize,
    last: Pose2,
    searches: Vec<Searched>,
    lost: usize,
    /// Maps that the estimator itself began anew.
    restarts: u32,
}

impl Life {
    /// Of a robot that knows where it is: its start is its map's origin.
    pub fn new(rig: &Rig<MAX_SENSORS>) -> Self {
        Self {
            kept: None,
            locator: Locator::new(State::Tracking),
            rig: rig_hash(rig),
            sequence: 0,
            is_lifted: false,
            frames: 0,
            last: Pose2::default(),
            searches: Vec::new(),
            lost: 0,
            restarts: 0,
        }
    }

    /// The robot begins somewhere in this map, a record of this sequence number, or elsewhere.
    pub fn begin_in(&mut self, map: Vec<u8>, sequence: u32) {
        self.sequence = sequence;
        self.kept = Some(map);
        self.locator.restart(State::Searching);
    }

    /// Whether the pose is claimed in the frame of the kept map, or of the drive's start where there is none.
    pub fn is_located(&self) -> bool {
        !self.is_lifted && self.locator.state().is_located()
    }

    /// Counts the frames that poses were given in.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// What every search found.
    pub fn searches(&self) -> &[Searched] {
        &self.searches
    }

    /// How often a place was given up.
    pub fn lost(&self) -> usize {
        self.lost
    }

    /// The record that the robot would keep now; none without a map.
    pub fn record(&self, slam: &HostSlam) -> Option<Vec<u8>> {
        if self.is_located() { self.record_of(slam) } else { self.kept.clone() }
    }

    fn record_of(&self, slam: &HostSlam) -> Option<Vec<u8>> {
        let mut bytes = Vec::new();
        Writer::new(slam, self.sequence + 1, self.rig).bytes(|piece| bytes.extend_from_slice(piece));
        (slam.frame().walls > 0).then_some(bytes)
    }

    /// Takes in what the wheel-drop switches say.
    pub fn lift(&mut self, slam: &mut HostSlam, is_lifted: bool) {
        if is_lifted && !self.is_lifted {
            self.kept = self.record(slam).or_else(|| self.kept.take());
            self.lose(slam);
        } else if self.is_lifted && !is_lifted {
            // What the wheels turned in the air is no motion.
            slam.restart_map();
        }
        self.is_lifted = is_lifted;
    }

    /// Begins a fresh map, with the calibration as it is known.
    fn lose(&mut self, slam: &mut HostSlam) {
        self.frames += 1;
        self.lost += usize::from(self.locator.state().is_located());
        self.locator.lost();
        slam.restart_map();
        self.restarts = slam.counters().restarts;
    }

    /// Takes in a step of the estimator, the row of this index; true where the map was taken up.
    pub fn step(&mut self, slam: &mut HostSlam, report: &StepReport<MAX_SENSORS>, index: usize) -> bool {
        let restarts = core::mem::replace(&mut self.restarts, slam.counters().restarts);
        let Some(kept) = self.kept.as_deref().filter(|_| !self.is_lifted) else { return false };
        if slam.counters().restarts != restarts && self.locator.state().is_located() {
            self.lose(slam);
            return false;
        }
        let reckoned: Pose2 = slam.dead_reckoning().into();
        let travelled_m = self.last.relative(&reckoned);
        self.last = reckoned;
        let step = Step {
            position_m: [slam.state_mean(0), slam.state_mean(1)],
            travelled_m: travelled_m.x_m.hypot(travelled_m.y_m) as f32,
            readings: agreement(report),
        };
        let Ok(record) = Record::whole(kept) else { return false };
        let before = self.locator.verdict().copied();
        let event = self.locator.step(&*slam, &record, &step, WITHOUT_END);
        if let Some(verdict) = self.locator.verdict().filter(|verdict| before.as_ref() != Some(verdict)) {
            let [x, y] = verdict.best.matched;
            self.searches.push(Searched {
                step: index,
                log_odds: verdict.log_odds,
                against_places: verdict.others,
                walls: [verdict.walls, x + y],
            });
        }
        match event {
            Some(Event::Found(found)) => match slam.take_up(&record, &found) {
                Ok(()) => {
                    self.frames += 1;
                    return true;
                }
                Err(_) => self.lose(slam),
            },
            Some(Event::Lost) => self.lose(slam),
            None => {}
        }
        false
    }
}

/// A reading that is off by less than this says nothing against the robot's place, metres: an end of a wall, a thing before it.
const GROSS_M: f32 = 0.08;

/// Readings of walls that agreed with the map, and that are grossly off.
fn agreement(report: &StepReport<MAX_SENSORS>) -> [u8; 2] {
    let count = |is: fn(&Outcome) -> bool| report.readings.iter().filter(|reading| is(&reading.outcome)).count() as u8;
    let agrees = |outcome: &Outcome| matches!(outcome, Outcome::Updated { .. });
    let is_off =
        |outcome: &Outcome| matches!(outcome, Outcome::Gated { innovation_m, .. } if innovation_m.abs() > GROSS_M);
    [count(agrees), count(is_off)]
}
