//! `lab hil --outlive`: the map outlives a reset in the middle of a drive and a power cut in the middle of a save.

use std::fmt;

use hal_sim::Simulation;
use wire::{Command, Place, PlaceState};

use super::Hil;
use super::boot::{Boot, Moment, PERIOD_US};

/// A robot that knows where it is is nearer to its true place than this, metres.
const FOUND_M: f64 = 0.1;
/// It finds itself within this time, seconds.
const FOUND_S: f64 = 200.0;
/// Drive after that, or after the last save, for there to be something to save, seconds.
const ON_S: f64 = 20.0;
/// Time to stand and save, seconds.
const SAVE_S: f64 = 3.0;
/// In this time the place is told once at least, seconds.
const TOLD_S: f64 = 1.2;
/// Words after which the power fails in a save: in the erase before the first one, and in the middle of the record.
const POWER_WORDS: [u32; 2] = [0, 1000];

/// What became of a map.
#[derive(Clone, Debug, Default)]
pub struct Outlived {
    /// When the robot knew where it was after each start but the first, seconds.
    pub found_s: Vec<f64>,
    /// Estimates with the same bits on host and target.
    pub identical: u64,
}

impl fmt::Display for Outlived {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found: Vec<String> = self.found_s.iter().map(|found_s| format!("{found_s:.0} s")).collect();
        writeln!(f, "  {:<34}{:>12}", "estimates with the host's bits", self.identical)?;
        writeln!(f, "  {:<34}{:>12}   after two resets and two power cuts in a save", "found after", found.join(", "))
    }
}

impl Hil {
    /// Maps and saves; loses its power in the middle of the next drive, and finds itself again; loses it in the middle of two
    /// saves, finds itself in the map of before each time, and saves.
    ///
    /// # Errors
    /// What is not as it has to be, for people.
    pub fn outlive(&self) -> Result<Outlived, String> {
        let mut story = Story { hil: self, home: self.simulation()?, flash: self.flash()?, told: Outlived::default() };
        let mut kept = 0;
        story.boot(None, |boot, _| {
            boot.command(Command::Start)?;
            let mut driving = pass(boot, 60.0 * self.minutes)?;
            // Just after a stop that it made to save there is nothing to save.
            loop {
                let before = std::mem::replace(&mut driving, pass(boot, ON_S)?);
                if driving.place.saves == before.place.saves {
                    break;
                }
            }
            driving.expect("while it drives", |place| place.state == PlaceState::Tracking && place.failed == 0)?;
            boot.command(Command::Stop)?;
            kept = driving.place.saves + 1;
            pass(boot, SAVE_S)?.expect("once it stands", |place| place.saves == kept && place.sequence == kept)?;
            boot.command(Command::Start)?;
            pass(boot, ON_S).map(|_| ())
        })?;
        story.boot(None, find)?;
        for words in POWER_WORDS {
            story.boot(Some(words), |boot, told| {
                find(boot, told)?;
                match stand(boot) {
                    Ok(_) => Err("the power did not fail in the save".into()),
                    Err(_) => Ok(()),
                }
            })?;
        }
        story.boot(None, |boot, told| {
            find(boot, told)?;
            stand(boot)?
                .expect("after the power cut", |place| (place.saves, place.failed, place.sequence) == (1, 0, kept + 1))
        })?;
        Ok(story.told)
    }
}

/// A home, and a robot in it that is started several times.
struct Story<'h> {
    hil: &'h Hil,
    home: Simulation,
    flash: Vec<u8>,
    told: Outlived,
}

impl Story<'_> {
    /// Starts the robot, lets that much happen to it, and cuts its power.
    fn boot(
        &mut self,
        power_words: Option<u32>,
        what: impl FnOnce(&mut Boot, &mut Outlived) -> Result<(), String>,
    ) -> Result<(), String> {
        let mut boot = Boot::start(self.hil, &mut self.home, self.flash.clone(), power_words)?;
        what(&mut boot, &mut self.told)?;
        let (shadow, flash) = boot.cut();
        let outcome = shadow.finish(&[], &[]);
        outcome.verdict()?;
        self.told.identical += outcome.identical;
        self.flash = flash;
        Ok(())
    }
}

/// What was seen last.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    place: Place,
    /// Of the estimate, in the frame of the first start.
    error_m: f64,
}

impl Seen {
    fn expect(&self, when: &str, is_right: impl Fn(&Place) -> bool) -> Result<(), String> {
        if is_right(&self.place) {
            Ok(())
        } else {
            Err(format!("{when} the robot said of its place: {:?}", self.place))
        }
    }
}

/// Lets time pass.
fn pass(boot: &mut Boot, seconds: f64) -> Result<Seen, String> {
    let mut seen = Seen::default();
    for _ in 0..(seconds * 1e6 / PERIOD_US as f64) as u64 {
        let Moment { estimate, place, truth, .. } = boot.pass()?;
        seen.place = place.unwrap_or(seen.place);
        if let Some(estimate) = estimate {
            let [x_m, y_m, _] = estimate.pose.map(f64::from);
            seen.error_m = (x_m - truth.x_m).hypot(y_m - truth.y_m);
        }
    }
    Ok(seen)
}

/// Drives until the robot knows where it is, and checks that it is there.
fn find(boot: &mut Boot, told: &mut Outlived) -> Result<(), String> {
    pass(boot, TOLD_S)?.expect("after a start", |place| place.state == PlaceState::Searching)?;
    boot.command(Command::Start)?;
    let mut found_s = TOLD_S;
    while found_s < FOUND_S {
        let Seen { place, error_m } = pass(boot, TOLD_S)?;
        found_s += TOLD_S;
        if place.state == PlaceState::Tracking {
            told.found_s.push(found_s);
            let is_there = error_m < FOUND_M;
            return if is_there { Ok(()) } else { Err(format!("the robot is {error_m:.2} m from where it says")) };
        }
    }
    Err(format!("the robot did not find itself in {FOUND_S} s"))
}

/// Drives on for a while, then stands, for the map to be saved.
fn stand(boot: &mut Boot) -> Result<Seen, String> {
    pass(boot, ON_S)?;
    boot.command(Command::Stop)?;
    pass(boot, SAVE_S)
}
