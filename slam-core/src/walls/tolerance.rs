//! How far walls of a home's grid stand off it: not at all, or as walls are built.
//!
//! A wall along the grid is tied to it loosely at first. What readings made of it since then says how much likelier it is that it is to be
//! tied less loosely (the Savage-Dickey density ratio; Dickey 1971), and of all walls together, which of both tolerances the home has.

use crate::filter::ekf::EkfView;
use crate::filter::layout::ALPHA;
use crate::geometry::angle::off_quarter;
use crate::walls::decision::{GRID_TOLERANCE, LOOSE_RAD, relative_variance};
use crate::walls::wall::{Direction, Wall};

/// How far walls of a grid stand off it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tolerance {
    /// They are its direction.
    Exact,
    /// As builders may leave them.
    Built,
}

/// Angle by which built walls stand off their grid, 1-sigma, radians: a third of a degree. Of a wall one metre long 6 mm are allowed, of
/// longer ones less (DIN 18202, table 2).
pub const BUILT_RAD: f32 = 0.006;

/// Log of the odds that walls of a home stand on its grid as exactly as such sensors tell, before any tells: in three homes of four.
const EXACT_HOMES: f32 = 1.1;

/// Walls that tell of it, at most, and the length from which on they do, metres: shorter ones are things that stand as they were put.
const MOST: usize = 12;
const TELLING_M: f32 = 1.0;

/// A wall's direction against the grid's.
#[derive(Clone, Copy, Debug)]
pub struct Deviation {
    /// Its state.
    theta: usize,
    /// How loosely it is tied to the grid, 1-sigma, radians.
    pub tied_rad: f32,
    /// How far it is off, radians.
    pub off_rad: f32,
    /// What that is known to, rad^2.
    pub variance: f32,
}

impl Deviation {
    /// Of a wall that has a direction of its own.
    #[inline(never)]
    pub fn of(ekf: &EkfView, wall: &Wall) -> Option<Self> {
        let theta = wall.direction.state()?;
        let tied_rad = if matches!(wall.direction, Direction::Built(..)) { BUILT_RAD } else { LOOSE_RAD };
        let off_rad = off_quarter(ekf.mean(theta), ekf.mean(ALPHA));
        Some(Self { theta, tied_rad, off_rad, variance: relative_variance(ekf, theta, ALPHA) })
    }

    /// Log of how many times likelier it is to be tied at `to_rad` than as it is; what is tied so is.
    #[inline(never)]
    pub fn rather(&self, to_rad: f32) -> f32 {
        let further = further(self.tied_rad, to_rad);
        let known = further + self.variance;
        // What is known worse than it is tied, as a map that was widened is, says nothing of a looser tie.
        if self.tied_rad == to_rad || further * known <= 0.0 {
            return 0.0;
        }
        log_widths(self.tied_rad, to_rad, known) - 0.5 * self.off_rad * self.off_rad / known
    }

    /// Log of how many times likelier it is to be tied at `to_rad` than loosely.
    #[inline(never)]
    pub fn told(&self, to_rad: f32) -> f32 {
        self.rather(to_rad) - self.rather(LOOSE_RAD)
    }
}

/// Log of the density at its centre of what is so tied over that before, times by how much that of the measurement between both is less
/// where it is known to so much, rad^2.
#[inline(never)]
fn log_widths(from_rad: f32, to_rad: f32, known: f32) -> f32 {
    0.5 * libm::logf(from_rad * from_rad * further(from_rad, to_rad) / (to_rad * to_rad * known))
}

/// Variance of the measurement that ties at `to_rad` what is tied at `from_rad`, rad^2: below zero where it takes a tie back.
pub fn further(from_rad: f32, to_rad: f32) -> f32 {
    1.0 / (1.0 / (to_rad * to_rad) - 1.0 / (from_rad * from_rad))
}

/// Log of the odds that walls along the grid stand as built walls do rather than on it exactly, by their directions.
#[inline(never)]
pub fn built_rather_than_exact(walls: &[Wall], ekf: &EkfView) -> f32 {
    joint(walls, ekf, BUILT_RAD) - joint(walls, ekf, GRID_TOLERANCE) - EXACT_HOMES
}

/// What a wall tells of it, if anything.
#[inline(never)]
fn telling(wall: &Wall, ekf: &EkfView) -> Option<Deviation> {
    wall.direction.quarter().filter(|_| wall.length_m() >= TELLING_M)?;
    let deviation = Deviation::of(ekf, wall)?;
    // What stands askew is of neither kind.
    let known = BUILT_RAD * BUILT_RAD + ekf.covariance(deviation.theta, deviation.theta);
    (deviation.off_rad * deviation.off_rad <= 9.0 * known).then_some(deviation)
}

/// A wall in the Cholesky factor of what the directions of all are known to.
struct Row {
    wall: Deviation,
    factors: [f32; MOST],
    sigma_rad: f32,
    /// What it is off beyond what those before it tell, over that.
    white: f32,
}

/// The same as [`Deviation::rather`] of all walls together: of those that are tied more loosely than that.
#[inline(never)]
fn joint(walls: &[Wall], ekf: &EkfView, to_rad: f32) -> f32 {
    let mut rows: heapless::Vec<Row, MOST> = heapless::Vec::new();
    let mut log = 0.0;
    let telling = walls.iter().filter_map(|wall| telling(wall, ekf));
    for wall in telling.filter(|wall| wall.tied_rad > to_rad).take(MOST) {
        let further = further(wall.tied_rad, to_rad);
        let (mut variance, mut off_rad) = (wall.variance + further, wall.off_rad);
        let mut factors = [0.0; MOST];
        for (i, before) in rows.iter().enumerate() {
            // Of two differences from one direction, by what is known of the three angles.
            let apart = relative_variance(ekf, wall.theta, before.wall.theta);
            let mut covariance = 0.5 * (wall.variance + before.wall.variance - apart);
            for (factor, other) in factors.iter().zip(&before.factors) {
                covariance -= factor * other;
            }
            let factor = covariance / before.sigma_rad;
            variance -= factor * factor;
            off_rad -= factor * before.white;
            if let Some(slot) = factors.get_mut(i) {
                *slot = factor;
            }
        }
        // The measurement's own variance is new in each; less is left by rounding only.
        let variance = variance.max(further);
        let sigma_rad = float::sqrtf(variance);
        let white = off_rad / sigma_rad;
        log += log_widths(wall.tied_rad, to_rad, variance) - 0.5 * white * white;
        let _ = rows.push(Row { wall, factors, sigma_rad, white });
    }
    log
}
