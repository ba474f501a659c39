//! A recorded drive as the robot would have written it down, and the path and the map as its back end places them, a little at
//! a time.

use look_back::look_back::Effort;
use look_back::{Hit, Progress, RobotDiary, RobotLookBack, Unknown};
use slam_core::{Increment, Outcome, Rig, WallKind, WallView};

use super::smoother::{self, Expected, Noise};
use crate::input::rig_file::MAX_SENSORS;
use crate::recording::{Pose2, Recording, wrap};

/// Multiply-adds of one piece of work, and steps that are written down in one.
const BUDGET: u32 = 20_000;
const STEPS_AT_ONCE: usize = 50;

/// The robot looks back whenever there are so many new keyframes, a quarter of its diary, and when all is over.
const EVERY: usize = 64;

/// A keyframe that was begun.
struct Begun {
    step: usize,
    /// Once it was made one with an earlier one: that one, and the pose in its frame.
    part_of: Option<(usize, Pose2)>,
}

/// What the robot has in its memory, and what the desk needs beside that to draw the whole path.
pub struct RobotLooksBack {
    diary: Box<RobotDiary>,
    solver: Box<RobotLookBack>,
    /// Each keyframe that was begun, by its serial number.
    begun: Vec<Begun>,
    /// Steps that are written down.
    written: usize,
    /// Keyframes that no look back has placed.
    waiting: usize,
    is_looking: bool,
    looks: Vec<(Progress, Effort)>,
    expected: Expected,
}

impl RobotLooksBack {
    /// At the start of a drive; none where that has no steps.
    pub fn new(recording: &Recording, rig: &Rig<MAX_SENSORS>) -> Option<Self> {
        let first = recording.steps.first()?;
        Some(Self {
            diary: Box::new(RobotDiary::new(&rig.drive, single(&first.pose))),
            solver: Box::new(RobotLookBack::new()),
            begun: vec![Begun { step: 0, part_of: None }],
            written: 1,
            waiting: 0,
            is_looking: false,
            looks: Vec::new(),
            expected: Expected::default(),
        })
    }

    /// Does one small piece of the work of placing a drive's first `end` steps; whether there is more. Goes on where it
    /// was with a drive that has grown.
    pub fn work(&mut self, recording: &Recording, rig: &Rig<MAX_SENSORS>, end: usize) -> bool {
        if self.is_looking {
            let progress = self.solver.work(&mut self.diary, BUDGET);
            self.is_looking = progress == Progress::Working;
            if !self.is_looking {
                self.looks.push((progress, self.solver.effort()));
            }
            return self.is_looking || self.written < end;
        }
        for step in (self.written..end).take(STEPS_AT_ONCE) {
            let is_last = step + 1 == end;
            let before = self.placed();
            self.waiting += usize::from(self.write_down(recording, rig, step, is_last));
            self.follow(&before);
            self.written = step + 1;
            if is_last || self.waiting >= EVERY {
                self.waiting = 0;
                self.is_looking = true;
                self.solver.begin(&self.diary);
                return true;
            }
        }
        self.written < end
    }

    /// Steps that are placed, when there is nothing left to do.
    pub fn steps(&self) -> usize {
        self.written
    }

    /// How each look back ended, and what it took.
    pub fn looks(&self) -> &[(Progress, Effort)] {
        &self.looks
    }

    /// The diary.
    pub fn diary(&self) -> &RobotDiary {
        &self.diary
    }

    /// The record with the path and the walls that were found, not scored.
    pub fn moved(&self, recording: &Recording) -> Recording {
        smoother::moved(recording, &self.path(recording), self.walls())
    }

