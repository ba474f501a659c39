//! CARMEN logs: `FLASER` messages, whose beams the rig's range sensors pick by bearing.
//!
//! `FLASER n r_0 .. r_{n-1} x y theta odom_x odom_y odom_theta ipc_timestamp host logger_timestamp`, metres, radians and
//! seconds. Beam i points at -90 + i 180/n degrees. `ODOM` messages repeat what the scans' own odometry says; they and
//! all other messages are passed over.

use slam_core::{DriveModel, Motion, RangeInput, RangeModel, Sample};

use super::lines::Lines;
use super::odometry::Differencer;
use super::{Clock, Fault, Row, Rows, SECONDS, seconds};
use crate::input::rig_file::{MAX_SENSORS, Robot};
use crate::recording::{Pose2, wrap};
use input_file::FileError;

/// Fields after the ranges.
const TAIL: usize = 9;

/// Whether a line is a message, not a CSV header.
pub fn is_message(line: &str) -> bool {
    let word = line.split_whitespace().next().unwrap_or("");
    line.split_whitespace().count() > 1
        && word.starts_with(|c: char| c.is_ascii_uppercase())
        && word.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
}

/// Reads the scans of a CARMEN log.
pub struct Reader {
    lines: Lines,
    /// Bearings of the rig's sensors, degrees, and their names.
    bearings: Vec<(f64, String)>,
    first: Option<(usize, String)>,
    clock: Clock,
    differencer: Differencer,
    out_of_order: usize,
    failed: bool,
    scan_m: Vec<f32>,
}

impl Reader {
    /// Finds the first scan and moves the robot's sensors to the beams nearest to their bearings.
    pub fn new(mut lines: Lines, robot: &mut Robot) -> Result<Self, FileError> {
        let fit = |what: String| FileError::new(lines.file(), what);
        if !matches!(robot.rig.drive, DriveModel::Odometry { .. }) {
            return Err(fit("is a CARMEN log, which has no encoder ticks; the rig file must have [odometry]".into()));
        }
        for (sensor, name) in robot.rig.sensors.iter().zip(&robot.names) {
            if !matches!(sensor.model, RangeModel::Metric { .. }) {
                let what = "is a CARMEN log, which has metres; the rig file's range sensor";
                return Err(fit(format!("{what} {name} must have noise_m and noise_rel")));
            }
        }
        let degrees = |rad: f32| wrap(f64::from(rad)).to_degrees();
        let bearings = robot.rig.sensors.iter().map(|sensor| degrees(sensor.mount.bearing_rad));
        let bearings: Vec<(f64, String)> = bearings.zip(robot.names.iter().cloned()).collect();
        let first = next_scan(&mut lines)?;
        let Some((number, line)) = &first else {
            return Err(FileError::new(lines.file(), "has no FLASER message; there is nothing to replay"));
        };
        let scan = Scan::parse(line).map_err(|(place, what)| lines.error(*number, what).at(place))?;
        for (sensor, (bearing_deg, name)) in robot.rig.sensors.iter_mut().zip(&bearings) {
            let beam = scan.beam(*bearing_deg, name).map_err(|(place, what)| lines.error(*number, what).at(place))?;
            // As a rig file would give it, so that the same bearing means the same bits.
            sensor.mount.bearing_rad = (scan.bearing_deg(beam) as f32).to_radians();
        }
        let (clock, differencer) = (Clock::default(), Differencer::default());
        Ok(Self { lines, bearings, first, clock, differencer, out_of_order: 0, failed: false, scan_m: Vec::new() })
    }

    /// The row of a scan; none where its time does not increase.
    fn row(&mut self, line: &str) -> Result<Option<Row>, Fault> {
        let scan = Scan::parse(line)?;
        let Some(time_us) = self.clock.tick(scan.t_s) else { return Ok(None) };
        let mut ranges = [RangeInput::Missing; MAX_SENSORS];
        for (range, (bearing_deg, name)) in ranges.iter_mut().zip(&self.bearings) {
            *range = scan.range(scan.beam(*bearing_deg, name)?);
        }
        let motion = Motion::Increment(self.differencer.step(scan.odometry));
        let sample = Sample { time_us, motion, ranges };
        let (t_text, t_s) = (scan.t_text.to_owned(), scan.t_s);
        self.scan_m = scan.ranges_m;
        Ok(Some(Row { t_text, t_s, sample, odometry: None, truth: None, lifted: false, docked: false }))
    }
}

