//! Taking up a kept map: the filter becomes that map, and of the fresh one only the robot's place beside two walls survives.

use crate::filter::ekf::{EkfView, Jacobian};
use crate::filter::layout::{self, ALPHA, THETA, X, Y};
use crate::geometry::angle::{normal, sin_cos, wrap};
use crate::geometry::line::Line;
use crate::geometry::pose::Pose;
use crate::jolts::Jolts;
use crate::kept::{Kept, KeptFrame, KeptWall, POSE_STATES};
use crate::motion::shortfall::Shortfall;
use crate::rig::DriveModel;
use crate::slam::Slam;
use crate::walls::anchor::Anchor;
use crate::walls::decision::relative_variance;
use crate::walls::exactness::Exactness;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::MapFrame;
use crate::walls::wall::{Direction, Wall};
use core::f32::consts::FRAC_PI_2;

/// Two walls at a smaller angle than this do not say where the robot is, as the sine of that angle.
const LEAST_SINE: f32 = 0.5;

/// The robot's distance from a wall that two maps have is known no better than this, metres: 3 mm of mount and surface each,
/// and what was learned of the calibration between the two.
const SAME_WALL_M: f32 = 0.01;

/// What correlates the distances from both walls and the heading in the fresh map is not carried over: their variances are
/// doubled for it.
const DOUBT: f32 = 2.0;

/// How a fresh map lies in a kept one: by two walls of different directions that both have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Match {
    /// Quarter turns, counter-clockwise, from the fresh map's grid to the kept one's.
    pub quarters: u8,
    /// Identifiers of the two walls: fresh, kept.
    pub pairs: [(u16, u16); 2],
}

/// Why a kept map cannot be taken up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unfit {
    /// It has more states or walls than there is room for.
    TooLarge,
    /// Its calibration has other states than this estimator's.
    OtherCalibration,
    /// It has no grid, or the fresh map has none.
    NoGrid,
    /// A wall of the match is not there, or its two walls are parallel.
    NoMatch,
    /// A number of it is none.
    NoNumber,
}

/// Where the robot is beside two walls of the fresh map and along its grid.
pub(crate) struct Beside {
    /// Distances from the walls along their normals, metres, and their covariance.
    distances_m: [f32; 2],
    variance: [[f32; 2]; 2],
    /// Heading against the grid, radians, and its variance.
    heading_rad: f32,
    heading_variance: f32,
}

impl<const S: usize, const W: usize, const B: usize, const ROWS: usize> Slam<S, W, B, ROWS> {
    /// Takes up a kept map in place of its own, where `found` says how its own lies in it. The robot goes on where it is;
    /// what it has learned of its sensors' noise stays.
    ///
    /// # Errors
    /// The kept map is not one that this estimator can go on with; nothing is changed then.
    pub fn take_up(&mut self, kept: &dyn Kept, found: &Match) -> Result<(), Unfit> {
        let frame = kept.frame();
        self.suits(kept)?;
        if !self.map.has_grid {
            return Err(Unfit::NoGrid);
        }
        let beside = self.beside(found, ALPHA).ok_or(Unfit::NoMatch)?;
        let wall_of = |id: u16| (0..usize::from(frame.walls)).filter_map(|i| kept.wall(i)).find(|wall| wall.id == id);
        let [Some(first), Some(second)] = found.pairs.map(|(_, id)| wall_of(id)) else { return Err(Unfit::NoMatch) };
        let pose = Placement::of(kept, [first, second], &beside, found.quarters).ok_or(Unfit::NoMatch)?;
        self.load(kept, &frame);
        self.monitor.begin_map(self.map.next_id());
        self.slippage.keep();
        self.doubt_calibration();
        self.stand(&pose);
        Ok(())
    }

    /// The robot is there; what was seen from elsewhere and waits to say something is forgotten.
    pub(crate) fn stand(&mut self, there: &Placement) {
        there.initialise(&mut self.ekf);
        self.first.pose = layout::pose(&self.ekf);
        self.shortfall = Shortfall::NONE;
        self.candidates.clear();
        self.holds.forget();
        self.jolts = Jolts::NONE;
    }

