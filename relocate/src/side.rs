//! A wall of a map, turned onto the map's grid: a position across one axis and an extent along the other.

use core::f32::consts::FRAC_PI_2;

use heapless::Vec;
use slam_core::angle::{sin_cos, wrap};
use slam_core::kept::{Kept, KeptWall};

/// The index of the state that is the grid's direction.
pub(crate) const ALPHA: usize = 3;

/// A wall that stands farther off the grid than this is not matched, radians: three degrees.
const OFF_GRID_RAD: f32 = 0.05;

/// A wall that fewer readings met may be noise.
const LEAST_UPDATES: u32 = 10;

/// A wall is no shorter than this, metres.
const SHORTEST_M: f32 = 0.25;

/// A wall on a grid whose first direction is x. Its normal points away from the side that it is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Identifier in its map.
    pub id: u16,
    /// Direction of its normal: x, y, -x, -y for 0 to 3.
    pub facing: u8,
    /// The state that is the distance of its line from the map's origin.
    pub rho: u16,
    /// Where its line cuts the axis that its normal is along, metres.
    pub at_m: f32,
    /// Its extent along the other axis, metres.
    pub extent_m: [f32; 2],
}

impl Side {
    /// The wall at a place of a map; none where it stands off the grid or may be noise.
    fn of(kept: &impl Kept, wall: &KeptWall) -> Option<Self> {
        let [rho_m, beta_rad] = kept.line(wall);
        let off = wrap(beta_rad - kept.mean(ALPHA));
        let quarters = libm::roundf(off * (1.0 / FRAC_PI_2));
        let is_wall = wall.updates >= LEAST_UPDATES && wall.hi_m - wall.lo_m >= SHORTEST_M;
        if !is_wall || wrap(off - quarters * FRAC_PI_2).abs() > OFF_GRID_RAD {
            return None;
        }
        let facing = (quarters as i32 & 3) as u8;
        // Its middle: a wall that is a little askew is turned about it onto the grid.
        let middle_m = 0.5 * (wall.lo_m + wall.hi_m);
        let (s, c) = sin_cos(wrap(off - quarters * FRAC_PI_2));
        let (across_m, along_m) = (c * rho_m - s * middle_m, s * rho_m + c * middle_m);
        let half_m = 0.5 * (wall.hi_m - wall.lo_m);
        // The normal of facing k is that of 0, turned k times; so is the direction along the wall.
        let (sign, along_sign) = [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)][usize::from(facing)];
        Some(Self {
            id: wall.id,
            facing,
            rho: wall.rho,
            at_m: sign * across_m,
            extent_m: [along_sign * along_m - half_m, along_sign * along_m + half_m],
        })
    }

    /// Length, metres.
    pub fn length_m(&self) -> f32 {
        self.extent_m[1] - self.extent_m[0]
    }

    /// The axis that its normal is along: 0 for x.
    pub fn axis(&self) -> usize {
        usize::from(self.facing & 1)
    }

    /// How `at_m` goes with the distance of its line from the map's origin.
    pub(crate) fn sign(&self) -> f32 {
        if self.facing < 2 { 1.0 } else { -1.0 }
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
    a.axis() == b.axis() && (a.at_m - b.at_m).abs() < ORIGIN_M
}

/// The walls of a map that stand on its grid, the longest where there is no room for all; none where it has no grid.
pub fn sides<const N: usize>(kept: &impl Kept) -> Vec<Side, N> {
    let mut found = Vec::new();
    find_sides(kept, &mut found);
    found
}

/// The same, in place.
pub(crate) fn find_sides<const N: usize>(kept: &impl Kept, found: &mut Vec<Side, N>) {
    found.clear();
    let frame = kept.frame();
    if !frame.has_grid {
        return;
    }
    let walls = (0..usize::from(frame.walls)).filter_map(|i| kept.wall(i));
    for side in walls.filter_map(|wall| Side::of(kept, &wall)) {
        if let Err(side) = found.push(side) {
            let shortest = found.iter_mut().min_by(|a, b| a.length_m().total_cmp(&b.length_m()));
            if let Some(shortest) = shortest.filter(|shortest| shortest.length_m() < side.length_m()) {
                *shortest = side;
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
