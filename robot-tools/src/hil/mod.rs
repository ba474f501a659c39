//! `lab hil`: the firmware on its own processor, emulated or real, in the loop with the simulated home.
//!
//! Every 20 ms of simulated time the firmware gets what its sensors show and answers with what it gives the motors.
//! Beside it the host runs the same estimator on the same samples: every estimate must be the same, bit for bit.

mod boot;
mod flash;
mod link;
mod outcome;
mod outlive;
mod shadow;
mod sweeping;
mod target;

use std::path::PathBuf;

use hal_sim::{Plan, SimOptions, Simulation};
use robot::rig::BuiltIn;
use wire::{Command, Sample};

use crate::port;
use boot::{Boot, PERIOD_US};
use flash::Memory;
use keeper::SLOT_BYTES;
use kept_map::{Record, Refused, rig_hash};
use lab::input::built_in;
use lab::input::log::writer;
use lab::input::rig_file::Robot;
use lab::numbers::shortest;
use lab::recording::{Job, Pose2};
use lab::run::{newest_map, unsuitable};
use lab::show::output::folder::Folder;
use lab::show::output::streams::{LineFile, tum_line};
pub use outcome::Outcome;
pub use outlive::Outlived;
use shadow::Shadow;
use slam_core::{Config, RobotSlam};
use sweeping::Sweeping;
pub use sweeping::Swept;
pub use target::Target;

/// Files that a run writes.
const NAMES: [&str; 6] = ["log.csv", "rig.toml", "trajectory.tum", "truth.tum", "map.bin", "hil.json"];

/// A drive in the loop.
#[derive(Clone, Debug)]
pub struct Hil {
    /// Name of a built-in plan, or a plan file.
    pub plan: String,
    /// What the robot is to do.
    pub job: Job,
    /// Length of the drive, minutes; the longest, where the job has an end.
    pub minutes: f64,
    /// Everything random follows from it.
    pub seed: u64,
    /// The output folder.
    pub out: PathBuf,
    /// The robot that the firmware is built for.
    pub robot: BuiltIn,
    /// Whether look backs are handed over.
    pub hand_overs: bool,
    /// A `map.bin` that the robot begins with in its flash.
    pub map: Option<PathBuf>,
    /// Where the firmware runs.
    pub target: Target,
}

impl Hil {
    /// Drives and compares; `progress` is told the share done, 0 to 1.
    ///
    /// # Errors
    /// What keeps the drive from starting or going on, for people. A difference between host and target is no error
    /// here: see [`Outcome::verdict`].
    pub fn run(&self, mut progress: impl FnMut(f64)) -> Result<Outcome, String> {
        let (robot, rig_toml) = built_in(self.robot).map_err(|error| error.to_string())?;
        let mut simulation = self.simulation()?;
        let mut sweeping = Sweeping::new(&self.plan()?, &simulation);
        let mut boot = Boot::start(self, &mut simulation, self.flash()?, None)?;
        // Results of before make room when there is something to come, for one of them may be the map that it begins with.
        let folder = Folder::prepare(&self.out, &NAMES).map_err(|error| error.to_string())?;
        let mut files = Files::create(&folder, &robot, &rig_toml)?;
        boot.command(match self.job {
            Job::Explore => Command::Start,
            Job::Clean => Command::Clean { anew: true },
        })?;
        let periods = (60.0 * self.minutes * 1e6 / PERIOD_US as f64).ceil() as u64;
        for period in 1..=periods {
            let moment = boot.pass()?;
            if let Some(estimate) = moment.estimate {
                files.row(&robot, &moment.shown, &estimate, moment.truth)?;
            }
            sweeping.record(&moment);
            progress(period as f64 / periods as f64);
            if sweeping.is_over() {
                break;
            }
        }
        files.close()?;
        let (shadow, _) = boot.cut();
        if let Some(map) = shadow.record() {
            folder.write("map.bin", map).map_err(|error| error.to_string())?;
        }
        let swept = (self.job == Job::Clean).then(|| sweeping.finish());
        let outcome = Outcome { swept, ..outcome(&self.plan()?, &simulation, shadow) };
        folder.write("hil.json", outcome.to_json(self)).map_err(|error| error.to_string())?;
        Ok(outcome)
    }

