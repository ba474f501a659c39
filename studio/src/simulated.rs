//! A simulated drive, advanced a little at a time.

use std::path::Path;

use hal_sim::{Plan, SimOptions, plan_file};
use lab::input::log::writer;
use lab::input::rig_file::{Robot, rig_error};
use lab::input::{built_in, built_in_robot};
use lab::recording::Recording;
use lab::run::{Drive, Session};
use lab::show::report::growing::Growing;
use lab::show::report::{self};
use robot::rig::BuiltIn;
use serde_json::{Value, json};
use slam_core::Config;

/// Longest drive that is kept, seconds: an hour, so that the page's memory has a bound.
pub const LONGEST_S: f64 = 3600.0;

/// What is simulated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scene {
    /// The name of a built-in plan, or a plan file's text.
    pub plan: String,
    /// The name of a built-in robot, or a rig file's text; the default robot where empty.
    pub rig: String,
    /// Everything random follows from it.
    pub seed: u64,
}

/// A robot that maps a home.
pub struct Simulated {
    drive: Drive,
    session: Session,
    robot: Robot,
    rig_toml: String,
    plan: Plan,
    growing: Growing,
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
        let drive = Drive::new(&plan, &robot, SimOptions::default(), scene.seed).map_err(|error| error.to_string())?;
        let config = Config::for_rig(&robot.rig);
        let session = Session::new(&robot, config, plan.name.clone())
            .map_err(|error| rig_error(Path::new("rig"), &error).to_string())?;
        let log = writer::header(&robot) + "\n";
        Ok(Self { drive, session, robot, rig_toml, plan, growing: Growing::default(), log })
    }

    /// Drives on until this time, seconds since the start, but for at most so many samples.
    pub fn advance(&mut self, until_s: f64, most: usize) {
        for _ in 0..most {
            if self.time_s().is_some_and(|time_s| time_s >= until_s.min(LONGEST_S)) {
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

    /// What stands where now, in the plan's frame, metres: `faces` as x0, y0, x1, y1, `rounds` as x, y and radius.
    pub fn home(&self) -> Value {
        let faces = self.plan.faces.iter().map(|face| [face.from_m, face.to_m].concat());
        let rounds = self.plan.rounds.iter().map(|round| [round.centre_m[0], round.centre_m[1], round.radius_m]);
        json!({ "faces": faces.collect::<Vec<_>>(), "rounds": rounds.collect::<Vec<_>>() })
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

fn robot_of(rig: &str) -> Result<(Robot, String), String> {
    let named = BuiltIn::ALL.into_iter().find(|kind| kind.name() == rig);
    let found = match (named, rig) {
        (Some(kind), _) => built_in(kind),
        (None, "") => built_in_robot(),
        (None, text) => Robot::parse(Path::new("rig"), text).map(|robot| (robot, text.to_owned())),
    };
    found.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(plan: &str) -> Scene {
        Scene { plan: plan.into(), rig: String::new(), seed: 1 }
    }

    #[test]
    fn a_drive_in_pieces_is_the_drive_of_the_program() {
        let mut pieces = Simulated::new(&scene("room")).unwrap();
        for i in 1..=100 {
            pieces.advance(f64::from(i) * 0.3, 5);
            pieces.steps();
        }
        let (robot, _) = built_in_robot().unwrap();
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