    /// Whether a kept map is one that this estimator can go on with.
    ///
    /// # Errors
    /// Why it is not.
    pub fn suits(&self, kept: &dyn Kept) -> Result<(), Unfit> {
        let (frame, own) = (kept.frame(), self.frame());
        if usize::from(frame.states) > self.ekf.capacity() || usize::from(frame.walls) > W {
            return Err(Unfit::TooLarge);
        }
        if frame.common != own.common {
            return Err(Unfit::OtherCalibration);
        }
        if !frame.has_grid {
            return Err(Unfit::NoGrid);
        }
        let states = POSE_STATES..usize::from(frame.states);
        let is_number = |i: usize| {
            let variance = kept.covariance(i, i);
            kept.mean(i).is_finite() && variance.is_finite() && variance >= 0.0
        };
        let is_wall = |wall: KeptWall| {
            let has_state = wall.direction.state().is_none_or(|i| states.contains(&i));
            states.contains(&usize::from(wall.rho)) && has_state && wall.lo_m.is_finite() && wall.hi_m.is_finite()
        };
        let walls_hold = (0..usize::from(frame.walls)).all(|i| kept.wall(i).is_some_and(is_wall));
        if walls_hold && states.clone().all(is_number) { Ok(()) } else { Err(Unfit::NoNumber) }
    }

    /// Where the robot is beside the fresh walls of a match, and heads against the direction that is this state; none where a wall is
    /// not there.
    pub(crate) fn beside(&self, found: &Match, direction: usize) -> Option<Beside> {
        let grid = ManhattanFrame::of(&self.ekf);
        let pose = layout::pose(&self.ekf);
        let distance = |id: u16| {
            let wall = self.map.walls().iter().find(|wall| wall.id == id)?;
            let line = wall.line(&self.ekf, &grid);
            // d = rho - p . n(beta)
            let along_m = line.along([pose.x_m, pose.y_m]);
            let mut jacobian = Jacobian::new();
            for entry in [(X, -line.normal[0]), (Y, -line.normal[1])] {
                let _ = jacobian.push(entry);
            }
            let _ = jacobian.push((wall.direction.turns_with(), -along_m));
            let _ = jacobian.push((wall.rho(), 1.0));
            Some((line.distance([pose.x_m, pose.y_m]), jacobian))
        };
        let [(first_m, first), (second_m, second)] = [distance(found.pairs[0].0)?, distance(found.pairs[1].0)?];
        let least = SAME_WALL_M * SAME_WALL_M;
        let [a, b] = [&first, &second].map(|jacobian| DOUBT * self.ekf.variance(jacobian).max(0.0) + least);
        Some(Beside {
            distances_m: [first_m, second_m],
            variance: [[a, 0.0], [0.0, b]],
            heading_rad: wrap(pose.theta_rad - self.ekf.mean(direction)),
            heading_variance: DOUBT * relative_variance(&self.ekf, THETA, direction),
        })
    }

    /// Sensors and wheels may have changed since, as much as the rig says that units differ: dust, wear, warmth.
    fn doubt_calibration(&mut self) {
        let (scale_sigma, third_sigma) = match self.rig.drive {
            DriveModel::Wheels { scale_sigma, track_sigma, .. } => (scale_sigma, track_sigma),
            DriveModel::Odometry { scale_sigma, veer_sigma, .. } => (scale_sigma, veer_sigma),
        };
        let drive = self.drive.states.in_order().into_iter().zip([scale_sigma, scale_sigma, third_sigma]);
        let gains =
            self.sensors.iter().zip(&self.rig.sensors).map(|(sensor, rig)| (sensor.gain_state(), rig.gain_sigma));
        for (state, sigma) in drive.chain(gains) {
            if let Some(i) = state {
                self.ekf.correlate(i, i, sigma * sigma);
            }
        }
    }

