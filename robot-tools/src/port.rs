//! A robot at a serial port: frames from it, commands to it.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use slam_core::{RangeInput, RangeModel};
use wire::{DecodeError, Decoder, Frame, Sample, encode};

use lab::input::log::Row;
use lab::input::rig_file::{MAX_SENSORS, Robot};
use lab::numbers::shortest;
use lab::recording::Pose2;

/// Rate of the firmware's serial line, baud.
const BAUD: u32 = 115_200;

/// How often a silent line is looked at.
const LOOK: Duration = Duration::from_millis(500);

/// A robot sends 25 samples a second: after so long without a whole frame something is wrong.
const PATIENCE: Duration = Duration::from_secs(5);

/// Both directions of a line.
pub type Line = (Box<dyn Read + Send>, Box<dyn Write + Send>);

/// Opens a serial port; a file or pipe of recorded bytes is read as if it were one.
///
/// # Errors
/// What the system says.
pub fn open(device: &str) -> Result<Line, String> {
    let path = Path::new(device);
    if path.is_file() {
        let failed = |error: std::io::Error| format!("{device}: {error}");
        let sink = OpenOptions::new().write(true).open("/dev/null").map_err(failed)?;
        return Ok((Box::new(File::open(path).map_err(failed)?), Box::new(sink)));
    }
    let failed = |error: serialport::Error| format!("{device}: {error}; name the serial port that the robot is at");
    let port = serialport::new(device, BAUD).timeout(LOOK).open().map_err(failed)?;
    let reader = port.try_clone().map_err(failed)?;
    Ok((Box::new(reader), Box::new(port)))
}

/// A robot's sample as a row of its log.
///
/// # Errors
/// It has readings of another kind than the robot's rig says, or of more sensors.
pub fn row(sample: &Sample, robot: &Robot, truth: Option<Pose2>) -> Result<Row, String> {
    let t_s = sample.time_us as f64 * 1e-6;
    let few = sample.to_slam();
    let mut ranges = [RangeInput::Missing; MAX_SENSORS];
    for (i, (wide, range)) in ranges.iter_mut().zip(few.ranges).enumerate() {
        let sends = match (range, robot.rig.sensors.get(i).map(|sensor| sensor.model)) {
            (RangeInput::Missing, _) => None,
            (RangeInput::Counts(_), Some(RangeModel::Sharp { .. })) => None,
            (RangeInput::Metres(_), Some(RangeModel::Metric { .. })) => None,
            (RangeInput::Counts(_), _) => Some("converter counts"),
            (RangeInput::Metres(_), _) => Some("metres"),
        };
        if let Some(kind) = sends {
            return Err(format!(
                "the robot sends {kind} of range sensor {i}, which its rig has not: name the robot's rig with --rig"
            ));
        }
        *wide = range;
    }
    let wire::Contacts { lifted, docked, .. } = sample.contacts;
    let sample = slam_core::Sample { time_us: few.time_us, motion: few.motion, ranges };
    Ok(Row { t_text: shortest(t_s), t_s, sample, odometry: None, truth, lifted, docked })
}

/// What was heard of a robot.
#[derive(Clone, Debug)]
pub enum Heard {
    /// A frame.
    Frame(Frame),
    /// No whole frame for five seconds; [`Port::trouble`] says what it may be.
    Nothing,
    /// The line has ended.
    End,
}

/// A robot that is listened to.
pub struct Port {
    from: Box<dyn Read + Send>,
    to: Box<dyn Write + Send>,
    decoder: Decoder,
    bytes: Vec<u8>,
    damaged: u32,
    /// Bytes of damaged frames.
    damaged_bytes: u64,
    /// Bytes of the frame that is not whole yet.
    begun_bytes: u64,
    /// Bytes since the last whole frame.
    strange_bytes: u64,
}

impl Port {
    /// On an open line.
    pub fn new((from, to): Line) -> Self {
        Self {
            from,
            to,
            decoder: Decoder::new(),
            bytes: Vec::new(),
            damaged: 0,
            damaged_bytes: 0,
            begun_bytes: 0,
            strange_bytes: 0,
        }
    }

    /// Waits for the next frame, not forever.
    ///
    /// # Errors
    /// What the system says, or that the robot speaks another version.
    pub fn frame(&mut self) -> Result<Heard, String> {
        let begin = Instant::now();
        loop {
            while let Some(byte) = self.bytes.pop() {
                self.begun_bytes += 1;
                self.strange_bytes += 1;
                match self.decoder.push(byte) {
                    None => {}
                    Some(Ok(frame)) => {
                        (self.begun_bytes, self.strange_bytes) = (0, 0);
                        return Ok(Heard::Frame(frame));
                    }
                    Some(Err(DecodeError::Version(theirs))) => {
                        let ours = wire::VERSION;
                        return Err(format!("the robot speaks version {theirs} of the protocol, this program {ours}"));
                    }
                    Some(Err(_)) => {
                        self.damaged += 1;
                        self.damaged_bytes += std::mem::take(&mut self.begun_bytes);
                    }
                }
            }
            if begin.elapsed() > PATIENCE {
                return Ok(Heard::Nothing);
            }
            let mut buffer = [0; 1024];
            match self.from.read(&mut buffer) {
                Ok(0) => return Ok(Heard::End),
                Ok(count) => self.bytes.extend(buffer[..count].iter().rev()),
                Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
                Err(error) => return Err(format!("the serial line: {error}")),
            }
        }
    }

    /// Says something to the robot.
    ///
    /// # Errors
    /// What the system says.
    pub fn send(&mut self, frame: &Frame) -> Result<(), String> {
        let bytes = encode(frame).map_err(|error| format!("{error:?}"))?;
        self.to.write_all(&bytes).and_then(|()| self.to.flush()).map_err(|error| format!("the serial line: {error}"))
    }

    /// Frames that arrived damaged so far, and their bytes; the first may be half a one.
    pub fn damaged(&self) -> (u32, u64) {
        (self.damaged, self.damaged_bytes)
    }

    /// Why there may be no whole frame.
    pub fn trouble(&self) -> String {
        match self.strange_bytes {
            0 => "nothing arrives: is the robot switched on, and is it at this port?".to_owned(),
            bytes => format!(
                "{bytes} bytes arrive and no whole frame: the line must run at {BAUD} baud, and the robot must run the \
                 firmware of this version"
            ),
        }
    }
}
