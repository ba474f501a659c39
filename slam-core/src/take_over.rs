//! Taking over what a look back found: its joint estimate becomes the filter's, unless there is a reason against it.
//!
//! Pose, grid, the drive's calibration, the sensors' gains and walls become those of the hand-over, which has all the motion and all the readings
//! up to the present but those of its last second or so. What is not part of it stays: the age of readings, whose error is taken
//! for independent of the rest from then on; walls that were born since, as they lie to the robot; readings that wait to become
//! walls, which are in the frame of dead reckoning.

mod links;

use heapless::Vec;

use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::{self, ALPHA, THETA, X, Y};
use crate::geometry::angle::{normal, sin_cos, wrap};
use crate::geometry::pose::Pose;
use crate::hand_over::{self, HandOver, PlacedWall};
use crate::jolts::Jolts;
use crate::motion::drive::DriveStates;
use crate::report::NotTaken;
use crate::rig::DriveModel;
use crate::slam::Slam;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::MapView;
use crate::walls::wall::{Direction, Wall, WallPolicy};
use links::{Link, MOST_LINKS, MOST_WALLS, NONE, link};

/// A wall met within this length of path is in view, metres: about the range of the sensors.
const IN_VIEW_M: f32 = 3.0;

/// A wall that so many readings met is known to the filter itself.
const KNOWN_AFTER: u32 = 10;

/// Where the filter and the look back see a wall from the robot may differ by five sigma: the errors of both go together.
const GATE: f32 = 25.0;

/// A look back whose pose has so many times the filter's variance lacks what the filter saw last.
const LESS_SURE: f32 = 2.0;

/// Beyond what either knows, walls are not flat to this, metres, and not straight to this, radians.
const FLUSH_M: f32 = 0.005;
const STRAIGHT_RAD: f32 = 0.01;

/// Walls born since that are kept.
const MOST_NEWBORN: usize = 8;

/// A line as it lies to a pose: distance along its normal, metres, and the normal's direction, radians.
fn seen_from(pose: &Pose, rho_m: f32, beta_rad: f32) -> (f32, f32) {
    let (s, c) = sin_cos(beta_rad);
    (rho_m - pose.x_m * c - pose.y_m * s, wrap(beta_rad - pose.theta_rad))
}

/// Where a pose is along a line, metres.
fn along(pose: &Pose, beta_rad: f32) -> f32 {
    let (s, c) = sin_cos(beta_rad);
    pose.y_m * c - pose.x_m * s
}

/// Variances of a line's distance and direction as the filter sees it from the robot, and their covariance.
fn known_from_robot(wall: &Wall, ekf: &EkfView, beta_rad: f32) -> [f32; 3] {
    let (s, c) = sin_cos(beta_rad);
    let direction = wall.direction.state().unwrap_or(ALPHA);
    let distance = [(X, -c), (Y, -s), (wall.rho(), 1.0), (direction, -along(&layout::pose(ekf), beta_rad))];
    let turn = [(THETA, -1.0), (direction, 1.0)];
    let variance = |entries: Jacobian| ekf.variance(&entries).max(0.0);
    let known = [variance(distance.into_iter().collect()), variance(turn.into_iter().collect())];
    let both = variance(distance.into_iter().chain(turn).collect());
    [known[0], known[1], 0.5 * (both - known[0] - known[1])]
}

/// The place about which a wall is turned, metres.
fn anchor_m(placed: &PlacedWall) -> [f32; 2] {
    let (s, c) = sin_cos(placed.beta_rad);
    [placed.rho_m * c - placed.anchor_m * s, placed.rho_m * s + placed.anchor_m * c]
}

/// A wall that the look back does not know yet, as it lies to the robot.
struct Newborn {
    id: u16,
    distance_m: f32,
    turn_rad: f32,
    /// Variances of the two, and their covariance.
    known: [f32; 3],
    extent_m: [f32; 2],
}

impl Newborn {
    fn of(wall: &Wall, ekf: &EkfView) -> Self {
        let (pose, line) = (layout::pose(ekf), wall.line(ekf, &ManhattanFrame::of(ekf)));
        let (distance_m, turn_rad) = seen_from(&pose, line.rho_m, line.beta_rad);
        let here_m = along(&pose, line.beta_rad);
        let extent_m = [wall.lo_m - here_m, wall.hi_m - here_m];
        Self { id: wall.id, distance_m, turn_rad, known: known_from_robot(wall, ekf, line.beta_rad), extent_m }
    }

