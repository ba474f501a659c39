//! What a robot sensed, row by row: `log.csv` and CARMEN logs, plain or gzipped, told apart by content.

mod carmen;
mod csv;
mod lines;
mod odometry;
pub mod truth;
pub mod writer;

use std::io::Cursor;
use std::path::Path;

use slam_core::Sample;

use crate::input::rig_file::{MAX_SENSORS, Robot};
use crate::recording::Pose2;
use input_file::FileError;
use lines::Lines;

/// One row of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Time as the log writes it.
    pub t_text: String,
    /// The same, seconds.
    pub t_s: f64,
    /// What the estimator gets.
    pub sample: Sample<MAX_SENSORS>,
    /// The dead-reckoned pose that the sample's motion led to, where a log.csv has one.
    pub odometry: Option<Pose2>,
    /// The true pose, in the log's own frame, where the row carries one.
    pub truth: Option<Pose2>,
    /// The wheel-drop switches say that the robot is off the floor.
    pub lifted: bool,
    /// The charging contact says that the robot stands in its dock.
    pub docked: bool,
}

/// A whole scan of evenly spaced beams, of which the rig's sensors are some.
#[derive(Clone, Copy, Debug)]
pub struct Scan<'a> {
    /// The ranges, metres.
    pub ranges_m: &'a [f32],
    /// Direction of the first beam in the robot's frame, radians.
    pub first_rad: f64,
    /// Angle from one beam to the next, radians.
    pub step_rad: f64,
}

/// The rows of a log, in order. After an error there are none.
pub trait Rows: Iterator<Item = Result<Row, FileError>> {
    /// Whether rows come with whole scans.
    fn has_scans(&self) -> bool {
        false
    }

    /// The whole scan of the row read last, where the log has one.
    fn whole_scan(&self) -> Option<Scan<'_>> {
        None
    }

    /// What a user should know about the log though it is no error, so far.
    fn notes(&self) -> Vec<String>;
}

/// Opens a log for a robot, whose sensors' bearings are moved to the beams that a CARMEN log has.
///
/// # Errors
/// The file cannot be read, is no log, or does not fit the robot.
pub fn open(file: &Path, robot: &mut Robot) -> Result<Box<dyn Rows>, FileError> {
    rows(Lines::open(file)?, file, robot)
}

/// The rows of a log whose content is in memory; `file` is what errors call it.
///
/// # Errors
/// It is no log, or does not fit the robot.
pub fn of_bytes(file: &Path, content: Vec<u8>, robot: &mut Robot) -> Result<Box<dyn Rows>, FileError> {
    rows(Lines::of(file, Cursor::new(content))?, file, robot)
}

fn rows(mut lines: Lines, file: &Path, robot: &mut Robot) -> Result<Box<dyn Rows>, FileError> {
    let first = lines.peek_content()?;
    match first.as_deref().map(carmen::is_message) {
        Some(true) => Ok(Box::new(carmen::Reader::new(lines, robot)?)),
        Some(false) => Ok(Box::new(csv::Reader::new(lines, robot)?)),
        None => Err(FileError::new(file, "is empty; it must be a log.csv or a CARMEN log")),
    }
}

/// A column or field, and what is wrong with it.
type Fault = (String, String);

/// Largest time of a row, seconds from the clock's zero in either direction: three centuries. A clock in milliseconds or
/// microseconds since 1970 is beyond it.
const LATEST_S: f64 = 1e10;

/// A time as a log writes it, seconds.
fn seconds(text: &str) -> Option<f64> {
    text.parse().ok().filter(|t_s: &f64| t_s.abs() <= LATEST_S)
}

/// What a time must be.
const SECONDS: &str = "a finite number of seconds, from -1e10 to 1e10";

/// Microseconds since the log's first row, always increasing.
#[derive(Debug, Default)]
struct Clock {
    first_s: Option<f64>,
    last: Option<(f64, u64)>,
}

impl Clock {
    /// The time of the next row, or none where `t_s` does not increase.
    fn tick(&mut self, t_s: f64) -> Option<u64> {
        let since_s = t_s - *self.first_s.get_or_insert(t_s);
        let rounded_us = (since_s * 1e6).round() as u64;
        let time_us = match self.last {
            Some((last_s, _)) if t_s <= last_s => return None,
            // Rows closer than a microsecond still increase.
            Some((_, last_us)) => rounded_us.max(last_us + 1),
            None => rounded_us,
        };
        self.last = Some((t_s, time_us));
        Some(time_us)
    }
}
