//! `lab stop`: a robot at a serial port stands, whatever it does.

use std::time::{Duration, Instant};

use clap::Args;
use wire::{Command, Frame};

use crate::port::{self, Heard, Port};

/// Arguments of `lab stop`.
#[derive(Clone, Debug, Args)]
pub struct Stop {
    /// The serial port that the robot is at.
    #[arg(long, value_name = "DEV")]
    port: String,
}

impl Stop {
    /// Tells the robot to stop until it stands.
    ///
    /// # Errors
    /// It does not stand, or does not answer.
    pub fn run(&self) -> Result<(), String> {
        stop(&mut Port::new(port::open(&self.port)?))?;
        println!("the robot stands");
        Ok(())
    }
}

/// The command is told again so often: a frame may get lost.
const AGAIN: Duration = Duration::from_millis(300);
/// It is told so often at least.
const TELLS: u32 = 3;
/// The robot stands when its encoders count nothing in so many samples, a second.
const STILL: u32 = 25;
/// It stands after so long, or does not obey.
const LONGEST: Duration = Duration::from_secs(5);

/// Tells a robot to stop until its encoders say that it stands.
///
/// # Errors
/// It does not stand, or does not answer.
pub(crate) fn stop(port: &mut Port) -> Result<(), String> {
    let (begin, mut told_at, mut told) = (Instant::now(), None, 0);
    let (mut last, mut still) = (None, 0);
    while begin.elapsed() < LONGEST {
        if told_at.is_none_or(|at: Instant| at.elapsed() > AGAIN) {
            port.send(&Frame::Command(Command::Stop))?;
            (told_at, told) = (Some(Instant::now()), told + 1);
        }
        match port.frame()? {
            Heard::Frame(Frame::Sample(sample)) => {
                let ticks = [sample.left_ticks, sample.right_ticks];
                still = if last.replace(ticks) == Some(ticks) { still + 1 } else { 0 };
                if still >= STILL && told >= TELLS {
                    return Ok(());
                }
            }
            Heard::Frame(_) => {}
            Heard::Nothing => return Err(format!("{}; cut the robot's supply", port.trouble())),
            // What was recorded is read at once.
            Heard::End if still >= STILL => return Ok(()),
            Heard::End if last.is_none() => return Err(port.trouble()),
            Heard::End => break,
        }
    }
    Err("the robot was told to stop and its wheels turn still: cut its supply".to_owned())
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};
    use std::sync::{Arc, Mutex};

    use wire::{Decoder, Sample, encode};

    use super::*;

    /// What the robot was told.
    #[derive(Clone, Default)]
    struct Told(Arc<Mutex<Vec<u8>>>);

    impl Write for Told {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    /// What comes of it where the robot's left wheel is at these counts from sample to sample.
    fn stopped(counts: impl Iterator<Item = i32>) -> (Result<(), String>, Vec<Frame>) {
        let sample = |left_ticks| Frame::Sample(Sample { left_ticks, ..Sample::default() });
        let bytes: Vec<u8> = counts.flat_map(|left_ticks| encode(&sample(left_ticks)).unwrap().to_vec()).collect();
        let told = Told::default();
        let outcome = stop(&mut Port::new((Box::new(Cursor::new(bytes)), Box::new(told.clone()))));
        let mut decoder = Decoder::new();
        let told = told.0.lock().unwrap().iter().filter_map(|byte| decoder.push(*byte)).map(Result::unwrap).collect();
        (outcome, told)
    }

    #[test]
    fn a_robot_stands_when_its_wheels_do() {
        let (outcome, told) = stopped((0..100).chain([100; 40]));
        assert_eq!((outcome, &told[0]), (Ok(()), &Frame::Command(Command::Stop)));
        let (outcome, _) = stopped(0..100);
        assert!(outcome.unwrap_err().contains("turn still"));
        let (outcome, _) = stopped(0..0);
        assert!(outcome.unwrap_err().contains("nothing arrives"));
    }
}
