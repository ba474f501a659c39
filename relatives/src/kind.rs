//! The systems by name.

use crate::Relative;
use crate::geometry::Segment;
use crate::known::Known;
use crate::rows::line_ekf::{Extraction, LineEkf};
use crate::rows::ortho::Ortho;
use crate::rows::particles::Particles;
use crate::rows::psm_slam::PsmSlam;
use crate::rows::range_hough::RangeHough;
use crate::rows::reckoning::Reckoning;
use crate::rows::sonar_ekf::SonarEkf;
use crate::rows::sparse_gslam::SparseGslam;

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
    /// After OrthoSLAM.
    Ortho,
    /// Sparse-gslam.
    SparseGslam,
    /// The same with SoMaSLAM's soft right angles.
    Soma,
    /// After Beevers and Huang, 100 particles.
    Beevers100,
    /// The same with 600.
    Beevers600,
    /// The same with 40 and walls at right angles.
    Beevers40Square,
    /// After Zunino and Christensen 2001: edges by triangulation.
    Zunino,
    /// After Choi, Ahn and Chung 2005: edges and walls by triangulation.
    Choi2005,
    /// After Diosi and Kleeman 2005: polar scan matching.
    Psm,
    /// After Jensfelt and Christensen 1999: the walls are given.
    Jensfelt,
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

/// Walls are given where they are as long as this, metres, to this 1-sigma, as if measured by hand.
const GIVEN: (f64, f64) = (1.0, 0.01);

impl Kind {
    /// Every system.
    pub const ALL: [Self; 14] = [
        Self::DeadReckoning,
        Self::Abrate,
        Self::Choi2008,
        Self::Choi2008Free,
        Self::Ortho,
        Self::SparseGslam,
        Self::Soma,
        Self::Beevers100,
        Self::Beevers600,
        Self::Beevers40Square,
        Self::Zunino,
        Self::Choi2005,
        Self::Psm,
        Self::Jensfelt,
    ];

    /// As experiment files and the command line call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DeadReckoning => "dead-reckoning",
            Self::Abrate => "abrate",
            Self::Choi2008 => "choi-2008",
            Self::Choi2008Free => "choi-2008-free",
            Self::Ortho => "ortho-slam",
            Self::SparseGslam => "sparse-gslam",
            Self::Soma => "soma-slam",
            Self::Beevers100 => "beevers-100",
            Self::Beevers600 => "beevers-600",
            Self::Beevers40Square => "beevers-40-square",
            Self::Zunino => "zunino-2001",
            Self::Choi2005 => "choi-2005",
            Self::Psm => "psm",
            Self::Jensfelt => "jensfelt-1999",
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

    /// Why it cannot run on such a robot; none where it can.
    pub fn obstacle(self, setup: &Setup) -> Option<&'static str> {
        match self {
            Self::Zunino | Self::Choi2005 if !setup.cones => {
                Some("it triangulates cones of a sonar, and these are beams")
            }
            Self::Psm if !setup.has_scans => Some("it matches whole scans, and there are single beams"),
            Self::Jensfelt if setup.known.is_empty() => Some("it is given the walls, and nobody knows them here"),
            Self::DeadReckoning | Self::Zunino | Self::Choi2005 => None,
            _ if setup.cones => {
                Some("it takes a reading for a point ahead of the sensor, and a cone is 25 degrees wide")
            }
            _ => None,
        }
    }

    /// Builds the system.
    ///
    /// # Errors
    /// Why it cannot run on such a robot.
    pub fn build(self, setup: &Setup) -> Result<Box<dyn Relative>, &'static str> {
        if let Some(obstacle) = self.obstacle(setup) {
            return Err(obstacle);
        }
        let seed = setup.seed;
        Ok(match self {
            Self::DeadReckoning => Box::new(Reckoning::default()),
            Self::Abrate => Box::new(LineEkf::new(Extraction::EndPoints)),
            Self::Choi2008 => Box::new(LineEkf::new(Extraction::ConstrainedHough)),
            Self::Choi2008Free => Box::new(LineEkf::new(Extraction::Hough)),
            Self::Ortho => Box::new(Ortho::default()),
            Self::SparseGslam => Box::new(SparseGslam::new(false)),
            Self::Soma => Box::new(SparseGslam::new(true)),
            Self::Beevers100 => Box::new(Particles::new(100, false, seed)),
            Self::Beevers600 => Box::new(Particles::new(600, false, seed)),
            Self::Beevers40Square => Box::new(Particles::new(40, true, seed)),
            Self::Zunino => Box::new(SonarEkf::new(false)),
            Self::Choi2005 => Box::new(SonarEkf::new(true)),
            Self::Psm => Box::new(PsmSlam::default()),
            Self::Jensfelt => Box::new(RangeHough::new(Known::new(&setup.known, GIVEN.0, GIVEN.1, seed))),
        })
    }
}
