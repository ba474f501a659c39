//! What is said. The order of variants and fields is the format: a change needs a new [`VERSION`](crate::VERSION), but for a
//! variant at the end.

use crate::map::{MapAnswer, MapRequest};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most range sensors of a robot.
pub const SENSORS: usize = 8;
/// Most calibration factors: a gain per sensor, two scales, the track.
const FACTORS: usize = SENSORS + 3;

/// One message.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Frame {
    /// What the robot sensed, raw.
    Sample(Sample),
    /// What it makes of that.
    Estimate(Estimate),
    /// One wall of its map.
    Wall(Wall),
    /// Its self-calibration.
    Calibration(Calibration),
    /// Everything that went wrong so far.
    Faults(Faults),
    /// What the motors are given.
    Motors(Motors),
    /// What the robot shall do.
    Command(Command),
    /// What its back end did so far.
    LookBack(LookBack),
    /// Whether it knows where it is in its kept map.
    Place(Place),
    /// What is wanted with that map.
    MapRequest(MapRequest),
    /// What it says to that.
    MapAnswer(MapAnswer),
    /// How far it is with the floor.
    Floor(Floor),
    /// Which of its range sensors are frozen.
    Frozen(Frozen),
}

/// Raw input of one estimator step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time since the robot's start, microseconds.
    pub time_us: u64,
    /// Cumulative counts of the left wheel, forward positive; they may wrap.
    pub left_ticks: i32,
    /// Cumulative counts of the right wheel.
    pub right_ticks: i32,
    /// Each range sensor's reading, in the rig's order.
    pub ranges: Vec<Range, SENSORS>,
    /// Bumper, cliff and wheel-drop inputs.
    pub contacts: Contacts,
}

/// One reading of a range sensor; floats travel with all their bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Range {
    /// No reading.
    #[default]
    Missing,
    /// Converter counts of an analogue sensor.
    Counts(u16),
    /// Metres, of a sensor that reports them.
    Metres(f32),
}

/// Inputs that stop the wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Contacts {
    /// The left half of the bumper is pressed.
    pub bump_left: bool,
    /// The right half of the bumper is pressed.
    pub bump_right: bool,
    /// There is no floor under the front.
    pub cliff: bool,
    /// A wheel hangs: the robot is off the floor.
    pub lifted: bool,
    /// The charging contact is closed: the robot stands in its dock. That stops nothing.
    pub docked: bool,
}

/// The estimate after one sample; floats travel with all their bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Time of the sample, microseconds.
    pub time_us: u64,
    /// x, y (metres) and heading (radians) in the map frame.
    pub pose: [f32; 3],
    /// Covariance: xx, xy, xtheta, yy, ytheta, thetatheta; m^2, m rad, rad^2.
    pub covariance: [f32; 6],
    /// Direction of the wall grid and its 1-sigma, radians; none before the first grid wall.
    pub alpha: Option<[f32; 2]>,
    /// The pose by the encoders alone: x, y (metres), heading (radians).
    pub dead_reckoning: [f32; 3],
    /// Walls in the map.
    pub walls: u8,
    /// How the estimator is.
    pub health: Health,
    /// Changes whenever the map as a whole is another one (`slam_core::Slam::epoch`).
    pub epoch: u32,
    /// How late the estimator's step began after its sample was due, microseconds.
    pub late_us: u32,
}

/// How the estimator is, as `slam_core::Health` describes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the variants are those of slam_core::Health")]
pub enum Health {
    #[default]
    Well,
    Unexplained,
    Contradicted,
    Disoriented,
    Degenerate,
}

/// One wall: the points p with p . (cos beta, sin beta) = rho, from lo to hi along (-sin beta, cos beta).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Place of this wall in the map as it is sent now.
    pub index: u8,
    /// Walls in the map as it is sent now.
    pub of: u8,
    /// Identifier.
    pub id: u16,
    /// How it is represented.
    pub kind: WallKind,
    /// Signed distance from the origin along the normal, metres.
    pub rho_m: f32,
    /// Direction of the normal, radians.
    pub beta_rad: f32,
    /// Start of the observed extent, metres.
    pub lo_m: f32,
    /// End of the observed extent, metres.
    pub hi_m: f32,
    /// 1-sigma of rho, metres.
    pub sigma_rho_m: f32,
    /// Readings that updated it.
    pub updates: u32,
}

/// How a wall is represented in the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WallKind {
    /// rho and theta.
    Free,
    /// rho and theta, the direction taken from the grid.
    Snapped,
    /// rho; the direction is the grid's.
    Grid,
}

/// The robot's self-calibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Every factor that is estimated.
    pub factors: Vec<Factor, FACTORS>,
}

/// One calibration factor, 1 where exact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Factor {
    /// Which one.
    pub parameter: Parameter,
    /// The factor.
    pub estimate: f32,
    /// Its 1-sigma.
    pub sigma: f32,
}

/// What a calibration factor belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Parameter {
    /// The left wheel's travel per tick.
    ScaleLeft,
    /// The right wheel's travel per tick.
    ScaleRight,
    /// The track.
    Track,
    /// Dead-reckoned distance.
    ScaleDistance,
    /// Dead-reckoned turns.
    ScaleTurn,
    /// The range sensor with this index.
    Gain(u8),
    /// Turn that dead reckoning misses, radians per metre driven.
    Veer,
}

