//! A recorded drive as the robot would have written it down, and the path and the map as it would place them.

use look_back::look_back::Effort;
use look_back::{Hit, Progress, RobotDiary, RobotLookBack, Unknown};
use slam_core::{Increment, Outcome, Rig, WallKind, WallView};

use lab::evaluate::smoother::{Noise, moved};
use lab::input::rig_file::MAX_SENSORS;
use lab::recording::{Pose2, Recording, wrap};

/// Multiply-adds that are asked for at once.
const BUDGET: u32 = 20_000;

/// The robot looks back whenever there are so many new keyframes, a quarter of its diary, and when all is over.
pub const EVERY: usize = 64;

/// What came of it.
#[derive(Clone, Debug)]
pub struct Looked {
    /// The record with this path and map, not scored.
    pub recording: Recording,
    /// The diary in the end.
    pub diary: Box<RobotDiary>,
    /// How each look back ended, and what it took.
    pub looks: Vec<(Progress, Effort)>,
}

/// Feeds a record to a diary of the robot's size and looks back. None where the record is empty.
pub fn look_back(recording: &Recording, rig: &Rig<MAX_SENSORS>) -> Option<Looked> {
    let first = recording.steps.first()?;
    let mut robot = Robot {
        diary: Box::new(RobotDiary::new(&rig.drive, single(&first.pose))),
        solver: Box::new(RobotLookBack::new()),
        begun: vec![Begun { step: 0, part_of: None }],
        looks: Vec::new(),
    };
    let mut waiting = 0;
    for step in 1..recording.steps.len() {
        let is_last = step + 1 == recording.steps.len();
        let before: Vec<(u32, Pose2)> = robot.placed();
        waiting += usize::from(robot.drive(recording, rig, step, is_last));
        robot.follow(&before);
        if is_last || waiting >= EVERY {
            robot.look_back();
            waiting = 0;
        }
    }
    let path = robot.path(recording);
    let walls = robot.walls();
    Some(Looked { recording: moved(recording, &path, walls), diary: robot.diary, looks: robot.looks })
}

/// A keyframe that was begun.
struct Begun {
    step: usize,
    /// Once it was made one with an earlier one: that one, and the pose in its frame.
    part_of: Option<(usize, Pose2)>,
}

/// What the robot has in its memory, and what the desk needs beside that to draw the whole path.
struct Robot {
    diary: Box<RobotDiary>,
    solver: Box<RobotLookBack>,
    /// Each keyframe that was begun, by its serial number.
    begun: Vec<Begun>,
    looks: Vec<(Progress, Effort)>,
}

impl Robot {
    /// Writes a step down; whether a keyframe was begun.
    fn drive(&mut self, recording: &Recording, rig: &Rig<MAX_SENSORS>, index: usize, is_last: bool) -> bool {
        let step = &recording.steps[index];
        let moved = recording.steps[index - 1].dead_reckoning.relative(&step.dead_reckoning);
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
            let wall = match reading.outcome {
                Outcome::Updated { wall, .. } => Some(wall),
                Outcome::Gated { .. } | Outcome::Unexplained => None,
                Outcome::Missing | Outcome::Refused(_) => continue,
            };
            let Some([x, y]) = reading.hit_m else { continue };
            let end = step.pose.relative(&Pose2::new(x.into(), y.into(), 0.0));
            let noise = Noise::of(sensor, end.x_m.hypot(end.y_m));
            self.diary.hit(&Hit {
                from_m: [sensor.mount.x_m, sensor.mount.y_m],
                end_m: [end.x_m as f32, end.y_m as f32],
                sigma_m: noise.sigma_m as f32,
                alike: noise.alike as f32,
                sensor: number as u8,
                wall,
            });
        }
        begins
    }

    fn look_back(&mut self) {
        self.solver.begin(&self.diary);
        let progress = loop {
            match self.solver.work(&mut self.diary, BUDGET) {
                Progress::Working => {}
                ended => break ended,
            }
        };
        self.looks.push((progress, self.solver.effort()));
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

    /// Every step's pose: between two keyframes what the odometry misses is spread evenly.
    fn path(&self, recording: &Recording) -> Vec<Pose2> {
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
            let local = |to: usize| recording.steps[begun].dead_reckoning.relative(&recording.steps[to].dead_reckoning);
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
        (0..recording.steps.len()).map(place).collect()
    }

    /// Of what the last look back found; not a number where it was not asked.
    fn variance(&self, unknown: Unknown) -> f32 {
        self.solver.covariance(unknown, unknown).unwrap_or(f32::NAN)
    }

    fn walls(&self) -> Vec<WallView> {
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
