//! A real log, read once and replayed in many ways.

use hal_sim::rng::Rng;
use lab::evaluate::score;
use lab::evaluate::smoother;
use lab::input::log::truth::{self, Truth};
use lab::input::log::{self, Row};
use lab::input::rig_file::Robot;
use lab::recording::{Pose2, Recording};
use lab::run::Session;
use slam_core::{Config, DriveModel, HostSlam, Increment, Motion, Pose, RangeInput, RangeModel};

use crate::real_logs::RealLog;

/// Factors of the range noise that a rig file states. Real logs are chaotic: a change that should not matter can decide which wall a
/// reading goes to, so that a figure is the median and the worst of these replays.
pub const NOISES: [f32; 9] = [1.0, 0.98, 1.02, 0.96, 1.04, 0.99, 1.01, 0.97, 1.03];

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
    /// What the odometry has beyond the log's.
    pub odometry: Disturbance,
}

/// What an odometry that is a pose has beyond the log's, and what the rig says of it.
#[derive(Clone, Copy, Debug)]
pub struct Disturbance {
    /// Turn per metre driven forwards, degrees.
    pub drift_deg_per_m: f64,
    /// Factor of distances.
    pub scale: f64,
    /// How far each row's pose is from the moment of its ranges, 1-sigma, seconds.
    pub jitter_s: f64,
    /// Factor of the variances that the rig states.
    pub stated: f32,
}

impl Disturbance {
    /// As logged.
    pub const NONE: Self = Self { drift_deg_per_m: 0.0, scale: 1.0, jitter_s: 0.0, stated: 1.0 };
}

impl Default for Trial {
    fn default() -> Self {
        Self {
            config: Config::real_rooms(),
            cap_m: f32::INFINITY,
            noise: 1.0,
            from_s: 0.0,
            every: 1,
            rows: 1,
            odometry: Disturbance::NONE,
        }
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
        let mut robot = Robot::read(&folder.join(log.rig)).unwrap_or_else(|error| panic!("{error}"));
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
        let disturbed = trial.odometry.of(&self.rows[begin..]);
        for rows in disturbed.chunks(trial.rows) {
            let row = trial.row(rows);
            session.push(&row);
            times_s.push(row.t_s);
        }
        let mut recording = session.finish();
        score::score(&mut recording, &times_s, self.truth.as_ref());
        smoother::add(&mut recording, &trial.robot(&self.robot).rig, &mut |_| ());
        recording
    }

    /// The rows between two times, seconds after the first.
    #[must_use]
    pub fn between(&self, from_s: f64, to_s: f64) -> Self {
        let first_s = self.rows.first().map_or(0.0, |row| row.t_s);
        let is_within = |row: &&Row| (from_s..to_s).contains(&(row.t_s - first_s));
        Self { rows: self.rows.iter().filter(is_within).cloned().collect(), ..self.clone() }
    }

    /// A drive without a map; `each` sees the estimator after every row.
    ///
    /// # Panics
    /// The trial's robot cannot be.
    pub fn drive_seen(&self, trial: &Trial, mut each: impl FnMut(&HostSlam)) {
        let mut session = Session::new(&trial.robot(&self.robot), trial.config, "").expect("a robot that can be");
        for row in &self.rows {
            session.push(row);
            each(session.slam());
        }
    }

    /// A drive that begins in a kept map, not knowing where, or without one.
    ///
    /// # Errors
    /// Why the robot cannot begin in this map.
    ///
    /// # Panics
    /// The trial's robot cannot be.
    pub fn drive_in(&self, map: Option<Vec<u8>>, trial: &Trial) -> Result<Driven, String> {
        let mut session = Session::new(&trial.robot(&self.robot), trial.config, "").expect("a robot that can be");
        if let Some(map) = map {
            session.begin_in(map)?;
        }
        for row in &self.rows {
            session.push(row);
        }
        let times_s: Vec<f64> = self.rows.iter().map(|row| row.t_s).collect();
        let truth = self.truth.as_ref().map(|truth| truth::pair(&times_s, truth));
        Ok(Driven { map: session.map(), recording: session.finish(), truth })
    }
}

/// A drive, and the map that is left of it.
#[derive(Debug)]
pub struct Driven {
    /// What the estimator made of it.
    pub recording: Recording,
    /// The record that the robot would keep.
    pub map: Option<Vec<u8>>,
    /// The true pose at every row, in the truth's own frame; none where there is no truth.
    pub truth: Option<Vec<Option<Pose2>>>,
}

