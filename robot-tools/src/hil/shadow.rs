//! The host's estimator beside the firmware's: same samples, same bits.

use hal_sim::{Face, SeenWall};
use keeper::{Circumstances, Keeper};
use kept_map::{Writer, rig_hash};
use look_back::{RobotBackEnd, STEP_US};
use robot::rig::BuiltIn;
use slam_core::{Config, RobotSlam, StepReport};
use wire::{Contacts, Estimate, Faults, LookBack, Place, Sample};

use super::flash::Memory;
use super::link::Answer;
use super::outcome::{Difference, Latenesses, Outcome};
use lab::evaluate::score;
use lab::evaluate::score::map::PassedWall;
use lab::recording::{Pose2, Segment};

/// The host's estimator, with a count of what was the same.
pub struct Shadow {
    slam: Box<RobotSlam>,
    /// The back end, where the firmware hands over.
    back_end: Option<Box<RobotBackEnd>>,
    keeper: Keeper<Memory>,
    /// The loop runs on the processor's own clock: what changes just as a sample is due is in that one or in the next.
    is_timed: bool,
    /// The contacts that were shown last.
    shown: Contacts,
    identical: u64,
    differences: Vec<Difference>,
    paths: Vec<[Pose2; 3]>,
    faults: Option<Faults>,
    look_back: Option<LookBack>,
    place: Option<Place>,
    late_us: Vec<u32>,
    damaged: u32,
}

impl Shadow {
    /// The estimator as the firmware starts it, with what its flash for maps has.
    pub fn new(robot: BuiltIn, hand_overs: bool, is_timed: bool, flash: Vec<u8>) -> Result<Self, String> {
        let config = Config { hand_overs, ..Config::for_rig::<{ wire::SENSORS }>(&robot.rig()) };
        let slam = RobotSlam::with_config(robot.rig(), config);
        let slam = Box::new(slam.map_err(|error| format!("the built-in rig: {} {}", error.key, error.allowed))?);
        let keeper = Keeper::start(Memory(flash), &slam);
        Ok(Self {
            slam,
            back_end: hand_overs.then(|| Box::new(RobotBackEnd::IDLE)),
            keeper,
            is_timed,
            shown: Contacts::default(),
            identical: 0,
            differences: Vec::new(),
            paths: Vec::new(),
            faults: None,
            look_back: None,
            place: None,
            late_us: Vec::new(),
            damaged: 0,
        })
    }

    /// Takes the sample that the firmware says it took, and holds its estimate against the host's. `shown` is what the
    /// sensors showed at that time. Gives the firmware's estimate.
    pub fn check(&mut self, shown: &Sample, answer: &Answer, truth: Pose2) -> Option<Estimate> {
        self.damaged += answer.damaged;
        self.faults = answer.faults.or(self.faults);
        self.look_back = answer.look_back.or(self.look_back);
        self.place = answer.place.or(self.place);
        let (sample, theirs) = (answer.sample.as_ref()?, answer.estimate?);
        if !self.is_of(sample, shown) {
            self.differ(sample, &format!("the sample is not what the sensors showed: {sample:?}, {shown:?}"));
        }
        self.shown = shown.contacts;
        let report = self.slam.step(&sample.to_slam());
        let ours = Estimate::of(&self.slam, sample.time_us);
        // In the order and with the work of the firmware's tasks.
        let mut hands_over = false;
        if let Some(back_end) = &mut self.back_end {
            back_end.record(&self.slam, &report);
            hands_over = back_end.is_catching_up();
        }
        if !hands_over || self.slam.is_about_to_forget() {
            self.keep(sample, &report, answer.flash.as_deref());
        }
        if let Some(back_end) = &mut self.back_end {
            back_end.work(STEP_US);
            back_end.hand_over(&mut self.slam);
        }
        self.late_us.push(theirs.late_us);
        if ours.same_bits(&theirs) {
            self.identical += 1;
        } else {
            self.differ(sample, &format!("host {:?}, target {:?}", ours.pose, theirs.pose));
        }
        let pose = |[x_m, y_m, theta_rad]: [f32; 3]| Pose2::new(x_m.into(), y_m.into(), theta_rad.into());
        self.paths.push([pose(theirs.pose), pose(theirs.dead_reckoning), truth]);
        Some(theirs)
    }

    /// Keeps the map as the firmware does, which saved it where its flash has changed; both must have the same bytes then.
    fn keep(&mut self, sample: &Sample, report: &StepReport<{ wire::SENSORS }>, flash: Option<&[u8]>) {
        let saved = flash.filter(|theirs| *theirs != self.keeper.flash().0);
        let (Contacts { lifted: is_lifted, docked: is_docked, .. }, is_saved) = (sample.contacts, saved.is_some());
        let now = Circumstances { is_lifted, is_docked, stands: is_saved, is_off: is_saved };
        self.keeper.step(&mut self.slam, report, now);
        if saved.is_some_and(|theirs| theirs != self.keeper.flash().0) {
            self.differ(sample, "the map that was saved");
        }
    }

