//! The command line of the workbench.

#![forbid(unsafe_code)]

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::{ArgAction, Args, Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use lab::evaluate::compare::Compare;
use lab::input::settings::{Settings, VariantArgs};
use lab::recording::{Pose2, Recording};
use lab::run::{Job, Progress, RelativeReplay, Replay, Replayed, Run};
use lab::show::closing;
use monte_carlo::command::ExperimentArgs;
use relatives::Kind;
use robot::rig::BuiltIn;
use robot_tools::doctor::Doctor;
use robot_tools::hil::{Hil, Target};
use robot_tools::kept_map::MapArgs;
use robot_tools::monitor::Monitor;
use robot_tools::stop::Stop;

/// The workbench: a simulated cleaning robot maps a flat, or a recorded log is replayed through the same estimator.
///
/// Without a command it simulates, as `lab run` does.
#[derive(Debug, Parser)]
#[command(name = "lab", version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: RunArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Let a simulated robot map a simulated home.
    Run(RunArgs),
    /// Replay a recorded log: log.csv or CARMEN, plain or gzipped.
    Replay(ReplayArgs),
    /// Set the scores of two output folders side by side: which is better, and by how much.
    Compare(Compare),
    /// Run the robot's firmware on its processor, emulated or real, in the loop with the simulated home.
    Hil(HilArgs),
    /// Show what a robot at a serial port says, and record it.
    Monitor(Monitor),
    /// Have a robot at a serial port stand.
    Stop(Stop),
    /// Check a robot at a serial port part by part.
    Doctor(Doctor),
    /// Fetch, store or forget the map that a robot at a serial port keeps.
    Map(MapArgs),
    /// Compare estimators over many simulated drives, as an experiment file says.
    Experiment(ExperimentArgs),
}

#[derive(Debug, Args)]
struct RunArgs {
    /// Floor plan: the name of a built-in one, or a file.
    #[arg(long, value_name = "NAME|FILE", default_value = "flat")]
    plan: String,
    /// What the robot is to do: `explore`, which maps the home, or `clean`, which sweeps its floor and comes back.
    #[arg(long, value_name = "JOB", default_value = "explore", value_parser = job)]
    job: Job,
    /// Length of the drive in minutes; the longest, where the job has an end: 10, and 60 to clean.
    #[arg(long, value_name = "M", value_parser = minutes, allow_negative_numbers = true)]
    minutes: Option<f64>,
    /// Seed of everything random: the same seed gives the same drive, bit for bit.
    #[arg(long, value_name = "S", default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Robot: `sharp` (the default: eight analogue sensors, ticks), `time-of-flight` (four that report metres, ticks), `odometry`
    /// (the same four, a dead-reckoned pose), or a rig file.
    #[arg(long, value_name = "NAME|FILE")]
    rig: Option<PathBuf>,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "out/run")]
    out: PathBuf,
    /// Begin in this kept map, the map.bin of an earlier run, not knowing where, but for what a pose.bin beside it says.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Where the robot stands at first, in the plan: metres, metres, degrees. It is not told.
    #[arg(long, value_name = "X,Y,DEG", value_parser = start, allow_hyphen_values = true)]
    start: Option<Pose2>,
    /// Also write readings.csv: what became of every reading.
    #[arg(long)]
    trace: bool,
    /// Also write the run for Foxglove.
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    #[command(flatten)]
    variant: VariantArgs,
}

