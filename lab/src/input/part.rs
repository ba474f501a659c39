//! The estimator's parts that can be switched off, to see what each is worth.
//!
//! This is the one list of them: `--without` on the command line, `without` in experiment files, the ablations of real
//! logs and `without` in `summary.json` all follow it.

use slam_core::{Config, Linearisation, MapFrame, Slip, WallPolicy};

/// A part that can be switched off.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// What the command line, files and tables call it.
    pub name: &'static str,
    /// What the estimator does without it.
    pub without: &'static str,
    switch_off: fn(&mut Config),
}

/// Every part.
pub const PARTS: [Part; 18] = [
    Part::new("grid", "every wall has a direction of its own", |config| config.walls.policy = WallPolicy::Free),
    Part::new("gains", "the range sensors' gains are taken for exact", |config| config.sensing.calibrate_gains = false),
    Part::new("scales", "the drive's scales are taken for exact", |config| config.motion.calibrate_scales = false),
    Part::new("track", "the track is taken for exact", |config| config.motion.calibrate_track = false),
    Part::new("first-estimates", "models are differentiated at the latest estimates", |config| {
        config.measurement.linearisation = Linearisation::Latest;
    }),
    Part::new("deviation", "walls on the grid have exactly its direction", |config| {
        if config.walls.policy == WallPolicy::NearGrid {
            config.walls.policy = WallPolicy::Grid;
        }
    }),
    Part::new("repeats", "each reading of a wall is a new one, however near the last", |config| {
        config.sensing.repeats = false
    }),
    Part::new("bends", "a wall that turns the robot one way is believed as any other", |config| {
        config.sensing.bends = false
    }),
    Part::new("relief", "the surfaces of walls are planes", |config| config.walls.relief_m = 0.0),
    Part::new("frame", "the start pose holds the map frame", |config| config.walls.frame = MapFrame::Start),
    Part::new("clutter", "a reading inside a wall's gate is the wall's", |config| config.measurement.clutter = false),
    Part::new("latency", "readings that come in metres are of the moment", |config| {
        config.sensing.calibrate_latency = false
    }),
    Part::new("stamps", "all rows of readings in metres are equally late", |config| config.sensing.stamps = false),
    Part::new("age", "analogue readings are as old as their data sheet says", |config| {
        config.sensing.calibrate_age = false;
    }),
    Part::new("slip", "the rig states all the noise of motion", |config| config.motion.slip = Slip::Stated),
    Part::new("sign", "odometry that always says forwards is believed", |config| config.motion.find_sign = false),
    Part::new("mean-travel", "scales multiply each step's motion as it is", |config| config.motion.mean_travel = false),
    Part::new("levels", "the noise is as large as the rig states", |config| config.sensing.learn_noise = false),
];

impl Part {
    const fn new(name: &'static str, without: &'static str, switch_off: fn(&mut Config)) -> Self {
        Self { name, without, switch_off }
    }

    /// The part of this name.
    pub fn of_name(name: &str) -> Option<&'static Part> {
        PARTS.iter().find(|part| part.name == name)
    }

    /// The settings without it.
    pub fn off(&self, mut config: Config) -> Config {
        (self.switch_off)(&mut config);
        config
    }

    /// Whether these settings are without it.
    pub fn is_off(&self, config: &Config) -> bool {
        self.off(*config) == *config
    }
}

/// The names, for help and errors.
pub fn names() -> String {
    PARTS.map(|part| part.name).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_is_on_by_default_and_changes_something_of_its_own() {
        let configs = PARTS.map(|part| part.off(Config::real_rooms()));
        for (i, (part, config)) in PARTS.iter().zip(&configs).enumerate() {
            assert!(!part.is_off(&Config::real_rooms()) && part.is_off(config), "{}", part.name);
            assert!(configs[..i].iter().all(|other| other != config), "{}", part.name);
            assert_eq!(Part::of_name(part.name).map(|found| found.without), Some(part.without));
        }
    }
}