fn next_scan(lines: &mut Lines) -> Result<Option<(usize, String)>, FileError> {
    while let Some((number, line)) = lines.next_content()? {
        if line.split_whitespace().next() == Some("FLASER") {
            return Ok(Some((number, line)));
        }
    }
    Ok(None)
}

impl Iterator for Reader {
    type Item = Result<Row, FileError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.failed {
            let scan = match self.first.take() {
                Some(first) => Ok(Some(first)),
                None => next_scan(&mut self.lines),
            };
            let row = match scan {
                Ok(None) => return None,
                Ok(Some((number, line))) => {
                    self.row(&line).map_err(|(place, what)| self.lines.error(number, what).at(place))
                }
                Err(error) => Err(error),
            };
            match row {
                Ok(Some(row)) => return Some(Ok(row)),
                Ok(None) => self.out_of_order += 1,
                Err(error) => {
                    self.failed = true;
                    return Some(Err(error));
                }
            }
        }
        None
    }
}

impl Rows for Reader {
    fn has_scans(&self) -> bool {
        true
    }

    fn whole_scan(&self) -> Option<super::Scan<'_>> {
        let first_rad = -std::f64::consts::FRAC_PI_2;
        let step_rad = std::f64::consts::PI / self.scan_m.len() as f64;
        (!self.scan_m.is_empty()).then_some(super::Scan { ranges_m: &self.scan_m, first_rad, step_rad })
    }

    fn notes(&self) -> Vec<String> {
        match self.out_of_order {
            0 => Vec::new(),
            n => vec![format!("passed over {n} scans whose logger timestamp did not increase")],
        }
    }
}

/// One FLASER message.
struct Scan<'a> {
    ranges_m: Vec<f32>,
    odometry: Pose2,
    t_text: &'a str,
    t_s: f64,
}

impl<'a> Scan<'a> {
    /// Parses a FLASER line; an error is a field and what is wrong with it.
    fn parse(line: &'a str) -> Result<Self, Fault> {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let n = fields.get(1).and_then(|field| field.parse::<usize>().ok()).filter(|n| *n > 0);
        let n = n.ok_or_else(|| {
            ("number of beams".to_owned(), format!("is {:?}; it must be 1 or more", fields.get(1).unwrap_or(&"")))
        })?;
        let expected = n.saturating_add(2 + TAIL);
        if fields.len() != expected {
            let what = format!("there are {}; a FLASER of {n} beams has {expected}", fields.len());
            return Err(("fields".to_owned(), what));
        }
        let tail = &fields[2 + n..];
        let odometry = Pose2::new(
            finite(tail[3], "odometry x")?,
            finite(tail[4], "odometry y")?,
            finite(tail[5], "odometry theta")?,
        );
        let t_text = tail[8];
        let ranges_m = fields[2..2 + n].iter().enumerate().map(|(beam, text)| {
            let what = || (format!("range {beam}"), format!("is {text:?}; it must be a number of metres"));
            text.parse::<f32>().map_err(|_| what())
        });
        let ranges_m = ranges_m.collect::<Result<Vec<f32>, _>>()?;
        let wrong = || ("logger timestamp".to_owned(), format!("is {t_text:?}; it must be {SECONDS}"));
        Ok(Self { ranges_m, odometry, t_text, t_s: seconds(t_text).ok_or_else(wrong)? })
    }

    fn spacing_deg(&self) -> f64 {
        180.0 / self.ranges_m.len() as f64
    }

    fn bearing_deg(&self, beam: usize) -> f64 {
        -90.0 + beam as f64 * self.spacing_deg()
    }

    /// The beam nearest to a bearing.
    fn beam(&self, bearing_deg: f64, name: &str) -> Result<usize, Fault> {
        let beam = ((bearing_deg + 90.0) / self.spacing_deg()).round();
        // The last beam stops one spacing short of +90 degrees: +90 itself is still that beam's.
        if !(-0.0..=self.ranges_m.len() as f64).contains(&beam) {
            let what = format!("points at {bearing_deg:.1} degrees; the laser's beams span -90 to 90");
            return Err((format!("range sensor {name}"), what));
        }
        Ok((beam as usize).min(self.ranges_m.len() - 1))
    }

    fn range(&self, beam: usize) -> RangeInput {
        let range_m = self.ranges_m[beam];
        if range_m.is_nan() { RangeInput::Missing } else { RangeInput::Metres(range_m) }
    }
}

fn finite(text: &str, place: &str) -> Result<f64, Fault> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err((place.to_owned(), format!("is {text:?}; it must be a finite number"))),
    }
}
