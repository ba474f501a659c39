//! One Gauss-Newton step over a diary, in slices.

use slam_core::Pose;
use slam_core::angle::wrap;

use crate::diary::Diary;
use crate::frame::{Frame, relative};
use crate::group::Group;
use crate::keyframe::Keyframe;
use crate::rows::{self, ALPHA, DISTANCE, GAINS, LAST_POSE, TURN, VEER, WALLS};
use crate::system::{Link, System};
use crate::wall::Wall;

/// Variances that keep what nothing is known of where it is: a wall's offset, m^2, and a direction, rad^2.
const FREE_M2: f32 = 100.0;
pub const FREE_RAD2: f32 = 1.0;

/// Largest turn of a pose in one step, radians: so far sines go with their derivatives. What would turn by more goes that far.
pub const FURTHEST_RAD: f32 = 0.5;

/// Multiply-adds of a group's rows, of a stretch's, of a pose's elimination without the border, of a pose's move.
const GROUP_COST: u32 = 120;
const STRETCH_COST: u32 = 150;
const POSE_COST: u32 = 100;
const MOVE_COST: u32 = 10;

/// What of a step comes next.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Eliminate,
    Factor { row: usize },
    Forward,
    Back { key: usize },
    Apply,
}

/// What a slice of a step came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slice {
    /// There is more to do.
    More,
    /// The step is done; the largest increment, metres or radians.
    Moved(f32),
    /// The equations have no finite solution; nothing was moved.
    Unsolvable,
}

/// The step and all its memory.
#[derive(Clone, Debug)]
pub struct Solver<const K: usize, const W: usize, const B: usize, const P: usize> {
    pub system: System<B, P>,
    chain: [Link; K],
    /// Which of the border's walls each wall of the diary is.
    order: [Option<u8>; W],
    walls: usize,
    /// Poses that are placed; later ones move with the last of them.
    keys: usize,
    stage: Stage,
    /// The keyframe at which a pass is, and its first group.
    key: usize,
    group: usize,
}

impl<const K: usize, const W: usize, const B: usize, const P: usize> Solver<K, W, B, P> {
    /// Without equations.
    pub const NEW: Self = Self {
        system: System::NEW,
        chain: [Link::ZERO; K],
        order: [None; W],
        walls: 0,
        keys: 0,
        stage: Stage::Eliminate,
        key: 0,
        group: 0,
    };

    /// Place of a wall's offset in the border; its direction is the next.
    pub fn place(&self, wall: usize) -> Option<usize> {
        let position: u8 = (*self.order.get(wall)?)?;
        Some(WALLS + 2 * usize::from(position))
    }

