//! A simulated drive, advanced a little at a time.

use std::path::Path;

use hal_sim::floor::CELL_M;
use hal_sim::{Plan, Pose2, SimOptions, plan_file};
use lab::input::log::writer;
use lab::input::rig_file::{Robot, rig_error};
use lab::recording::{Recording, health};
use lab::run::{Drive, Job, Session};
use lab::show::report::growing::Growing;
use lab::show::report::{self};
use serde_json::{Value, json};
use slam_core::Config;

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
        let (robot, rig_toml) = robot_of(&scene.rig)?;
        let begin = match scene.job {
            Job::Explore => Drive::new,
            Job::Clean => Drive::cleaning,
        };
        let drive = begin(&plan, &robot, SimOptions::default(), scene.seed).map_err(|error| error.to_string())?;
        let config = Config::for_rig(&robot.rig);
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

    /// What stands where now, in the plan's frame, metres: `faces` as x0, y0, x1, y1, `rounds` as x, y and radius; where the
    /// floor is swept, how [`Simulated::floor`] lies: its lower corner, a cell's edge, and cells in a row.
    pub fn home(&self) -> Value {
        let faces = self.plan.faces.iter().map(|face| [face.from_m, face.to_m].concat());
        let rounds = self.plan.rounds.iter().map(|round| [round.centre_m[0], round.centre_m[1], round.radius_m]);
        let (corner_m, columns) = self.drive.floor().place();
        let floor = (self.job == Job::Clean).then(|| json!({ "corner": corner_m, "cell": CELL_M, "columns": columns }));
        json!({ "faces": faces.collect::<Vec<_>>(), "rounds": rounds.collect::<Vec<_>>(), "floor": floor })
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

    /// Cuts the robot's power and gives it back: of all that it knew it has the map that it kept, and it is not told where it is.
    ///
    /// # Errors
    /// There is no map yet, or none that a place can be found in.
    pub fn cut_power(&mut self) -> Result<(), String> {
        let map =
            self.session.map().ok_or("there is no map yet that could be kept; let the robot find a wall first")?;
        let mut session = Session::new(&self.robot, Config::for_rig(&self.robot.rig), self.plan.name.clone())
            .map_err(|error| rig_error(Path::new("rig"), &error).to_string())?;
        session.begin_in(map).map_err(|what| format!("the kept map {what}"))?;
        (self.session, self.growing, self.back) = (session, Growing::default(), LookingBack::default());
        self.log = writer::header(&self.robot) + "\n";
        self.drive.reboot(&self.robot);
        Ok(())
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
        let step = self.recording().steps.last();
        let (searching, health) = (step.is_some_and(|step| step.searching), step.map(|step| health::name(step.health)));
        let complaint = self.recording().complaint();
        let (doing, is_over) = (self.drive.doing(), self.drive.is_over());
        let swept = (self.job == Job::Clean).then(|| self.drive.floor().now());
        let simulation = self.drive.simulation();
        let (pose, contacts, time_s) = (simulation.pose(), simulation.contacts(), simulation.time_s());
        let people = self.plan.people.iter().map(|person| {
            let [x_m, y_m] = person.position(time_s);
            [x_m, y_m, person.radius_m]
        });
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
mod tests {
    use super::*;

    fn scene(plan: &str) -> Scene {
        Scene { plan: plan.into(), seed: 1, ..Scene::default() }
    }

    #[test]
    fn a_drive_in_pieces_is_the_drive_of_the_program() {
        let mut pieces = Simulated::new(&scene("room")).unwrap();
        for i in 1..=100 {
            pieces.advance(f64::from(i) * 0.3, 5);
            pieces.steps();
        }
        let (robot, _) = robot_of("").unwrap();
        let plan = plan_file::load("room").unwrap();
        let mut drive = Drive::new(&plan, &robot, SimOptions::default(), 1).unwrap();
        let mut session = Session::new(&robot, Config::for_rig(&robot.rig), "room").unwrap();
        while session.recording().steps.len() < pieces.recording().steps.len() {
            drive.step(&mut session);
        }
        assert!(pieces.recording().steps.len() > 400, "{}", pieces.recording().steps.len());
        assert_eq!(pieces.recording().steps, session.recording().steps);
    }

    #[test]
    fn a_robot_that_was_carried_says_so_and_finds_its_map_again() {
        let mut simulated = Simulated::new(&scene("flat")).unwrap();
        simulated.advance(200.0, 10_000);
        assert!(simulated.carry(Some([-3.0, 0.0])).is_ok(), "outside is free, if odd");
        assert!(simulated.carry(Some([0.0, 0.0])).is_err(), "a corner has no room");
        let mut simulated = Simulated::new(&scene("flat")).unwrap();
        simulated.advance(200.0, 10_000);
        simulated.carry(Some([2.5, 1.0])).unwrap();
        simulated.advance(202.0, 100);
        assert_eq!((&simulated.state()["lifted"], &simulated.state()["searching"]), (&json!(true), &json!(true)));
        simulated.advance(400.0, 10_000);
        assert_eq!(simulated.state()["searching"], false);
        let error = simulated.recording().steps.last().and_then(|step| step.error()).expect("it is located");
        assert!(error.x_m.hypot(error.y_m) < 0.1, "{error:?}");
    }

    #[test]
    fn a_robot_without_power_begins_anew_in_its_map() {
        let mut simulated = Simulated::new(&scene("flat")).unwrap();
        assert!(simulated.cut_power().is_err());
        simulated.advance(120.0, 10_000);
        simulated.cut_power().unwrap();
        simulated.advance(1.0, 30);
        assert!(
            simulated.recording().steps.len() <= 30 && simulated.recording().steps.iter().all(|step| step.searching)
        );
    }

    #[test]
    fn a_covered_sensor_sees_nothing_and_a_new_wall_is_seen() {
        let mut simulated = Simulated::new(&scene("room")).unwrap();
        (0..8).for_each(|sensor| simulated.cover(sensor, true));
        simulated.advance(5.0, 1000);
        assert_eq!(simulated.recording().walls().len(), 0);
        (0..8).for_each(|sensor| simulated.cover(sensor, false));
        let (_, text) = plan_file::BUILT_IN[0];
        let faces = simulated.plan.faces.len();
        simulated.rebuild(&format!("{text}\n[[wall]]\nfrom_m = [1.0, 2.0]\nto_m = [2.0, 2.0]\n")).unwrap();
        assert_eq!(simulated.plan.faces.len(), faces + 1);
        assert!(simulated.rebuild("[[wall]]").is_err());
        simulated.advance(30.0, 1000);
        assert!(simulated.recording().walls().len() > 1);
    }

    #[test]
    fn a_robot_that_cleans_sweeps_the_floor_and_stops_when_it_is_back() {
        let mut simulated = Simulated::new(&Scene { job: Job::Clean, ..scene("room") }).unwrap();
        simulated.advance(60.0, 10_000);
        let early = simulated.state();
        let seen = simulated.floor().chunks(2).filter(|at_s| at_s[0] <= 60.0).count() as f64;
        let floor = simulated.floor().chunks(2).filter(|at_s| !at_s[0].is_nan()).count() as f64;
        assert!((early["swept"][0].as_f64().unwrap() - seen / floor).abs() < 1e-9, "{early}");
        simulated.advance(LONGEST_S, 100_000);
        let late = simulated.state();
        assert_eq!((&late["over"], &late["doing"]), (&json!(true), &json!("done")), "{late}");
        assert!(late["swept"][0].as_f64().unwrap() > 0.9, "{late}");
        let steps = simulated.recording().steps.len();
        simulated.advance(LONGEST_S, 10);
        assert_eq!(simulated.recording().steps.len(), steps);
    }

    #[test]
    fn one_call_does_no_more_than_it_may() {
        let mut simulated = Simulated::new(&scene("flat")).unwrap();
        simulated.advance(1e9, 10);
        assert_eq!(simulated.recording().steps.len(), 10);
    }

    #[test]
    fn a_bad_plan_is_said_with_its_place() {
        let error = Simulated::new(&scene("[start]\nx_m = 1\ny_m = 1\nheading = 3\n")).err().unwrap();
        assert!(error.starts_with("plan:4: start: heading") || error.contains("heading"), "{error}");
    }
}