    /// Puts the kept states and walls in the place of its own; the pose's are zero.
    fn load(&mut self, kept: &dyn Kept, frame: &KeptFrame) {
        self.map.has_dock = frame.has_dock;
        let Self { ekf, map, drive, config, .. } = self;
        ekf.clear();
        for i in 0..usize::from(frame.states) {
            let (mean, variance) = if i < POSE_STATES { (0.0, 0.0) } else { (kept.mean(i), kept.covariance(i, i)) };
            ekf.augment(mean, &Jacobian::new(), variance);
            for j in POSE_STATES..i {
                ekf.correlate(j, i, kept.covariance(j, i));
            }
        }
        let next_id = map.next_id();
        map.clear(config.walls.frame);
        map.has_grid = frame.has_grid;
        (map.exactness, map.tolerance) = Exactness::of_quarters(frame.exactness);
        if config.walls.frame == MapFrame::Walls {
            map.start = frame.start;
        }
        map.anchor = frame.anchor.map(|(pose, covariance)| Anchor::new(pose, covariance));
        let seen_at_m = drive.dead_reckoning.path_m;
        let walls = (0..usize::from(frame.walls)).filter_map(|i| kept.wall(i));
        // No two walls of a drive have one name.
        let next_id = if next_id.wrapping_sub(frame.next_id) as i16 > 0 { next_id } else { frame.next_id };
        // Its readings are differentiated at where it is now.
        map.restore(walls.map(|wall| restored(&wall, kept.line(&wall)[1], seen_at_m)), next_id);
    }
}

fn restored(kept: &KeptWall, beta_rad: f32, seen_at_m: f32) -> Wall {
    Wall {
        id: kept.id,
        rho: kept.rho,
        direction: match kept.direction {
            Direction::Grid(quarter) => Direction::Grid(quarter & 3),
            Direction::NearGrid(theta, quarter) => Direction::NearGrid(theta, quarter & 3),
            Direction::Built(theta, quarter) => Direction::Built(theta, quarter & 3),
            other => other,
        },
        lo_m: kept.lo_m,
        hi_m: kept.hi_m,
        updates: kept.updates,
        score: kept.score,
        seen_at_m,
        first_normal: normal(beta_rad),
        drawn: kept.drawn,
    }
}

/// The pose in the kept map: its value, its derivatives by the kept states, and its own variance.
pub(crate) struct Placement {
    pose: Pose,
    by_states: [Jacobian; 3],
    own: [[f32; 3]; 3],
}

impl Placement {
    /// The point at these distances from two walls, p . n = rho - d for both, and the heading along the grid; none where the
    /// walls are all but parallel.
    pub(crate) fn of(kept: &dyn Kept, walls: [KeptWall; 2], beside: &Beside, quarters: u8) -> Option<Self> {
        let lines = walls.map(|wall| {
            let [rho_m, beta_rad] = kept.line(&wall);
            let (s, c) = sin_cos(beta_rad);
            Line { rho_m, beta_rad, normal: [c, s] }
        });
        let [[a, b], [c, d]] = [lines[0].normal, lines[1].normal];
        let sine = a * d - b * c;
        if sine.abs() < LEAST_SINE {
            return None;
        }
        // The inverse of the matrix of both normals.
        let inverse = [[d / sine, -b / sine], [-c / sine, a / sine]];
        let offsets = [0, 1].map(|i| lines[i].rho_m - beside.distances_m[i]);
        let point = inverse.map(|row| row[0] * offsets[0] + row[1] * offsets[1]);
        let theta_rad = wrap(kept.mean(ALPHA) + f32::from(quarters & 3) * FRAC_PI_2 + beside.heading_rad);
        let mut by_states = [Jacobian::new(), Jacobian::new(), Jacobian::new()];
        for (wall, (line, column)) in walls.iter().zip(lines.iter().zip([0, 1])) {
            let along_m = line.along(point);
            for (jacobian, row) in by_states.iter_mut().zip(&inverse) {
                let _ = jacobian.push((usize::from(wall.rho), row[column]));
                let _ = jacobian.push((wall.direction.turns_with(), -along_m * row[column]));
            }
        }
        let _ = by_states[2].push((ALPHA, 1.0));
        let mut own = [[0.0; 3]; 3];
        for i in 0..2 {
            for j in 0..2 {
                own[i][j] = inverse[i][0] * inverse[j][0] * beside.variance[0][0]
                    + inverse[i][1] * inverse[j][1] * beside.variance[1][1];
            }
        }
        own[2][2] = beside.heading_variance;
        Some(Self { pose: Pose { x_m: point[0], y_m: point[1], theta_rad }, by_states, own })
    }

    fn initialise(&self, ekf: &mut EkfView) {
        let values = [self.pose.x_m, self.pose.y_m, self.pose.theta_rad];
        for (i, (value, jacobian)) in values.into_iter().zip(&self.by_states).enumerate() {
            ekf.initialise(i, value, jacobian, self.own[i][i]);
        }
        ekf.correlate(X, Y, self.own[0][1]);
    }
}