#[derive(Debug, Args)]
struct ReplayArgs {
    /// The log.
    log: PathBuf,
    /// Rig file of the robot that recorded it.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// Folder for the results.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// True poses to score against; truth.csv beside the log when not given.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Begin in this kept map, the map.bin of an earlier run or replay, not knowing where, but for what a pose.bin beside it says.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Another system instead of the estimator, for comparison (docs/reference/relatives.md).
    #[arg(long, value_name = "NAME", value_parser = Kind::of_name, conflicts_with_all = ["map", "trace", "VariantArgs"])]
    with: Option<Kind>,
    /// Also write readings.csv: what became of every reading.
    #[arg(long)]
    trace: bool,
    /// Also write the run for Foxglove.
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    #[command(flatten)]
    variant: VariantArgs,
}

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("where").required(true))]
struct HilArgs {
    /// In the emulator qemu-system-arm.
    #[arg(long, group = "where")]
    qemu: bool,
    /// On a board at this serial port; reset the board first.
    #[arg(long, group = "where", value_name = "DEV")]
    port: Option<String>,
    /// With --qemu: over the emulated serial line, slowly, as with a board.
    #[arg(long, requires = "qemu")]
    serial: bool,
    /// With --qemu: on the processor's own clock, 16 ns an instruction; says how late steps began.
    #[arg(long, requires = "qemu", conflicts_with = "serial")]
    timed: bool,
    /// With --qemu: whether the firmware takes look backs over. A board does.
    #[arg(long, requires = "qemu", conflicts_with = "serial", value_name = "BOOL", default_value_t = true, action = ArgAction::Set)]
    hand_overs: bool,
    /// With --qemu: a kept map that the robot begins with in its flash, a file `map.bin`.
    #[arg(long, requires = "qemu", conflicts_with = "serial", value_name = "FILE")]
    map: Option<PathBuf>,
    /// With --qemu: saves its map, has its power cut while it drives and while it saves, and finds itself again each time; --minutes
    /// is the length of the first drive, and no files are written.
    #[arg(long, requires = "qemu", conflicts_with_all = ["serial", "timed", "map", "out"])]
    outlive: bool,
    /// With --qemu: the firmware's image; `cargo xtask hil` builds it.
    #[arg(long, value_name = "ELF", default_value = "target/thumb/thumbv7em-none-eabihf/release/hil")]
    image: PathBuf,
    /// Robot that the firmware is built for.
    #[arg(long, value_name = "NAME", default_value = "sharp", value_parser = built_in)]
    rig: BuiltIn,
    /// Floor plan: the name of a built-in one, or a file.
    #[arg(long, value_name = "NAME|FILE", default_value = "flat")]
    plan: String,
    /// What the robot is told to do: `explore`, which maps the home, or `clean`, which sweeps its floor and comes back.
    #[arg(long, value_name = "JOB", default_value = "explore", value_parser = job, conflicts_with = "outlive")]
    job: Job,
    /// Length of the drive in minutes; the longest, where the job has an end.
    #[arg(long, value_name = "M", default_value = "3", value_parser = minutes, allow_negative_numbers = true)]
    minutes: f64,
    /// Seed of everything random: the same seed gives the same drive, bit for bit.
    #[arg(long, value_name = "S", default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "out/hil")]
    out: PathBuf,
}

fn built_in(name: &str) -> Result<BuiltIn, String> {
    let names = BuiltIn::ALL.map(BuiltIn::name).join(", ");
    BuiltIn::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| format!("there are: {names}"))
}

/// Longest drive, minutes: a record of a day fills the memory.
const MAX_MINUTES: f64 = 240.0;

fn minutes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(minutes) if minutes > 0.0 && minutes <= MAX_MINUTES => Ok(minutes),
        _ => Err(format!("it must be a number above 0 and up to {MAX_MINUTES}")),
    }
}

fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("it must be a whole number from 0 to {}", u64::MAX))
}

fn job(name: &str) -> Result<Job, String> {
    let names = Job::ALL.map(|(name, _)| name).join(", ");
    Job::ALL.into_iter().find(|(own, _)| *own == name).map(|(_, job)| job).ok_or_else(|| format!("there are: {names}"))
}

fn start(text: &str) -> Result<Pose2, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|number: &f64| number.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[x_m, y_m, heading_deg]) => Ok(Pose2::new(x_m, y_m, heading_deg.to_radians())),
        _ => Err("it must be three numbers: metres, metres, degrees, as 1.5,2,-90".to_owned()),
    }
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match cli.command {
        Some(Command::Replay(args)) => replay(args),
        Some(Command::Run(args)) => run(args),
        Some(Command::Compare(compare)) => compare.text().map(|text| print(&text)).map_err(Into::into),
        Some(Command::Hil(args)) => hil(args),
        Some(Command::Monitor(monitor)) => monitor.run().map_err(Into::into),
        Some(Command::Stop(stop)) => stop.run().map_err(Into::into),
        Some(Command::Doctor(doctor)) => doctor.run().map_err(Into::into),
        Some(Command::Map(map)) => map.run().map_err(Into::into),
        Some(Command::Experiment(experiment)) => experiment.run().map_err(Into::into),
        None => run(cli.run),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: RunArgs) -> Result<(), Box<dyn Error>> {
    let RunArgs { plan, job, minutes, seed, rig, out, map, start, trace, mcap, variant } = args;
    mcap.as_deref().map_or(Ok(()), foxglove_file::check)?;
    let bar = ProgressBar::new(1000).with_style(style(match job {
        Job::Explore => "driving {wide_bar} {percent} %, {eta} to go",
        Job::Clean => "sweeping {wide_bar} {percent} % of the floor, {elapsed}",
    }));
    let minutes = minutes.unwrap_or(match job {
        Job::Explore => 10.0,
        Job::Clean => 60.0,
    });
    let run = Run { plan, job, minutes, seed, rig, out, map, start, settings: Settings::ForRig(variant), trace };
    let recording = run.run(|progress| show(&bar, progress));
    bar.finish_and_clear();
    let recording = recording?;
    recording.notes.iter().for_each(|note| eprintln!("note: {}: {note}", run.plan));
    film(mcap.as_deref(), &recording)?;
    say(&recording, &run.out)
}

