//! A fresh map in a kept one that is bent.

mod askew;
mod copies;
mod displaced;
mod doubts;
mod lately;

use std::vec::Vec;

use slam_core::Pose;
use slam_core::kept::{Direction, Kept, KeptFrame, KeptWall};

use crate::{CLAIM, Progress, Search, Verdict};

/// States before the walls': the pose, and the grid's direction.
const COMMON: usize = 4;

/// Walls of two rooms: direction of the normal in quarter turns, where its line cuts that axis, and its extent (metres); whether it is of
/// the far room.
const WALLS: [(u8, f32, [f32; 2], bool); 10] = [
    (2, 0.0, [0.0, 2.3], false),
    (0, 3.1, [0.0, 1.4], false),
    (3, 0.0, [0.0, 3.1], false),
    (1, 2.3, [0.6, 2.5], false),
    (2, 5.2, [-1.1, 0.7], true),
    (0, 7.4, [1.2, 2.9], true),
    (0, 9.0, [-1.1, 1.2], true),
    (3, -1.1, [5.2, 9.0], true),
    (1, 2.9, [5.6, 7.4], true),
    (1, 1.2, [7.4, 8.8], true),
];

/// A map of those walls.
struct Map {
    /// How far the far room stands off along x, metres.
    bend_m: f32,
    /// How badly the map knows that, 1-sigma, metres, and whether it is the same for all walls there.
    sigma_m: f32,
    is_common: bool,
}

impl Map {
    fn is_bent(i: usize) -> bool {
        let (quarter, _, _, is_far) = WALLS[i];
        is_far && quarter % 2 == 0
    }

    fn sign(i: usize) -> f32 {
        if WALLS[i].0 < 2 { 1.0 } else { -1.0 }
    }
}

impl Kept for Map {
    fn frame(&self) -> KeptFrame {
        KeptFrame {
            states: (COMMON + WALLS.len()) as u16,
            common: COMMON as u16,
            walls: WALLS.len() as u16,
            next_id: WALLS.len() as u16,
            has_grid: true,
            has_dock: true,
            exactness: 0,
            start: Pose::ORIGIN,
            anchor: None,
            number: 0,
        }
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        let (quarter, _, [lo_m, hi_m], is_far) = *WALLS.get(index)?;
        // Extents of walls that face along y are those of the room, which is where it is bent to.
        let by_m = if is_far && quarter % 2 == 1 { self.bend_m } else { 0.0 };
        let [lo_m, hi_m] = [lo_m + by_m, hi_m + by_m];
        // Along (-sin beta, cos beta): y, -x, -y, x.
        let is_turned = matches!(quarter, 1 | 2);
        let [lo_m, hi_m] = if is_turned { [-hi_m, -lo_m] } else { [lo_m, hi_m] };
        Some(KeptWall {
            id: index as u16,
            rho: (COMMON + index) as u16,
            direction: Direction::Grid(quarter),
            lo_m,
            hi_m,
            updates: 100,
            score: 100,
            drawn: None,
        })
    }

    fn mean(&self, i: usize) -> f32 {
        let Some(wall) = i.checked_sub(COMMON) else { return 0.0 };
        let by_m = if Self::is_bent(wall) { self.bend_m } else { 0.0 };
        Self::sign(wall) * (WALLS[wall].1 + by_m)
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        let (Some(a), Some(b)) = (i.checked_sub(COMMON), j.checked_sub(COMMON)) else { return 0.0 };
        // The robot is in the near room and knows that best.
        let own = if a == b { if WALLS[a].3 { 4e-4 } else { 1e-4 } } else { 0.0 };
        let is_shared = Self::is_bent(a) && Self::is_bent(b) && (self.is_common || a == b);
        own + if is_shared { Self::sign(a) * Self::sign(b) * self.sigma_m * self.sigma_m } else { 0.0 }
    }
}

/// A map that is right.
const STRAIGHT: Map = Map { bend_m: 0.0, sigma_m: 0.0, is_common: true };

fn search(kept: &Map, path_m: &[[f32; 2]]) -> Verdict {
    search_of(&STRAIGHT, kept, path_m)
}

fn search_of(fresh: &dyn Kept, kept: &dyn Kept, path_m: &[[f32; 2]]) -> Verdict {
    let mut search = Search::IDLE;
    assert!(search.begin(fresh, kept, path_m), "a map with walls on a grid");
    while search.work(kept, 100) == Progress::Working {}
    search.verdict().expect("a place")
}

const INSIDE: [[f32; 2]; 3] = [[1.0, 1.0], [2.0, 1.5], [2.0, 0.5]];

#[test]
fn walls_that_are_off_alike_are_one_place() {
    let straight = search(&Map { bend_m: 0.0, sigma_m: 0.0, is_common: true }, &INSIDE);
    let bent = search(&Map { bend_m: 0.5, sigma_m: 0.5, is_common: true }, &INSIDE);
    let alone = search(&Map { bend_m: 0.5, sigma_m: 0.5, is_common: false }, &INSIDE);
    let is_right = |verdict: &Verdict| verdict.best.quarters == 0 && verdict.best.shift_m[1].abs() < 0.01;
    let odds: Vec<f32> = [&straight, &bent, &alone].map(|verdict| verdict.log_odds).to_vec();
    assert!(is_right(&straight) && is_right(&bent), "{straight:?} {bent:?}");
    assert!(bent.log_odds > CLAIM && bent.log_odds > alone.log_odds + 4.0, "{odds:?}");
    assert!(straight.log_odds > bent.log_odds, "a bend is no evidence: {odds:?}");
    // A map that does not know that it is bent has half of the walls wrong.
    let sure = search(&Map { bend_m: 0.5, sigma_m: 0.01, is_common: true }, &INSIDE);
    assert!(sure.log_odds < bent.log_odds - 4.0, "{sure:?}");
}

#[test]
fn places_that_differ_by_no_more_than_is_known_count_once() {
    // Seeds of the near room and of the far one differ by half a metre.
    let bent = search(&Map { bend_m: 0.5, sigma_m: 0.5, is_common: true }, &INSIDE);
    assert!(bent.others > bent.log_odds && bent.others > CLAIM, "{bent:?}");
}

#[test]
fn a_path_through_a_wall_counts_as_far_as_the_wall_is_known() {
    let path = |x_m: f32| [[6.0, 2.0], [x_m, 2.0], [6.0, 2.0]];
    let odds = |sigma_m: f32, x_m: f32| {
        let known = Map { bend_m: 0.0, sigma_m, is_common: false };
        search(&known, &path(x_m)).log_odds
    };
    let cost = |sigma_m: f32| odds(sigma_m, 6.5) - odds(sigma_m, 7.8);
    assert!(cost(0.01) > 2.0, "0.4 m behind a wall that is known to 1 cm: {}", cost(0.01));
    assert!(cost(1.0) < 1.0, "behind one that is known to 1 m: {}", cost(1.0));
}
