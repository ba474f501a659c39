//! The walls of a fresh map with what it knows of them together, as they were when a search began.

use heapless::Vec;
use slam_core::angle::sin_cos;
use slam_core::kept::Kept;

use crate::odds;
use crate::order::descending;
use crate::side::{ALPHA, Side, covariance_m2, find_sides};
use crate::{FRESH_SIDES, LATELY_M};

/// Entries of a symmetric matrix of so many rows, each once.
const ENTRIES: usize = FRESH_SIDES * (FRESH_SIDES + 1) / 2;

/// The states that are the robot's position.
const POSE: [usize; 2] = [0, 1];

/// Variance of rho - n . p.
fn beside_m2(map: &dyn Kept, rho: usize, [x, y]: [f32; 2]) -> f32 {
    let [p, q] = POSE;
    let of_pose = x * x * map.covariance(p, p) + 2.0 * x * y * map.covariance(p, q) + y * y * map.covariance(q, q);
    let of_both = x * map.covariance(p, rho) + y * map.covariance(q, rho);
    (map.covariance(rho, rho) - 2.0 * of_both + of_pose).max(0.0)
}

/// The walls of a fresh map.
#[derive(Clone, Debug)]
pub(crate) struct Fresh {
    /// Turned by so many quarters.
    pub sides: Vec<Side, FRESH_SIDES>,
    pub quarters: u8,
    /// How much each of them counts.
    pub weights: Vec<f32, FRESH_SIDES>,
    /// And how much its ends do, as they are turned.
    pub end_weights: Vec<[f32; 2], FRESH_SIDES>,
    /// Covariance of how far they are off along their normals.
    covariance_m2: Vec<f32, ENTRIES>,
    /// Variance of the robot's distance from each of them.
    beside_m2: Vec<f32, FRESH_SIDES>,
}

impl Fresh {
    pub(crate) const NONE: Self = Self {
        sides: Vec::new(),
        quarters: 0,
        weights: Vec::new(),
        end_weights: Vec::new(),
        covariance_m2: Vec::new(),
        beside_m2: Vec::new(),
    };

    /// Takes in the walls of a map; false where none stands on a grid.
    pub(crate) fn take(&mut self, map: &dyn Kept) -> bool {
        find_sides(map, LATELY_M, &mut self.sides);
        descending(&mut self.sides, Side::rank_m);
        self.quarters = 0;
        odds::weigh(&self.sides, &mut self.weights);
        odds::weigh_ends(&self.sides, &mut self.end_weights);
        self.covariance_m2.clear();
        self.beside_m2.clear();
        let (s, c) = sin_cos(map.mean(ALPHA));
        for (i, a) in self.sides.iter().enumerate() {
            let rho = usize::from(a.rho);
            for b in self.sides.iter().take(i + 1) {
                // There is room for every entry.
                let _ = self.covariance_m2.push(a.sign() * b.sign() * covariance_m2(map, a, b));
            }
            let normal = [[c, s], [-s, c]][a.axis()].map(|part| part * a.sign());
            let _ = self.beside_m2.push(beside_m2(map, rho, normal));
        }
        !self.sides.is_empty()
    }

    /// Turns it by another quarter.
    pub(crate) fn turn(&mut self) {
        self.quarters += 1;
        self.sides.iter_mut().for_each(|side| *side = side.turned());
        odds::weigh_ends(&self.sides, &mut self.end_weights);
    }

    /// Covariance of where two of its walls are across their axes.
    pub(crate) fn covariance_m2(&self, i: usize, j: usize) -> f32 {
        let (low, high) = if i < j { (i, j) } else { (j, i) };
        let sign = |k: usize| self.sides.get(k).map_or(0.0, Side::sign);
        sign(i) * sign(j) * self.covariance_m2.get(high * (high + 1) / 2 + low).copied().unwrap_or(0.0)
    }

    /// Variance of the robot's distance from a wall.
    pub(crate) fn beside_m2(&self, i: usize) -> f32 {
        self.beside_m2.get(i).copied().unwrap_or(0.0)
    }
}
