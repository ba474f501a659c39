//! What drives: the pilot, which explores, or the floor job, which cleans: one at a time, in one memory.

use core::mem::ManuallyDrop;

use slam_core::{Pose, Rig};

use crate::bearings::Bearings;
use crate::contact::{Contacts, Lift};
use crate::floor::{AreaKind, FLOOR_RECORD_BYTES, FloorConfig, FloorJob, FloorProgress, FloorRecordError, Notes};
use crate::pilot::beam::Beam;
use crate::pilot::{Activity, Pilot, PilotConfig, Senses};
use crate::traits::{LastingMemory, WheelSpeeds};

/// What the robot knows of the map that its pose is in, at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whereabouts {
    /// A number that tells the kept map from every other one; none where none is kept.
    pub kept: Option<u32>,
    /// With another number, nothing is any more where it was: another map is kept, or none is and the robot was carried.
    pub world: u32,
    /// With a higher number, the home was in the map twice: the robot is elsewhere in it than it took itself to be for a while.
    pub redrawn: u32,
    /// With another number, the map since the last start or lift begins elsewhere.
    pub fresh: u8,
    /// The pose is in the frame of the kept map, or of the start where none is kept.
    pub is_located: bool,
    /// Direction of the walls' grid in the map frame, radians; none until it is known.
    pub grid_rad: Option<f32>,
    /// Where the map's first drive started, in the map frame.
    pub start: Pose,
    /// The pose by the wheels alone since the robot's start, whatever map it is in.
    pub reckoned: Pose,
    /// A corner of the areas in the kept map: one after the other from step to step.
    pub corner: Option<AreaCorner>,
}

impl Whereabouts {
    /// Where no map is kept, before anything is known of the walls.
    pub const START: Self = Self {
        kept: None,
        world: 0,
        redrawn: 0,
        fresh: 0,
        is_located: true,
        grid_rad: None,
        start: Pose::ORIGIN,
        reckoned: Pose::ORIGIN,
        corner: None,
    };
}

/// A corner of an area to stay out of or to clean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaCorner {
    /// Its place among the corners of all areas.
    pub index: u8,
    /// Corners of all areas.
    pub of: u8,
    /// What its area is for.
    pub kind: AreaKind,
    /// It is the first one of its area.
    pub is_first: bool,
    /// Where it is in the map frame, metres.
    pub at_m: [f32; 2],
}

/// The one that drives. A new floor job is written from the program's constants to where the other one was: a second one on the stack would need
/// as much memory again. That is so because nothing is dropped before, and there is nothing to drop in either. A pilot goes
/// over the stack, as zeros, for a constant takes as much flash as it takes memory.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "one memory for both is what this is for")]
enum Driver<const S: usize> {
    /// Nobody yet: what it takes to begin with this is no constant of the size of the others.
    Nobody,
    Pilot(ManuallyDrop<Pilot<S>>),
    Floor(ManuallyDrop<FloorJob<S>>),
}

/// What a robot with at most `S` range sensors is at: it explores, or it cleans.
#[derive(Clone, Debug)]
pub struct Job<const S: usize> {
    driver: Driver<S>,
    /// What the floor job goes by.
    bearings: Bearings,
    /// The world, and whether the robot was located in it, as of the last step.
    known: Option<(u32, u32, u8, bool)>,
    /// The pilot stands until it is told to explore.
    pauses: bool,
    /// How far what is to be known after a reset is written down.
    notes: Notes,
    lift: Lift,
}

impl<const S: usize> Job<S> {
    /// At nothing: it stands until it is told to explore or to clean.
    pub fn idle() -> Self {
        Self {
            driver: Driver::Nobody,
            bearings: Bearings::new(),
            known: None,
            pauses: false,
            notes: Notes::NEW,
            lift: Lift::NONE,
        }
    }

    /// One that explores in this manner.
    pub fn exploring(config: PilotConfig, rig: &Rig<S>) -> Self {
        let mut job = Self::idle();
        job.begin_to_explore(config, rig);
        job
    }

