//! A run as an MCAP file that Foxglove opens: pose, truth, dead reckoning and path, walls and plan, hits, and figures to plot.
//!
//! Messages are JSON with Foxglove's well-known schemas; all is in the frame `map`, metres and radians, times are those of the
//! log since its first row.

#![forbid(unsafe_code)]

mod messages;
mod schemas;

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, ErrorKind, Read as _, Seek, Write};
use std::path::Path;

use input_file::FileError;
use lab::evaluate::score::path::nees;
use lab::recording::{Pose2, Recording, Segment, Step};
use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};
use serde_json::Value;
use slam_core::{Outcome, WallView};

pub use messages::Figures;
pub use schemas::{SCHEMAS, Topic};

/// How often the path is written, map snapshots.
const PATH_EVERY: usize = 10;
/// Most poses of a path.
const PATH_POSES: usize = 1000;

/// An MCAP file that messages are added to.
pub struct Output<W: Write + Seek> {
    writer: Writer<W>,
    channels: BTreeMap<Topic, u16>,
    sequence: u32,
}

impl<W: Write + Seek> Output<W> {
    /// Begins the file.
    ///
    /// # Errors
    /// What the system says.
    pub fn new(to: W) -> Result<Self, McapError> {
        let mut writer = Writer::with_options(to, WriteOptions::new().compression(None).library(LIBRARY))?;
        let mut channels = BTreeMap::new();
        for topic in Topic::ALL {
            let (name, schema) = topic.schema();
            let id = writer.add_schema(name, "jsonschema", schema.as_bytes())?;
            channels.insert(topic, writer.add_channel(id, topic.name(), "json", &BTreeMap::new())?);
        }
        Ok(Self { writer, channels, sequence: 0 })
    }

    /// Adds a message.
    fn push(&mut self, topic: Topic, t_s: f64, message: &Value) -> Result<(), McapError> {
        let log_time = nanoseconds(t_s);
        let header = MessageHeader {
            channel_id: self.channels[&topic],
            sequence: self.sequence,
            log_time,
            publish_time: log_time,
        };
        self.sequence = self.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, message.to_string().as_bytes())
    }

    /// Adds a pose; one that is no number is left out.
    ///
    /// # Errors
    /// What the system says.
    pub fn pose(&mut self, topic: Topic, t_s: f64, pose: &Pose2) -> Result<(), McapError> {
        messages::pose_in_frame(t_s, pose).map_or(Ok(()), |message| self.push(topic, t_s, &message))
    }

    /// Adds a path, thinned out where it is long.
    ///
    /// # Errors
    /// What the system says.
    pub fn path(&mut self, t_s: f64, poses: &[Pose2]) -> Result<(), McapError> {
        let stride = poses.len().div_ceil(PATH_POSES).max(1);
        let poses = poses.iter().step_by(stride);
        self.push(Topic::Path, t_s, &messages::poses_in_frame(t_s, poses))
    }

    /// Adds the map's walls.
    ///
    /// # Errors
    /// What the system says.
    pub fn walls(&mut self, t_s: f64, walls: &[WallView]) -> Result<(), McapError> {
        self.push(Topic::Walls, t_s, &messages::walls(t_s, walls))
    }

    /// Adds the true plan.
    ///
    /// # Errors
    /// What the system says.
    pub fn plan(&mut self, t_s: f64, plan: &[Segment]) -> Result<(), McapError> {
        self.push(Topic::Plan, t_s, &messages::plan(t_s, plan))
    }

    /// Adds where beams ended.
    ///
    /// # Errors
    /// What the system says.
    pub fn hits(&mut self, t_s: f64, hits: &[[f32; 2]]) -> Result<(), McapError> {
        self.push(Topic::Hits, t_s, &messages::point_cloud(t_s, hits))
    }

    /// Adds numbers to plot.
    ///
    /// # Errors
    /// What the system says.
    pub fn figures(&mut self, t_s: f64, figures: &Figures) -> Result<(), McapError> {
        self.push(Topic::Figures, t_s, &figures.message(t_s))
    }

    /// Ends the file; without it readers find no index.
    ///
    /// # Errors
    /// What the system says.
    pub fn finish(mut self) -> Result<(), McapError> {
        self.writer.finish().map(drop)
    }
}