    /// Puts it where the robot sees it now; false where there is no room.
    fn put(&self, wall: &mut Wall, ekf: &mut EkfView) -> bool {
        let pose = layout::pose(ekf);
        let on_grid = match wall.direction {
            Direction::Grid(quarter) => Some(ManhattanFrame::of(ekf).beta(quarter)),
            _ => None,
        };
        let beta_rad = on_grid.unwrap_or_else(|| wrap(pose.theta_rad + self.turn_rad));
        let turned_with = if on_grid.is_some() { ALPHA } else { THETA };
        let ((s, c), here_m) = (sin_cos(beta_rad), along(&pose, beta_rad));
        let needed = 1 + usize::from(on_grid.is_none());
        if ekf.len() + needed > ekf.capacity() {
            return false;
        }
        let rho_m = self.distance_m + pose.x_m * c + pose.y_m * s;
        let offset = [(X, c), (Y, s), (turned_with, here_m)].into_iter().collect();
        let [distance_m2, turn_rad2, cross] = self.known;
        let noise = distance_m2 + if on_grid.is_some() { 0.0 } else { here_m * (here_m * turn_rad2 + 2.0 * cross) };
        let rho = ekf.augment(rho_m, &offset, noise).unwrap_or(0);
        let mut add_direction = || {
            let theta = ekf.augment(beta_rad, &[(THETA, 1.0)].into_iter().collect(), turn_rad2).unwrap_or(0);
            ekf.correlate(rho, theta, cross + here_m * turn_rad2);
            theta as u16
        };
        wall.set_rho(rho);
        wall.first_normal = [c, s];
        wall.direction = match wall.direction {
            Direction::Grid(quarter) => Direction::Grid(quarter),
            Direction::NearGrid(_, quarter) | Direction::Built(_, quarter) => {
                Direction::NearGrid(add_direction(), quarter)
            }
            Direction::Free(_) | Direction::Snapped(_) => Direction::Free(add_direction()),
        };
        [wall.lo_m, wall.hi_m] = self.extent_m.map(|end_m| end_m + here_m);
        true
    }
}

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// Takes a hand-over for the filter's estimate. Walls, poses and identifiers that others hold are of another
    /// [`epoch`](Slam::epoch) from then on. One that is refused is counted and changes nothing.
    ///
    /// # Errors
    /// Why it is refused.
    pub fn take_over(&mut self, found: &HandOver) -> Result<(), NotTaken> {
        let judged = self.judge(found);
        self.counters.add_hand_over(judged);
        judged?;
        if found.is_displaced {
            self.counters.add_jolt();
            self.jolts = Jolts::NONE;
        }
        self.replace(found);
        self.slippage.keep();
        self.map.begin_epoch();
        Ok(())
    }

    /// Whether it may be taken.
    fn judge(&self, found: &HandOver) -> Result<(), NotTaken> {
        // The walls that are in doubt went from a map that is about to be forgotten; they are not to come back before it is kept.
        if found.epoch != self.epoch() || self.is_about_to_forget() {
            return Err(NotTaken::Outdated);
        }
        let is_snapped = matches!(self.config.walls.policy, WallPolicy::Snapped { .. });
        if is_snapped || found.walls.len() > MOST_WALLS {
            return Err(NotTaken::Unsupported);
        }
        if !found.is_sound() {
            return Err(NotTaken::Unsound);
        }
        let path_m = self.drive.dead_reckoning.path_m;
        let in_view = |wall: &&Wall| wall.updates >= KNOWN_AFTER && path_m - wall.seen_at_m < IN_VIEW_M;
        let (mut known, mut apart) = (0, 0);
        for wall in self.map.walls().iter().filter(in_view) {
            let Some(index) = found.wall_named(wall.id) else { continue };
            known += 1;
            apart += usize::from(!self.agrees(wall, found, index));
        }
        // The filter knows best how what it sees now lies to the robot.
        if 2 * apart > known {
            return Err(NotTaken::Apart);
        }
        let [x, y, theta] = [X, Y, THETA].map(|i| self.ekf.covariance(i, i));
        let [their_x, their_y, their_theta] =
            [X, Y, THETA].map(|i| found.covariance(hand_over::POSE + i, hand_over::POSE + i));
        let is_less_sure = their_x + their_y > LESS_SURE * (x + y) || their_theta > LESS_SURE * theta;
        if is_less_sure && !found.is_displaced { Err(NotTaken::LessSure) } else { Ok(()) }
    }

    /// Whether a wall lies to the robot as a hand-over has it.
    fn agrees(&self, wall: &Wall, found: &HandOver, index: usize) -> bool {
        let Some(placed) = found.walls.get(index) else { return false };
        let (pose, line) = (layout::pose(&self.ekf), wall.line(&self.ekf, &ManhattanFrame::of(&self.ekf)));
        let (own_m, own_rad) = seen_from(&pose, line.rho_m, line.beta_rad);
        let (their_m, their_rad) = seen_from(&found.pose, placed.rho_m, placed.beta_rad);
        let [known_m2, known_rad2, _] = known_from_robot(wall, &self.ekf, line.beta_rad);
        let (s, c) = sin_cos(placed.beta_rad);
        let offset = hand_over::WALLS + 2 * index;
        let arm_m = placed.anchor_m - along(&found.pose, placed.beta_rad);
        let there = [(offset, 1.0), (offset + 1, arm_m), (hand_over::POSE, -c), (hand_over::POSE + 1, -s)];
        let turned = [(offset + 1, 1.0), (hand_over::POSE + 2, -1.0)];
        let [off_m, off_rad] = [their_m - own_m, wrap(their_rad - own_rad)];
        let gate_m2 = GATE * (known_m2 + found.of_sums(&there, &there) + FLUSH_M * FLUSH_M);
        let gate_rad2 = GATE * (known_rad2 + found.of_sums(&turned, &turned) + STRAIGHT_RAD * STRAIGHT_RAD);
        off_m * off_m <= gate_m2 && off_rad * off_rad <= gate_rad2
    }

    pub(crate) fn replace(&mut self, found: &HandOver) {
        let before = layout::pose(&self.ekf);
        let path_m = self.drive.dead_reckoning.path_m;
        let is_new = |wall: &&Wall| found.wall_named(wall.id).is_none() && path_m - wall.seen_at_m < IN_VIEW_M;
        let newborn: Vec<Newborn, MOST_NEWBORN> = self
            .map
            .walls()
            .iter()
            .filter(is_new)
            .take(MOST_NEWBORN)
            .map(|wall| Newborn::of(wall, &self.ekf))
            .collect();
        let base = self.ekf.len() - self.map.walls().iter().map(Wall::states).sum::<usize>();
        for last in (base..self.ekf.len()).rev() {
            self.ekf.remove(last);
        }
        let mut links = Vec::new();
        self.means(found, &newborn, &mut links);
        self.ekf.relate(&links, found);
        for born in &newborn {
            self.map.put(&mut self.ekf, born);
        }
        self.first.pose = layout::pose(&self.ekf);
        self.map.redraw(&self.ekf);
        self.holds.go_with(&before, &found.pose);
    }

    /// Sets the means and allots the walls' states; writes down what each state is of the unknowns.
    fn means(&mut self, found: &HandOver, newborn: &[Newborn], links: &mut Vec<Link, MOST_LINKS>) {
        let mut add = |link| {
            let _ = links.push(link);
        };
        let Pose { x_m, y_m, theta_rad } = found.pose;
        for (state, mean) in [(X, x_m), (Y, y_m), (THETA, theta_rad)] {
            self.ekf.set_mean(state, mean);
            add(link(state, [(hand_over::POSE + state, 1.0), NONE]));
        }
        self.map.has_grid = found.alpha_rad.is_some();
        self.ekf.set_mean(ALPHA, found.alpha_rad.unwrap_or(0.0));
        add(link(ALPHA, [(hand_over::ALPHA, if self.map.has_grid { 1.0 } else { 0.0 }), NONE]));
        for (state, mean, terms) in calibration(&self.rig.drive, &self.drive.states, found) {
            self.ekf.set_mean(state, mean);
            add(link(state, terms));
        }
        for (i, (sensor, gain)) in self.sensors.iter().zip(found.gains).enumerate() {
            if let Some(state) = sensor.gain_state() {
                self.ekf.set_mean(state, gain);
                add(link(state, [(hand_over::GAINS + i, 1.0), NONE]));
            }
        }
        let is_new = |id: u16| newborn.iter().any(|born| born.id == id);
        self.map.keep_one_of_each(found, is_new);
        let policy = self.config.walls.policy;
        self.map.allot(&mut self.ekf, found, policy, &mut add);
    }
}