    fn plan(&self) -> Result<Plan, String> {
        hal_sim::plan_file::load(&self.plan).map_err(|error| error.to_string())
    }

    fn simulation(&self) -> Result<Simulation, String> {
        Simulation::new(&self.plan()?, &self.robot.rig(), SimOptions::default(), self.seed)
            .map_err(|error| error.to_string())
    }

    /// What the robot's flash for maps has at first: of a target that has none, nothing.
    fn flash(&self) -> Result<Vec<u8>, String> {
        if !matches!(self.target, Target::Emulator { .. } | Target::EmulatorTimed { .. }) {
            return Ok(Vec::new());
        }
        let Memory(mut flash) = Memory::erased();
        if let Some(file) = &self.map {
            let map = std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
            let map = newest_map(&map).to_vec();
            let (rig, refused) = (self.robot.rig(), |refused: Refused| format!("{} {refused}", file.display()));
            let record = Record::parse(&map).map_err(refused)?;
            record.of_rig(rig_hash(&rig)).map_err(refused)?;
            let config = Config::for_rig(&rig);
            let slam = Box::new(RobotSlam::with_config(rig, config).expect("a built-in rig is a valid one"));
            slam.suits(&record).map_err(|unfit| format!("{} {}", file.display(), unsuitable(unfit)))?;
            let slot = flash.get_mut(..map.len()).filter(|slot| slot.len() <= SLOT_BYTES as usize);
            let is_long = || format!("{}: a robot has room for {SLOT_BYTES} bytes, not {}", file.display(), map.len());
            slot.ok_or_else(is_long)?.copy_from_slice(&map);
        }
        Ok(flash)
    }
}

fn outcome(plan: &Plan, simulation: &Simulation, shadow: Shadow) -> Outcome {
    let faces = plan.faces_in_start_frame();
    let seen = simulation.coverage().walls(lab::evaluate::score::map::LONG_M, lab::evaluate::score::map::PASSED_M);
    shadow.finish(&faces, &seen)
}

/// The files that grow with the drive.
struct Files {
    log: LineFile,
    trajectory: LineFile,
    truth: LineFile,
}

impl Files {
    fn create(folder: &Folder, robot: &Robot, rig_toml: &str) -> Result<Self, String> {
        let create = |name: &str| LineFile::create(folder.file(name)).map_err(|error| error.to_string());
        folder.write("rig.toml", rig_toml).map_err(|error| error.to_string())?;
        let mut files =
            Self { log: create("log.csv")?, trajectory: create("trajectory.tum")?, truth: create("truth.tum")? };
        files.log.line(&writer::header(robot)).map_err(|error| error.to_string())?;
        Ok(files)
    }

    fn row(&mut self, robot: &Robot, shown: &Sample, estimate: &wire::Estimate, truth: Pose2) -> Result<(), String> {
        let row = port::row(shown, robot, Some(truth))?;
        let [x, y, theta_rad] = estimate.pose;
        let trajectory = tum_line(&row.t_text, [shortest(x), shortest(y)], theta_rad.into());
        let true_line = tum_line(&row.t_text, [shortest(truth.x_m), shortest(truth.y_m)], truth.theta_rad);
        let lines = [
            (&mut self.log, writer::line(robot, &row)),
            (&mut self.trajectory, trajectory),
            (&mut self.truth, true_line),
        ];
        lines.into_iter().try_for_each(|(file, line)| file.line(&line)).map_err(|error| error.to_string())
    }

    fn close(self) -> Result<(), String> {
        [self.log, self.trajectory, self.truth]
            .into_iter()
            .try_for_each(LineFile::close)
            .map_err(|error| error.to_string())
    }
}
