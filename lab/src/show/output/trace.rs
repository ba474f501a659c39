//! `readings.csv`: what became of every reading, to see why one was taken, refused or given to the wrong wall.

use slam_core::{Outcome, ReadingReport};

use super::folder::Folder;
use super::streams::LineFile;
use super::summary::refusal_name;
use crate::numbers::shortest;
use crate::recording::{Recording, nis};
use input_file::FileError;

const HEADER: &str = "t_s,sensor,outcome,wall,range_m,hit_x_m,hit_y_m,innovation_m,variance_m2,nis";

/// Writes one line per reading; sensors without one have none.
///
/// # Errors
/// What the system says.
pub fn write(folder: &Folder, recording: &Recording) -> Result<(), FileError> {
    let mut file = LineFile::create(folder.file("readings.csv"))?;
    file.line(HEADER)?;
    for (i, step) in recording.steps.iter().enumerate() {
        for (sensor, reading) in recording.sensors.iter().zip(recording.readings(i)) {
            if reading.outcome != Outcome::Missing {
                file.line(&format!("{},{},{}", step.t_text, sensor.name, cells(reading)))?;
            }
        }
    }
    file.close()
}

fn cells(reading: &ReadingReport) -> String {
    let number = |number: Option<f32>| number.map_or(String::new(), shortest);
    let (outcome, wall, innovation_m, variance_m2) = match reading.outcome {
        Outcome::Missing => ("missing", None, None, None),
        Outcome::Refused(refusal) => (refusal_name(refusal), None, None, None),
        Outcome::Updated { wall, innovation_m, variance_m2, .. } => {
            ("updated", Some(wall), Some(innovation_m), Some(variance_m2))
        }
        Outcome::Gated { wall, innovation_m, variance_m2 } => {
            ("outside_gate", Some(wall), Some(innovation_m), Some(variance_m2))
        }
        Outcome::Unexplained => ("unexplained", None, None, None),
    };
    let hit = reading.hit_m;
    let numbers = [reading.range_m, hit.map(|hit| hit[0]), hit.map(|hit| hit[1]), innovation_m, variance_m2];
    let wall = wall.map_or(String::new(), |id| id.to_string());
    let nis = nis(&reading.outcome).map(|nis| nis as f32);
    format!("{outcome},{wall},{},{}", numbers.map(number).join(","), number(nis))
}