    /// One that cleans in this manner.
    pub fn cleaning(config: FloorConfig, rig: &Rig<S>) -> Self {
        let mut job = Self::idle();
        job.begin_to_clean(config, rig);
        job
    }

    fn begin_to_explore(&mut self, config: PilotConfig, rig: &Rig<S>) {
        self.known = None;
        self.driver = Driver::Pilot(const { ManuallyDrop::new(Pilot::ZEROS) });
        if let Driver::Pilot(pilot) = &mut self.driver {
            pilot.prepare(config, rig);
        }
    }

    // Its variables are on the stack only while it runs, not beside those of a step.
    #[inline(never)]
    fn begin_to_clean(&mut self, config: FloorConfig, rig: &Rig<S>) {
        self.known = None;
        self.bearings = Bearings::new();
        self.driver = Driver::Floor(const { ManuallyDrop::new(FloorJob::BLANK) });
        if let Driver::Floor(job) = &mut self.driver {
            job.prepare(config, Beam::of_rig(rig));
        }
    }

    /// Explores: on with it, or from here where it did not.
    pub fn explore(&mut self, rig: &Rig<S>) {
        self.pauses = false;
        if !matches!(self.driver, Driver::Pilot(_)) {
            self.begin_to_explore(PilotConfig::DEFAULT, rig);
        }
    }

    /// Cleans: on with the floor that is left, or all of it anew from here, where that is wanted, it did not clean, or it was done.
    pub fn clean(&mut self, rig: &Rig<S>, anew: bool) {
        match &mut self.driver {
            Driver::Floor(job) if !(anew || job.is_over()) => job.resume(),
            _ => self.begin_to_clean(FloorConfig::DEFAULT, rig),
        }
    }

    /// Stands until it is told to go on.
    pub fn pause(&mut self) {
        match &mut self.driver {
            Driver::Nobody => {}
            Driver::Pilot(_) => self.pauses = true,
            Driver::Floor(job) => job.pause(),
        }
    }

    /// Writes down a piece of what is to be known of the floor after a reset, in the kept map of this number: in every step, all of it
    /// in three seconds. A job that is over, or that goes by a map that is not there then, leaves nothing, nor does one that was given up for
    /// exploring.
    pub fn note(&mut self, map: Option<u32>, memory: &mut impl LastingMemory) {
        let job = match &mut self.driver {
            Driver::Floor(job) => job,
            Driver::Pilot(_) if !self.pauses => return self.notes.wipe(memory),
            Driver::Pilot(_) | Driver::Nobody => return,
        };
        match map.filter(|_| self.bearings.is_worth_noting(job)) {
            Some(map) => {
                job.note(map, &mut self.notes, memory);
            }
            None => self.notes.wipe(memory),
        }
    }

    /// The same, all of it at once; none where nothing is to be known.
    pub fn saved(&mut self, map: u32) -> Option<[u8; FLOOR_RECORD_BYTES]> {
        let mut memory = [0; FLOOR_RECORD_BYTES];
        match &mut self.driver {
            Driver::Floor(job) if self.bearings.is_worth_noting(job) => job.save(map, &mut memory),
            _ => return None,
        }
        Some(memory)
    }

    /// A job about to clean goes on with the floor that was saved, if that was in the kept map of this number.
    ///
    /// # Errors
    /// The memory has no floor job in that map: all of the floor is left.
    pub fn restore(&mut self, map: u32, memory: &impl LastingMemory) -> Result<(), FloorRecordError> {
        if let Driver::Floor(job) = &mut self.driver {
            job.restore(map, memory)?;
            self.bearings.go_by_own_map();
        }
        Ok(())
    }

    /// What the pilot is doing; none where it cleans.
    pub fn activity(&self) -> Option<Activity> {
        match &self.driver {
            Driver::Pilot(pilot) => Some(pilot.activity()),
            _ => None,
        }
    }