/// Counts since the robot's start; they saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Faults {
    /// Of the estimator.
    pub slam: SlamFaults,
    /// Of everything around it.
    pub board: BoardFaults,
}

/// The estimator's counts, as `slam_core::Counters` describes them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are those of slam_core::Counters")]
pub struct SlamFaults {
    pub steps: u32,
    pub updates: u32,
    pub refused: [u32; slam_core::Refusal::COUNT],
    pub buffered: u32,
    pub overwritten: u32,
    pub births: u32,
    pub map_full: u32,
    pub merges: u32,
    pub prunes: u32,
    pub bad_motion: u32,
    pub restarts: u32,
}

/// Counts of the firmware's tasks and channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BoardFaults {
    /// Range sensors that could not be read.
    pub ranges_failed: u32,
    /// The encoders could not be read.
    pub encoders_failed: u32,
    /// The motors could not be set.
    pub motors_failed: u32,
    /// Samples dropped because the estimator was behind.
    pub samples_dropped: u32,
    /// Frames dropped because the serial line was behind.
    pub frames_dropped: u32,
    /// Commands dropped because they came too fast.
    pub commands_dropped: u32,
    /// Damaged frames and bytes lost on the serial line.
    pub bytes_lost: u32,
    /// Times the bumper or the cliff sensor stopped the wheels.
    pub contact_stops: u32,
    /// Times the wheels were stopped because the estimator or the drive task had gone silent.
    pub dead_man_stops: u32,
    /// Starts after the watchdog bit.
    pub watchdog_resets: u32,
    /// Supervisor periods in which some task had not reported.
    pub late_tasks: u32,
    /// No count: the most stack that was ever in use, bytes.
    pub stack_used_bytes: u32,
}

/// The back end's counts since the robot's start; they saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LookBack {
    /// Keyframes in the diary now.
    pub keyframes: u16,
    /// Groups of hits in it.
    pub groups: u16,
    /// Whether a look back is under way.
    pub is_working: bool,
    /// Look backs that were done.
    pub done: u32,
    /// That ended without a result.
    pub fruitless: u32,
    /// That were thrown away, since the estimator began anew.
    pub outdated: u32,
    /// Hand-overs that the estimator took.
    pub taken_over: u32,
    /// Those that it did not, by reason, in the order of `slam_core::NotTaken::ALL`.
    pub not_taken: [u32; slam_core::NotTaken::COUNT],
    /// Steps for which the estimator had to wait until the back end was returned; the sensors were read and the pilot told before.
    pub late: u32,
}

/// Whether the robot knows where it is in its kept map, with counts since its start; they saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// What it knows.
    pub state: PlaceState,
    /// The number of the kept map's save; 0 without one.
    pub sequence: u32,
    /// Maps saved.
    pub saves: u32,
    /// Saves that the flash refused.
    pub failed: u32,
    /// Times that it found itself.
    pub found: u32,
    /// Times that it gave up where it was, or was lifted.
    pub lost: u32,
    /// Natural logarithm of the odds of the best place that the last search found.
    pub log_odds: Option<f32>,
}

/// How far a robot that sweeps the floor is, by its own map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Floor {
    /// What it is doing: a place in `robot::FloorState::ALL`.
    pub state: u8,
    /// Floor swept so far, m^2.
    pub swept_m2: f32,
    /// Floor that was seen, has room for the body and is not swept, m^2.
    pub left_m2: f32,
    /// Time since the job began, seconds.
    pub seconds: u32,
}

/// What a robot knows of its place in its kept map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlaceState {
    /// There is no kept map: where it started is its map's origin.
    #[default]
    Fresh,
    /// It does not know: its pose is in the frame of a fresh map.
    Searching,
    /// It claims a place, and may take that back.
    Probation,
    /// It knows.
    Tracking,
    /// Its readings contradict the map.
    Doubtful,
}

/// What the motors are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motors {
    /// Time of the sample that this answers, microseconds.
    pub time_us: u64,
    /// Share of the supply at the left motor, -1 to 1.
    pub left: f32,
    /// Share of the supply at the right motor.
    pub right: f32,
}

/// What the robot shall do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Drive and map.
    Start,
    /// Stand still; the estimator goes on, and a floor that is being swept waits.
    Stop,
    /// Forget the map: where the robot stands is the new origin.
    ResetMap,
    /// Turn the wheels for a short time with this share of the supply, for checks at the bench; only when stopped.
    Spin {
        /// Left motor, -1 to 1.
        left: f32,
        /// Right motor, -1 to 1.
        right: f32,
    },
    /// Sweep the floor.
    Clean {
        /// All of it, from where the robot stands, which is home then; else on with what it was stopped at, and anew where that is nothing.
        anew: bool,
    },
}

/// Range sensors whose output stays the same whatever they look at; their readings are refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Frozen {
    /// Those that are frozen now, a bit each, in the rig's order.
    pub sensors: u16,
}
