//! Estimator settings on the command line.

use clap::{Args, ValueEnum};
use serde::Deserialize;
use slam_core::{Clustering, Config, Linearisation, RangeModel, RangeSensor, WallPolicy};

use crate::input::part::{self, Part};
use crate::input::rig_file::Robot;

/// Settings of the estimator, for comparison; the defaults are the ones to use.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Estimator (the defaults are the ones to use)")]
pub struct VariantArgs {
    #[arg(
        long,
        value_enum,
        help = "Which walls the map may have [default: near-grid where a sensor reports metres, else grid]"
    )]
    walls: Option<Walls>,
    /// How unexplained readings are grouped into new walls.
    #[arg(long, value_enum, default_value_t = Groups::Sensor)]
    clusters: Groups,
    /// At which estimates the models are differentiated.
    #[arg(long, value_enum, default_value_t = Jacobians::First)]
    jacobians: Jacobians,
    /// Whether the estimator takes over what is found by looking back while the robot drives, as on a robot [default: as the rig
    /// file says, else true with analogue sensors and in floor jobs].
    #[arg(long, value_name = "BOOL")]
    hand_overs: Option<bool>,
    /// Take the rig file's gains, scales and track for exact.
    #[arg(long)]
    no_calibration: bool,
    /// Switch off a part of the estimator; may be given more than once.
    #[arg(long, value_name = "PART", value_parser = part_of, long_help = part_help())]
    without: Vec<&'static Part>,
}

fn part_of(name: &str) -> Result<&'static Part, String> {
    Part::of_name(name).ok_or_else(|| format!("it must be one of {}", part::names()))
}

fn part_help() -> String {
    let parts = part::PARTS.iter().map(|part| format!("\n- {}: {}", part.name, part.without));
    format!("Switch off a part of the estimator; may be given more than once:{}", parts.collect::<String>())
}

/// Which walls the map may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Walls {
    /// Grid walls, and free ones where the data are off the grid.
    Grid,
    /// The same, a grid wall up to half a degree or so off the grid.
    NearGrid,
    /// Lines with their own direction.
    Free,
    /// Lines whose direction is snapped to the grid.
    Snapped,
    /// The same, each line's direction moving with the grid's.
    SnappedMoving,
}

/// How unexplained readings are grouped into new walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Groups {
    /// By the sensor that made them.
    Sensor,
    /// By density over all sensors (DBSCAN).
    Dbscan,
}

/// At which estimates the models are differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Jacobians {
    /// The poses as they were predicted, the grid as it was founded.
    First,
    /// The latest ones: a plain extended Kalman filter.
    Latest,
}

impl Walls {
    /// As the estimator calls it.
    pub fn policy(self) -> WallPolicy {
        match self {
            Self::Grid => WallPolicy::Grid,
            Self::NearGrid => WallPolicy::NearGrid,
            Self::Free => WallPolicy::Free,
            Self::Snapped => WallPolicy::Snapped { theta_moves: false },
            Self::SnappedMoving => WallPolicy::Snapped { theta_moves: true },
        }
    }
}

impl Groups {
    /// As the estimator calls it.
    pub fn clustering(self) -> Clustering {
        match self {
            Self::Sensor => Clustering::BySensor,
            Self::Dbscan => Clustering::Dbscan,
        }
    }
}

impl Jacobians {
    /// As the estimator calls it.
    pub fn linearisation(self) -> Linearisation {
        match self {
            Self::First => Linearisation::FirstEstimates,
            Self::Latest => Linearisation::Latest,
        }
    }
}

/// The estimator's settings.
#[derive(Clone, Debug)]
pub enum Settings {
    /// These.
    Exactly(Config),
    /// What suits the rig, changed by what the command line says.
    ForRig(VariantArgs),
}

impl Settings {
    /// The settings for a rig.
    pub fn config(&self, robot: &Robot) -> Config {
        match self {
            Self::Exactly(config) => *config,
            Self::ForRig(variant) => variant.config(robot),
        }
    }

    /// Whether hand-overs are left to the rig file and the job.
    pub fn leaves_hand_overs(&self) -> bool {
        matches!(self, Self::ForRig(VariantArgs { hand_overs: None, .. }))
    }
}

/// What the workbench does with a robot unless it is told otherwise. With analogue sensors what look backs find is taken over, as on the
/// robot; with sensors that report metres it is asked for, in the rig file or for a floor job, for on logs of real rooms some live paths are
/// worse with it (docs/results/hand-overs.md), and there is the look back over the whole log.
pub fn by_default(robot: &Robot) -> Config {
    let config = Config::for_rig(&robot.rig);
    let reports_metres = |sensor: &RangeSensor| matches!(sensor.model, RangeModel::Metric { .. });
    let is_wanted = robot.hand_overs.unwrap_or_else(|| !robot.rig.sensors.iter().any(reports_metres));
    if is_wanted { config.with_hand_overs() } else { config }
}

/// The same for a floor job. What look backs find is taken over, as on the robot, unless the rig file says otherwise: a job takes a quarter of
/// an hour, and comes home by the map (docs/results/robots.md).
pub fn on_a_floor(robot: &Robot) -> Config {
    Config { hand_overs: robot.hand_overs.unwrap_or(true), ..by_default(robot) }
}

/// A robot for a floor job, and its rig file's text, which says what it takes over to who replays the drive.
pub fn for_a_floor((robot, rig_toml): (Robot, String)) -> (Robot, String) {
    let hand_overs = on_a_floor(&robot).hand_overs;
    handing_over((robot, rig_toml), hand_overs)
}

/// A robot that takes over what look backs find, or does not, and its rig file's text, which says so where that is not its default.
pub fn handing_over((robot, rig_toml): (Robot, String), hand_overs: bool) -> (Robot, String) {
    if hand_overs == by_default(&robot).hand_overs {
        return (robot, rig_toml);
    }
    let says_so = |line: &&str| line.trim_start_matches([' ', '\t', '"', '\'']).starts_with("hand_overs");
    let rest: String = rig_toml.split_inclusive('\n').filter(|line| !says_so(line)).collect();
    let text = format!("hand_overs = {hand_overs}\n\n{}", rest.trim_start_matches(['\u{feff}', '\n', '\r']));
    (Robot { hand_overs: Some(hand_overs), ..robot }, text)
}

impl VariantArgs {
    /// The settings for a rig.
    fn config(&self, robot: &Robot) -> Config {
        let base = by_default(robot);
        let calibrate = !self.no_calibration;
        let mut config = base;
        config.walls.policy = self.walls.map_or(base.walls.policy, Walls::policy);
        config.births.clustering = self.clusters.clustering();
        config.measurement.linearisation = self.jacobians.linearisation();
        config.hand_overs = self.hand_overs.unwrap_or(base.hand_overs);
        config.sensing.calibrate_gains = calibrate;
        config.motion.calibrate_scales = calibrate;
        config.motion.calibrate_track = calibrate;
        config.sensing.calibrate_latency = calibrate && base.sensing.calibrate_latency;
        config.sensing.calibrate_age = calibrate && base.sensing.calibrate_age;
        self.without.iter().fold(config, |config, part| part.off(config))
    }
}
