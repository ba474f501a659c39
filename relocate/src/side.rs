//! A wall of a map, turned onto the map's grid: a position across one axis and an extent along the other.

use core::f32::consts::FRAC_PI_2;

use heapless::Vec;
use slam_core::angle::{sin_cos, wrap};
use slam_core::kept::{Kept, KeptWall};

/// The index of the state that is the grid's direction.
pub(crate) const ALPHA: usize = 3;

/// A wall that stands farther off the grid than this is askew, radians: three degrees.
pub(crate) const OFF_GRID_RAD: f32 = 0.05;

/// The direction of an askew wall is known this well, 1-sigma, radians, or it is not matched: two degrees.
const KNOWN_RAD: f32 = 0.035;

/// Directions of one askew wall in two maps differ by no more, radians: two sigmas of both.
const ALIKE_RAD: f32 = 0.1;

/// Between the directions of the grid, where what is askew to one is taken for askew to the next, radians: not halfway, where walls stand
/// across corners.
const BETWEEN_RAD: f32 = 0.65;

/// A wall that fewer readings met may be noise.
const LEAST_UPDATES: u32 = 10;

/// A wall is no shorter than this, metres.
const SHORTEST_M: f32 = 0.25;

/// A wall beside a grid whose first direction is x. Its normal points away from the side that it is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Identifier in its map.
    pub id: u16,
    /// Direction of its normal: x, y, -x, -y for 0 to 3.
    pub facing: u8,
    /// How far its normal is turned from that, radians; zero where it is on the grid.
    pub askew_rad: f32,
    /// The state that is its direction, where it is askew.
    pub beta: u16,
    /// The state that is the distance of its line from the map's origin.
    pub rho: u16,
    /// Where its line cuts the axis that its normal is along, metres; of an askew one, where its middle is along it.
    pub at_m: f32,
    /// Its extent along the other axis, metres; of an askew one, as if it were turned about its middle onto the grid.
    pub extent_m: [f32; 2],
}

/// Whether too few readings met a wall, or it is too short.
pub(crate) fn may_be_noise(wall: &KeptWall) -> bool {
    wall.updates < LEAST_UPDATES || wall.hi_m - wall.lo_m < SHORTEST_M
}

impl Side {
    /// The wall at a place of a map; none where it may be noise, or is askew, who knows how much.
    fn of(kept: &dyn Kept, wall: &KeptWall) -> Option<Self> {
        let [rho_m, beta_rad] = kept.line(wall);
        let off = wrap(beta_rad - kept.mean(ALPHA));
        let quarters = libm::floorf((off + BETWEEN_RAD) * (1.0 / FRAC_PI_2));
        let askew_rad = wrap(off - quarters * FRAC_PI_2);
        let is_askew = askew_rad.abs() > OFF_GRID_RAD;
        let beta = wall.direction.turns_with() as u16;
        if may_be_noise(wall) || is_askew && direction_rad2(kept, beta) > KNOWN_RAD * KNOWN_RAD {
            return None;
        }
        let facing = (quarters as i32 & 3) as u8;
        // Its middle: a wall that is a little askew is turned about it onto the grid.
        let middle_m = 0.5 * (wall.lo_m + wall.hi_m);
        let (s, c) = sin_cos(askew_rad);
        let (across_m, along_m) = (c * rho_m - s * middle_m, s * rho_m + c * middle_m);
        let half_m = 0.5 * (wall.hi_m - wall.lo_m);
        // The normal of facing k is that of 0, turned k times; so is the direction along the wall.
        let (sign, along_sign) = [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)][usize::from(facing)];
        Some(Self {
            id: wall.id,
            facing,
            askew_rad: if is_askew { askew_rad } else { 0.0 },
            beta,
            rho: wall.rho,
            at_m: sign * across_m,
            extent_m: [along_sign * along_m - half_m, along_sign * along_m + half_m],
        })
    }

    /// Length, metres.
    pub fn length_m(&self) -> f32 {
        self.extent_m[1] - self.extent_m[0]
    }

    /// Whether it is taken for one on the grid.
    pub(crate) fn is_on_grid(&self) -> bool {
        self.askew_rad == 0.0
    }

    /// Its length, and far more where it is on the grid: askew ones are matched after those, where there is room.
    pub(crate) fn rank_m(&self) -> f32 {
        self.length_m() + if self.is_on_grid() { 1000.0 } else { 0.0 }
    }

    /// The axis that its normal is along: 0 for x.
    pub fn axis(&self) -> usize {
        usize::from(self.facing & 1)
    }

    /// How `at_m` goes with the distance of its line from the map's origin.
    pub(crate) fn sign(&self) -> f32 {
        if self.facing < 2 { 1.0 } else { -1.0 }
    }

    /// Where its middle is, metres.
    pub(crate) fn middle_m(&self) -> [f32; 2] {
        let along_m = 0.5 * (self.extent_m[0] + self.extent_m[1]);
        if self.axis() == 0 { [self.at_m, along_m] } else { [along_m, self.at_m] }
    }

    /// The unit vector along which distances from its line are counted: that of its axis, turned as far as it is askew.
    pub(crate) fn across(&self) -> [f32; 2] {
        let (s, c) = if self.is_on_grid() { (0.0, 1.0) } else { sin_cos(self.askew_rad) };
        if self.axis() == 0 { [c, s] } else { [-s, c] }
    }

    /// How far a point is from its line, metres.
    pub(crate) fn off_m(&self, point_m: [f32; 2]) -> f32 {
        dot(self.across(), self.middle_m()) - dot(self.across(), point_m)
    }

    /// Whether the directions of two may be one; one on the grid and one askew are two.
    pub(crate) fn is_parallel(&self, other: &Self) -> bool {
        let is_alike = (self.askew_rad - other.askew_rad).abs() < ALIKE_RAD && self.is_on_grid() == other.is_on_grid();
        is_alike && self.axis() == other.axis()
    }

    /// Whether it may be another map's wall.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.facing == other.facing && self.is_parallel(other)
    }

    /// Turned about the origin by a quarter turn, counter-clockwise.
    pub fn turned(&self) -> Self {
        // (x, y) becomes (-y, x): what cut x cuts y; what cut y cuts -x.
        let mut side = *self;
        let [lo_m, hi_m] = self.extent_m;
        if self.axis() == 0 {
            side.extent_m = [-hi_m, -lo_m];
        } else {
            side.at_m = -self.at_m;
        }
        side.facing = (self.facing + 1) & 3;
        side
    }
}

