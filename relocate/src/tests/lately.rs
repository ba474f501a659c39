//! A fresh map that covers more than the robot met of late.

use slam_core::kept::{Kept, KeptFrame, KeptWall};

use super::{INSIDE, Map, STRAIGHT, WALLS, search_of};
use crate::{LATELY_M, Verdict};

/// A map of a robot that left the far room so much path ago, metres.
struct Left {
    map: Map,
    ago_m: f32,
}

impl Kept for Left {
    fn frame(&self) -> KeptFrame {
        self.map.frame()
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        self.map.wall(index)
    }

    fn unseen_m(&self, index: usize) -> Option<f32> {
        Some(if WALLS[index].3 { self.ago_m } else { 0.0 })
    }

    fn mean(&self, i: usize) -> f32 {
        self.map.mean(i)
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        self.map.covariance(i, j)
    }
}

/// Where a robot is whose fresh map has the far room half a metre off and does not know it.
fn search(ago_m: f32) -> Verdict {
    let bent = Left { map: Map { bend_m: 0.5, sigma_m: 0.01, is_common: true }, ago_m };
    search_of(&bent, &STRAIGHT, &INSIDE)
}

#[test]
fn walls_that_were_left_long_ago_say_nothing_of_where_the_robot_is() {
    let [here, gone] = [LATELY_M - 1.0, LATELY_M + 1.0].map(search);
    assert_eq!([here.walls, gone.walls], [10, 4]);
    assert!(gone.best.quarters == 0 && gone.best.shift_m.iter().all(|shift_m| shift_m.abs() < 0.01), "{gone:?}");
    assert!(gone.log_odds > here.log_odds + 2.0, "a bend that no covariance tells: {here:?} {gone:?}");
}
