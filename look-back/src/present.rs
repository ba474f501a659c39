//! What a look back found, brought up to the present, for the filter to take over.

use heapless::Vec;
use slam_core::angle::wrap;
use slam_core::hand_over::{ALPHA, DISTANCE, GAINS, HandOver, POSE, TURN, VEER};
use slam_core::{Calibration, NotTaken, PlacedWall, Pose, Slam};

use crate::diary::Diary;
use crate::frame::Frame;
use crate::group::Group;
use crate::keyframe::Keyframe;
use crate::look_back::LookBack;
use crate::names::{NAMES, Name};
use crate::rows;
use crate::solve::{FREE_RAD2, Solver};

/// Residuals beyond five sigma are of something else.
const GATE: f32 = 25.0;

/// Multiply-adds of a stretch and of a group for each unknown, beside those for each entry of the covariance.
const UNKNOWN_COST: usize = 40;

/// The last pose on its way from the last keyframe that was placed to the robot: what was sensed meanwhile is taken in keyframe by
/// keyframe, as a Kalman filter does. The walls and the calibration change with it; the diary's stay as they are.
#[derive(Clone, Copy, Debug)]
pub struct Present {
    pose: Pose,
    /// The keyframe at which it is.
    key: usize,
    /// The first group that is not taken in yet.
    group: usize,
    /// Groups of that keyframe that are.
    taken: usize,
}

impl Present {
    /// At no keyframe; every byte is zero.
    pub const NONE: Self = Self { pose: Pose::ORIGIN, key: 0, group: 0, taken: 0 };

    /// At the last keyframe that was placed.
    pub fn begin<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
        solver: &mut Solver<K, W, B, P>,
    ) {
        let key = solver.keys().saturating_sub(1);
        solver.system.settle();
        *self = Self {
            pose: diary.keyframes.get(key).map_or(Pose::ORIGIN, |key| key.pose),
            key,
            group: diary.seen_from_first(key).len(),
            taken: 0,
        };
    }

    /// Takes in the next group, or after the last of its keyframe the stretch to the next one, in so many multiply-adds; none at the
    /// last keyframe, which is still being written.
    pub fn go_on<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
        solver: &mut Solver<K, W, B, P>,
    ) -> Option<u32> {
        let key = diary.keyframes.get(self.key).filter(|_| self.key + 1 < diary.keyframes.len())?;
        self.take_next(diary, solver, key)
    }

    /// The same of the last keyframe, as it is; none at the robot.
    pub fn arrive<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
        solver: &mut Solver<K, W, B, P>,
    ) -> Option<u32> {
        self.take_next(diary, solver, diary.keyframes.get(self.key)?)
    }

    fn take_next<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
        solver: &mut Solver<K, W, B, P>,
        key: &Keyframe,
    ) -> Option<u32> {
        let unknowns = solver.system.len();
        if self.taken == usize::from(key.groups) {
            self.travel(diary, solver, key);
            self.key += 1;
            self.taken = 0;
            return Some((UNKNOWN_COST * unknowns) as u32);
        }
        self.see(diary, solver, diary.groups.get(self.group)?);
        self.group += 1;
        self.taken += 1;
        Some((unknowns * (unknowns + UNKNOWN_COST)) as u32)
    }

    /// Where it is.
    #[cfg(test)]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    fn see<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
        solver: &mut Solver<K, W, B, P>,
        group: &Group,
    ) {
        let wall = group.wall().and_then(|wall| Some((diary.walls.get(wall)?.as_ref()?, solver.place(wall)?)));
        let Some((wall, place)) = wall else { return };
        let rows = rows::of_group(group, &diary.gains, &self.pose, &Frame::of(&self.pose), wall, place);
        solver.system.update(&rows, GATE);
        let [x, y, theta] = solver.system.take_pose();
        self.pose = Pose::new(self.pose.x_m + x, self.pose.y_m + y, self.pose.theta_rad + theta);
    }

    fn travel<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
        solver: &mut Solver<K, W, B, P>,
        key: &Keyframe,
    ) {
        let calibration = calibration(diary, solver);
        let variances = diary.odometry.variances(key);
        let (by, noise) = stretch(key, &self.pose, &calibration, variances);
        solver.system.move_on(&by, noise);
        self.pose = self.pose.compose(&calibrated(key, &calibration));
    }
}

/// The calibration with its increments.
fn calibration<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
    diary: &Diary<K, G, W>,
    solver: &Solver<K, W, B, P>,
) -> Calibration {
    let Calibration { distance, turn, veer_rad_per_m } = diary.calibration;
    let by = |place| solver.system.increment(place);
    Calibration { distance: distance + by(DISTANCE), turn: turn + by(TURN), veer_rad_per_m: veer_rad_per_m + by(VEER) }
}

/// Variance of the grid's direction from which on no wall says what it is, rad^2: half of that of none. Those that were on it are not any more,
/// and the filter is to found another one.
const UNKNOWN_RAD2: f32 = 0.5 * FREE_RAD2;