/// Walls across one axis that are nearer to each other than this have one origin, metres: a wall between rooms has two
/// faces, and doors and furniture cut one face into several walls.
pub(crate) const ORIGIN_M: f32 = 0.15;

/// Whether two walls of a map are of one origin.
pub(crate) fn is_one(a: &Side, b: &Side) -> bool {
    a.is_parallel(b) && a.off_m(b.middle_m()).abs() < ORIGIN_M
}

/// The scalar product of two vectors.
pub(crate) fn dot(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

/// Variance of a direction against the grid's.
fn direction_rad2(kept: &dyn Kept, beta: u16) -> f32 {
    let beta = usize::from(beta);
    kept.covariance(beta, beta) - 2.0 * kept.covariance(beta, ALPHA) + kept.covariance(ALPHA, ALPHA)
}

/// Covariance of how far two walls of a map are off where they are, as both are counted across their axes. An askew wall that turns
/// against the grid about the map's origin moves its middle, too.
pub(crate) fn covariance_m2(kept: &dyn Kept, a: &Side, b: &Side) -> f32 {
    if a.is_on_grid() && b.is_on_grid() {
        // Mostly, and at a third of the cost.
        return a.sign() * b.sign() * kept.covariance(usize::from(a.rho), usize::from(b.rho));
    }
    let states = |side: &Side| {
        let [x, y] = side.across();
        let arm_m = if side.is_on_grid() { 0.0 } else { dot([-y, x], side.middle_m()) };
        [(usize::from(side.rho), side.sign()), (usize::from(side.beta), -arm_m), (ALPHA, arm_m)]
    };
    let is_part = |part: &(usize, f32)| part.1 != 0.0;
    let of = |(i, by_i): (usize, f32)| {
        let parts = states(b).into_iter().filter(is_part);
        by_i * parts.map(|(j, by_j)| by_j * kept.covariance(i, j)).sum::<f32>()
    };
    states(a).into_iter().filter(is_part).map(of).sum()
}

/// The walls of a map that has a grid, those on it and the longest where there is no room for all.
pub fn sides<const N: usize>(kept: &dyn Kept) -> Vec<Side, N> {
    let mut found = Vec::new();
    find_sides(kept, f32::INFINITY, &mut found);
    found
}

/// The same in place, without walls that the robot met longer ago than so much path, metres. Of a kept map that is not known, and all count.
pub(crate) fn find_sides<const N: usize>(kept: &dyn Kept, within_m: f32, found: &mut Vec<Side, N>) {
    found.clear();
    let frame = kept.frame();
    if !frame.has_grid {
        return;
    }
    let is_of_late = |i: &usize| kept.unseen_m(*i).is_none_or(|path_m| path_m < within_m);
    let walls = (0..usize::from(frame.walls)).filter(is_of_late).filter_map(|i| kept.wall(i));
    for side in walls.filter_map(|wall| Side::of(kept, &wall)) {
        if let Err(side) = found.push(side) {
            let least = found.iter_mut().min_by(|a, b| a.rank_m().total_cmp(&b.rank_m()));
            if let Some(least) = least.filter(|least| least.rank_m() < side.rank_m()) {
                *least = side;
            }
        }
    }
}

/// A point of a map's frame, turned onto its grid of direction `alpha_rad`.
pub fn path_on_grid(point_m: [f32; 2], alpha_rad: f32) -> [f32; 2] {
    let (s, c) = sin_cos(alpha_rad);
    [c * point_m[0] + s * point_m[1], c * point_m[1] - s * point_m[0]]
}

/// Turned about the origin by so many quarter turns, counter-clockwise.
pub(crate) fn turned_point([x, y]: [f32; 2], quarters: u8) -> [f32; 2] {
    match quarters & 3 {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}
