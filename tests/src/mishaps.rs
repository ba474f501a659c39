//! Drives in which something holds or kicks the robot, and whether it finds out by its readings.

use std::fmt;
use std::sync::LazyLock;

use hal_sim::mishap::{Hold, Kick};
use hal_sim::pose::wrap;
use hal_sim::{Plan, Pose2, plan_file};
use lab::evaluate::score::path::squared_by_covariance;

use crate::carries::{Driven, drive, rig};

/// When it happens, seconds.
pub const AT_S: f64 = 150.0;

/// For how long it is held, seconds.
const HELD_S: f64 = 4.0;

/// What happens in a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mishap {
    /// Nothing.
    Nothing,
    /// The wheels turn for four seconds and the robot stays.
    Hold,
    /// The robot is moved by 10 cm and turned by 15 degrees.
    Kick,
}

impl fmt::Display for Mishap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nothing => "nothing",
            Self::Hold => "hold",
            Self::Kick => "kick",
        })
    }
}

impl Mishap {
    /// Until when the robot may be lost, seconds: ten after a hold, twenty after a kick.
    fn until_s(self) -> f64 {
        match self {
            Self::Hold => AT_S + HELD_S + 10.0,
            Self::Nothing | Self::Kick => AT_S + 20.0,
        }
    }
}

/// What a drive came to.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Error of the position in the start frame at the end of the drive, metres.
    pub off_m: f64,
    /// Error of the heading there, radians.
    pub off_rad: f64,
    /// Normalised estimation error squared there.
    pub nees: f64,
    /// How often the estimator took the robot to be held.
    pub holds: u32,
    /// How often it took it to be displaced.
    pub jolts: u32,
}

/// Of the poses that are known as well as the robot says, a millionth has a larger normalised error squared.
const FAR: f64 = 30.0;

impl Found {
    /// Whether the robot is farther off than it can be if it knows its place as well as it says.
    pub fn is_too_sure(&self) -> bool {
        self.nees > FAR
    }

    /// Whether the robot knows where it is, to so many metres and radians.
    pub fn is_within(&self, off_m: f64, off_rad: f64) -> bool {
        self.off_m < off_m && self.off_rad < off_rad
    }
}

/// A built-in home in which that happens.
///
/// # Panics
/// Where there is no home of this name.
pub fn home(name: &str, mishap: Mishap) -> Plan {
    let mut plan = plan_file::load(name).unwrap_or_else(|error| panic!("{error}"));
    match mishap {
        Mishap::Nothing => {}
        Mishap::Hold => plan.mishaps.holds.push(Hold { at_s: AT_S, held_s: HELD_S, is_jammed: false }),
        Mishap::Kick => {
            plan.mishaps.kicks.push(Kick { at_s: AT_S, slide_m: 0.10, turn_rad: 15.0_f64.to_radians() });
        }
    }
    plan
}

/// Drives in the flat in which nothing happens, by seeds from 1.
pub static LEFT_ALONE: LazyLock<Vec<Found>> =
    LazyLock::new(|| (1..=300).map(|seed| found("flat", Mishap::Nothing, seed)).collect());

/// A drive of the built-in robot in a home of this name.
pub fn found(name: &str, mishap: Mishap, seed: u64) -> Found {
    let plan = home(name, mishap);
    let mut truth = Pose2::default();
    let slam = drive(&plan, &rig(8), mishap.until_s(), seed, |Driven { in_plan, .. }| {
        truth = plan.start.relative(&in_plan);
        true
    });
    let (estimate, counters) = (slam.estimate(), slam.counters());
    let off_rad = wrap(f64::from(estimate.pose.theta_rad) - truth.theta_rad);
    let [x_m, y_m] = [f64::from(estimate.pose.x_m) - truth.x_m, f64::from(estimate.pose.y_m) - truth.y_m];
    let covariance: [[f32; 3]; 3] = estimate.covariance.into();
    let covariance = covariance.map(|row| row.map(f64::from));
    Found {
        off_m: x_m.hypot(y_m),
        off_rad: off_rad.abs(),
        nees: squared_by_covariance([x_m, y_m, off_rad], &covariance).unwrap_or(f64::INFINITY),
        holds: counters.holds,
        jolts: counters.jolts,
    }
}
