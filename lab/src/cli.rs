//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use slam_core::Config;

use crate::error::FileError;
use crate::output::closing;
use crate::replay::{Replay, Replayed};

/// The workbench: a simulated cleaning robot maps a flat, or a recorded log is replayed through the same estimator.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Replay a recorded log: log.csv or CARMEN, plain or gzipped.
    Replay(ReplayArgs),
}

#[derive(Debug, Args)]
struct ReplayArgs {
    /// The log.
    log: PathBuf,
    /// The robot that recorded it.
    #[arg(long)]
    rig: PathBuf,
    /// Where the results go.
    #[arg(long)]
    out: PathBuf,
    /// True poses to score against; truth.csv beside the log when not given.
    #[arg(long)]
    truth: Option<PathBuf>,
}

/// Runs the program with the process's own arguments.
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Some(Command::Replay(args)) => replay(args),
        None => Ok(()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn replay(args: ReplayArgs) -> Result<(), FileError> {
    let ReplayArgs { log, rig, out, truth } = args;
    let bar = ProgressBar::new_spinner().with_style(style("{spinner} {pos} rows, {elapsed}"));
    let replay = Replay { log, rig, out, truth, config: Config::default() };
    let replayed = replay.run(|rows| bar.set_position(rows as u64));
    bar.finish_and_clear();
    let Replayed { recording, notes, error } = replayed?;
    for note in notes {
        eprintln!("note: {}: {note}", replay.log.display());
    }
    print!("{}", closing::table(&recording));
    println!("  results in {}", replay.out.display());
    error.map_or(Ok(()), Err)
}

fn style(template: &str) -> ProgressStyle {
    // The templates are constants of this file; a bad one only loses its looks.
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
