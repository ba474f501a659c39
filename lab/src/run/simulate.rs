//! `lab run`: a simulated robot maps a simulated home.

use std::path::{Path, PathBuf};

use hal_sim::{Pose2, SimError, SimOptions};
use robot::FloorRecordError;
use serde_json::json;
use slam_core::Config;

use super::Progress;
use super::drive::Drive;
use super::kept_files::{JOB, begin_in, beside, keep, renewed, write_or_remove};
use super::map_file::MapId;
use super::session::Session;
use crate::evaluate::smoother;
use crate::input::rig_file::{Robot, rig_error};
use crate::input::settings::{Settings, for_a_floor, handing_over};
use crate::input::{self, log::writer};
use crate::recording::{Job, Recording};
use crate::show::output::folder::Folder;
use crate::show::output::streams::{LineFile, Streams};
use crate::show::output::summary::Origin;
use crate::show::output::{self, NAMES};
use input_file::FileError;

/// What to run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Name of a built-in plan, or a plan file.
    pub plan: String,
    /// What the robot is to do.
    pub job: Job,
    /// Length of the drive at most, minutes.
    pub minutes: f64,
    /// Everything random follows from it.
    pub seed: u64,
    /// Name of a built-in robot, or a rig file; the default robot when not given.
    pub rig: Option<PathBuf>,
    /// The output folder.
    pub out: PathBuf,
    /// The kept map that the drive begins in, not knowing where.
    pub map: Option<PathBuf>,
    /// Where the robot stands at first, in the plan's frame; the plan's start where not given.
    pub start: Option<Pose2>,
    /// The estimator's settings.
    pub settings: Settings,
    /// Whether to write what became of every reading.
    pub trace: bool,
}

impl Run {
    /// Drives, estimates and writes the output folder; `progress` is told how far it is.
    ///
    /// # Errors
    /// What keeps the run from starting, or an output from being written.
    pub fn run(&self, mut progress: impl FnMut(Progress)) -> Result<Recording, FileError> {
        let mut plan = hal_sim::plan_file::load(&self.plan)?;
        if let Some(start) = &self.start {
            plan.check_start(start)
                .map_err(|what| FileError::new(Path::new(&self.plan), format!("the place of --start {what}")))?;
        }
        let mut options = SimOptions::default();
        match (&self.map, self.start) {
            // The kept map's frame is the plan's start, as that of the drive that made it.
            (Some(_), start) => options.start = start,
            (None, start) => plan.start = start.unwrap_or(plan.start),
        }
        let (robot, rig_toml) = match &self.rig {
            Some(rig) => input::robot(rig)?,
            None => input::built_in_robot()?,
        };
        let (robot, rig_toml) = match self.job {
            Job::Clean if self.settings.leaves_hand_overs() => for_a_floor((robot, rig_toml)),
            Job::Clean | Job::Explore => {
                let hand_overs = self.settings.config(&robot).hand_overs;
                handing_over((robot, rig_toml), hand_overs)
            }
        };
        let rig_name = self.rig.clone().unwrap_or_else(|| PathBuf::from("built-in rig"));
        let drive = match self.job {
            Job::Explore => Drive::new(&plan, &robot, options, self.seed),
            Job::Clean => Drive::cleaning(&plan, &robot, options, self.seed),
        };
        let mut drive = drive.map_err(|error| self.simulation_error(&rig_name, &error))?;
        let config = self.settings.config(&robot);
        let mut session =
            Session::new(&robot, config, plan.name.clone()).map_err(|error| rig_error(&rig_name, &error))?;
        let begun_in = begin_in(&mut session, self.map.as_deref())?;
        if let Some(why) = self.go_on(&mut drive, begun_in)? {
            progress(Progress::Dropped(why));
        }
        let names: Vec<&str> = NAMES.iter().copied().chain(["log.csv", "rig.toml", JOB]).collect();
        let mut folder = Folder::prepare(&self.out, &renewed(&names, &self.out, self.map.as_deref()))?;
        folder.write("rig.toml", &rig_toml)?;
        let mut streams = Streams::create(&folder)?;
        let mut log = LineFile::create(folder.file("log.csv"))?;
        log.line(&writer::header(&robot))?;
        let duration_s = 60.0 * self.minutes;
        drive.run(&mut session, duration_s, |row, recording, share| -> Result<(), FileError> {
            progress(Progress::Driven(share));
            log.line(&writer::line(&robot, row))?;
            recording.steps.last().map_or(Ok(()), |step| streams.push(step))
        })?;
        log.close()?;
        streams.close()?;
        let kept = keep(&folder, &session)?;
        write_or_remove(&folder, JOB, kept.and_then(|map| drive.job_in(map)))?;
        let mut recording = drive.finish(session);
        recording.seed = Some(self.seed);
        recording.notes = recording.findings().into_iter().chain(drive.findings()).collect();
        let looking_back =
            smoother::add(&mut recording, &robot.rig, &mut |rounds| progress(Progress::LookingBack(rounds)));
        let origin = Origin { error: recording.fault(), ..self.origin(&robot, rig_toml, config) };
        output::finish(&mut folder, &recording, looking_back.as_ref(), &origin)?;
        Ok(recording)
    }

    /// Goes on with the floor job beside the kept map, if there is one; why not.
    fn go_on(&self, drive: &mut Drive, map: Option<MapId>) -> Result<Option<FloorRecordError>, FileError> {
        let (Job::Clean, Some(file), Some(id)) = (self.job, &self.map, map) else { return Ok(None) };
        Ok(beside(file, JOB)?.and_then(|bytes| drive.go_on_with(id, &bytes).err()))
    }

    /// What cannot be simulated, as an error in the file that is at fault.
    fn simulation_error(&self, rig: &Path, error: &SimError) -> FileError {
        let plan = Path::new(&self.plan);
        let is_of_plan =
            matches!(error, SimError::StartBlocked(..) | SimError::PlaceBlocked(..) | SimError::NoSuchSensor(..));
        FileError::new(if is_of_plan { plan } else { rig }, error.to_string())
    }

    fn origin(&self, robot: &Robot, rig_toml: String, config: Config) -> Origin {
        Origin {
            arguments: vec![
                ("command", json!("run")),
                ("plan", json!(self.plan)),
                // A plan file may change: its text is what the run can be repeated with.
                ("plan_toml", json!(std::fs::read_to_string(&self.plan).ok())),
                ("job", json!(self.job.name())),
                ("minutes", json!(self.minutes)),
                ("seed", json!(self.seed)),
                ("rig", json!(self.rig)),
                ("map", json!(self.map)),
                ("start", json!(self.start.map(|start| [start.x_m, start.y_m, start.theta_rad.to_degrees()]))),
            ],
            rig_toml,
            config,
            suits: Config::for_rig(&robot.rig),
            trace: self.trace,
            error: None,
        }
    }
}
