//! The estimator over a log, a few rows at a time.

use std::path::Path;

use input_file::FileError;
use lab::evaluate::score;
use lab::input::log::truth::{self, Truth};
use lab::input::log::{self, Rows};
use lab::input::rig_file::{Robot, rig_error};
use lab::input::settings::by_default;
use lab::recording::{Recording, TruthFrame};
use lab::run::Session;
use lab::show::output::streams::{ESTIMATE_HEADER, estimate_line};
use lab::show::report::growing::Growing;
use lab::show::report::{self};
use serde_json::{Value, json};

use crate::looking_back::LookingBack;

/// A user's file: its name and content.
pub type File = (String, Vec<u8>);

/// What is replayed.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// `log.csv` or CARMEN, plain or gzipped.
    pub log: File,
    /// The rig file.
    pub rig: File,
    /// True poses.
    pub truth: Option<File>,
    /// The kept map that the drive begins in, not knowing where.
    pub map: Option<File>,
}

/// A log on its way through the estimator.
pub struct Replayed {
    robot: Robot,
    rows: Option<Box<dyn Rows>>,
    session: Session,
    begins_in_map: bool,
    truth: Option<Truth>,
    times_s: Vec<f64>,
    estimate: String,
    notes: Vec<String>,
    error: Option<String>,
    /// The record with its scores, once the log is over.
    scored: Option<Recording>,
    growing: Growing,
    back: LookingBack,
}

impl Replayed {
    /// At the log's first row.
    ///
    /// # Errors
    /// What is wrong with a file: its name, the line and column or key, and what would be right.
    pub fn new(files: Files) -> Result<Self, FileError> {
        let rig_file = Path::new(&files.rig.0);
        let text = String::from_utf8(files.rig.1)
            .map_err(|_| FileError::new(rig_file, "is not text; a rig file is TOML in UTF-8"))?;
        let mut robot = Robot::parse(rig_file, &text)?;
        let log_file = Path::new(&files.log.0);
        let rows = log::of_bytes(log_file, files.log.1, &mut robot)?;
        let truth = files.truth.map(|(name, content)| truth::of_bytes(Path::new(&name), content)).transpose()?;
        let config = by_default(&robot);
        let mut session =
            Session::new(&robot, config, files.log.0.clone()).map_err(|error| rig_error(rig_file, &error))?;
        let begins_in_map = files.map.is_some();
        if let Some((name, content)) = files.map {
            session.begin_in(content).map_err(|what| FileError::new(Path::new(&name), what))?;
        }
        Ok(Self {
            robot,
            rows: Some(rows),
            session,
            begins_in_map,
            truth,
            times_s: Vec::new(),
            estimate: ESTIMATE_HEADER.to_owned() + "\n",
            notes: Vec::new(),
            error: None,
            scored: None,
            growing: Growing::without_truth(),
            back: LookingBack::default(),
        })
    }

    /// Feeds at most so many rows to the estimator. When the log is over, everything is scored, and [`Replayed::steps`] gives all
    /// steps once more, with the truth where it is known.
    pub fn advance(&mut self, most: usize) {
        for _ in 0..most {
            match self.rows.as_mut().and_then(Iterator::next) {
                Some(Ok(row)) => {
                    self.estimate += &estimate_line(self.session.push(&row));
                    self.estimate.push('\n');
                    self.times_s.push(row.t_s);
                }
                Some(Err(error)) => return self.end(Some(error.to_string())),
                None => return self.end(None),
            }
        }
    }

    fn end(&mut self, error: Option<String>) {
        let Some(rows) = self.rows.take() else { return };
        self.notes = rows.notes();
        let is_empty = error.is_none() && self.times_s.is_empty();
        self.error = error.or_else(|| is_empty.then(|| "the log has a header but no rows".to_owned()));
        let mut recording = self.session.so_far();
        recording.truth_frame = if self.begins_in_map { TruthFrame::Unknown } else { TruthFrame::FirstPose };
        score::score(&mut recording, &self.times_s, self.truth.as_ref());
        self.scored = Some(recording);
        self.growing = Growing::default();
    }

    /// Whether the log is over.
    pub fn is_over(&self) -> bool {
        self.rows.is_none()
    }

    /// What the estimator did so far.
    pub fn recording(&self) -> &Recording {
        self.scored.as_ref().unwrap_or_else(|| self.session.recording())
    }

    /// What stays as it is.
    pub fn head(&self) -> Value {
        Growing::head(self.recording())
    }

    /// How far it is, what was passed over, and the bad line that ended the log.
    pub fn state(&self) -> Value {
        let last = self.recording().steps.last();
        json!({
            "rows": self.times_s.len(),
            "over": self.is_over(),
            "notes": self.notes,
            "error": self.error,
            "searching": last.is_some_and(|step| step.searching),
            "health": last.map(|step| lab::recording::health::name(step.health)),
            "complaint": self.recording().complaint(),
        })
    }

