//! What a line is: on the grid, off it, or not clear yet (Rousse & Qiu 3.3).

use crate::births::askew::{Among, among};
use crate::births::local_line::LocalLine;
use crate::filter::ekf::EkfView;
use crate::filter::layout::{ALPHA, THETA};
use crate::geometry::angle::wrap;
use crate::walls::decision::{self, GRID_SHARE, SHORT_SHARE, decide, looseness};
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::wall::{Wall, WallPolicy};

/// Largest sigma of the direction of a free line, or of one that tells of the heading, relative to the robot that saw it,
/// radians: two degrees. What the heading is not known by is the heading's: walls that are seen under it share it, and are
/// known relative to one another.
const DIRECTION_SIGMA: f32 = 0.035;

/// Shortest free wall, metres: a few points from around a corner turn a line of half the length by ten degrees, and no
/// grid is there to tell.
const FREE_LENGTH_M: f32 = 0.5;

/// Shortest free wall where there is an exact grid, metres: what is shorter may be two sides of a thing, or a side and a
/// chair leg, and turns the heading.
const ASKEW_LENGTH_M: f32 = 1.0;

/// Length below which a line may be furniture or a row of things, metres.
pub const SHORT_M: f32 = 0.75;

/// Fewest points of a free wall.
const FREE_POINTS: u32 = 8;

/// Length of path within which two lines off the grid by the same angle show that the heading is off, metres: over a
/// longer one the heading itself wanders.
const TOGETHER_M: f32 = 10.0;

/// Least distance between two such lines, metres: nearer ones may be two sides of one thing that stands askew.
const APART_M: f32 = 1.5;

/// Heading sigma against the grid from which on one line does not tell that it stands on it, radians: four degrees. Beyond it
/// the density of the grid's directions is less than nine times that of any other, which is the share of walls on the grid.
const VAGUE_RAD: f32 = 0.07;

/// Largest angle of such lines off the grid, in standard deviations of the heading.
const SIGMAS: f32 = 4.0;

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Not yet clear; more points will tell.
    Wait,
    /// On the grid, this many quarter turns from alpha.
    OnGrid(u8),
    /// On the grid but for a deviation of its own of this variance, rad^2.
    NearGrid(u8, f32),
    /// Off the grid, or there is none in this policy.
    Free,
    /// Off the grid, along or across the wall whose direction this state is, which is so far from the line's, radians.
    Askew(u16, f32),
    /// The snapped wall of Rousse & Qiu.
    Snapped,
}

/// How a line stands to the grid.
#[derive(Clone, Copy, Debug)]
struct Lean {
    /// Angle from the nearest grid direction, radians.
    off_rad: f32,
    /// Variance of the line's direction, rad^2, and the part of it that is of the readings alone.
    variance: f32,
    seen_variance: f32,
    /// That grid direction, in quarter turns from alpha.
    quarter: u8,
    /// Centroid in the frame of dead reckoning, metres.
    seen_m: [f32; 2],
    /// Path length when it was seen, metres.
    path_m: f32,
}

/// The last line that may have been off the grid because the heading was.
#[derive(Clone, Copy, Debug)]
pub struct Doubts(Option<Lean>);

impl Doubts {
    /// None yet.
    pub const NONE: Self = Self(None);

    /// The path is counted anew from what it is by now, metres.
    pub fn count_anew(&mut self, path_m: f32) {
        if let Some(line) = &mut self.0 {
            line.path_m -= path_m;
        }
    }

