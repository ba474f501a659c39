//! `lab doctor`: goes through a robot at a serial port part by part and says what is swapped, reversed or off.

mod checks;

use std::io::{BufRead, Write};
use std::path::PathBuf;

use clap::Args;
use wire::{Command, Frame, Sample};

use crate::port::{self, Heard, Port};
use checks::Finding;
use lab::input::rig_file::Robot;

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

/// Samples that a check listens to: two seconds.
const LISTEN: usize = 50;
/// Distance at which something is held in front of a sensor, metres.
const HELD_M: f32 = 0.3;
/// Share of the supply that a motor is tried with.
const TRIED_DUTY: f32 = 0.3;
/// How far the robot is pushed to find the encoders' scale, metres.
const PUSHED_M: f32 = 1.0;

/// The robot and the person beside it.
pub trait Bench {
    /// Tells the person what to do and waits until it is done.
    ///
    /// # Errors
    /// Nobody answers.
    fn ask(&mut self, what: &str) -> Result<(), String>;

    /// Tells the person something.
    fn say(&mut self, what: &str);

    /// The next samples of the robot, as many.
    ///
    /// # Errors
    /// The robot says nothing more.
    fn listen(&mut self, samples: usize) -> Result<Vec<Sample>, String>;

    /// Tells the robot what to do.
    ///
    /// # Errors
    /// The line is broken.
    fn send(&mut self, command: Command) -> Result<(), String>;
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

/// Goes through all checks on a bench; returns how many found something wrong.
///
/// # Errors
/// The robot or the person does not answer.
pub fn examine(bench: &mut impl Bench, robot: &Robot) -> Result<usize, String> {
    let mut wrong = 0;
    let mut note = |bench: &mut dyn FnMut(&str), name: &str, finding: Finding| match finding {
        Ok(fine) => bench(&format!("  ok     {name}: {fine}")),
        Err(fault) => {
            wrong += 1;
            bench(&format!("  WRONG  {name}: {fault}"));
        }
    };
    bench.send(Command::Stop)?;
    bench.ask("Put the robot in the middle of the room, nothing nearer than a metre, wheels off the floor.")?;
    let free = bench.listen(LISTEN)?;
    for (index, (sensor, name)) in robot.rig.sensors.iter().zip(&robot.names).enumerate() {
        let bearing_deg = sensor.mount.bearing_rad.to_degrees();
        bench.ask(&format!(
            "Hold a white board {HELD_M} m in front of sensor {index}, {name}, at {bearing_deg:.0} degrees."
        ))?;
        let held = bench.listen(LISTEN)?;
        let finding = checks::sensor(index, robot, HELD_M, &free, &held);
        note(&mut |text| bench.say(text), name, finding);
    }
    for part in checks::CONTACTS {
        bench.ask(&format!("{} and keep it so.", part.what))?;
        let samples = bench.listen(LISTEN / 5)?;
        note(&mut |text| bench.say(text), part.name, checks::contact(&part, &samples));
        bench.ask("Let go.")?;
    }
    for (wheel, name) in ["left", "right"].into_iter().enumerate() {
        let before = bench.listen(2)?;
        bench.ask(&format!("Turn the {name} wheel forward by hand, about one turn."))?;
        let after = bench.listen(2)?;
        note(&mut |text| bench.say(text), &format!("{name} encoder"), checks::turned(wheel, &before, &after));
        let duty = |on: usize| if on == wheel { TRIED_DUTY } else { 0.0 };
        bench.send(Command::Spin { left: duty(0), right: duty(1) })?;
        let spun = bench.listen(LISTEN / 2)?;
        note(&mut |text| bench.say(text), &format!("{name} motor"), checks::turned(wheel, &after, &spun));
    }
    let before = bench.listen(2)?;
    bench.ask(&format!("Put the robot on the floor and push it straight forward by {PUSHED_M} m."))?;
    let after = bench.listen(2)?;
    note(&mut |text| bench.say(text), "encoder scale", checks::scale(robot, PUSHED_M, &before, &after));
    Ok(wrong)
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
        self.port.send(command)
    }
}