    /// The wall of the diary that is the border's first, second, and so on.
    pub fn walls(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.walls).filter_map(|position| self.order.iter().position(|at| at.map(usize::from) == Some(position)))
    }

    /// Keyframes that are placed.
    pub fn keys(&self) -> usize {
        self.keys
    }

    /// Says which walls are placed, and how many keyframes. Walls come in the order in which they were first seen, so that the
    /// elimination has to do with those of the path so far only.
    pub fn choose<const G: usize>(&mut self, diary: &Diary<K, G, W>, is_placed: impl Fn(usize) -> bool) {
        self.keys = diary.keyframes.len();
        self.order = [None; W];
        self.walls = 0;
        for wall in diary.groups.iter().filter_map(Group::wall).filter(|wall| is_placed(*wall)) {
            if let Some(order) = self.order.get_mut(wall).filter(|order| order.is_none()) {
                *order = u8::try_from(self.walls).ok();
                self.walls += 1;
            }
        }
    }

    /// Begins a step.
    pub fn begin<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) {
        diary.walls.iter_mut().flatten().for_each(Wall::anchor);
        self.system.begin(self.walls);
        diary.odometry.prior(&diary.calibration).iter().for_each(|row| self.system.add(row));
        for (number, (weight, residual)) in diary.gains.prior().enumerate() {
            self.system.add_prior(GAINS + number, weight, residual);
        }
        self.system.damp(ALPHA, 1.0 / FREE_RAD2);
        for (wall, place) in self.placed(diary) {
            self.system.damp(place, 1.0 / FREE_M2);
            self.system.damp(place + 1, 1.0 / FREE_RAD2);
            if let Some(row) = diary.alpha_rad.and_then(|alpha_rad| rows::of_grid(&wall, alpha_rad, place)) {
                self.system.add(&row);
            }
        }
        self.system.reset_active();
        self.stage = Stage::Eliminate;
        (self.key, self.group) = (0, 0);
    }

    /// The walls that are placed, and where they are in the border.
    fn placed<const G: usize>(
        &self,
        diary: &Diary<K, G, W>,
    ) -> impl Iterator<Item = (Wall, usize)> + use<K, W, B, P, G> {
        let (walls, order) = (diary.walls, self.order);
        let place = |(wall, position): (Option<Wall>, Option<u8>)| Some((wall?, WALLS + 2 * usize::from(position?)));
        walls.into_iter().zip(order).filter_map(place)
    }

    /// Goes on by a slice, whose cost in multiply-adds it says.
    pub fn slice<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> (u32, Slice) {
        let len = self.system.len() as u32;
        match self.stage {
            Stage::Eliminate => (self.eliminate(diary), Slice::More),
            Stage::Factor { row } if self.system.factor_row(row) => {
                self.stage = Stage::Factor { row: row + 1 };
                ((row * row / 2) as u32, Slice::More)
            }
            Stage::Factor { .. } => {
                self.system.solve();
                self.stage = Stage::Forward;
                (self.key, self.group) = (0, 0);
                (len * len, Slice::More)
            }
            Stage::Forward => (self.forward(diary), Slice::More),
            Stage::Back { key } => {
                self.back(key);
                (POSE_COST, Slice::More)
            }
            Stage::Apply => (MOVE_COST * diary.keyframes.len() as u32, self.apply(diary)),
        }
    }

    /// The present keyframe of a pass, the next one's pose, and its groups.
    fn present<'d, const G: usize>(&self, diary: &'d Diary<K, G, W>) -> Option<(&'d Keyframe, Pose, &'d [Group])> {
        let next = diary.keyframes.get(self.key + 1).filter(|_| self.key + 1 < self.keys)?;
        let key = diary.keyframes.get(self.key)?;
        let groups = diary.groups.get(self.group..self.group + usize::from(key.groups))?;
        Some((key, next.pose, groups))
    }

    fn eliminate<const G: usize>(&mut self, diary: &Diary<K, G, W>) -> u32 {
        let Some((key, next, groups)) = self.present(diary) else {
            self.system.keep_last();
            self.stage = Stage::Factor { row: 0 };
            return 0;
        };
        let frame = Frame::of(&key.pose);
        for group in groups {
            let wall = group.wall().and_then(|wall| Some((diary.walls.get(wall)?.as_ref()?, self.place(wall)?)));
            let Some((wall, place)) = wall else { continue };
            rows::of_group(group, &diary.gains, &key.pose, &frame, wall, place)
                .iter()
                .for_each(|row| self.system.add(row));
        }
        let rows = diary.odometry.rows(key, &next, &diary.calibration);
        rows.iter().for_each(|row| self.system.add(row));
        if self.key == 0 {
            self.system.pass(&rows);
        } else {
            self.system.eliminate(&rows);
        }
        self.advance(groups.len());
        let active = self.system.active() as u32;
        GROUP_COST * groups.len() as u32 + STRETCH_COST + POSE_COST + 3 * active * active / 2 + 30 * active
    }

    fn forward<const G: usize>(&mut self, diary: &Diary<K, G, W>) -> u32 {
        let Some((key, next, groups)) = self.present(diary) else {
            self.stage = Stage::Back { key: self.keys.saturating_sub(2) };
            return 0;
        };
        if self.key == 0 {
            let rows = diary.odometry.rows(key, &next, &diary.calibration);
            rows.iter().for_each(|row| self.system.add_known(row));
            self.system.pass_known();
        } else {
            let frame = Frame::of(&key.pose);
            for group in groups {
                let wall = group.wall().and_then(|wall| Some((diary.walls.get(wall)?.as_ref()?, self.place(wall)?)));
                let Some((wall, place)) = wall else { continue };
                let rows = rows::of_group(group, &diary.gains, &key.pose, &frame, wall, place);
                rows.iter().for_each(|row| self.system.add_known(row));
            }
            let rows = diary.odometry.rows(key, &next, &diary.calibration);
            rows.iter().for_each(|row| self.system.add_known(row));
            let link = self.system.link();
            if let Some(entry) = self.chain.get_mut(self.key) {
                *entry = link;
            }
        }
        self.advance(groups.len());
        GROUP_COST * groups.len() as u32 + STRETCH_COST + 2 * POSE_COST
    }

    fn advance(&mut self, groups: usize) {
        self.key += 1;
        self.group += groups;
    }

    fn back(&mut self, key: usize) {
        if key == 0 {
            self.stage = Stage::Apply;
            return;
        }
        let next = self.increment(key + 1);
        if let Some(link) = self.chain.get_mut(key) {
            link.resolve(next);
        }
        self.stage = Stage::Back { key: key - 1 };
    }

    /// A pose's increment, once it is known.
    fn increment(&self, key: usize) -> [f32; 3] {
        if key + 1 >= self.keys {
            return [0, 1, 2].map(|i| self.system.increment(LAST_POSE + i));
        }
        self.chain.get(key).filter(|_| key > 0).map_or([0.0; 3], |link| link.own)
    }

    /// The share of a step up to which its derivatives hold.
    fn share(&self) -> f32 {
        let turns = (0..self.keys).map(|key| self.increment(key)[2].abs());
        let furthest = turns.fold(0.0, f32::max);
        if furthest > FURTHEST_RAD { FURTHEST_RAD / furthest } else { 1.0 }
    }

    fn apply<const G: usize>(&mut self, diary: &mut Diary<K, G, W>) -> Slice {
        let poses = (0..self.keys).flat_map(|key| self.increment(key));
        let border = (0..self.system.len()).map(|place| self.system.increment(place));
        let mut largest = 0.0f32;
        for value in poses.chain(border) {
            if !value.is_finite() {
                return Slice::Unsolvable;
            }
            largest = largest.max(value.abs());
        }
        let share = self.share();
        let of_border = |place: usize| share * self.system.increment(place);
        let last = self.keys.saturating_sub(1);
        let before = diary.keyframes.get(last).map_or(Pose::ORIGIN, |key| key.pose);
        for (i, key) in diary.keyframes.iter_mut().enumerate().take(self.keys) {
            let [x, y, theta] = self.increment(i).map(|value| share * value);
            key.pose = Pose::new(key.pose.x_m + x, key.pose.y_m + y, key.pose.theta_rad + theta);
        }
        let after = diary.keyframes.get(last).map_or(Pose::ORIGIN, |key| key.pose);
        for key in diary.keyframes.iter_mut().skip(self.keys) {
            key.pose = after.compose(&relative(&before, &key.pose));
        }
        diary.calibration.distance += of_border(DISTANCE);
        diary.calibration.turn += of_border(TURN);
        diary.calibration.veer_rad_per_m += of_border(VEER);
        for (number, gain) in diary.gains.values.iter_mut().enumerate() {
            *gain += of_border(GAINS + number);
        }
        diary.alpha_rad = diary.alpha_rad.map(|alpha| wrap(alpha + of_border(ALPHA)));
        for (wall, position) in diary.walls.iter_mut().zip(self.order) {
            if let (Some(wall), Some(position)) = (wall, position) {
                let place = WALLS + 2 * usize::from(position);
                wall.shift(of_border(place), of_border(place + 1));
            }
        }
        Slice::Moved(largest)
    }
}
