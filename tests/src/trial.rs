//! A real log, read once and replayed in many ways.

use lab::evaluate::score;
use lab::evaluate::smoother;
use lab::input::log::truth::{self, Truth};
use lab::input::log::{self, Row};
use lab::input::rig_file::Robot;
use lab::recording::Recording;
use lab::run::Session;
use slam_core::{Config, Increment, Motion, Pose, RangeInput, RangeModel};

use crate::real_logs::RealLog;

/// What a replay differs in from the log's own rig file and the estimator's defaults.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// The estimator's settings.
    pub config: Config,
    /// Longest range that is a reading, metres, where the rig file allows more.
    pub cap_m: f32,
    /// Factor of the range sensors' noise.
    pub noise: f32,
    /// Where to begin in the log, seconds.
    pub from_s: f64,
    /// Of so many sensors only the first is used.
    pub every: usize,
    /// Of so many rows only the last is used, with the motion of all of them.
    pub rows: usize,
}

impl Default for Trial {
    fn default() -> Self {
        Self { config: Config::real_rooms(), cap_m: f32::INFINITY, noise: 1.0, from_s: 0.0, every: 1, rows: 1 }
    }
}

/// The rows of a log, with the robot and the truth.
#[derive(Clone, Debug)]
pub struct LoadedLog {
    robot: Robot,
    rows: Vec<Row>,
    truth: Option<Truth>,
}

impl LoadedLog {
    /// Reads a log.
    ///
    /// # Panics
    /// It is not at hand, or damaged.
    pub fn read(log: RealLog) -> Self {
        let folder = log.folder();
        let mut robot = Robot::read(&folder.join("rig.toml")).unwrap_or_else(|error| panic!("{error}"));
        let rows = log::open(&folder.join(log.file), &mut robot).and_then(|rows| rows.collect::<Result<Vec<_>, _>>());
        let rows = rows.unwrap_or_else(|error| panic!("{error}"));
        let truth = folder.join("truth.csv");
        let truth = truth.is_file().then(|| truth::read(&truth).unwrap_or_else(|error| panic!("{error}")));
        Self { robot, rows, truth }
    }

    /// What the estimator makes of it in a trial.
    ///
    /// # Panics
    /// The trial's robot cannot be.
    pub fn replay(&self, trial: &Trial) -> Recording {
        let mut session = Session::new(&trial.robot(&self.robot), trial.config, "").expect("a robot that can be");
        let begin_s = self.rows.first().map_or(0.0, |row| row.t_s + trial.from_s);
        let mut times_s = Vec::new();
        let begin = self.rows.partition_point(|row| row.t_s < begin_s);
        for rows in self.rows[begin..].chunks(trial.rows) {
            let row = trial.row(rows);
            session.push(&row);
            times_s.push(row.t_s);
        }
        let mut recording = session.finish();
        score::score(&mut recording, &times_s, self.truth.as_ref());
        smoother::add(&mut recording, &trial.robot(&self.robot).rig, &mut |_| ());
        recording
    }
}

impl Trial {
    fn robot(&self, own: &Robot) -> Robot {
        let mut robot = own.clone();
        for sensor in &mut robot.rig.sensors {
            sensor.max_m = sensor.max_m.min(self.cap_m);
            match &mut sensor.model {
                RangeModel::Sharp { noise_v, .. } => *noise_v *= self.noise,
                RangeModel::Metric { noise_m, noise_rel } => {
                    *noise_m *= self.noise;
                    *noise_rel *= self.noise;
                }
            }
        }
        robot
    }

    /// The last of these rows, with the motion of all of them.
    fn row(&self, rows: &[Row]) -> Row {
        let mut row = rows.last().expect("a chunk has a row").clone();
        if let Motion::Increment(motion) = &mut row.sample.motion {
            *motion = together(rows);
        }
        for (_, range) in row.sample.ranges.iter_mut().enumerate().filter(|(sensor, _)| sensor % self.every != 0) {
            *range = RangeInput::Missing;
        }
        row
    }
}

/// Motions one after the other, as one. Wheel ticks add up by themselves.
fn together(rows: &[Row]) -> Increment {
    let poses = rows.iter().filter_map(|row| match row.sample.motion {
        Motion::Increment(i) => Some(Pose { x_m: i.forward_m, y_m: i.left_m, theta_rad: i.turn_rad }),
        Motion::Ticks(_) => None,
    });
    let pose = poses.fold(Pose::ORIGIN, |all, pose| all.compose(&pose));
    Increment { forward_m: pose.x_m, left_m: pose.y_m, turn_rad: pose.theta_rad }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulated::rows;
    use lab::input::built_in_robot;
    use slam_core::Outcome;

    #[test]
    fn a_trial_changes_what_it_says() {
        let (robot, _) = built_in_robot().expect("the built-in rig is good");
        let log = LoadedLog { robot, rows: rows("room", 0.5, 1), truth: None };
        let own = log.replay(&Trial::default());
        let used = |recording: &Recording| recording.figures.updates;
        let later = log.replay(&Trial { from_s: 10.0, ..Trial::default() });
        assert_eq!(later.steps.len(), own.steps.len() - 250);
        assert!(later.figures.estimate.is_some(), "the truth is still there");
        let near = log.replay(&Trial { cap_m: 0.5, ..Trial::default() });
        let noisy = log.replay(&Trial { noise: 2.0, ..Trial::default() });
        assert!(used(&near) < used(&own) && noisy.figures.mean_nis < own.figures.mean_nis);
        let few = log.replay(&Trial { every: 2, ..Trial::default() });
        let is_silent = |step: usize| few.readings(step)[1].outcome == Outcome::Missing;
        assert!((0..few.steps.len()).all(is_silent) && used(&few) > 0);
        let slow = log.replay(&Trial { rows: 5, ..Trial::default() });
        assert_eq!(slow.steps.len(), own.steps.len().div_ceil(5));
        assert!(slow.figures.path_m > 0.95 * own.figures.path_m, "the motion of all rows but the first few is there");
    }

    #[test]
    fn four_sides_of_a_square_lead_back() {
        let side = Motion::Increment(Increment { forward_m: 1.0, left_m: 0.0, turn_rad: core::f32::consts::FRAC_PI_2 });
        let mut rows = rows("room", 0.01, 1);
        rows.truncate(4);
        rows.iter_mut().for_each(|row| row.sample.motion = side);
        let all = together(&rows);
        assert!(all.forward_m.abs() < 1e-5 && all.left_m.abs() < 1e-5 && all.turn_rad.abs() < 1e-5, "{all:?}");
        let two = together(&rows[..2]);
        assert!((two.forward_m - 1.0).abs() < 1e-5 && (two.left_m - 1.0).abs() < 1e-5, "{two:?}");
    }
}
