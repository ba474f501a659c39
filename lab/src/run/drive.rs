//! A simulated drive: the pilot steers by what the robot senses and estimates, and every sample is a log row.

use hal_sim::floor::{FloorRaster, Moment};
use hal_sim::{ClosedLoop, Estimate, Plan, SimError, SimOptions, Simulation};
use robot::{Activity, Bounds, FLOOR_RECORD_BYTES, FloorConfig, FloorProgress, FloorRecordError, PilotConfig};

use super::map_file::MapId;
use super::session::Session;
use crate::evaluate::score;
use crate::evaluate::score::map::{LONG_M, PASSED_M, PassedWall};
use crate::input::log::Row;
use crate::input::rig_file::{MAX_SENSORS, Robot};
use crate::numbers::shortest;
use crate::recording::{Figures, Job, Pose2, Recording, Segment, TruthFrame};

/// A robot in a home, with the pilot that drives it.
pub struct Drive {
    robot: ClosedLoop,
    plan: Vec<Segment>,
    floor: FloorRaster,
    /// Where the robot must not go and what it is to clean, in the start frame.
    bounds: Bounds,
    job: Job,
    /// Since when, and where in the start frame, the pilot has been stuck.
    stuck: Option<(f64, Pose2)>,
}

/// A robot that came so far from where it was stuck is not any more, metres: its own width.
const AWAY_M: f64 = 0.35;

impl Drive {
    /// A robot at the plan's start that maps the home. Every random number follows from `seed`.
    ///
    /// # Errors
    /// The rig cannot be simulated or the robot does not fit where the plan puts it.
    pub fn new(plan: &Plan, robot: &Robot, options: SimOptions, seed: u64) -> Result<Self, SimError> {
        let simulation = Simulation::new(plan, &robot.rig, options, seed)?;
        Ok(Self::of(plan, Job::Explore, ClosedLoop::new(simulation, &robot.rig, PilotConfig::default())))
    }

    /// The same with the floor to clean.
    ///
    /// # Errors
    /// The rig cannot be simulated or the robot does not fit where the plan puts it.
    pub fn cleaning(plan: &Plan, robot: &Robot, options: SimOptions, seed: u64) -> Result<Self, SimError> {
        let simulation = Simulation::new(plan, &robot.rig, options, seed)?;
        Ok(Self::of(plan, Job::Clean, ClosedLoop::cleaning(simulation, &robot.rig, FloorConfig::default())))
    }

    fn of(plan: &Plan, job: Job, robot: ClosedLoop) -> Self {
        let simulation = &robot.simulation;
        let faces = plan.faces_in_start_frame();
        let floor = FloorRaster::new(plan, simulation.options().body_radius_m, simulation.pose_in_plan());
        let bounds = plan.bounds.seen_from(&plan.start.to_pose());
        let plan = faces.iter().map(|face| Segment { from_m: face.from_m, to_m: face.to_m }).collect();
        Self { robot, stuck: None, floor, bounds, job, plan }
    }

    /// Drives to the next sample, which the session estimates and records; the first is taken where the robot stands.
    pub fn step(&mut self, session: &mut Session) -> Row {
        let mut report = None;
        session.draw_areas(&self.bounds);
        let docked = self.robot.simulation.condition().is_charging;
        session.dock(docked);
        let frame = self.robot.step_in(&mut |sample| {
            let done = report.insert(session.estimate(sample));
            (Estimate::new(session.slam().pose(), done), session.whereabouts())
        });
        session.lift(frame.lifted);
        let t_s = frame.sample.time_us as f64 * 1e-6;
        self.record_floor(t_s);
        if self.robot.job.activity() == Some(Activity::Stuck) {
            self.stuck.get_or_insert((t_s, frame.truth));
        }
        let stays = |place: &Pose2| (frame.truth.x_m - place.x_m).hypot(frame.truth.y_m - place.y_m) < AWAY_M;
        self.stuck = self.stuck.filter(|(_, place)| stays(place));
        // Microseconds have six decimals: the text reads back as the same ones.
        let t_text = shortest((t_s * 1e6).round() / 1e6);
        let odometry = self.robot.simulation.odometry();
        let (sample, truth, lifted) = (frame.sample, Some(frame.truth), frame.lifted);
        let row = Row { t_text, t_s, sample, odometry, truth, lifted, docked };
        if let Some(report) = report {
            session.record(&row, &report);
        }
        row
    }

    fn record_floor(&mut self, t_s: f64) {
        let contacts = self.robot.simulation.contacts();
        self.floor.record(&Moment {
            t_s,
            pose: self.robot.simulation.pose_in_plan(),
            doing: self.doing(),
            is_pressed: contacts.bump_left || contacts.bump_right,
            is_on_floor: !contacts.lifted,
        });
    }

    /// Drives for this long (seconds); `each` gets every row when it is recorded, and what share of the drive is done: of the
    /// time, or of the floor where the job is to sweep it.
    ///
    /// # Errors
    /// The first error of `each`, which ends the drive.
    pub fn run<E>(
        &mut self,
        session: &mut Session,
        duration_s: f64,
        mut each: impl FnMut(&Row, &Recording, f64) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut t_s = f64::NEG_INFINITY;
        while t_s < duration_s && !self.is_over() {
            let row = self.step(session);
            t_s = row.t_s;
            let done = if self.job == Job::Clean { self.floor.now().swept } else { t_s / duration_s };
            each(&row, session.recording(), done)?;
        }
        Ok(())
    }

    /// Ends the session: the record with every score against what is true here.
    pub fn finish(&self, session: Session) -> Recording {
        self.judged(session.finish())
    }

    /// The record as it would be if the drive ended now.
    pub fn so_far(&self, session: &Session) -> Recording {
        self.judged(session.so_far())
    }