/// The drive's calibration states, their means and what they are of the unknowns. A wheel's scale is that of distance, less or
/// more by the veer over half a track; the track's factor is that of distance over that of turning.
fn calibration(
    drive: &DriveModel,
    states: &DriveStates,
    found: &HandOver,
) -> impl Iterator<Item = (usize, f32, [(usize, f32); 2])> + use<> {
    let hand_over::Calibration { distance, turn, veer_rad_per_m: veer } = found.calibration;
    let rows = match *drive {
        DriveModel::Wheels { track_m, .. } => {
            let side = |half_m: f32| {
                let factor = 1.0 + veer * half_m;
                (distance * factor, [(hand_over::DISTANCE, factor), (hand_over::VEER, distance * half_m)])
            };
            let track = [(hand_over::DISTANCE, 1.0 / turn), (hand_over::TURN, -distance / (turn * turn))];
            [side(-0.5 * track_m), side(0.5 * track_m), (distance / turn, track)]
        }
        DriveModel::Odometry { .. } => {
            let per_metre = turn / distance;
            [
                (distance, [(hand_over::DISTANCE, 1.0), NONE]),
                (turn, [(hand_over::TURN, 1.0), NONE]),
                (per_metre * veer, [(hand_over::VEER, per_metre), NONE]),
            ]
        }
    };
    states.in_order().into_iter().zip(rows).filter_map(|(state, (mean, terms))| Some((state?, mean, terms)))
}

