//! `log.csv`: one header line, then one row per sample.

use slam_core::{DriveModel, Motion, RangeInput, RangeModel, Sample, Ticks};

use super::lines::Lines;
use super::odometry::Differencer;
use super::{Clock, Fault, Row, Rows, SECONDS, seconds};
use crate::input::rig_file::{MAX_SENSORS, Robot};
use crate::recording::Pose2;
use input_file::FileError;

const TICKS: [&str; 2] = ["left_ticks", "right_ticks"];
const POSE: [&str; 3] = ["odom_x_m", "odom_y_m", "odom_theta_rad"];
const LIFTED: &str = "lifted";
const DOCKED: &str = "docked";
const TRUTH: [&str; 3] = ["true_x_m", "true_y_m", "true_theta_rad"];

/// A column of the log.
#[derive(Clone, Debug)]
struct Column {
    name: String,
    index: usize,
}

#[derive(Debug)]
enum MotionColumns {
    Ticks([Column; 2]),
    Pose([Column; 3]),
}

/// Where everything is in a row.
#[derive(Debug)]
struct Columns {
    count: usize,
    time: Column,
    motion: MotionColumns,
    /// One per sensor, and whether it holds counts.
    ranges: Vec<(Column, bool)>,
    truth: Option<[Column; 3]>,
    lifted: Option<Column>,
    docked: Option<Column>,
    ignored: Vec<String>,
}

/// Reads the rows of a `log.csv`.
pub struct Reader {
    lines: Lines,
    columns: Columns,
    clock: Clock,
    differencer: Differencer,
    failed: bool,
}

impl Reader {
    /// Reads the header and checks that it fits the robot.
    pub fn new(mut lines: Lines, robot: &Robot) -> Result<Self, FileError> {
        let columns = match lines.next_content()? {
            Some((number, header)) => {
                let names = names(&lines, number, &header)?;
                Columns::find(&names, robot).map_err(|(column, what)| lines.error(number, what).at(column))?
            }
            None => return Err(FileError::new(lines.file(), "is empty")),
        };
        Ok(Self { lines, columns, clock: Clock::default(), differencer: Differencer::default(), failed: false })
    }

    fn row(&mut self, line: &str) -> Result<Row, Fault> {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let columns = &self.columns;
        count_cells(&cells, columns.count)?;
        let t_s = seconds(cells[columns.time.index]).ok_or_else(|| bad(&cells, &columns.time, SECONDS))?;
        let time_us = self.clock.tick(t_s).ok_or_else(|| {
            let what = format!("is {}; it must be above the row before", cells[columns.time.index]);
            (columns.time.name.clone(), what)
        })?;
        let (motion, odometry) = match &columns.motion {
            MotionColumns::Ticks([left, right]) => {
                (Motion::Ticks(Ticks { left: count(&cells, left)?, right: count(&cells, right)? }), None)
            }
            MotionColumns::Pose(pose) => {
                let pose = pose_of(&cells, pose)?;
                (Motion::Increment(self.differencer.step(pose)), Some(pose))
            }
        };
        let mut ranges = [RangeInput::Missing; MAX_SENSORS];
        for (range, (column, is_counts)) in ranges.iter_mut().zip(&columns.ranges) {
            *range = reading(&cells, column, *is_counts)?;
        }
        let truth = match &columns.truth {
            Some(pose) if pose.iter().any(|column| !is_missing(cells[column.index])) => Some(pose_of(&cells, pose)?),
            _ => None,
        };
        let (t_text, sample) = (cells[columns.time.index].to_owned(), Sample { time_us, motion, ranges });
        let is_on = |column: &Option<Column>, allowed| {
            column.as_ref().map_or(Ok(false), |column| switch(&cells, column, allowed))
        };
        let lifted = is_on(&columns.lifted, "0 on the floor or 1 off it, or empty where it is not known")?;
        let docked = is_on(&columns.docked, "0 out of the dock or 1 in it, or empty where it is not known")?;
        Ok(Row { t_text, t_s, sample, odometry, truth, lifted, docked })
    }
}

impl Iterator for Reader {
    type Item = Result<Row, FileError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let row = match self.lines.next_content() {
            Ok(None) => return None,
            Ok(Some((number, line))) => {
                self.row(&line).map_err(|(column, what)| self.lines.error(number, what).at(column))
            }
            Err(error) => Err(error),
        };
        self.failed = row.is_err();
        Some(row)
    }
}

impl Rows for Reader {
    fn notes(&self) -> Vec<String> {
        match self.columns.ignored.as_slice() {
            [] => Vec::new(),
            names => vec![format!("ignored columns that no log.csv has: {}", names.join(", "))],
        }
    }
}

