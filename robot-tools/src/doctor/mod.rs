//! Goes through a robot part by part and says what is swapped, reversed or off: [`Examination`] knows what is to be done and
//! what the samples say, `lab doctor` does it at a terminal and a serial port.

mod checks;
mod examination;
#[cfg(feature = "desk")]
mod terminal;

use wire::{Command, Sample};

pub use checks::Finding;
pub use examination::{Examination, Found};
use lab::input::rig_file::Robot;
#[cfg(feature = "desk")]
pub use terminal::Doctor;

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

/// Goes through all checks on a bench; returns how many found something wrong.
///
/// # Errors
/// The robot or the person does not answer.
pub fn examine(bench: &mut impl Bench, robot: &Robot) -> Result<usize, String> {
    let mut examination = Examination::new(robot);
    let mut told = 0;
    while !examination.is_over() {
        if let Some(what) = examination.ask().map(str::to_owned) {
            bench.ask(&what)?;
            examination.answer();
        } else if let Some(command) = examination.send() {
            bench.send(command)?;
        } else {
            bench.listen(examination.listens())?.into_iter().for_each(|sample| examination.take(sample));
        }
        for Found { part, finding } in &examination.found()[told..] {
            match finding {
                Ok(fine) => bench.say(&format!("  ok     {part}: {fine}")),
                Err(fault) => bench.say(&format!("  WRONG  {part}: {fault}")),
            }
        }
        told = examination.found().len();
    }
    Ok(examination.found().iter().filter(|found| found.finding.is_err()).count())
}