    /// Whether this is the sample that was shown.
    fn is_of(&self, sample: &Sample, shown: &Sample) -> bool {
        let but_contacts = Sample { contacts: shown.contacts, ..sample.clone() };
        let is_late = self.is_timed && sample.contacts == self.shown;
        but_contacts == *shown && (is_held(&sample.contacts, &shown.contacts, &self.shown) || is_late)
    }

    fn differ(&mut self, sample: &Sample, what: &str) {
        self.differences.push(Difference { time_us: sample.time_us, what: what.to_owned() });
    }

    /// The record that the robot would keep now; none without a map, or where it does not know where it is in the one that it has.
    pub fn record(&self) -> Option<Vec<u8>> {
        let mut bytes = Vec::new();
        Writer::new(&*self.slam, 1, rig_hash(self.slam.rig())).bytes(|piece| bytes.extend_from_slice(piece));
        (self.keeper.is_located() && self.slam.walls().next().is_some()).then_some(bytes)
    }

    /// Scores the drive.
    pub fn finish(self, faces: &[Face], seen: &[SeenWall]) -> Outcome {
        let plan: Vec<Segment> = faces.iter().map(|f| Segment { from_m: f.from_m, to_m: f.to_m }).collect();
        let passed = |seen: &SeenWall| PassedWall { wall: plan[seen.face], stretches_m: seen.stretches_m.clone() };
        let passed: Vec<PassedWall> = seen.iter().map(passed).collect();
        let pairs = |which: usize| self.paths.iter().map(|p| (p[which], p[2])).collect::<Vec<_>>();
        let estimate = score::path::score(&pairs(0));
        let walls: Vec<_> = self.slam.walls().collect();
        let map = estimate.map(|score| score::map::score(&walls, &plan, &passed, &score.alignment));
        Outcome {
            identical: self.identical,
            differences: self.differences,
            estimate,
            odometry: score::path::score(&pairs(1)),
            map,
            walls: walls.len(),
            faults: self.faults,
            look_back: self.look_back,
            place: self.place,
            late_us: Latenesses::of(self.late_us),
            damaged: self.damaged,
            swept: None,
        }
    }
}

/// Whether these contacts are those that were shown, but for some that were shown before: the firmware releases a contact late, for switches
/// bounce.
fn is_held(sample: &Contacts, shown: &Contacts, before: &Contacts) -> bool {
    let of = |contacts: &Contacts| {
        let Contacts { bump_left, bump_right, cliff, lifted, docked: _ } = *contacts;
        [bump_left, bump_right, cliff, lifted]
    };
    let contacts = of(sample).into_iter().zip(of(shown)).zip(of(before));
    let are_held = contacts.into_iter().all(|((sample, shown), before)| sample == shown || (sample && before));
    are_held && sample.docked == shown.docked
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot::rig::default_rig;
    use wire::{BoardFaults, Range, SlamFaults};

    /// What a firmware that works says to two samples; `change` may falsify it.
    fn outcome(change: impl Fn(&mut Answer)) -> Outcome {
        let mut shadow = Shadow::new(BuiltIn::Sharp, false, false, Vec::new()).unwrap();
        let mut target = RobotSlam::new(default_rig()).unwrap();
        for step in 1..=2_u64 {
            let ranges = (0..8).map(|i| Range::Counts(1000 + 7 * i + step as u16)).collect();
            let sample = Sample { time_us: step * 40_000, ranges, ..Sample::default() };
            target.step(&sample.to_slam());
            let board = BoardFaults::default();
            let mut answer = Answer {
                estimate: Some(Estimate::of(&target, sample.time_us)),
                sample: Some(sample.clone()),
                faults: Some(Faults { slam: SlamFaults::default(), board }),
                ..Answer::default()
            };
            change(&mut answer);
            shadow.check(&sample, &answer, Pose2::default());
        }
        shadow.finish(&[], &[])
    }

    #[test]
    fn the_same_bits_pass() {
        let outcome = outcome(|_| {});
        assert_eq!((outcome.identical, outcome.verdict()), (2, Ok(())));
    }

    #[test]
    fn one_other_bit_fails() {
        let outcome = outcome(|answer| {
            let estimate = answer.estimate.as_mut().unwrap();
            estimate.covariance[5] = f32::from_bits(estimate.covariance[5].to_bits() ^ 1);
        });
        assert_eq!(outcome.identical, 0);
        assert!(outcome.verdict().unwrap_err().starts_with("2 differences between host and target"));
    }

    #[test]
    fn another_sample_than_the_sensors_showed_fails() {
        let outcome = outcome(|answer| answer.sample.as_mut().unwrap().left_ticks += 1);
        assert!(outcome.verdict().unwrap_err().contains("not what the sensors showed"));
    }

    #[test]
    fn losses_and_silence_fail() {
        let lossy = outcome(|answer| answer.faults.as_mut().unwrap().board.frames_dropped = 3);
        assert!(lossy.verdict().unwrap_err().contains("frames_dropped: 3"));
        let silent = outcome(|answer| answer.estimate = None);
        assert!(silent.verdict().unwrap_err().contains("no estimate"));
    }
}