    /// Whether this line and the last one agree on how far the heading is off, its variance against the grid being
    /// `heading`. Each alone may well stand askew; that two walls of different directions do so by the same angle is less
    /// likely than that the robot does not know its own. The angle between the two must be known as well as that of walls
    /// that found a grid: of vague lines some agree by chance, and the heading turns with them.
    fn agree(&mut self, line: Lean, heading: f32) -> bool {
        let possible = line.off_rad * line.off_rad < SIGMAS * SIGMAS * heading;
        if !possible || line.seen_variance > DIRECTION_SIGMA * DIRECTION_SIGMA {
            return false;
        }
        let Some(last) = self.0.replace(line) else { return false };
        let is_across = line.quarter != last.quarter && line.path_m - last.path_m < TOGETHER_M;
        let [x, y] = [line.seen_m[0] - last.seen_m[0], line.seen_m[1] - last.seen_m[1]];
        if is_across && x * x + y * y <= APART_M * APART_M {
            // Another side of the same thing tells nothing; the next wall of that direction may.
            self.0 = Some(last);
            return false;
        }
        // Walls as they are built stand off each other by so much, whatever the policy.
        let variance = line.variance + last.variance + 2.0 * decision::deviation(WallPolicy::NearGrid);
        is_across
            && line.seen_variance + last.seen_variance < DIRECTION_SIGMA * DIRECTION_SIGMA
            && decide(line.off_rad - last.off_rad, variance, GRID_SHARE) == Some(true)
    }
}

/// Maximum likelihood between the grid's directions, from which walls have this variance (rad^2), and a free line
/// (Rousse & Qiu 3.3).
pub fn judge(
    ekf: &EkfView,
    policy: WallPolicy,
    grid: Option<&ManhattanFrame>,
    line: &LocalLine,
    walls: &[Wall],
    doubts: &mut Doubts,
) -> Verdict {
    let deviation = decision::deviation(policy);
    // A wall near the grid keeps a direction of its own: nothing is turned by taking one for it.
    let is_exact = grid.is_some() && deviation == 0.0;
    let relative = decision::relative_variance(ekf, THETA, ALPHA);
    // A heading that is known badly tells of no line whether it stands on the grid: each has its own direction until it is known better.
    let is_vague = relative > VAGUE_RAD * VAGUE_RAD;
    let shortest_m = if is_exact && !is_vague { ASKEW_LENGTH_M } else { FREE_LENGTH_M };
    let determined = line.seen_direction_variance < DIRECTION_SIGMA * DIRECTION_SIGMA
        && line.length_m >= shortest_m
        && line.count >= FREE_POINTS;
    let free = if determined { Verdict::Free } else { Verdict::Wait };
    let Some(grid) = grid.filter(|_| policy != WallPolicy::Free) else { return free };
    let theta = ekf.mean(THETA) + line.normal_rad;
    let quarter = grid.quarter(theta);
    let off = wrap(theta - grid.beta(quarter));
    let variance = line.direction_variance + relative + deviation;
    let share = if is_exact && line.length_m < SHORT_M { SHORT_SHARE } else { GRID_SHARE };
    let lean = Lean {
        off_rad: off,
        variance: line.direction_variance,
        seen_variance: line.seen_direction_variance,
        quarter,
        seen_m: line.seen_m,
        path_m: line.path_m,
    };
    let looseness = looseness(policy);
    if policy == WallPolicy::Grid {
        match among(ekf, walls, line, (off, variance, share), ASKEW_LENGTH_M) {
            None | Some(Among::Grid) => {}
            Some(Among::Askew(state, off_rad)) => return Verdict::Askew(state, off_rad),
            Some(Among::Either(apart_rad)) => return Verdict::NearGrid(quarter, looseness.max(apart_rad * apart_rad)),
            Some(Among::Off) => return free,
            Some(Among::Unclear) => return if is_vague { free } else { Verdict::Wait },
        }
    }
    // The method of Rousse & Qiu is left as it is.
    let is_agreed = !matches!(policy, WallPolicy::Snapped { .. }) && doubts.agree(lean, relative);
    let on_grid = if is_agreed { Some(true) } else { decide(off, variance, share) };
    // Nor is it turned by one line: how many walls stand on the grid would decide, not the line.
    let is_vague = is_vague && !is_agreed;
    let on_grid = on_grid.filter(|on_grid| !(*on_grid && is_vague));
    match (on_grid, policy) {
        (Some(true), WallPolicy::Snapped { .. }) => Verdict::Snapped,
        (Some(true), _) => Verdict::NearGrid(quarter, looseness),
        (Some(false), _) => free,
        (None, _) if is_vague => free,
        (None, _) => Verdict::Wait,
    }
}
