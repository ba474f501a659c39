//! A fresh map that was begun in the frame of the kept one, since readings contradicted that.

use slam_core::Pose;
use slam_core::kept::{Kept, KeptFrame, KeptWall};

use super::{INSIDE, Map, STRAIGHT};
use crate::odds::{self, Displaced};
use crate::{Progress, Search, Verdict};

/// A map whose frame lies there in that of the drive's start.
struct Begun {
    map: Map,
    at: Pose,
}

impl Kept for Begun {
    fn frame(&self) -> KeptFrame {
        KeptFrame { anchor: Some((self.at, [[0.0; 3]; 3])), ..self.map.frame() }
    }

    fn wall(&self, index: usize) -> Option<KeptWall> {
        self.map.wall(index)
    }

    fn mean(&self, i: usize) -> f32 {
        self.map.mean(i)
    }

    fn covariance(&self, i: usize, j: usize) -> f32 {
        self.map.covariance(i, j)
    }
}

/// A search of a robot that its map has so far off, in this way; of one of whom that is not asked without it.
fn search(off: Option<Pose>, by: Displaced) -> Verdict {
    search_from(Pose::ORIGIN, off, by)
}

/// The same of one that was switched on at this place of its kept map.
fn search_from(start: Pose, off: Option<Pose>, by: Displaced) -> Verdict {
    // Both frames lie somewhere in that of the start.
    let kept = Begun { map: STRAIGHT, at: Pose::new(3.0, -1.0, 0.7) };
    let fresh = Begun { map: STRAIGHT, at: start.inverse().compose(&kept.at).compose(&off.unwrap_or(Pose::ORIGIN)) };
    let mut search = Search::IDLE;
    assert!(search.begin(&fresh, &kept, &INSIDE), "a map with walls on a grid");
    if off.is_some() {
        search.expect_near([&fresh, &kept], &start, by);
    }
    while search.work(&kept, 100) == Progress::Working {}
    search.verdict().expect("a place")
}

#[test]
fn a_place_near_the_old_one_is_likelier_and_any_other_half_as_likely() {
    let anywhere = search(None, odds::CONTRADICTED);
    let gain = |x_m: f32, turned_deg: f32| {
        let verdict = search(Some(Pose::new(x_m, 0.0, turned_deg.to_radians())), odds::CONTRADICTED);
        assert!(verdict.best.is_same_place(&anywhere.best), "{verdict:?}");
        verdict.best.score - anywhere.best.score
    };
    let [none, askew, far, carried] = [(0.0, 0.0), (0.5, 25.0), (2.0, 0.0), (9.0, 0.0)].map(|(x, turn)| gain(x, turn));
    assert!(none > 2.0 && none > askew && none > far, "{none} {askew} {far}");
    assert!(askew > 0.5 && far > 0.5, "{askew} {far}");
    let half = -core::f32::consts::LN_2;
    assert!((carried - half).abs() < 0.1 && (gain(0.0, 180.0) - half).abs() < 0.1, "{carried}");
}

#[test]
fn in_the_dock_a_robot_is_likely_where_the_map_began_and_as_likely_with_a_dock_that_was_moved() {
    let anywhere = search(None, odds::DOCKED);
    let gain = |x_m: f32| search(Some(Pose::new(x_m, 0.0, 0.0)), odds::DOCKED).best.score - anywhere.best.score;
    assert!(gain(0.0) > 5.0 && gain(0.03) > 4.9, "{} {}", gain(0.0), gain(0.03));
    assert!((gain(2.0) + core::f32::consts::LN_2).abs() < 0.1, "{}", gain(2.0));
}

#[test]
fn a_robot_is_likely_where_it_stood_and_the_less_so_the_worse_that_was_known() {
    let stood = Pose::new(1.5, 0.5, 2.0);
    let anywhere = search(None, odds::CONTRADICTED);
    let gain = |x_m: f32, known_m2: f32| {
        let by = Displaced::nudged(known_m2, known_m2);
        search_from(stood, Some(Pose::new(x_m, 0.0, 0.0)), by).best.score - anywhere.best.score
    };
    let [here, nudged, badly_known] = [(0.0, 0.0), (0.2, 0.0), (0.0, 1.0)].map(|(x_m, known_m2)| gain(x_m, known_m2));
    assert!(here > 4.0 && here - nudged > 0.4 && here - nudged < 0.6, "{here} {nudged}");
    assert!((1.0..here - 2.0).contains(&badly_known), "{badly_known}");
    assert!((gain(3.0, 0.0) + core::f32::consts::LN_2).abs() < 0.1, "carried: {}", gain(3.0, 0.0));
}