    /// Writes a step down; whether a keyframe was begun.
    fn write_down(&mut self, recording: &Recording, rig: &Rig<MAX_SENSORS>, index: usize, is_last: bool) -> bool {
        let step = &recording.steps[index];
        let moved = recording.steps[index - 1].sensed.relative(&step.sensed);
        let increment =
            Increment { forward_m: moved.x_m as f32, left_m: moved.y_m as f32, turn_rad: moved.theta_rad as f32 };
        self.diary.travel(&increment);
        let begins = self.diary.is_due() || is_last;
        if begins {
            self.diary.begin_keyframe(&single(&step.pose));
            self.begun.push(Begun { step: index, part_of: None });
        }
        if let Some((alpha_rad, _)) = step.alpha {
            self.diary.grid(alpha_rad);
        }
        for (number, (reading, sensor)) in recording.readings(index).iter().zip(&rig.sensors).enumerate() {
            let about_m = self.expected.range_m(number, sensor, reading);
            let wall = match reading.outcome {
                Outcome::Updated { wall, .. } => Some(wall),
                Outcome::Gated { .. } | Outcome::Unexplained => None,
                Outcome::Missing | Outcome::Refused(_) => continue,
            };
            let Some(([x, y], about_m)) = reading.hit_m.zip(about_m) else { continue };
            let end = step.pose.relative(&Pose2::new(x.into(), y.into(), 0.0));
            let noise = Noise::of(sensor, about_m);
            self.diary.hit(&Hit {
                from_m: [sensor.mount.x_m, sensor.mount.y_m],
                end_m: [end.x_m as f32, end.y_m as f32],
                variance_m2: (noise.sigma_m * noise.sigma_m) as f32,
                alike: noise.alike as f32,
                sensor: number as u8,
                wall,
            });
        }
        begins
    }

    /// The diary's keyframes at present.
    fn placed(&self) -> Vec<(u32, Pose2)> {
        self.diary.keyframes().map(|(serial, pose)| (serial, pose.into())).collect()
    }

    /// Remembers where keyframes were that have been made one with others since.
    fn follow(&mut self, before: &[(u32, Pose2)]) {
        let mut left = self.diary.keyframes().map(|(serial, _)| serial).peekable();
        let mut kept = (0, Pose2::default());
        for &(serial, pose) in before {
            if left.next_if_eq(&serial).is_some() {
                kept = (serial as usize, pose);
            } else {
                self.begun[serial as usize].part_of = Some((kept.0, kept.1.relative(&pose)));
            }
        }
    }

    /// The pose of every step that was written down: between two keyframes what the odometry misses is spread evenly.
    pub fn path(&self, recording: &Recording) -> Vec<Pose2> {
        let mut poses: Vec<Option<Pose2>> = vec![None; self.begun.len()];
        for (serial, pose) in self.placed() {
            poses[serial as usize] = Some(pose);
        }
        let mut keys: Vec<(usize, Pose2)> = Vec::new();
        for (i, begun) in self.begun.iter().enumerate() {
            let whole = begun.part_of.map(|(whole, inner)| keys[whole].1.compose(&inner));
            keys.push((begun.step, whole.or(poses[i]).expect("each is in the diary or part of an earlier one")));
        }
        let place = |step: usize| {
            let before = keys.partition_point(|(begun, _)| *begun <= step) - 1;
            let (begun, pose) = keys[before];
            let local = |to: usize| recording.steps[begun].sensed.relative(&recording.steps[to].sensed);
            let now = pose.compose(&local(step));
            let Some(&(next, next_pose)) = keys.get(before + 1) else { return now };
            let share = (step - begun) as f64 / (next - begun) as f64;
            let arrived = pose.compose(&local(next));
            Pose2::new(
                now.x_m + share * (next_pose.x_m - arrived.x_m),
                now.y_m + share * (next_pose.y_m - arrived.y_m),
                now.theta_rad + share * wrap(next_pose.theta_rad - arrived.theta_rad),
            )
        };
        (0..self.written).map(place).collect()
    }

    /// Of what the last look back found; not a number where it was not asked.
    fn variance(&self, unknown: Unknown) -> f32 {
        self.solver.covariance(unknown, unknown).unwrap_or(f32::NAN)
    }

    /// The walls that were found.
    pub fn walls(&self) -> Vec<WallView> {
        let seen = self.diary.walls().filter(|(_, wall)| wall.hits > 0);
        let view = |(index, wall): (usize, &look_back::Wall)| WallView {
            id: self.diary.id_of(index).unwrap_or(u16::MAX),
            kind: if wall.on_grid { WallKind::Grid } else { WallKind::Free },
            rho_m: wall.rho_m,
            beta_rad: wall.beta_rad,
            lo_m: wall.lo_m,
            hi_m: wall.hi_m,
            sigma_rho_m: self.variance(Unknown::Offset(index)).sqrt(),
            updates: wall.hits,
        };
        seen.map(view).collect()
    }
}

fn single(pose: &Pose2) -> slam_core::Pose {
    slam_core::Pose { x_m: pose.x_m as f32, y_m: pose.y_m as f32, theta_rad: pose.theta_rad as f32 }
}
