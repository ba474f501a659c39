//! `lab experiment` on the command line.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use crate::file::Experiment;
use crate::page::{self, Written};
use crate::runner::{Runner, Shard};
use crate::sensor::SensorArgs;
use crate::{store, table};
use input_file::FileError;

/// `lab experiment`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct ExperimentArgs {
    #[command(subcommand)]
    part: Option<Part>,
    /// Experiment file.
    #[arg(required = true)]
    file: Option<PathBuf>,
    /// Folder for the results; out/experiment/NAME when not given. What is finished in it is not done again.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Do a part only: the k-th of n. The parts are joined with `lab experiment merge`.
    #[arg(long, value_name = "K/N")]
    shard: Option<Shard>,
    /// Threads; one for each core when not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

#[derive(Debug, Subcommand)]
enum Part {
    /// Join the folders that --shard wrote, and make tables, figures and page of the whole.
    Merge {
        /// Folder for the whole.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
        /// Folders of the parts.
        #[arg(required = true)]
        parts: Vec<PathBuf>,
    },
    /// Fit the sensor model to a real sensor's log.
    Sensor(SensorArgs),
}

impl ExperimentArgs {
    /// Runs the command.
    ///
    /// # Errors
    /// A file that cannot be used, or a drive that cannot be simulated.
    pub fn run(self) -> Result<(), FileError> {
        match self.part {
            Some(Part::Merge { out, parts }) => {
                let experiment = store::merge(&out, &parts)?;
                say(&page::write(&out, &experiment)?, &out);
                return Ok(());
            }
            Some(Part::Sensor(sensor)) => return sensor.run(),
            None => {}
        }
        let file = self.file.unwrap_or_default();
        let experiment = Experiment::read(&file)?;
        let shard = self.shard.unwrap_or(Shard::WHOLE);
        let out = self.out.unwrap_or_else(|| default_out(&file, shard));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let runner = Runner { out: out.clone(), shard, jobs: self.jobs.map_or(cores, usize::from) };
        let bar = ProgressBar::new(0).with_style(
            // The template is a constant; a bad one only loses its looks.
            ProgressStyle::with_template("{pos} of {len} drives {wide_bar} {elapsed}, {eta} to go")
                .unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        let done = runner.run(&experiment, &|done, of| {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
        });
        bar.finish_and_clear();
        done?;
        say(&page::write(&out, &experiment)?, &out);
        Ok(())
    }
}

fn default_out(file: &Path, shard: Shard) -> PathBuf {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let part = if shard == Shard::WHOLE { String::new() } else { format!("-{}-of-{}", shard.k, shard.n) };
    Path::new("out/experiment").join(format!("{name}{part}"))
}

/// The tables on the standard output, where somebody still listens.
fn say(written: &Written, out: &Path) {
    let Written { lines, verdicts } = written;
    let _ = write!(
        std::io::stdout(),
        "{}\n{}results in {}\n",
        table::markdown(lines),
        table::verdicts_markdown(verdicts),
        out.display()
    );
}