impl<const K: usize, const W: usize, const B: usize, const P: usize> LookBack<K, W, B, P> {
    /// Direction of the grid, radians; none where no wall is on it.
    pub(crate) fn grid<const G: usize>(&self, diary: &Diary<K, G, W>) -> Option<f32> {
        let is_known = self.solver.system.covariance(ALPHA, ALPHA) < UNKNOWN_RAD2;
        diary.alpha_rad.filter(|_| is_known)
    }

    /// Hands what was found over to a filter, once it has arrived where that is.
    ///
    /// # Errors
    /// Why the filter did not take it.
    #[inline(never)]
    pub(crate) fn hand_over<const G: usize, const S: usize, const WALLS: usize, const O: usize, const ROWS: usize>(
        &self,
        diary: &mut Diary<K, G, W>,
        slam: &mut Slam<S, WALLS, O, ROWS>,
        epoch: u32,
    ) -> Result<(), NotTaken> {
        let solver = &self.solver;
        diary.alpha_rad = self.grid(diary);
        let walls: Vec<PlacedWall, W> = gathered(solver.walls().filter_map(|index| placed(diary, solver, index)));
        let place = |wall: usize| solver.walls().position(|index| index == wall);
        let named = |name: &Name| Some((name.id, u8::try_from(place(name.wall.into())?).ok()?));
        let names: Vec<(u16, u8), NAMES> = gathered(diary.names.iter().filter_map(named));
        let found = HandOver {
            epoch,
            pose: self.present.pose,
            alpha_rad: diary.alpha_rad.map(|alpha_rad| wrap(alpha_rad + solver.system.increment(ALPHA))),
            calibration: calibration(diary, solver),
            gains: core::array::from_fn(|i| {
                diary.gains.values.get(i).map_or(1.0, |gain| gain + solver.system.increment(GAINS + i))
            }),
            walls: &walls,
            names: &names,
            covariance: solver.system.covariance_entries(),
            is_displaced: diary.turned.is_new,
        };
        // What f32 did not tell from nothing has no variance.
        let found = if self.is_positive() { found } else { HandOver { covariance: &[], ..found } };
        slam.take_over(&found)?;
        diary.turned.is_new = false;
        diary.follow_filter();
        Ok(())
    }
}

/// As many as there is room for.
fn gathered<T, const N: usize>(all: impl Iterator<Item = T>) -> Vec<T, N> {
    let mut found = Vec::new();
    for one in all.take(N) {
        // There is room for so many.
        let _ = found.push(one);
    }
    found
}

/// The motion of a keyframe's stretch.
fn calibrated(key: &Keyframe, calibration: &Calibration) -> Pose {
    let Calibration { distance, turn, veer_rad_per_m } = *calibration;
    let turned = turn * (key.motion.theta_rad + veer_rad_per_m * key.path_m);
    Pose::new(distance * key.motion.x_m, distance * key.motion.y_m, turned)
}

/// Derivatives of the pose after a stretch by other unknowns than itself, and the noise of the stretch.
fn stretch(
    key: &Keyframe,
    pose: &Pose,
    calibration: &Calibration,
    [position_m2, heading_rad2]: [f32; 2],
) -> ([[(usize, f32); 3]; 3], [f32; 3]) {
    let Calibration { distance, turn, veer_rad_per_m } = *calibration;
    let [x, y] = Frame::of(pose).turn([key.motion.x_m, key.motion.y_m]);
    let none = (ALPHA, 0.0);
    let by_turn = key.motion.theta_rad + veer_rad_per_m * key.path_m;
    let by = [
        [(POSE + 2, -distance * y), (DISTANCE, x), none],
        [(POSE + 2, distance * x), (DISTANCE, y), none],
        [(TURN, by_turn), (VEER, turn * key.path_m), none],
    ];
    // Slips are the motion's; the noise of turns is the odometry's, as its scale makes it the motion's.
    (by, [position_m2, position_m2, turn * turn * heading_rad2])
}

/// A wall as it is handed over.
fn placed<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
    diary: &Diary<K, G, W>,
    solver: &Solver<K, W, B, P>,
    index: usize,
) -> Option<PlacedWall> {
    let mut wall = *diary.walls.get(index)?.as_ref()?;
    let place = solver.place(index)?;
    wall.shift(solver.system.increment(place), solver.system.increment(place + 1));
    let is_seen = wall.lo_m < wall.hi_m;
    Some(PlacedWall {
        id: diary.id_of(index)?,
        rho_m: wall.rho_m,
        beta_rad: wall.beta_rad,
        anchor_m: wall.anchor_m,
        lo_m: if is_seen { wall.lo_m } else { wall.anchor_m },
        hi_m: if is_seen { wall.hi_m } else { wall.anchor_m },
        hits: if is_seen { wall.hits } else { 0 },
        on_grid: wall.on_grid,
    })
}
