//! Parts of the robot that fail: a bumper that is jammed, a cliff sensor under dust, a range sensor that shows nothing or always the same.

use robot::Contacts;

/// What fails, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// The left half of the bumper stays pressed.
    BumpLeft,
    /// The right half of the bumper stays pressed.
    BumpRight,
    /// The cliff sensor sees no floor.
    Cliff,
    /// A range sensor, by its place in the rig, shows this distance, metres, whatever is there, or nothing. Its output is as noisy as that of one
    /// that works.
    Sensor {
        /// Its place in the rig.
        index: usize,
        /// What it shows, metres.
        shows_m: Option<f64>,
    },
}

/// A part that fails for a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What fails.
    pub part: Part,
    /// From when, seconds since the start.
    pub at_s: f64,
    /// For how long, seconds; may be for good.
    pub lasts_s: f64,
}

impl Fault {
    fn is_there(&self, time_s: f64) -> bool {
        (self.at_s..self.at_s + self.lasts_s).contains(&time_s)
    }
}

/// What the inputs tell at this time (seconds since the start) where this is touched.
pub(crate) fn told(faults: &[Fault], mut contacts: Contacts, time_s: f64) -> Contacts {
    for fault in faults.iter().filter(|fault| fault.is_there(time_s)) {
        match fault.part {
            Part::BumpLeft => contacts.bump_left = true,
            Part::BumpRight => contacts.bump_right = true,
            Part::Cliff => contacts.cliff = true,
            Part::Sensor { .. } => {}
        }
    }
    contacts
}

/// What a range sensor that fails at this time shows, metres, or nothing; none where it works.
pub(crate) fn shown(faults: &[Fault], sensor: usize, time_s: f64) -> Option<Option<f64>> {
    faults.iter().filter(|fault| fault.is_there(time_s)).find_map(|fault| match fault.part {
        Part::Sensor { index, shows_m } if index == sensor => Some(shows_m),
        _ => None,
    })
}