    fn judged(&self, mut recording: Recording) -> Recording {
        recording.truth_frame = TruthFrame::Map;
        recording.true_walls = self.plan.clone();
        recording.job = Some(self.job);
        recording.stuck_from_s = self.stuck.map(|(from_s, _)| from_s);
        recording.figures.floor = Some(self.floor.score());
        self.reveal_calibration(&mut recording);
        score::score(&mut recording, &[], None);
        if let Some(alignment) = recording.figures.estimate.map(|score| score.alignment) {
            let map = score::map::score(recording.walls(), &self.plan, &self.passed(), &alignment);
            recording.figures.map = Some(map);
        }
        recording
    }

    /// The figures so far, with every score of path and map against what is true here.
    pub fn figures(&self, session: &Session) -> Figures {
        let mut figures = session.figures();
        (figures.estimate, figures.odometry) = score::against_truth(session.recording());
        if let Some(alignment) = figures.estimate.map(|score| score.alignment) {
            let map = score::map::score(session.recording().walls(), &self.plan, &self.passed(), &alignment);
            figures.map = Some(map);
        }
        figures
    }

    /// The program of this robot begins anew where it stands: its pilot or floor job knows nothing of before.
    pub fn reboot(&mut self, robot: &Robot) {
        let simulation = self.robot.simulation.clone();
        self.robot = match self.job {
            Job::Clean => ClosedLoop::cleaning(simulation, &robot.rig, FloorConfig::default()),
            Job::Explore => ClosedLoop::new(simulation, &robot.rig, PilotConfig::default()),
        };
        self.stuck = None;
    }

    /// What is to be known of the floor after a reset, in this kept map; none where there is nothing left to do, or it does not go by
    /// that map.
    pub fn job_in(&mut self, map: MapId) -> Option<[u8; FLOOR_RECORD_BYTES]> {
        self.robot.job.saved(map.0)
    }

    /// A drive about to begin in this kept map goes on with the floor that was left.
    ///
    /// # Errors
    /// What is wrong with the bytes: all of the floor is left.
    pub fn go_on_with(&mut self, map: MapId, bytes: &[u8]) -> Result<(), FloorRecordError> {
        let memory: [u8; FLOOR_RECORD_BYTES] = bytes.try_into().map_err(|_| FloorRecordError::Nothing)?;
        self.robot.job.restore(map.0, &memory)
    }

    /// Holds what is estimated from now on against this plan, which the robot's home was rebuilt by.
    pub fn rebuild(&mut self, plan: &Plan) {
        self.robot.simulation.rebuild(plan);
        self.floor.rebuild(plan);
        let start = self.robot.simulation.start_in_plan();
        self.bounds = plan.bounds.seen_from(&start.to_pose());
        let faces = plan.faces.iter().map(|face| face.seen_from(&start));
        self.plan = faces.map(|face| Segment { from_m: face.from_m, to_m: face.to_m }).collect();
    }

    /// What the robot is doing, in a word or two.
    pub fn doing(&self) -> &'static str {
        self.robot.job.doing()
    }

    /// Whether the robot has nothing left to do.
    pub fn is_over(&self) -> bool {
        self.robot.job.is_over()
    }

    /// How far the floor job says it is; none of a robot that has another job.
    pub fn progress(&self) -> Option<FloorProgress> {
        self.robot.job.floor()
    }

    /// What a user should know of how the job ended though it is no error.
    pub fn findings(&self) -> Vec<String> {
        let missed = self.progress().filter(|_| self.is_over()).map_or(0, |progress| progress.missed);
        let areas = (0..8).filter(|index| missed & (1 << index) != 0);
        areas.map(|index| format!("nothing of clean[{index}] was swept: the robot found no way there")).collect()
    }

    /// The floor as it was swept so far.
    pub fn floor(&self) -> &FloorRaster {
        &self.floor
    }

    /// What the robot is at: its own program, to be paused and told to go on.
    pub fn job(&mut self) -> &mut robot::Job<MAX_SENSORS> {
        &mut self.robot.job
    }

    /// The robot in its home, to be looked at and meddled with.
    pub fn simulation(&mut self) -> &mut Simulation {
        &mut self.robot.simulation
    }

    /// The true values of the calibration by the parameters' names: what [`Recording::parameters`] calls them.
    pub fn true_calibration(&self, recording: &Recording) -> Vec<(String, f64)> {
        let truth = self.robot.simulation.calibration();
        let drive = [
            ("scale_left", truth.drive.scale_left),
            ("scale_right", truth.drive.scale_right),
            ("track", truth.drive.track),
            ("scale_distance", truth.scale_distance),
            ("scale_turn", truth.scale_turn),
        ];
        let gains =
            recording.sensors.iter().zip(&truth.gains).map(|(sensor, gain)| (format!("gain_{}", sensor.name), *gain));
        drive.map(|(name, value)| (name.to_owned(), value)).into_iter().chain(gains).collect()
    }

    /// The true plan in the map frame.
    pub fn plan(&self) -> &[Segment] {
        &self.plan
    }

    /// The true walls that the robot passed so far.
    pub fn passed(&self) -> Vec<PassedWall> {
        let seen = self.robot.simulation.coverage().walls(LONG_M, PASSED_M);
        seen.into_iter().map(|seen| PassedWall { wall: self.plan[seen.face], stretches_m: seen.stretches_m }).collect()
    }

    /// Puts the true values of the calibration into a record.
    fn reveal_calibration(&self, recording: &mut Recording) {
        let all = self.true_calibration(recording);
        for parameter in &mut recording.parameters {
            parameter.truth = all.iter().find(|(name, _)| *name == parameter.name).map(|(_, value)| *value);
        }
    }
}