    /// What it is doing, in a word or two.
    pub fn doing(&self) -> &'static str {
        match &self.driver {
            Driver::Nobody => "idle",
            Driver::Pilot(pilot) => pilot.activity().name(),
            Driver::Floor(job) => job.state().name(),
        }
    }

    /// How far it is with the floor; none where it explores.
    pub fn floor(&self) -> Option<FloorProgress> {
        match &self.driver {
            Driver::Floor(job) => Some(job.progress()),
            _ => None,
        }
    }

    /// Whether there is nothing left to do, or the battery is empty.
    pub fn is_over(&self) -> bool {
        match &self.driver {
            Driver::Floor(job) => job.is_over(),
            Driver::Pilot(pilot) => pilot.is_flat(),
            Driver::Nobody => false,
        }
    }

    /// The wheel speeds until the next step.
    pub fn step(&mut self, senses: &Senses<S>, whereabouts: &Whereabouts) -> WheelSpeeds {
        let now = (whereabouts.world, whereabouts.redrawn, whereabouts.fresh, whereabouts.is_located);
        let is_elsewhere = self.known.replace(now).is_some_and(|before| before != now);
        let contacts = Contacts { lifted: self.lift.step(senses.contacts.lifted), ..senses.contacts };
        let senses = &Senses { contacts, ..*senses };
        match &mut self.driver {
            Driver::Nobody => WheelSpeeds::STOP,
            Driver::Pilot(pilot) => {
                if is_elsewhere {
                    pilot.forget();
                }
                pilot.watch_battery(&senses.condition);
                if self.pauses || pilot.is_flat() {
                    pilot.stand(senses.time_us);
                    return WheelSpeeds::STOP;
                }
                pilot.step(senses)
            }
            Driver::Floor(job) => self.bearings.step(job, senses, whereabouts),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::Condition;
    use crate::contact::Contacts;
    use crate::floor::FloorState;
    use crate::rig::default_rig;

    const HERE: Whereabouts = Whereabouts { grid_rad: Some(0.0), ..Whereabouts::START };

    /// A robot on open floor.
    struct Robot {
        job: Job<8>,
        time_us: u64,
    }

    impl Robot {
        fn new() -> Self {
            Self { job: Job::exploring(PilotConfig::DEFAULT, &default_rig()), time_us: 0 }
        }

        fn step(&mut self, whereabouts: &Whereabouts) -> WheelSpeeds {
            self.step_in(whereabouts, Condition::default())
        }

        fn step_in(&mut self, whereabouts: &Whereabouts, condition: Condition) -> WheelSpeeds {
            self.time_us += 40_000;
            let senses = Senses {
                time_us: self.time_us,
                pose: Pose::ORIGIN,
                ranges_m: [None; 8],
                contacts: Contacts::default(),
                condition,
            };
            self.job.step(&senses, whereabouts)
        }

        fn state(&self) -> Option<FloorState> {
            self.job.floor().map(|progress| progress.state)
        }
    }

    #[test]
    fn one_memory_is_no_larger_than_what_cleans() {
        assert!(size_of::<Job<8>>() <= size_of::<FloorJob<8>>() + 512, "{}", size_of::<Job<8>>());
    }

    #[test]
    fn it_explores_until_it_is_told_to_clean_and_goes_on_after_a_pause() {
        let mut robot = Robot::new();
        assert!(robot.step(&HERE).is_forward() && robot.state().is_none());
        robot.job.clean(&default_rig(), false);
        robot.step(&HERE);
        assert!(robot.step(&HERE).is_forward());
        assert_eq!(robot.state(), Some(FloorState::Edge));
        let swept_m2 = robot.job.floor().unwrap().swept_m2;
        assert!(swept_m2 > 0.0);
        robot.job.pause();
        assert_eq!((robot.step(&HERE), robot.state()), (WheelSpeeds::STOP, Some(FloorState::Paused)));
        robot.job.clean(&default_rig(), false);
        robot.step(&HERE);
        assert_eq!((robot.state(), robot.job.floor().unwrap().swept_m2), (Some(FloorState::Planning), swept_m2));
        robot.job.clean(&default_rig(), true);
        assert_eq!((robot.state(), robot.job.floor().unwrap().swept_m2), (Some(FloorState::Edge), 0.0));
        robot.job.explore(&default_rig());
        assert!(robot.state().is_none());
    }

    /// One that is told to stand plays no game with itself meanwhile, and goes on when it is told to.
    #[test]
    fn a_pilot_that_stood_for_an_hour_explores_at_once() {
        let mut robot = Robot::new();
        (0..100).for_each(|_| {
            robot.step(&HERE);
        });
        robot.job.pause();
        assert!((0..90_000).all(|_| robot.step(&HERE) == WheelSpeeds::STOP));
        robot.job.explore(&default_rig());
        assert!((0..50).any(|_| robot.step(&HERE).is_forward()));
    }

    #[test]
    fn a_pilot_with_an_empty_battery_stands_whatever_it_is_told() {
        let mut robot = Robot::new();
        let drive = |robot: &mut Robot, battery_v: f32, steps: usize| {
            let condition = Condition { battery_v: Some(battery_v), ..Condition::default() };
            (0..steps).map(|_| robot.step_in(&HERE, condition)).last()
        };
        drive(&mut robot, 11.0, 100);
        assert_ne!(drive(&mut robot, 9.0, 10), Some(WheelSpeeds::STOP), "motors that start pull the voltage down");
        assert_eq!(drive(&mut robot, 9.0, 100), Some(WheelSpeeds::STOP));
        robot.job.explore(&default_rig());
        assert!(drive(&mut robot, 9.0, 1) == Some(WheelSpeeds::STOP) && robot.job.is_over());
        drive(&mut robot, 12.0, 200);
        assert!(!robot.job.is_over());
    }

    /// Whether a robot that begins to clean in this kept map goes on with what is in the memory.
    fn goes_on(map: u32, memory: &[u8; FLOOR_RECORD_BYTES]) -> Result<(), FloorRecordError> {
        Job::<8>::cleaning(FloorConfig::DEFAULT, &default_rig()).restore(map, memory)
    }

    #[test]
    fn a_floor_is_forgotten_where_the_robot_explores_instead() {
        let (mut robot, mut memory) = (Robot::new(), [0; FLOOR_RECORD_BYTES]);
        robot.job.clean(&default_rig(), true);
        for _ in 0..200 {
            robot.step(&HERE);
            robot.job.note(Some(7), &mut memory);
        }
        assert_eq!(goes_on(7, &memory), Ok(()));
        // After a reset, nobody told the robot anything yet.
        let mut robot = Robot::new();
        robot.job.pause();
        robot.job.note(Some(7), &mut memory);
        assert_eq!(goes_on(7, &memory), Ok(()));
        robot.job.explore(&default_rig());
        robot.job.note(Some(7), &mut memory);
        assert_eq!(goes_on(7, &memory), Err(FloorRecordError::Nothing));
    }

    /// The map is saved where the robot stands, and its power may go right after that.
    #[test]
    fn a_floor_is_that_of_the_map_that_was_saved_last() {
        let (mut robot, mut memory) = (Robot::new(), [0; FLOOR_RECORD_BYTES]);
        robot.job.clean(&default_rig(), true);
        for (map, steps) in [(7, 200), (8, 1), (8, 20), (9, 1), (9, 200)] {
            for _ in 0..steps {
                robot.step(&HERE);
                robot.job.note(Some(map), &mut memory);
            }
            let kept = [7, 8, 9].map(|other| goes_on(other, &memory).is_ok());
            assert_eq!(kept, [7, 8, 9].map(|other| other == map), "{steps} steps in {map}");
        }
    }
}