    /// The page has shown another run meanwhile.
    pub fn tell_again(&mut self) {
        self.growing.tell_again();
    }

    /// The steps that the page has not got, see [`Growing::steps`].
    pub fn steps(&mut self) -> Vec<f64> {
        self.growing.steps(self.scored.as_ref().unwrap_or_else(|| self.session.recording()))
    }

    /// Map and calibration, where the page has older ones.
    pub fn map(&mut self) -> Option<Value> {
        self.growing.map(self.scored.as_ref().unwrap_or_else(|| self.session.recording()))
    }

    /// Every map and calibration that was recorded, in order.
    pub fn maps(&self) -> Value {
        Growing::maps(self.recording())
    }

    /// The figures so far.
    pub fn figures(&self) -> Value {
        match &self.scored {
            Some(recording) => report::figures(&recording.figures),
            None => report::figures(&self.session.figures()),
        }
    }

    /// `estimate.csv` so far.
    pub fn estimate(&self) -> &str {
        &self.estimate
    }

    /// `map.bin`: the record that the robot would keep; empty where there is no map.
    pub fn kept_map(&self) -> Vec<u8> {
        self.session.map().unwrap_or_default()
    }

    /// The page that `lab replay` writes of a log.
    pub fn report(&self) -> Option<String> {
        Some(report::html(self.recording()))
    }

    /// Goes on looking back, see [`LookingBack::work`].
    ///
    /// # Errors
    /// Why there is nothing to look back on.
    pub fn look_back(&mut self, pieces: usize) -> Result<bool, &'static str> {
        self.back.work(self.scored.as_ref().unwrap_or_else(|| self.session.recording()), &self.robot.rig, pieces)
    }

    /// The look back.
    pub fn back(&self) -> &LookingBack {
        &self.back
    }

    /// The page of the look back, see [`LookingBack::page`].
    pub fn look_back_page(&self) -> Option<String> {
        self.back.page(self.recording().clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scene, Simulated};

    fn driven() -> (Simulated, Files) {
        let mut simulated = Simulated::new(&Scene { plan: "room".into(), seed: 3, ..Scene::default() }).unwrap();
        simulated.advance(20.0, 1000);
        let log = ("log.csv".to_owned(), simulated.log().as_bytes().to_vec());
        let rig = ("rig.toml".to_owned(), simulated.rig_toml().as_bytes().to_vec());
        (simulated, Files { log, rig, ..Files::default() })
    }

    #[test]
    fn the_log_of_a_drive_replays_to_the_drive() {
        let (simulated, files) = driven();
        let mut replayed = Replayed::new(files).unwrap();
        while !replayed.is_over() {
            replayed.advance(7);
        }
        assert_eq!(replayed.state()["error"], Value::Null);
        let [there, here] = [simulated.recording(), replayed.recording()]
            .map(|run| run.steps.iter().map(|step| (step.pose, step.covariance)).collect::<Vec<_>>());
        assert_eq!(there, here);
        assert!(replayed.recording().figures.estimate.is_some() && replayed.report().is_some());
        let rounds = (0..100_000).take_while(|_| replayed.look_back(1).unwrap()).count();
        let walls = replayed.back().walls().unwrap();
        assert_eq!(walls["steps"], replayed.recording().steps.len(), "after {rounds} pieces");
        assert!(!walls["walls"].as_array().unwrap().is_empty());
        assert_eq!(replayed.back().path(replayed.recording()).len(), 2 * replayed.recording().steps.len());
        assert!(replayed.look_back_page().unwrap().contains("looking back"));
    }

    #[test]
    fn a_bad_line_ends_the_log_and_is_named() {
        let (_, mut files) = driven();
        let text = String::from_utf8(files.log.1).unwrap();
        let mut lines: Vec<&str> = text.lines().collect();
        lines[10] = "0.4,many,0,0,0,0,0,0,0,0,0,0,0,0,0,0";
        files.log.1 = lines.join("\n").into_bytes();
        let mut replayed = Replayed::new(files).unwrap();
        replayed.advance(10_000);
        let error = replayed.state()["error"].as_str().unwrap().to_owned();
        assert!(error.starts_with("log.csv:11: left_ticks: is \"many\""), "{error}");
        assert_eq!(replayed.recording().steps.len(), 9);
    }

    #[test]
    fn a_rig_of_another_robot_is_refused_with_its_key() {
        let (_, mut files) = driven();
        files.rig.1 = b"[wheels]\ntrack_m = -1\n".to_vec();
        let error = Replayed::new(files).err().unwrap().to_string();
        assert!(error.starts_with("rig.toml:"), "{error}");
    }
}