impl Trial {
    fn robot(&self, own: &Robot) -> Robot {
        let mut robot = own.clone();
        if let DriveModel::Odometry { noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad, .. } = &mut robot.rig.drive
        {
            for variance in [noise_m2_per_m, noise_rad2_per_m, noise_rad2_per_rad] {
                *variance *= self.odometry.stated;
            }
        }
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

impl Disturbance {
    /// The rows with this odometry. Jitter does not add up: each pose is moved along the way, to where the robot was at another
    /// moment.
    fn of(&self, rows: &[Row]) -> Vec<Row> {
        let mut rows = rows.to_vec();
        for row in &mut rows {
            if let Motion::Increment(motion) = &mut row.sample.motion {
                motion.turn_rad += self.drift_deg_per_m.to_radians() as f32 * motion.forward_m;
                motion.forward_m *= self.scale as f32;
                motion.left_m *= self.scale as f32;
            }
        }
        let mut random = Rng::stream(1, "stamps", 0);
        let shares: Vec<f64> = rows
            .windows(2)
            .map(|pair| (self.jitter_s * random.gaussian() / (pair[1].t_s - pair[0].t_s)).clamp(0.0, 1.0))
            .collect();
        let moved: Vec<Motion> = rows.iter().map(|row| row.sample.motion).collect();
        // What is driven before a pose is latched late is taken from the next row's motion.
        let mut taken = 0.0;
        for (number, row) in rows.iter_mut().enumerate() {
            let given = shares.get(number).copied().unwrap_or(0.0);
            let (rest, next) = (part(&moved[number], taken, 1.0), moved.get(number + 1));
            row.sample.motion = match next {
                Some(next) if given > 0.0 => both(&rest, &part(next, 0.0, given)),
                _ => rest,
            };
            taken = given;
        }
        rows
    }
}

/// The part of a motion between two shares of its time. Wheel ticks stay as they are.
fn part(motion: &Motion, from: f64, to: f64) -> Motion {
    let share = (to - from) as f32;
    match *motion {
        Motion::Increment(i) => Motion::Increment(Increment {
            forward_m: share * i.forward_m,
            left_m: share * i.left_m,
            turn_rad: share * i.turn_rad,
        }),
        ticks => ticks,
    }
}

/// Two motions, one after the other.
fn both(first: &Motion, second: &Motion) -> Motion {
    match (first, second) {
        (Motion::Increment(first), Motion::Increment(second)) => Motion::Increment(in_turn([*first, *second])),
        _ => *first,
    }
}

/// Motions one after the other, as one. Wheel ticks add up by themselves.
fn together(rows: &[Row]) -> Increment {
    in_turn(rows.iter().filter_map(|row| match row.sample.motion {
        Motion::Increment(i) => Some(i),
        Motion::Ticks(_) => None,
    }))
}

fn in_turn(motions: impl IntoIterator<Item = Increment>) -> Increment {
    let poses = motions.into_iter().map(|i| Pose { x_m: i.forward_m, y_m: i.left_m, theta_rad: i.turn_rad });
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

    #[test]
    fn a_disturbed_odometry_is_off_by_what_was_said() {
        let mut rows = rows("room", 0.1, 1);
        rows.truncate(20);
        let straight = Motion::Increment(Increment { forward_m: 0.1, left_m: 0.0, turn_rad: 0.0 });
        rows.iter_mut().for_each(|row| row.sample.motion = straight);
        let metres = 0.1 * rows.len() as f32;
        let drifting = Disturbance { drift_deg_per_m: 2.0, ..Disturbance::NONE }.of(&rows);
        assert!((together(&drifting).turn_rad - 2.0f32.to_radians() * metres).abs() < 1e-3);
        let long = Disturbance { scale: 1.05, ..Disturbance::NONE }.of(&rows);
        assert!((together(&long).forward_m - 1.05 * metres).abs() < 1e-3);
        // Rows are 40 ms apart, so that one of 20 ms may move half of a row's motion, and none in all.
        let jittery = Disturbance { jitter_s: 0.02, ..Disturbance::NONE }.of(&rows);
        let steps: Vec<f32> = jittery.iter().map(|row| together(std::slice::from_ref(row)).forward_m).collect();
        assert!(steps.iter().any(|m| *m > 0.11) && steps.iter().any(|m| *m < 0.09), "{steps:?}");
        assert!((together(&jittery).forward_m - metres).abs() < 0.01);
    }
}
