//! A home that is in one map twice.

use std::vec::Vec;

use slam_core::angle::sin_cos;
use slam_core::kept::{Direction, Kept, KeptFrame, KeptWall};
use slam_core::{Match, SecondCopy};

use super::{COMMON, Map, WALLS};
use crate::copy;
use crate::locator::CLAIM;
use crate::{Progress, Search, Verdict};

/// The walls of [`Map`], and again as a robot draws them that was turned about a point, or pushed along, and not told.
struct Twice {
    once: Map,
    turned_rad: f32,
    about_m: [f32; 2],
    /// How far it was pushed along besides, metres.
    pushed_m: [f32; 2],
    /// How far the walls of the second time are off one after the other, metres: those of another home.
    other_m: f32,
    /// It is beside the walls of the second time.
    is_beside: bool,
}

const HERE: Twice = Twice {
    once: Map { bend_m: 0.0, sigma_m: 0.0, is_common: true },
    turned_rad: 0.25,
    about_m: [2.0, 1.0],
    pushed_m: [0.0; 2],
    other_m: 0.0,
    is_beside: true,
};

impl Twice {
    /// Distance from the origin and direction of the normal of a wall that was drawn again, and how far it is shifted along.
    fn again(&self, i: usize) -> [f32; 3] {
        let wall = self.once.wall(i).expect("one of the walls");
        let [rho_m, beta_rad] = self.once.line(&wall);
        let beta_rad = beta_rad + self.turned_rad;
        // p' = c + R (p - c): what a turn about the origin does, and a shift.
        let ((s, c), [x, y]) = (sin_cos(self.turned_rad), self.about_m);
        let [dx, dy] = self.pushed_m;
        let shift = [x - c * x + s * y + dx, y - s * x - c * y + dy];
        let (sb, cb) = sin_cos(beta_rad);
        let other_m = self.other_m * (i as f32 * 2.4).sin();
        [rho_m + other_m + cb * shift[0] + sb * shift[1], beta_rad, cb * shift[1] - sb * shift[0]]
    }

    fn search(&self) -> Option<Verdict> {
        self.search_since(None)
    }

    /// The same where readings spoke for the robot being elsewhere from this wall on.
    fn search_since(&self, doubted: Option<u16>) -> Option<Verdict> {
        let copy = copy::find(self, doubted)?;
        assert_eq!(usize::from(copy.since), WALLS.len());
        let [fewer, more] = copy::parts(self, &copy)?;
        let mut search = Search::IDLE;
        assert!(search.begin_displaced(&fewer, &more, copy::begins_m(self, &copy)), "walls on a grid");
        while search.work(&more, 100) == Progress::Working {}
        search.verdict()
    }
}

impl Kept for Twice {
    fn frame(&self) -> KeptFrame {
        let once = self.once.frame();
        KeptFrame { states: once.states + 2 * once.walls, walls: 2 * once.walls, next_id: 2 * once.walls, ..once }
    }

    fn unseen_m(&self, index: usize) -> Option<f32> {
        Some(if (index >= WALLS.len()) == self.is_beside { 0.1 } else { 10.0 })
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        let Some(i) = index.checked_sub(WALLS.len()) else { return self.once.wall(index) };
        let wall = self.once.wall(i)?;
        let [.., along_m] = self.again(i);
        let rho = (COMMON + WALLS.len() + 2 * i) as u16;
        let [lo_m, hi_m] = [wall.lo_m + along_m, wall.hi_m + along_m];
        Some(KeptWall { id: index as u16, rho, direction: Direction::Free(rho + 1), lo_m, hi_m, ..wall })
    }

    fn mean(&self, i: usize) -> f32 {
        match i.checked_sub(COMMON + WALLS.len()) {
            None => self.once.mean(i),
            Some(state) => self.again(state / 2)[state % 2],
        }
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        if i.max(j) < COMMON + WALLS.len() {
            return self.once.covariance(i, j);
        }
        if i == j { 1e-4 } else { 0.0 }
    }
}

#[test]
fn walls_drawn_again_askew_lie_in_the_older_ones() {
    let found = HERE.search().expect("a place");
    assert!(found.log_odds > CLAIM, "{found:?}");
    let seeds = found.best.pairs.map(|pair| pair.expect("a wall of each axis"));
    assert!(seeds.iter().all(|&(copy, older)| usize::from(copy) == usize::from(older) + WALLS.len()), "{seeds:?}");
    // A map whose older walls are fewer is the other way round.
    let copy = copy::find(&HERE, None).expect("a copy");
    let parts = copy::parts(&HERE, &copy).expect("two parts");
    assert_eq!(copy::in_older(&parts, found.best.to_match().expect("a match")).pairs, seeds);
}

#[test]
fn a_wing_that_is_built_askew_is_none() {
    let odds: Vec<f32> =
        [0.4, 0.6, 0.8, 1.0].map(|other_m| Twice { other_m, ..HERE }.search().expect("a place").log_odds).to_vec();
    assert!(odds.iter().all(|odds| *odds < 0.5 * CLAIM), "{odds:?}");
}

#[test]
fn nothing_is_displaced_by_metres() {
    // The same walls, ten metres beside: a second flat like the first.
    let beside = Twice { about_m: [2.0, 41.0], ..HERE }.search().expect("a place");
    assert!(beside.log_odds < 0.0, "{beside:?}");
}

#[test]
fn a_robot_that_is_beside_its_older_walls_found_itself_back() {
    assert!(Twice { is_beside: false, ..HERE }.search().is_none());
    assert!(Twice { turned_rad: 0.0, ..HERE }.search().is_none(), "walls on the grid");
}

/// A robot that was pushed along by half a metre.
const PUSHED: Twice = Twice { turned_rad: 0.0, pushed_m: [0.4, -0.3], ..HERE };

/// The first wall that is drawn again.
const AGAIN: u16 = WALLS.len() as u16;

#[test]
fn walls_drawn_again_shifted_lie_in_the_older_ones_where_readings_speak_for_it() {
    let found = PUSHED.search_since(Some(AGAIN)).expect("a place");
    assert!(found.log_odds > CLAIM, "{found:?}");
    let seeds = found.best.pairs.map(|pair| pair.expect("a wall of each axis"));
    assert!(seeds.iter().all(|&(copy, older)| copy == older + AGAIN), "{seeds:?}");
    assert!(PUSHED.search().is_none(), "nothing speaks for it");
    assert!(Twice { is_beside: false, ..PUSHED }.search_since(Some(AGAIN)).is_none(), "it found itself back");
}

#[test]
fn what_is_new_beside_older_walls_is_no_shifted_copy() {
    let odds: Vec<f32> = [0.4, 0.6, 0.8, 1.0]
        .map(|other_m| Twice { other_m, ..PUSHED }.search_since(Some(AGAIN)).expect("a place").log_odds)
        .to_vec();
    assert!(odds.iter().all(|odds| *odds < 0.5 * CLAIM), "{odds:?}");
    // A second flat like the first.
    let beside = Twice { pushed_m: [10.0, 0.0], ..PUSHED }.search_since(Some(AGAIN)).expect("a place");
    assert!(beside.log_odds < 0.0, "{beside:?}");
}

#[test]
fn a_shifted_copy_begins_after_the_walls_that_tell_where_it_lies() {
    let found = Match { quarters: 0, pairs: [(9, 2), (8, 4)] };
    let shifted = SecondCopy { since: 7, grid: None };
    assert_eq!(copy::with_those_between(&shifted, &found).since, 5);
    let turned = SecondCopy { grid: Some(7), ..shifted };
    assert_eq!(copy::with_those_between(&turned, &found), turned);
}
