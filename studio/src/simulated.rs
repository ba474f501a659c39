//! A simulated drive, advanced a little at a time.

use std::path::Path;

use hal_sim::floor::CELL_M;
use hal_sim::{Plan, Pose2, SimOptions, plan_file};
use lab::input::log::writer;
use lab::input::rig_file::{Robot, rig_error};
use lab::input::settings::{by_default, for_a_floor};
use lab::recording::{Recording, health};
use lab::run::{Drive, Job, MapId, Session};
use lab::show::report::growing::Growing;
use lab::show::report::{self};
use robot::AreaKind;
use serde_json::{Value, json};

use crate::looking_back::LookingBack;
use crate::rig::robot_of;

/// Longest drive that is kept, seconds: an hour, so that the page's memory has a bound.
pub const LONGEST_S: f64 = 3600.0;

/// How long a robot is carried, seconds.
const CARRIED_S: f64 = 5.0;
/// How far a kick moves the robot, metres, and turns it, radians.
const KICK_M: f64 = 0.1;
const KICK_RAD: f64 = 0.25;
/// How long a robot is held, seconds.
const HELD_S: f64 = 4.0;

/// What is simulated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scene {
    /// The name of a built-in plan, or a plan file's text.
    pub plan: String,
    /// The name of a built-in robot, or a rig file's text; the default robot where empty.
    pub rig: String,
    /// What the robot is to do.
    pub job: Job,
    /// Everything random follows from it.
    pub seed: u64,
}

/// A robot that maps a home, or sweeps its floor.
pub struct Simulated {
    drive: Drive,
    job: Job,
    session: Session,
    robot: Robot,
    rig_toml: String,
    plan: Plan,
    growing: Growing,
    back: LookingBack,
    log: String,
}

impl Simulated {
    /// A robot at its start.
    ///
    /// # Errors
    /// What is wrong with plan or rig, where, and what would be right.
    pub fn new(scene: &Scene) -> Result<Self, String> {
        let plan = plan_of(&scene.plan)?;
        let robot = robot_of(&scene.rig)?;
        let (begin, (robot, rig_toml)): (fn(_, _, _, _) -> _, _) = match scene.job {
            Job::Explore => (Drive::new, robot),
            Job::Clean => (Drive::cleaning, for_a_floor(robot)),
        };
        let drive = begin(&plan, &robot, SimOptions::default(), scene.seed).map_err(|error| error.to_string())?;
        let config = by_default(&robot);
        let session = Session::new(&robot, config, plan.name.clone())
            .map_err(|error| rig_error(Path::new("rig"), &error).to_string())?;
        let log = writer::header(&robot) + "\n";
        let (growing, back) = (Growing::default(), LookingBack::default());
        Ok(Self { drive, job: scene.job, session, robot, rig_toml, plan, growing, back, log })
    }

    /// Drives on until this time, seconds since the start, but for at most so many samples.
    pub fn advance(&mut self, until_s: f64, most: usize) {
        for _ in 0..most {
            if self.drive.is_over() || self.time_s().is_some_and(|time_s| time_s >= until_s.min(LONGEST_S)) {
                return;
            }
            let row = self.drive.step(&mut self.session);
            self.log += &writer::line(&self.robot, &row);
            self.log.push('\n');
        }
    }

    /// The time of the last sample, seconds since the start; none before the first.
    pub fn time_s(&self) -> Option<f64> {
        self.recording().steps.last().map(|step| step.t_s)
    }

    /// What the estimator did so far.
    pub fn recording(&self) -> &Recording {
        self.session.recording()
    }

    /// What stays as it is: the run's head, the plan and the true calibration.
    pub fn head(&self) -> Value {
        let mut head = Growing::head(self.recording());
        let start = self.plan.start;
        let truth = self.drive.true_calibration(self.recording());
        head["truth"] = truth.into_iter().map(|(name, value)| (name, json!(value))).collect();
        head["start"] = json!([start.x_m, start.y_m, start.theta_rad]);
        head["longest_s"] = json!(LONGEST_S);
        head
    }

