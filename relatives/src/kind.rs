//! The systems by name.

use crate::Relative;
use crate::geometry::Segment;
use crate::rows::line_ekf::{Extraction, LineEkf};
use crate::rows::reckoning::Reckoning;

/// A system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// The motion alone.
    DeadReckoning,
    /// After Abrate, Bona and Indri: line EKF over infrared readings.
    Abrate,
    /// After Choi, Lee and Oh 2008: Hough lines around the map's right angles.
    Choi2008,
    /// The same without the constraint.
    Choi2008Free,
}

/// What a system is built for.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// Seed of everything random.
    pub seed: u64,
    /// Whether the robot has a scanner.
    pub has_scans: bool,
    /// Whether its readings are cones of a sonar.
    pub cones: bool,
    /// The walls of the home in the start frame, for those that are given the map; empty where they are not known.
    pub known: Vec<Segment>,
}

impl Kind {
    /// Every system.
    pub const ALL: [Self; 4] = [Self::DeadReckoning, Self::Abrate, Self::Choi2008, Self::Choi2008Free];

    /// As experiment files and the command line call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DeadReckoning => "dead-reckoning",
            Self::Abrate => "abrate",
            Self::Choi2008 => "choi-2008",
            Self::Choi2008Free => "choi-2008-free",
        }
    }

    /// The system of this name.
    ///
    /// # Errors
    /// The names that there are.
    pub fn of_name(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| format!("it must be one of {}", Self::ALL.map(Self::name).join(", ")))
    }

    /// Builds the system.
    ///
    /// # Errors
    /// Why it cannot run on such a robot.
    pub fn build(self, _setup: &Setup) -> Result<Box<dyn Relative>, &'static str> {
        Ok(match self {
            Self::DeadReckoning => Box::new(Reckoning::default()),
            Self::Abrate => Box::new(LineEkf::new(Extraction::EndPoints)),
            Self::Choi2008 => Box::new(LineEkf::new(Extraction::ConstrainedHough)),
            Self::Choi2008Free => Box::new(LineEkf::new(Extraction::Hough)),
        })
    }
}