impl MapView {
    /// Of the walls that the look back found to be one, keeps the one that most readings met; of the others those born since.
    fn keep_one_of_each(&mut self, found: &HandOver, is_new: impl Fn(u16) -> bool) {
        let mut kept: Vec<(u8, u16, u32), MOST_WALLS> = Vec::new();
        for wall in self.walls() {
            let Some(index) = found.wall_named(wall.id).and_then(|index| u8::try_from(index).ok()) else { continue };
            match kept.iter_mut().find(|(other, ..)| *other == index) {
                Some(best) if best.2 < wall.updates => *best = (index, wall.id, wall.updates),
                Some(_) => {}
                None => {
                    let _ = kept.push((index, wall.id, wall.updates));
                }
            }
        }
        self.retain(|wall| is_new(wall.id) || kept.iter().any(|(_, id, _)| *id == wall.id));
    }

    /// Gives every wall of the hand-over that is seen well enough its states, those that the filter does not have any more, too,
    /// while there is room.
    fn allot(&mut self, ekf: &mut EkfView, found: &HandOver, policy: WallPolicy, add: &mut impl FnMut(Link)) {
        let grid = ManhattanFrame::of(ekf);
        for (index, placed) in found.walls.iter().enumerate() {
            let names = found.names.iter().filter(|(_, wall)| usize::from(*wall) == index);
            let known = names.filter_map(|(name, _)| self.walls().iter().position(|wall| wall.id == *name)).min();
            let quarter =
                (placed.on_grid && self.has_grid && policy != WallPolicy::Free).then(|| grid.quarter(placed.beta_rad));
            // Which walls stand on the grid exactly the filter decides, by the covariance that it takes over, too.
            let direction = known.and_then(|known| self.walls().get(known)).map(|wall| wall.direction);
            let is_exact = policy == WallPolicy::Grid && matches!(direction, Some(Direction::Grid(_)));
            let needed = 1 + usize::from(quarter.is_none() || !is_exact);
            let has_room = ekf.len() + needed <= ekf.capacity() && (known.is_some() || !self.is_full());
            if placed.hits < KNOWN_AFTER || !has_room {
                if let Some(known) = known {
                    self.drop(known);
                }
                continue;
            }
            // A wall on an exact grid is turned about its anchor until it stands on it.
            let (rho_m, lever_m) = match quarter {
                Some(quarter) if is_exact => {
                    let ([x, y], [x_m, y_m]) = (grid.normal(quarter), anchor_m(placed));
                    (x * x_m + y * y_m, -y * x_m + x * y_m)
                }
                _ => (placed.rho_m, placed.anchor_m),
            };
            let mut allot = |mean| ekf.augment(mean, &Jacobian::new(), 0.0).unwrap_or(0);
            let (rho, offset) = (allot(rho_m), hand_over::WALLS + 2 * index);
            let direction = match quarter {
                Some(quarter) if is_exact => Direction::Grid(quarter),
                Some(quarter) => Direction::NearGrid(allot(placed.beta_rad) as u16, quarter),
                None => Direction::Free(allot(placed.beta_rad) as u16),
            };
            let turned_with = if direction.state().is_some() { offset + 1 } else { hand_over::ALPHA };
            add(link(rho, [(offset, 1.0), (turned_with, lever_m)]));
            if let Some(theta) = direction.state() {
                add(link(theta, [(offset + 1, 1.0), NONE]));
            }
            self.place(known, placed, rho, direction);
        }
    }

    fn place(&mut self, known: Option<usize>, placed: &PlacedWall, rho: usize, direction: Direction) {
        let (lo_m, hi_m, first_normal) = (placed.lo_m, placed.hi_m, normal(placed.beta_rad));
        let index = match known {
            Some(index) => index,
            None => {
                let wall = Wall { first_normal, ..Wall::at(rho, direction, (lo_m, hi_m)) };
                self.add(wall, placed.hits, f32::NEG_INFINITY);
                return self.rename_last(placed.id);
            }
        };
        if let Some(wall) = self.wall_mut(index) {
            wall.set_rho(rho);
            (wall.direction, wall.lo_m, wall.hi_m, wall.first_normal) = (direction, lo_m, hi_m, first_normal);
        }
    }

    /// Puts a wall that was born since where the robot sees it; there may be no room.
    fn put(&mut self, ekf: &mut EkfView, born: &Newborn) {
        let Some(index) = self.walls().iter().position(|wall| wall.id == born.id) else { return };
        if let Some(wall) = self.wall_mut(index)
            && !born.put(wall, ekf)
        {
            self.drop(index);
        }
    }
}
