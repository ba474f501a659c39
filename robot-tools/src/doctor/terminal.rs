//! `lab doctor`: a person at this terminal and a robot at a port.

use std::io::{BufRead, Write};
use std::path::PathBuf;

use clap::Args;
use wire::{Command, Frame, Sample};

use super::{Bench, examine};
use crate::port::{self, Heard, Port};

/// Arguments of `lab doctor`.
#[derive(Clone, Debug, Args)]
pub struct Doctor {
    /// The serial port that the robot is at.
    #[arg(long, value_name = "DEV")]
    port: String,
    /// Name of the built-in robot, or its rig file.
    #[arg(long, value_name = "NAME|FILE", default_value = "sharp")]
    rig: PathBuf,
}

impl Doctor {
    /// Goes through all checks.
    ///
    /// # Errors
    /// What was found wrong, or that the robot does not answer.
    pub fn run(&self) -> Result<(), String> {
        let (robot, _) = lab::input::robot(&self.rig).map_err(|error| error.to_string())?;
        let mut bench = Terminal { port: Port::new(port::open(&self.port)?) };
        // A dead line is told of before anybody is asked to do anything.
        bench.listen(1)?;
        let wrong = examine(&mut bench, &robot)?;
        match wrong {
            0 => Ok(()),
            count => Err(format!("{count} things to put right, see above")),
        }
    }
}

/// A person at this terminal and a robot at a port.
struct Terminal {
    port: Port,
}

impl Bench for Terminal {
    fn ask(&mut self, what: &str) -> Result<(), String> {
        println!("{what} Then press Enter.");
        std::io::stdout().flush().map_err(|error| error.to_string())?;
        let mut line = String::new();
        let read = std::io::stdin().lock().read_line(&mut line).map_err(|error| error.to_string())?;
        if read == 0 { Err("nobody answers at the terminal".into()) } else { Ok(()) }
    }

    fn say(&mut self, what: &str) {
        println!("{what}");
    }

    fn listen(&mut self, samples: usize) -> Result<Vec<Sample>, String> {
        let asked = std::time::Instant::now();
        let mut heard = Vec::new();
        while heard.len() < samples {
            let frame = match self.port.frame()? {
                Heard::Frame(frame) => frame,
                Heard::Nothing | Heard::End => return Err(self.port.trouble()),
            };
            match frame {
                // What waited in the line while the person was busy is from before.
                Frame::Sample(_) if asked.elapsed().as_millis() < 300 => {}
                Frame::Sample(sample) => heard.push(sample),
                _ => {}
            }
        }
        Ok(heard)
    }

    fn send(&mut self, command: Command) -> Result<(), String> {
        self.port.send(&Frame::Command(command))
    }
}