fn replay(args: ReplayArgs) -> Result<(), Box<dyn Error>> {
    let ReplayArgs { log, rig, out, truth, map, with, trace, mcap, variant } = args;
    mcap.as_deref().map_or(Ok(()), foxglove_file::check)?;
    let bar = ProgressBar::new_spinner().with_style(style("{spinner} {pos} rows, {elapsed}"));
    let replay = Replay { log, rig, out, truth, map, settings: Settings::ForRig(variant), trace };
    let replayed = match with {
        Some(with) => {
            let Replay { log, rig, out, truth, .. } = replay.clone();
            RelativeReplay { log, rig, out, truth, with }.run(|progress| show(&bar, progress))
        }
        None => replay.run(|progress| show(&bar, progress)),
    };
    bar.finish_and_clear();
    let Replayed { recording, error, .. } = replayed?;
    recording.notes.iter().for_each(|note| eprintln!("note: {}: {note}", replay.log.display()));
    film(mcap.as_deref(), &recording)?;
    let said = say(&recording, &replay.out);
    error.map_or(said, |error| Err(error.into()))
}

fn hil(args: HilArgs) -> Result<(), Box<dyn Error>> {
    let HilArgs { port, serial, timed, hand_overs, map, outlive, image, rig, plan, job, minutes, seed, out, .. } = args;
    let target = match port {
        Some(device) => Target::Port { device },
        None if serial => Target::EmulatorSerial { image },
        None if timed => Target::EmulatorTimed { image },
        None => Target::Emulator { image },
    };
    let bar = ProgressBar::new(1000).with_style(style("in the loop {wide_bar} {percent} %, {eta} to go"));
    let hil = Hil { plan, job, minutes, seed, out, robot: rig, hand_overs, map, target };
    if outlive {
        print(&hil.outlive()?.to_string());
        return Ok(());
    }
    let outcome = hil.run(|share| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    let outcome = outcome?;
    print(&format!("{outcome}  results in {}\n", hil.out.display()));
    outcome.verdict().map_err(Into::into)
}

/// Writes the run for Foxglove, where that is asked for.
fn film(file: Option<&Path>, recording: &Recording) -> Result<(), Box<dyn Error>> {
    file.map_or(Ok(()), |file| foxglove_file::write_file(file, recording).map_err(Into::into))
}

/// Text on the standard output, where somebody still listens.
fn print(text: &str) {
    let _ = write!(std::io::stdout(), "{text}");
}

/// The closing table; an error where the estimate is no number, or ended unwell.
fn say(recording: &Recording, out: &Path) -> Result<(), Box<dyn Error>> {
    print(&format!("{}  results in {}\n", closing::table(recording), out.display()));
    recording.complaint().map_or(Ok(()), |fault| Err(fault.into()))
}

/// The progress on the bar.
fn show(bar: &ProgressBar, progress: Progress) {
    match progress {
        Progress::Driven(share) => bar.set_position((1000.0 * share) as u64),
        Progress::Rows(rows) => bar.set_position(rows as u64),
        Progress::Dropped(why) => bar.suspend(|| eprintln!("note: job.bin: {why}; all of the floor is swept")),
        Progress::LookingBack(rounds) => {
            if rounds == 1 {
                bar.enable_steady_tick(Duration::from_millis(200));
                bar.set_style(style("{spinner} looking back: {pos} rounds, {elapsed}"));
            }
            bar.set_position(rounds as u64);
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    // The templates are constants of this file; a bad one only loses its looks.
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
