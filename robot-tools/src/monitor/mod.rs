//! `lab monitor`: what a robot at a serial port says, live, and recorded as a log that `lab replay` takes.

mod film;
mod recorder;
mod view;

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use lab::input::rig_file::Robot;
use signal_hook::consts::SIGINT;
use signal_hook::flag;
use wire::{Command, Frame};

use crate::port::{self, Heard, Port};
use crate::relay::relay;
use crate::stop::stop;
use film::Film;
use recorder::Recorder;
use view::View;

/// Arguments of `lab monitor`.
#[derive(Clone, Debug, Args)]
pub struct Monitor {
    /// The serial port that the robot is at; a file of recorded bytes works, too.
    #[arg(long, value_name = "DEV")]
    port: String,
    /// Tell the robot to start: `explore` (the default), `clean`, which goes on with the floor that it was stopped at, or `clean-anew`.
    #[arg(long, value_name = "JOB", num_args = 0..=1, default_missing_value = "explore", value_parser = start_of)]
    start: Option<Command>,
    /// Name of the built-in robot, or its rig file.
    #[arg(long, value_name = "NAME|FILE", default_value = "sharp")]
    rig: PathBuf,
    /// Folder for log.csv and rig.toml.
    #[arg(long, value_name = "DIR", default_value = "out/monitor")]
    out: PathBuf,
    /// Also write what the robot says for Foxglove.
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    /// Let the studio take part in the line, from this machine: an address such as 127.0.0.1:8091.
    #[arg(long, value_name = "ADDRESS")]
    serve: Option<String>,
    /// With --serve: the origin of a studio that is served from elsewhere, such as `https://example.org`.
    #[arg(long, value_name = "ORIGIN", requires = "serve")]
    allow: Option<String>,
}

/// What the robot can be told to start, by name.
const STARTS: [(&str, Command); 3] = [
    ("explore", Command::Start),
    ("clean", Command::Clean { anew: false }),
    ("clean-anew", Command::Clean { anew: true }),
];

fn start_of(name: &str) -> Result<Command, String> {
    let names = STARTS.map(|(name, _)| name).join(", ");
    STARTS
        .into_iter()
        .find(|(own, _)| *own == name)
        .map(|(_, start)| start)
        .ok_or_else(|| format!("there are: {names}"))
}

/// How often the view is drawn and the log handed to the system, microseconds of the robot's time.
const DRAW_US: u64 = 250_000;

impl Monitor {
    /// Shows and records until the line ends or the user stops it with Ctrl-C, which stops a robot that was told to start.
    ///
    /// # Errors
    /// What is wrong with line or files, for people.
    pub fn run(&self) -> Result<(), String> {
        let (robot, rig_toml) = lab::input::robot(&self.rig).map_err(|error| error.to_string())?;
        if let Some(file) = &self.mcap {
            foxglove_file::check(file).map_err(|error| error.to_string())?;
        }
        let mut port = Port::new(self.line()?);
        let mut files = None;
        let is_over = interrupted()?;
        let mut view = View::default();
        let mut drawn_us = 0;
        while !is_over.load(Ordering::Relaxed) {
            let frame = match port.frame()? {
                Heard::Frame(frame) => frame,
                Heard::Nothing => {
                    eprintln!("note: {}: {}", self.port, port.trouble());
                    continue;
                }
                Heard::End => break,
            };
            if files.is_none()
                && let Frame::Sample(sample) = &frame
            {
                // What was recorded before makes room when a robot of this rig speaks; it starts when it is recorded.
                port::row(sample, &robot, None)?;
                files = Some(self.files(&robot, &rig_toml)?);
                if let Some(start) = self.start {
                    port.send(&Frame::Command(start))?;
                }
            }
            if let Some((log, film)) = &mut files {
                if let Frame::Sample(sample) = &frame {
                    log.take(sample, &robot)?;
                }
                film.as_mut().map_or(Ok(()), |film| film.take(&frame))?;
            }
            view.take(frame);
            view.damaged = port.damaged();
            if view.time_us() >= drawn_us + DRAW_US || view.time_us() < drawn_us {
                drawn_us = view.time_us();
                files.as_mut().map_or(Ok(()), |(log, _)| log.flush())?;
                draw(&view);
            }
        }
        let is_stopped = is_over.load(Ordering::Relaxed);
        let stopped = if self.start.is_some() && is_stopped { stop(&mut port) } else { Ok(()) };
        if view.is_empty() {
            return Err(format!("{}: {}", self.port, port.trouble()));
        }
        let (log, film) = files.ok_or_else(|| format!("{}: the robot told nothing of what it senses", self.port))?;
        log.close()?;
        film.map_or(Ok(()), Film::finish)?;
        let end = if is_stopped { "stopped" } else { "the line has ended" };
        let _ = writeln!(std::io::stdout(), "{view}{end}; results in {}", self.out.display());
        stopped
    }
}

/// What becomes true with Ctrl-C; with a second one this program ends at once.
fn interrupted() -> Result<Arc<AtomicBool>, String> {
    let is_over = Arc::new(AtomicBool::new(false));
    flag::register_conditional_shutdown(SIGINT, 130, Arc::clone(&is_over))
        .and_then(|_| flag::register(SIGINT, Arc::clone(&is_over)))
        .map_err(|error| format!("Ctrl-C: {error}"))?;
    Ok(is_over)
}

impl Monitor {
    /// The files of what the robot says.
    fn files(&self, robot: &Robot, rig_toml: &str) -> Result<(Recorder, Option<Film>), String> {
        let log = Recorder::begin(&self.out, robot, rig_toml)?;
        Ok((log, self.mcap.as_deref().map(Film::create).transpose()?))
    }

    /// The robot's line, shared with pages where that is asked for.
    fn line(&self) -> Result<port::Line, String> {
        let line = port::open(&self.port)?;
        let Some(address) = &self.serve else { return Ok(line) };
        let (line, bound) = relay(line, address, self.allow.as_deref())?;
        eprintln!("note: the studio's mode Robot finds this robot at ws://{bound}");
        Ok(line)
    }
}

/// Draws over the last picture where there is a terminal; elsewhere the closing picture is enough.
fn draw(view: &View) {
    let mut stdout = std::io::stdout();
    if stdout.is_terminal() {
        let _ = write!(stdout, "\x1b[H\x1b[J{view}").and_then(|()| stdout.flush());
    }
}
