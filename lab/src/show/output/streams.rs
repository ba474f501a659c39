//! Outputs that grow with every row: `estimate.csv` and `trajectory.tum`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use super::folder::Folder;
use crate::numbers::shortest;
use crate::recording::Step;
use input_file::FileError;

/// The header line of `estimate.csv`.
pub const ESTIMATE_HEADER: &str =
    "t_s,x_m,y_m,theta_rad,var_x,cov_xy,cov_xtheta,var_y,cov_ytheta,var_theta,alpha_rad,walls,located";

/// A text file that lines are added to.
pub struct LineFile {
    path: PathBuf,
    output: BufWriter<File>,
}

impl LineFile {
    /// Makes the file.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(path: PathBuf) -> Result<Self, FileError> {
        match File::create(&path) {
            Ok(file) => Ok(Self { path, output: BufWriter::new(file) }),
            Err(cause) => Err(FileError::system(&path, "write", &cause)),
        }
    }

    /// Adds a line.
    ///
    /// # Errors
    /// What the system says.
    pub fn line(&mut self, line: &str) -> Result<(), FileError> {
        writeln!(self.output, "{line}").map_err(|cause| FileError::system(&self.path, "write", &cause))
    }

    /// Hands everything so far to the system.
    ///
    /// # Errors
    /// What the system says.
    pub fn flush(&mut self) -> Result<(), FileError> {
        self.output.flush().map_err(|cause| FileError::system(&self.path, "write", &cause))
    }

    /// Hands everything to the system.
    ///
    /// # Errors
    /// What the system says.
    pub fn close(mut self) -> Result<(), FileError> {
        self.flush()
    }
}

/// Both files.
pub struct Streams {
    estimate: LineFile,
    trajectory: LineFile,
}

impl Streams {
    /// Makes both files.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(folder: &Folder) -> Result<Self, FileError> {
        let mut estimate = LineFile::create(folder.file("estimate.csv"))?;
        estimate.line(ESTIMATE_HEADER)?;
        Ok(Self { estimate, trajectory: LineFile::create(folder.file("trajectory.tum"))? })
    }

    /// Adds a row to both.
    ///
    /// # Errors
    /// What the system says.
    pub fn push(&mut self, step: &Step) -> Result<(), FileError> {
        self.estimate.line(&estimate_line(step))?;
        self.trajectory.line(&trajectory_line(step))
    }

    /// Hands everything to the system.
    ///
    /// # Errors
    /// What the system says.
    pub fn close(self) -> Result<(), FileError> {
        self.estimate.close()?;
        self.trajectory.close()
    }
}

/// A line of `estimate.csv`.
pub fn estimate_line(step: &Step) -> String {
    let pose = [step.pose.x_m, step.pose.y_m, step.pose.theta_rad].map(|number| number as f32);
    let [[xx, xy, xt], [_, yy, yt], [_, _, tt]] = step.covariance;
    let alpha = step.alpha.map_or(f32::NAN, |(alpha_rad, _)| alpha_rad);
    let numbers = [pose[0], pose[1], pose[2], xx, xy, xt, yy, yt, tt, alpha].map(shortest).join(",");
    format!("{},{numbers},{},{}", step.t_text, step.walls, u8::from(!step.searching))
}

/// The estimated pose as a line of a `.tum` file.
pub fn trajectory_line(step: &Step) -> String {
    // The estimator's poses are f32: their shortest form is that of an f32.
    let position = [step.pose.x_m, step.pose.y_m].map(|number| shortest(number as f32));
    tum_line(&step.t_text, position, step.pose.theta_rad)
}

/// A line of a `.tum` file, `t x y z qx qy qz qw`, from the position as text and the heading in radians.
pub fn tum_line(t_text: &str, [x, y]: [String; 2], theta_rad: f64) -> String {
    let (qz, qw) = (0.5 * theta_rad).sin_cos();
    format!("{t_text} {x} {y} 0 0 0 {} {}", shortest(qz), shortest(qw))
}