impl Output<BufWriter<File>> {
    /// Begins a file of this name.
    ///
    /// # Errors
    /// What the system says, or that the file is somebody else's.
    pub fn create(file: &Path) -> Result<Self, FileError> {
        check(file)?;
        let to = File::create(file).map_err(|cause| FileError::system(file, "write", &cause))?;
        Self::new(BufWriter::new(to)).map_err(|error| failed(file, &error))
    }
}

/// Every MCAP file begins so.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// What wrote the file, as its header has it.
const LIBRARY: &str = "wall-slam";
/// The header's first bytes, which have both.
const HEADER_BYTES: u64 = 64;

/// Checks that a file can be written without loss: it is not there, or empty, or an MCAP file of this program. Its folder is made
/// where it is not there.
///
/// # Errors
/// It is another file or cannot be read, or its folder cannot be made.
pub fn check(file: &Path) -> Result<(), FileError> {
    if let Some(folder) = file.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        fs::create_dir_all(folder).map_err(|cause| FileError::system(folder, "create", &cause))?;
    }
    let mut header = Vec::new();
    match File::open(file).and_then(|open| open.take(HEADER_BYTES).read_to_end(&mut header)) {
        Err(cause) if cause.kind() == ErrorKind::NotFound => return Ok(()),
        Err(cause) => return Err(FileError::system(file, "read", &cause)),
        Ok(_) => {}
    }
    let is_own = header.starts_with(MAGIC) && header.windows(LIBRARY.len()).any(|bytes| bytes == LIBRARY.as_bytes());
    if header.is_empty() || is_own {
        return Ok(());
    }
    Err(FileError::new(file, "is no MCAP file that lab wrote, and would be overwritten; name another file with --mcap"))
}

/// An error of the file.
pub fn failed(file: &Path, error: &McapError) -> FileError {
    FileError::new(file, format!("cannot write: {error}"))
}

/// Writes a whole run.
///
/// # Errors
/// What the system says.
pub fn write_file(file: &Path, recording: &Recording) -> Result<(), FileError> {
    let mut output = Output::create(file)?;
    write(&mut output, recording).and_then(|()| output.finish()).map_err(|error| failed(file, &error))
}

/// Adds a whole run.
///
/// # Errors
/// What the system says.
pub fn write<W: Write + Seek>(output: &mut Output<W>, recording: &Recording) -> Result<(), McapError> {
    if !recording.true_walls.is_empty() {
        output.plan(0.0, &recording.true_walls_in_map())?;
    }
    let (mut maps, mut written) = (recording.maps.iter().enumerate().peekable(), Vec::new());
    let mut hits: Vec<[f32; 2]> = Vec::new();
    for (i, step) in recording.steps.iter().enumerate() {
        written.push(step.pose);
        add_step(output, step)?;
        let used = recording.readings(i).iter().filter(|reading| !matches!(reading.outcome, Outcome::Refused(_)));
        hits.extend(used.filter_map(|reading| reading.hit_m));
        while let Some((n, map)) = maps.next_if(|(_, map)| map.step <= i) {
            output.walls(step.t_s, &map.walls)?;
            output.hits(step.t_s, &hits)?;
            hits.clear();
            if n % PATH_EVERY == 0 || i + 1 == recording.steps.len() {
                output.path(step.t_s, &written)?;
            }
        }
    }
    Ok(())
}

fn add_step<W: Write + Seek>(output: &mut Output<W>, step: &Step) -> Result<(), McapError> {
    output.pose(Topic::Pose, step.t_s, &step.pose)?;
    output.pose(Topic::DeadReckoning, step.t_s, &step.start.compose(&step.dead_reckoning))?;
    if let Some(truth) = &step.truth {
        output.pose(Topic::Truth, step.t_s, &step.start.compose(truth))?;
    }
    let sigma = |axis: usize| f64::from(step.covariance[axis][axis]).sqrt();
    let figures = Figures {
        position_error_m: step.error().map(|error| error.x_m.hypot(error.y_m)),
        heading_error_rad: step.error().map(|error| error.theta_rad),
        sigma_x_m: sigma(0),
        sigma_y_m: sigma(1),
        sigma_theta_rad: sigma(2),
        nees: nees(step),
        walls: step.walls,
        health: lab::recording::health::name(step.health),
    };
    output.figures(step.t_s, &figures)
}

/// A time of the log as nanoseconds; one that is none is the first.
fn nanoseconds(t_s: f64) -> u64 {
    (t_s * 1e9).round() as u64
}