    /// What stands where now, in the plan's frame, metres: `faces` as x0, y0, x1, y1, `rounds` as x, y and radius, the corners of the
    /// `areas` to stay out of and to clean; where the floor is swept, how [`Simulated::floor`] lies: its lower corner, a cell's edge,
    /// and cells in a row.
    pub fn home(&self) -> Value {
        let faces = self.plan.faces.iter().map(|face| [face.from_m, face.to_m].concat());
        let rounds = self.plan.rounds.iter().map(|round| [round.centre_m[0], round.centre_m[1], round.radius_m]);
        let (corner_m, columns) = self.drive.floor().place();
        let floor = (self.job == Job::Clean).then(|| json!({ "corner": corner_m, "cell": CELL_M, "columns": columns }));
        let areas = |kind| self.plan.bounds.areas(kind).collect::<Vec<_>>();
        json!({
            "faces": faces.collect::<Vec<_>>(),
            "rounds": rounds.collect::<Vec<_>>(),
            "areas": { "keep_out": areas(AreaKind::KeepOut), "clean": areas(AreaKind::Clean) },
            "floor": floor,
        })
    }

    /// When each cell of the floor was swept first and again, see [`hal_sim::floor::FloorRaster::swept_s`].
    pub fn floor(&self) -> Vec<f32> {
        self.drive.floor().swept_s().flatten().collect()
    }

    /// The steps that the page has not got, see [`Growing::steps`].
    pub fn steps(&mut self) -> Vec<f64> {
        self.growing.steps(self.session.recording())
    }

    /// Map and calibration, where the page has older ones.
    pub fn map(&mut self) -> Option<Value> {
        self.growing.map(self.session.recording())
    }

    /// The figures so far.
    pub fn figures(&self) -> Value {
        report::figures(&self.drive.figures(&self.session))
    }

    /// What the robot sensed so far, as a `log.csv`.
    pub fn log(&self) -> &str {
        &self.log
    }

    /// Somebody lifts the robot, carries it for five seconds and puts it down: here, metres in the plan's frame, or somewhere in
    /// one of the plan's rooms.
    ///
    /// # Errors
    /// There is no room for it.
    pub fn carry(&mut self, to_m: Option<[f64; 2]>) -> Result<(), String> {
        let simulation = self.drive.simulation();
        let theta_rad = simulation.pose_in_plan().theta_rad;
        if to_m.is_none() && self.plan.rooms.is_empty() {
            return Err("the plan names no [[room]] to put the robot down in; choose a place on the map".to_owned());
        }
        let to = to_m.map(|[x_m, y_m]| Pose2 { x_m, y_m, theta_rad });
        simulation.carry(to, CARRIED_S).map_err(|_| "there is no room for the robot; choose a free place".to_owned())
    }

    /// Something kicks the robot.
    pub fn kick(&mut self) {
        self.drive.simulation().kick(KICK_M, KICK_RAD);
    }

    /// Something holds the robot for four seconds, while its wheels turn.
    pub fn hold(&mut self) {
        self.drive.simulation().hold(HELD_S);
    }

    /// Covers a range sensor or uncovers it.
    pub fn cover(&mut self, sensor: usize, is_covered: bool) {
        self.drive.simulation().cover(sensor, is_covered);
    }

    /// Cuts the robot's power and gives it back: of all that it knew it has the map that it kept, what was swept of the floor, and where it
    /// was, and it is not told where it is.
    ///
    /// # Errors
    /// There is no map yet, or none that a place can be found in.
    pub fn cut_power(&mut self) -> Result<(), String> {
        let map =
            self.session.map().ok_or("there is no map yet that could be kept; let the robot find a wall first")?;
        let kept = MapId::of(&map).map(|id| (id, self.session.pose_in(id), self.drive.job_in(id)));
        self.begin_in(map).map_err(|what| format!("the kept map {what}"))?;
        let Some((id, pose, job)) = kept else { return Ok(()) };
        pose.inspect(|pose| self.session.recall(id, pose));
        job.map_or(Ok(()), |job| self.drive.go_on_with(id, &job)).map_err(|what| what.to_string())
    }

    /// Cuts the robot's power and gives it back with this map in its memory, the bytes of a `map.bin`.
    ///
    /// # Errors
    /// What is wrong with the map; the robot drives on then.
    pub fn begin_in(&mut self, map: Vec<u8>) -> Result<(), String> {
        let mut session = Session::new(&self.robot, by_default(&self.robot), self.plan.name.clone())
            .map_err(|error| rig_error(Path::new("rig"), &error).to_string())?;
        session.begin_in(map)?;
        (self.session, self.growing, self.back) = (session, Growing::default(), LookingBack::default());
        self.log = writer::header(&self.robot) + "\n";
        self.drive.reboot(&self.robot);
        Ok(())
    }

