//! `lab map`: the robot's kept map as a file, and back.

use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::{Args, Subcommand};
use kept_map::{Record, Refused};
use wire::Frame;

use super::errand::{AGAIN_MS, Done, Errand, MapErrand};
use crate::port::{self, Heard, Port};

/// Arguments of `lab map`.
#[derive(Clone, Debug, Args)]
pub struct MapArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Clone, Debug, Subcommand)]
enum What {
    /// Fetch the map that the robot keeps.
    Get {
        /// The serial port that the robot is at.
        #[arg(long, value_name = "DEV")]
        port: String,
        /// File to write.
        #[arg(long, value_name = "FILE", default_value = "map.bin")]
        out: PathBuf,
    },
    /// Give the robot a map, which it then looks for itself in. It must stand.
    Put {
        /// A map.bin of this robot, or of a run or replay with its rig.
        file: PathBuf,
        /// The serial port that the robot is at.
        #[arg(long, value_name = "DEV")]
        port: String,
    },
    /// Have the robot forget its map: where it stands is the new origin. It must stand.
    Forget {
        /// The serial port that the robot is at.
        #[arg(long, value_name = "DEV")]
        port: String,
    },
}

impl MapArgs {
    /// Does what is asked for.
    ///
    /// # Errors
    /// What is wrong with the file, the line or the robot, and what would be right.
    pub fn run(&self) -> Result<(), String> {
        match &self.what {
            What::Get { port, out } => {
                // A file that is no map is somebody's; that is said before the robot is asked.
                free_for_a_map(out)?;
                let Done::Got(bytes) = at(port, Errand::Get)? else { return Ok(()) };
                std::fs::write(out, &bytes).map_err(|error| format!("{}: {error}", out.display()))?;
                println!("{}: {} bytes", out.display(), bytes.len());
            }
            What::Put { file, port } => {
                let failed = |what: String| format!("{}: {what}", file.display());
                let bytes = std::fs::read(file).map_err(|error| failed(error.to_string()))?;
                // What is wrong with the file is said before anybody looks for a robot.
                MapErrand::new(Errand::Put(bytes.clone())).map_err(failed)?;
                if let Done::Kept(sequence) = at(port, Errand::Put(bytes))? {
                    println!("the robot keeps it as its map number {sequence}, and looks for itself in it");
                }
            }
            What::Forget { port } => {
                at(port, Errand::Forget)?;
                println!("the robot keeps no map; where it stands is its new origin");
            }
        }
        Ok(())
    }
}

/// Bytes of a file that tell whether it is a kept map.
const MAGIC_BYTES: u64 = 8;

/// That a file may be written: it is not there, empty, or a kept map.
fn free_for_a_map(file: &Path) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", file.display());
    let mut begin = Vec::new();
    match File::open(file) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(failed(error)),
        // Reading a folder fails, too.
        Ok(present) => present.take(MAGIC_BYTES).read_to_end(&mut begin).map_err(failed)?,
    };
    if begin.is_empty() || Record::parse(&begin).err() != Some(Refused::Foreign) {
        return Ok(());
    }
    Err(format!("{}: is no kept map and would be overwritten; name another file with --out", file.display()))
}

/// Runs an errand with the robot at a port.
fn at(device: &str, errand: Errand) -> Result<Done, String> {
    let mut port = Port::new(port::open(device)?);
    let mut errand = MapErrand::new(errand)?;
    loop {
        port.send(&Frame::MapRequest(errand.request()?))?;
        let asked = Instant::now();
        while asked.elapsed() < Duration::from_millis(AGAIN_MS.into()) {
            match port.frame()? {
                Heard::Frame(Frame::MapAnswer(answer)) => {
                    if let Some(done) = errand.take(&answer)? {
                        return Ok(done);
                    }
                    break;
                }
                Heard::Frame(_) => {}
                Heard::Nothing | Heard::End => return Err(port.trouble()),
            }
        }
    }
}
