//! Maps of homes that are built askew to their own grid.

use std::vec::Vec;

use slam_core::Pose;
use slam_core::angle::{sin_cos, wrap};
use slam_core::kept::{Direction, Kept, KeptFrame, KeptWall};

use crate::{Progress, Search, Verdict};

/// The states before the walls': the pose, and the grid's direction.
const COMMON: usize = 4;

/// Two walls on the grid, and five askew: direction of the normal, degrees; distance of the line, start and end of the extent, metres.
const WALLS: [[f32; 4]; 7] = [
    [0.0, 2.0, -1.0, 1.5],
    [90.0, 1.5, -2.0, 1.0],
    [45.0, 2.3, -0.8, 0.9],
    [135.0, 1.9, -0.5, 1.0],
    [225.0, 2.6, -1.2, 0.3],
    [315.0, 2.1, -0.7, 0.7],
    [200.0, 2.8, -0.4, 1.1],
];

struct Map {
    walls: Vec<[f32; 4]>,
    alpha_rad: f32,
    direction_rad: f32,
}

impl Map {
    /// These walls in a frame that is turned by this, then moved.
    fn moved(walls: &[[f32; 4]], turn_rad: f32, [x_m, y_m]: [f32; 2]) -> Self {
        let moved = walls.iter().map(|[degrees, rho_m, lo_m, hi_m]| {
            let beta_rad = wrap(degrees.to_radians() + turn_rad);
            let (s, c) = sin_cos(beta_rad);
            let along_m = c * y_m - s * x_m;
            [beta_rad, rho_m + c * x_m + s * y_m, lo_m + along_m, hi_m + along_m]
        });
        Self { walls: moved.collect(), alpha_rad: turn_rad, direction_rad: 0.01 }
    }
}

impl Kept for Map {
    fn frame(&self) -> KeptFrame {
        KeptFrame {
            states: (COMMON + 2 * self.walls.len()) as u16,
            common: COMMON as u16,
            walls: self.walls.len() as u16,
            next_id: self.walls.len() as u16,
            has_grid: true,
            has_dock: false,
            exactness: 0,
            start: Pose::ORIGIN,
            anchor: None,
            number: 0,
        }
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        let [_, _, lo_m, hi_m] = *self.walls.get(index)?;
        let rho = (COMMON + 2 * index) as u16;
        let direction = Direction::Free(rho + 1);
        Some(KeptWall { id: index as u16, rho, direction, lo_m, hi_m, updates: 100, score: 100, drawn: None })
    }

    fn mean(&self, i: usize) -> f32 {
        match i.checked_sub(COMMON) {
            None => [0.0, 0.0, 0.0, self.alpha_rad][i],
            Some(of) => self.walls[of / 2][1 - of % 2],
        }
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        match i.checked_sub(COMMON) {
            Some(of) if i == j && of % 2 == 0 => 1e-4,
            Some(_) if i == j => self.direction_rad * self.direction_rad,
            _ => 0.0,
        }
    }
}

fn search(fresh: &Map, kept: &Map) -> Verdict {
    let mut search = Search::IDLE;
    assert!(search.begin(fresh, kept, &[]), "a map with walls on a grid");
    while search.work(kept, 100) == Progress::Working {}
    search.verdict().expect("a place")
}

#[test]
fn askew_walls_tell_where_a_robot_is() {
    let kept = Map::moved(&WALLS, 0.3, [5.0, -3.0]);
    let fresh = |walls: &[[f32; 4]]| Map {
        alpha_rad: 0.3,
        ..Map::moved(walls, 0.3 - core::f32::consts::FRAC_PI_2, [-1.0, 2.0])
    };
    let all = search(&fresh(&WALLS), &kept);
    assert_eq!((all.best.quarters, all.best.matched), (1, [4, 3]), "{all:?}");
    let without = search(&fresh(&WALLS[..2]), &kept);
    assert!(all.log_odds > without.log_odds + 4.0, "{all:?} {without:?}");
    // Where one stands elsewhere, or is turned, it says nothing for the place.
    for (i, by) in [(0, 20.0), (1, 0.4)] {
        let mut walls = WALLS;
        walls[4][i] += by;
        let other = search(&fresh(&walls), &kept);
        assert!(other.best.matched == [3, 3] && other.log_odds < all.log_odds - 1.0, "{other:?}");
    }
}

#[test]
fn a_line_whose_direction_is_not_known_is_not_asked() {
    let kept = Map::moved(&WALLS, 0.0, [0.0; 2]);
    let vague = Map { direction_rad: 0.1, ..Map::moved(&WALLS, 0.0, [0.0; 2]) };
    let found = search(&vague, &kept);
    assert_eq!((found.walls, found.best.matched), (2, [1, 1]), "{found:?}");
}