    /// The walls of the kept map that the robot looks for itself in: their ends, metres, in that map's frame; none while it is
    /// located.
    pub fn sought(&self) -> Option<Value> {
        self.session.sought().map(|map| Growing::kept_walls(&map))
    }

    /// Rebuilds the home after a plan file's text. The robot stays where it is.
    ///
    /// # Errors
    /// What is wrong with the text, where, and what would be right.
    pub fn rebuild(&mut self, plan: &str) -> Result<(), String> {
        self.plan = plan_of(plan)?;
        self.drive.rebuild(&self.plan);
        Ok(())
    }

    /// How things are now: the robot's true pose in the frame of its start, what is done to it, and what it searches.
    pub fn state(&mut self) -> Value {
        let searched = self.session.searches().last().copied();
        let places: Vec<_> = self.session.places();
        let places =
            places.iter().map(|place| json!([place.pose.x_m, place.pose.y_m, place.pose.theta_rad, place.share]));
        let step = self.recording().steps.last();
        let (searching, health) = (step.is_some_and(|step| step.searching), step.map(|step| health::name(step.health)));
        let complaint = self.recording().complaint();
        let (doing, is_over) = (self.drive.doing(), self.drive.is_over());
        let swept = (self.job == Job::Clean).then(|| self.drive.floor().now());
        let simulation = self.drive.simulation();
        let (pose, contacts, time_s) = (simulation.pose(), simulation.contacts(), simulation.time_s());
        let people = simulation.people().map(|([x_m, y_m], radius_m)| [x_m, y_m, radius_m]);
        let is_closed = |door: &&hal_sim::plan::Door| (door.closes_at_s..door.opens_at_s).contains(&time_s);
        let doors = self.plan.doors.iter().filter(is_closed).map(|door| [door.from_m, door.to_m].concat());
        json!({
            "truth": [pose.x_m, pose.y_m, pose.theta_rad],
            "lifted": contacts.lifted,
            "bumped": contacts.bump_left || contacts.bump_right,
            "covered": simulation.covered().collect::<Vec<_>>(),
            "people": people.collect::<Vec<_>>(),
            "doors": doors.collect::<Vec<_>>(),
            "searching": searching,
            "health": health,
            "complaint": complaint,
            "doing": doing,
            "over": is_over,
            "swept": swept.map(|share| [share.swept, share.twice]),
            "places": places.collect::<Vec<_>>(),
            "searched": searched.map(|searched| json!({
                "log_odds": searched.log_odds,
                "walls": searched.walls[0],
                "matched": searched.walls[1],
            })),
        })
    }

    /// `map.bin`: the record that the robot would keep; empty where there is no map.
    pub fn kept_map(&self) -> Vec<u8> {
        self.session.map().unwrap_or_default()
    }

    /// The page that `lab run` writes of a drive.
    pub fn report(&self) -> Option<String> {
        Some(report::html(&self.drive.so_far(&self.session)))
    }

    /// Goes on looking back, see [`LookingBack::work`].
    ///
    /// # Errors
    /// Why there is nothing to look back on.
    pub fn look_back(&mut self, pieces: usize) -> Result<bool, &'static str> {
        self.back.work(self.session.recording(), &self.robot.rig, pieces)
    }

    /// The look back.
    pub fn back(&self) -> &LookingBack {
        &self.back
    }

    /// The page of the look back, see [`LookingBack::page`].
    pub fn look_back_page(&self) -> Option<String> {
        self.back.page(self.drive.so_far(&self.session))
    }

    /// The robot as a rig file.
    pub fn rig_toml(&self) -> &str {
        &self.rig_toml
    }
}

fn plan_of(plan: &str) -> Result<Plan, String> {
    let built_in = plan_file::BUILT_IN.iter().find(|(name, _)| *name == plan);
    let (name, text) = built_in.copied().unwrap_or(("your plan", plan));
    plan_file::parse("plan", name, text).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests;
