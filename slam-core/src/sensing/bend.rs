//! Walls that bend.
//!
//! The map's walls are straight. Along one that is not, each reading turns the robot a little, all of them the same way and each within its
//! noise, until the heading is off by what the wall bends. Corrections by a straight wall go to both sides: their sum has the variance that
//! they take away (innovations are white: Mehra 1970). A wall whose corrections of the heading add up to more counts for less, be it
//! that it bends, that it is a row of things that are not in line, or that another stands where it ended.

use libm::expf;

/// Path over which corrections add up, metres. Where each is off by half of what the filter expects, which no gate sees, 36 of them are three
/// sigma: as many as two beams make that meet a wall every 0.28 m, as of a robot that drives at that speed and looks once a second.
const MEMORY_M: f32 = 5.0;

/// Walls that are kept account of: those that eight beams meet in a corridor, and two more.
const WALLS: usize = 6;

/// What the walls that were met of late did to the heading; in columns, for a row of each would be padded.
#[derive(Clone, Copy, Debug)]
pub struct Bends {
    path_m: f32,
    walls: [u16; WALLS],
    /// Sum of each one's corrections, radians.
    sums_rad: [f32; WALLS],
    /// Variance that is expected of that, rad^2; zero where there is no wall.
    expected_rad2: [f32; WALLS],
}

impl Bends {
    /// Nothing met.
    pub const NONE: Self = Self { path_m: 0.0, walls: [0; WALLS], sums_rad: [0.0; WALLS], expected_rad2: [0.0; WALLS] };

    /// Factor of the variance with which a reading of this wall is taken, at least 1: the mean of one, which is believed of any wall, and
    /// of the square of what this one turned the robot by over what is expected of it.
    pub fn excess(&self, wall: u16) -> f32 {
        let sums = self.walls.iter().zip(self.sums_rad.iter().zip(&self.expected_rad2));
        let found =
            sums.filter(|(other, (_, expected))| **other == wall && **expected > 0.0).map(|(_, sums)| sums).next();
        let squares = found.map_or(1.0, |(sum, expected)| sum * sum / expected.max(f32::MIN_POSITIVE));
        (0.5 + 0.5 * squares).clamp(1.0, f32::MAX)
    }

    /// The path is counted anew from what it is by now, metres.
    pub fn count_anew(&mut self, path_m: f32) {
        self.path_m -= path_m;
    }

    /// A wall's reading turned the robot by so much, radians, and took so much from the variance of its heading.
    pub fn note(&mut self, wall: u16, path_m: f32, turned_rad: f32, taken_rad2: f32) {
        let driven_m = path_m - self.path_m;
        if driven_m > 0.0 {
            let kept = expf(-driven_m / MEMORY_M);
            // The variance of a sum is that of its terms times the squares of their weights.
            self.sums_rad = self.sums_rad.map(|sum| kept * sum);
            self.expected_rad2 = self.expected_rad2.map(|expected| kept * kept * expected);
            self.path_m = path_m;
        }
        let sums = self.walls.iter_mut().zip(self.sums_rad.iter_mut().zip(&mut self.expected_rad2));
        // The one of which least is known makes room for a new one.
        let rank =
            |(other, (_, expected)): &(&mut u16, (&mut f32, &mut f32))| if **other == wall { -1.0 } else { **expected };
        let Some((other, (sum, expected))) = sums.min_by(|a, b| rank(a).total_cmp(&rank(b))) else { return };
        if *other != wall {
            (*other, *sum, *expected) = (wall, 0.0, 0.0);
        }
        *sum += turned_rad;
        *expected += taken_rad2.max(0.0);
    }
}