impl Columns {
    /// Finds the columns that the robot needs; an error is a column and what is wrong with it.
    fn find(names: &[&str], robot: &Robot) -> Result<Self, Fault> {
        let mut unused: Vec<&str> = names.to_vec();
        let mut find = |name: &str, why: &str| match names.iter().position(|found| *found == name) {
            Some(index) => {
                unused.retain(|left| *left != name);
                Ok(Column { name: name.to_owned(), index })
            }
            None => Err((
                name.to_owned(),
                format!("is missing from the header; {}", spelling(names, name).unwrap_or(why.to_owned())),
            )),
        };
        let time = find("t_s", "every log has it")?;
        let motion = match robot.rig.drive {
            DriveModel::Wheels { .. } => {
                let why = "a robot with [wheels] has left_ticks and right_ticks";
                MotionColumns::Ticks([find(TICKS[0], why)?, find(TICKS[1], why)?])
            }
            DriveModel::Odometry { .. } => {
                let why = "a robot with [odometry] has odom_x_m, odom_y_m and odom_theta_rad";
                MotionColumns::Pose([find(POSE[0], why)?, find(POSE[1], why)?, find(POSE[2], why)?])
            }
        };
        let mut ranges = Vec::new();
        for (i, (sensor, name)) in robot.rig.sensors.iter().zip(&robot.names).enumerate() {
            ranges.push(match sensor.model {
                RangeModel::Sharp { .. } => {
                    (find(&format!("adc_{i}"), &format!("range sensor {name} is an analogue one"))?, true)
                }
                RangeModel::Metric { .. } => {
                    (find(&format!("range_{i}_m"), &format!("range sensor {name} reports metres"))?, false)
                }
            });
        }
        let truth = if TRUTH.iter().any(|name| names.contains(name)) {
            let why = "the three true_* columns come together";
            Some([find(TRUTH[0], why)?, find(TRUTH[1], why)?, find(TRUTH[2], why)?])
        } else {
            None
        };
        let mut optional = |name| names.contains(&name).then(|| find(name, "it was there")).transpose();
        let (lifted, docked) = (optional(LIFTED)?, optional(DOCKED)?);
        if let Some(extra) = unused.iter().find(|name| is_range_column(name)) {
            let plural = if ranges.len() == 1 { "" } else { "s" };
            let what = format!("has no place; the rig file has {} range sensor{plural}", ranges.len());
            return Err(((*extra).to_owned(), what));
        }
        unused.retain(|name| !TICKS.contains(name) && !POSE.contains(name));
        let ignored = unused.into_iter().map(str::to_owned).collect();
        Ok(Self { count: names.len(), time, motion, ranges, truth, lifted, docked, ignored })
    }
}

/// The columns that a file's first line names, each of them once.
pub(super) fn names<'h>(lines: &Lines, number: usize, header: &'h str) -> Result<Vec<&'h str>, FileError> {
    if header.contains('\r') {
        return Err(lines.error(number, "its lines end with CR alone; they must end with LF or CR LF"));
    }
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    if names.iter().all(|name| name.is_empty() || name.parse::<f64>().is_ok()) {
        return Err(lines.error(number, "has no header; its first line must name the columns"));
    }
    match names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
        Some((_, name)) => Err(lines.error(number, "is there twice; each column has its own name").at(*name)),
        None => Ok(names),
    }
}

/// Checks that a line has as many cells as the header.
pub(super) fn count_cells(cells: &[&str], named: usize) -> Result<(), Fault> {
    if cells.len() == named {
        return Ok(());
    }
    Err(("columns".to_owned(), format!("there are {}; the header names {named}", cells.len())))
}

/// What is there in place of a column that is missing.
pub(super) fn spelling(names: &[&str], wanted: &str) -> Option<String> {
    if let [one] = names
        && let Some(separator) = [';', '\t', ' '].into_iter().find(|separator| one.contains(*separator))
    {
        return Some(format!("its columns are separated by {separator:?}; they must be by commas"));
    }
    let other = names.iter().find(|name| name.trim_matches(['"', '\'']).eq_ignore_ascii_case(wanted))?;
    Some(format!("it has {other}, which must be written {wanted}"))
}

fn is_range_column(name: &str) -> bool {
    let index =
        name.strip_prefix("adc_").or_else(|| name.strip_prefix("range_").and_then(|rest| rest.strip_suffix("_m")));
    index.is_some_and(|index| index.parse::<usize>().is_ok())
}

fn is_missing(cell: &str) -> bool {
    cell.is_empty() || cell.eq_ignore_ascii_case("nan")
}

fn bad(cells: &[&str], column: &Column, allowed: &str) -> Fault {
    (column.name.clone(), format!("is {:?}; it must be {allowed}", cells[column.index]))
}

fn number(cells: &[&str], column: &Column) -> Result<f64, Fault> {
    match cells[column.index].parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(bad(cells, column, "a finite number")),
    }
}

fn pose_of(cells: &[&str], columns: &[Column; 3]) -> Result<Pose2, Fault> {
    Ok(Pose2::new(number(cells, &columns[0])?, number(cells, &columns[1])?, number(cells, &columns[2])?))
}

/// A cumulative count; counters wider than the estimator's wrap like narrower ones.
fn count(cells: &[&str], column: &Column) -> Result<i32, Fault> {
    let count = cells[column.index].parse::<i64>().map_err(|_| bad(cells, column, "a whole number of ticks"))?;
    Ok(count as i32)
}

fn switch(cells: &[&str], column: &Column, allowed: &str) -> Result<bool, Fault> {
    match cells[column.index] {
        "0" => Ok(false),
        "1" => Ok(true),
        cell if is_missing(cell) => Ok(false),
        _ => Err(bad(cells, column, allowed)),
    }
}

fn reading(cells: &[&str], column: &Column, is_counts: bool) -> Result<RangeInput, Fault> {
    let cell = cells[column.index];
    if is_missing(cell) {
        return Ok(RangeInput::Missing);
    }
    if is_counts {
        let counts = cell.parse::<u16>();
        return counts.map(RangeInput::Counts).map_err(|_| {
            bad(cells, column, "a whole number of converter counts from 0 to 65535, or empty where there is no reading")
        });
    }
    let metres = cell.parse::<f32>();
    metres
        .map(RangeInput::Metres)
        .map_err(|_| bad(cells, column, "a number of metres, or empty where there is no reading"))
}
