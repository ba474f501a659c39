//! What a robot says, as an MCAP file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use foxglove_file::{Figures, Output, Topic, failed};
use lab::recording::Pose2;
use slam_core::WallView;
use wire::{Estimate, Frame, Wall};

/// An MCAP file that frames are added to.
pub struct Film {
    file: PathBuf,
    output: Output<BufWriter<File>>,
    first_us: Option<u64>,
    t_s: f64,
    path: Vec<Pose2>,
    walls: BTreeMap<u8, Wall>,
}

impl Film {
    /// Begins the file.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(file: &Path) -> Result<Self, String> {
        let output = Output::create(file).map_err(|error| error.to_string())?;
        let (first_us, t_s, path, walls) = (None, 0.0, Vec::new(), BTreeMap::new());
        Ok(Self { file: file.to_owned(), output, first_us, t_s, path, walls })
    }

    /// Adds what a frame says, where Foxglove can show it.
    ///
    /// # Errors
    /// What the system says.
    pub fn take(&mut self, frame: &Frame) -> Result<(), String> {
        let added = match frame {
            Frame::Estimate(estimate) => self.estimate(estimate),
            Frame::Wall(wall) => self.wall(wall),
            _ => Ok(()),
        };
        added.map_err(|error| failed(&self.file, &error).to_string())
    }

    fn estimate(&mut self, estimate: &Estimate) -> Result<(), mcap::McapError> {
        let first_us = *self.first_us.get_or_insert(estimate.time_us);
        self.t_s = estimate.time_us.saturating_sub(first_us) as f64 * 1e-6;
        self.walls.retain(|index, _| *index < estimate.walls);
        let pose = |[x, y, theta]: [f32; 3]| Pose2::new(x.into(), y.into(), theta.into());
        let now = pose(estimate.pose);
        self.path.push(now);
        self.output.pose(Topic::Pose, self.t_s, &now)?;
        self.output.pose(Topic::DeadReckoning, self.t_s, &pose(estimate.dead_reckoning))?;
        let [xx, _, _, yy, _, tt] = estimate.covariance.map(|variance| f64::from(variance).sqrt());
        let figures = Figures {
            sigma_x_m: xx,
            sigma_y_m: yy,
            sigma_theta_rad: tt,
            walls: estimate.walls.into(),
            health: lab::recording::health::name(estimate.health.into()),
            ..Figures::default()
        };
        self.output.figures(self.t_s, &figures)
    }

    fn wall(&mut self, wall: &Wall) -> Result<(), mcap::McapError> {
        self.walls.insert(wall.index, *wall);
        if wall.index + 1 < wall.of {
            return Ok(());
        }
        let views: Vec<WallView> = self.walls.values().map(WallView::from).collect();
        self.output.walls(self.t_s, &views)?;
        self.output.path(self.t_s, &self.path)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// What the system says.
    pub fn finish(self) -> Result<(), String> {
        self.output.finish().map_err(|error| failed(&self.file, &error).to_string())
    }
}
