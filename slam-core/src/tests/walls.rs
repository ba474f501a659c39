//! The list of walls: directions on the grid, first walls met, and removals that leave the others alone.

use core::f32::consts::{FRAC_PI_2, PI};
use std::vec::Vec;

use super::numeric::ray_to_line;
use super::random::Random;
use crate::filter::ekf::{Ekf, Jacobian, storage};
use crate::filter::layout::ALPHA;
use crate::geometry::angle::{sin_cos, wrap};
use crate::measurement::beam::FixedMount;
use crate::measurement::line_of_sight::first_met;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::Map;
use crate::walls::wall::{Direction, Wall, WallPolicy};

const CAPACITY: usize = 16;
type Filter = Ekf<{ storage(40) }>;

fn filter(random: &mut Random) -> Filter {
    let mut ekf = Filter::EMPTY;
    for i in 0..6 {
        let value = if i == ALPHA { random.uniform(-0.7, 0.7) } else { 0.0 };
        ekf.augment(value as f32, &Jacobian::new(), 1e-3);
    }
    ekf
}

/// Walls of every kind, all correlated with the pose.
fn map(random: &mut Random, ekf: &mut Filter) -> Map<CAPACITY> {
    let mut map = Map::EMPTY;
    while !map.is_full() {
        let mut add = |value: f64, random: &mut Random| {
            let mut jacobian = Jacobian::new();
            for i in 0..4 {
                jacobian.push((i, random.uniform(-1.0, 1.0) as f32)).unwrap();
            }
            ekf.augment(value as f32, &jacobian, 1e-4).unwrap()
        };
        let rho = add(random.uniform(0.5, 4.0), random);
        let direction = match random.below(3) {
            0 => Direction::Grid(random.below(4) as u8),
            kind => {
                let theta = add(random.uniform(-3.1, 3.1), random);
                if kind == 1 { Direction::Free(theta as u16) } else { Direction::Snapped(theta as u16) }
            }
        };
        let lo = random.uniform(-3.0, 2.0) as f32;
        map.add(Wall::at(rho, direction, (lo, lo + random.uniform(0.3, 3.0) as f32)), 20, 0.0);
    }
    map
}

#[test]
fn a_grid_direction_is_the_nearest_and_has_its_own_normal() {
    let mut random = Random::new(1);
    for _ in 0..500 {
        let alpha_rad = random.uniform(-0.78, 0.78) as f32;
        let grid = ManhattanFrame { alpha_rad, sin_cos: sin_cos(alpha_rad) };
        let theta = random.uniform(-3.1, 3.1) as f32;
        let beta = grid.beta(grid.quarter(theta));
        assert!(wrap(theta - beta).abs() <= 0.5 * FRAC_PI_2 + 1e-5, "{theta} {beta}");
        // Eq. 4 of Rousse & Qiu: beta = alpha - k pi/2 with k = floor((alpha - theta) 2/pi + 1/2).
        let (alpha, theta) = (f64::from(alpha_rad), f64::from(theta));
        let quarter = core::f64::consts::FRAC_PI_2;
        let printed = alpha - ((alpha - theta) / quarter + 0.5).floor() * quarter;
        assert!((printed - f64::from(beta)).sin().abs() < 1e-5, "{printed} {beta}");
        for quarter in 0..4 {
            let (s, c) = sin_cos(grid.beta(quarter));
            let [nx, ny] = grid.normal(quarter);
            assert!((nx - c).abs() < 1e-6 && (ny - s).abs() < 1e-6);
        }
    }
}

/// What a wall is, apart from where its states stand.
fn signature(map: &Map<CAPACITY>, ekf: &Filter) -> Vec<(u16, [u32; 6])> {
    let grid = ManhattanFrame::of(ekf);
    map.walls()
        .iter()
        .map(|wall| {
            let line = wall.line(ekf, &grid);
            let theta = match wall.direction {
                Direction::Free(theta)
                | Direction::Snapped(theta)
                | Direction::NearGrid(theta, _)
                | Direction::Built(theta, _) => {
                    let theta = usize::from(theta);
                    ekf.covariance(theta, wall.rho())
                }
                Direction::Grid(quarter) => f32::from(quarter),
            };
            let (own, with_pose) = (ekf.covariance(wall.rho(), wall.rho()), ekf.covariance(wall.rho(), 1));
            (wall.id, [line.rho_m, line.beta_rad, wall.lo_m, theta, own, with_pose].map(f32::to_bits))
        })
        .collect()
}

#[test]
fn removing_walls_leaves_the_others_as_they_were() {
    let mut random = Random::new(2);
    for _ in 0..50 {
        let mut ekf = filter(&mut random);
        let mut map = map(&mut random, &mut ekf);
        while !map.walls().is_empty() {
            let mut expected = signature(&map, &ekf);
            // Beams pass through one wall until it goes.
            let gone = random.below(map.walls().len());
            let states = if matches!(map.walls()[gone].direction, Direction::Grid(_)) { 1 } else { 2 };
            let (id, len) = (map.walls()[gone].id, ekf.len());
            let mut passes = 0;
            while !map.prune(&mut ekf, 0.0) {
                map.passed_through(gone, 0.0);
                passes += 1;
                assert!(passes < 100, "it never goes");
            }
            assert!(passes > 1, "one beam is not enough");
            expected.retain(|(other, _)| *other != id);
            expected.sort_unstable();
            let mut left = signature(&map, &ekf);
            left.sort_unstable();
            assert_eq!(left, expected);
            assert_eq!(ekf.len(), len - states);
        }
        assert_eq!(ekf.len(), 6);
    }
}

#[test]
fn identifiers_are_never_used_again() {
    let mut random = Random::new(3);
    let mut ekf = filter(&mut random);
    let mut map = map(&mut random, &mut ekf);
    for _ in 0..50 {
        map.passed_through(0, 0.0);
    }
    assert!(map.prune(&mut ekf, 0.0));
    let before: Vec<u16> = map.walls().iter().map(|w| w.id).collect();
    let rho = ekf.augment(1.0, &Jacobian::new(), 1e-4).unwrap();
    map.add(Wall::at(rho, Direction::Grid(0), (0.0, 1.0)), 20, 0.0);
    let newest = map.walls().last().unwrap().id;
    assert!(before.iter().all(|id| *id < newest) && newest as usize == CAPACITY);
}

/// Stretches of one line, a noisy fit apart: one wall of both extents, less uncertain than either.
#[test]
fn collinear_walls_become_one() {
    let mut random = Random::new(4);
    let mut ekf = filter(&mut random);
    let mut map = Map::<CAPACITY>::EMPTY;
    for (rho_m, extent) in [(2.0, (-1.0, 0.5)), (2.01, (0.6, 1.5)), (2.0, (3.0, 4.0)), (2.5, (-1.0, 0.5))] {
        let rho = ekf.augment(rho_m, &Jacobian::new(), 1e-4).unwrap();
        map.add(Wall::at(rho, Direction::Grid(0), extent), 20, 0.0);
    }
    let len = ekf.len();
    assert!(map.merge(&mut ekf, WallPolicy::Grid, 0, false));
    assert!(!map.merge(&mut ekf, WallPolicy::Grid, 0, false), "the third is behind a door, the fourth behind the wall");
    assert_eq!((map.walls().len(), ekf.len()), (3, len - 1));
    let merged = map.walls().iter().find(|w| w.lo_m == -1.0 && w.hi_m == 1.5).unwrap();
    // Half way to the other but for the 5 mm by which stretches of a wall may be out of plane.
    assert!((ekf.mean(merged.rho()) - 2.0044).abs() < 1e-4);
    assert!((ekf.covariance(merged.rho(), merged.rho()) - 0.56e-4).abs() < 0.1e-4);
    assert_eq!(merged.updates, 40);
}

/// A newborn twin is made of what the older wall's gate refused: it shows where the wall goes on, and moves nothing.
#[test]
fn a_newborn_twin_only_prolongs_the_wall() {
    let mut random = Random::new(7);
    let mut ekf = filter(&mut random);
    let mut map = Map::<CAPACITY>::EMPTY;
    for (rho_m, extent) in [(2.0, (-1.0, 0.5)), (2.01, (0.6, 1.5))] {
        let rho = ekf.augment(rho_m, &Jacobian::new(), 1e-4).unwrap();
        map.add(Wall::at(rho, Direction::Grid(0), extent), 20, 0.0);
    }
    assert!(map.merge(&mut ekf, WallPolicy::Grid, 1, true));
    let wall = map.walls()[0];
    assert_eq!((wall.lo_m, wall.hi_m), (-1.0, 1.5));
    assert_eq!((ekf.mean(wall.rho()), ekf.covariance(wall.rho(), wall.rho())), (2.0, 1e-4));
}

/// Two free walls 2 m long whose places are known to 10 cm and whose directions to one degree.
fn two_free_walls(ekf: &mut Filter, rho_m: f32, theta_rad: f32) -> Map<CAPACITY> {
    let mut map = Map::<CAPACITY>::EMPTY;
    for (rho_m, theta_rad) in [(2.0, 0.0), (rho_m, theta_rad)] {
        let rho = ekf.augment(rho_m, &Jacobian::new(), 0.5e-2).unwrap();
        let theta = ekf.augment(theta_rad, &Jacobian::new(), 1.5e-4).unwrap();
        map.add(Wall::at(rho, Direction::Free(theta as u16), (-1.0, 1.0)), 20, 0.0);
    }
    map
}

/// At either end the two are 11 cm apart, hardly more than is known of their places. But to one side at one end and to the
/// other at the other they cannot be.
#[test]
fn walls_askew_to_one_another_stay_two() {
    let mut ekf = filter(&mut Random::new(8));
    let mut map = two_free_walls(&mut ekf, 2.0, 0.11);
    assert!(!map.merge(&mut ekf, WallPolicy::Grid, 0, false) && !map.merge(&mut ekf, WallPolicy::Grid, 1, false));
}

/// Once they are one at one end they are nearly so at the other: said twice, it would turn them.
#[test]
fn merging_walls_side_by_side_turns_neither() {
    let mut ekf = filter(&mut Random::new(9));
    let mut map = two_free_walls(&mut ekf, 2.2, 0.0);
    assert!(map.merge(&mut ekf, WallPolicy::Grid, 0, false));
    let line = map.walls()[0].line(&ekf, &ManhattanFrame::of(&ekf));
    assert!(line.beta_rad.abs() < 1e-4, "turned by {} rad", line.beta_rad);
    assert!((line.rho_m - 2.1).abs() < 2e-3, "moved to {} m", line.rho_m);
}

#[test]
fn a_wall_near_the_grid_that_would_hide_the_newborn_is_found_again() {
    let merged = |apart_m: f32, newborn: bool| {
        let mut ekf = Filter::EMPTY;
        for _ in 0..4 {
            let _ = ekf.augment(0.0, &Jacobian::new(), 1e-6);
        }
        // Three sigma apart, each known to a tenth of that, and as parallel as one can be.
        let mut map = Map::<CAPACITY>::EMPTY;
        for rho_m in [2.0, 2.0 + apart_m] {
            let rho = ekf.augment(rho_m, &Jacobian::new(), 0.5 * (apart_m / 3.5) * (apart_m / 3.5)).unwrap();
            let theta = ekf.augment(0.0, &Jacobian::new(), 1e-4).unwrap();
            map.add(Wall::at(rho, Direction::NearGrid(theta as u16, 0), (-1.0, 1.0)), 50, 0.0);
        }
        map.merge(&mut ekf, WallPolicy::Grid, 1, newborn)
    };
    assert!(merged(0.3, true), "one would hide the other");
    assert!(!merged(0.3, false), "both may be known too well");
    assert!(!merged(0.7, true), "one may be a cupboard's back");
}

/// Two walls of the grid that are known badly to one another are one where they overlap. Where they stand side by side the one may be a
/// cupboard before the other.
#[test]
fn walls_that_are_vague_to_one_another_are_one_where_they_overlap() {
    let merged_by = |policy: WallPolicy, sigma_m: f32, extent: (f32, f32), newborn: bool| {
        let mut ekf = filter(&mut Random::new(5));
        let mut map = Map::<CAPACITY>::EMPTY;
        for (rho_m, extent) in [(2.0, (-1.0, 1.0)), (2.0 - 1.3 * sigma_m, extent)] {
            let rho = ekf.augment(rho_m, &Jacobian::new(), 0.5 * sigma_m * sigma_m).unwrap();
            map.add(Wall::at(rho, Direction::Grid(0), extent), 20, 0.0);
        }
        map.merge(&mut ekf, policy, 1, newborn)
    };
    let merged =
        |sigma_m: f32, extent: (f32, f32), newborn: bool| merged_by(WallPolicy::Grid, sigma_m, extent, newborn);
    for newborn in [false, true] {
        assert!(merged(0.3, (0.0, 0.8), newborn), "overlapping");
        assert!(!merged(0.3, (1.2, 2.0), newborn) && !merged(0.3, (0.8, 2.0), newborn), "side by side");
        assert!(merged(0.02, (1.2, 2.0), newborn), "known well");
        assert!(merged_by(WallPolicy::NearGrid, 0.3, (1.2, 2.0), newborn), "left as they are");
    }
}

#[test]
fn opposite_faces_of_a_partition_stay_two_walls() {
    let mut random = Random::new(5);
    let mut ekf = filter(&mut random);
    let mut map = Map::<CAPACITY>::EMPTY;
    for (rho_m, quarter) in [(2.0, 0), (-2.0, 2)] {
        let rho = ekf.augment(rho_m, &Jacobian::new(), 1e-4).unwrap();
        map.add(Wall::at(rho, Direction::Grid(quarter), (-1.0, 1.0)), 20, 0.0);
    }
    assert!(!map.merge(&mut ekf, WallPolicy::Grid, 0, false) && !map.merge(&mut ekf, WallPolicy::Grid, 1, false));
}

#[test]
fn the_first_wall_met_is_the_nearest_that_faces_the_beam() {
    let mut random = Random::new(6);
    let (mut met, mut missed) = (0, 0);
    for _ in 0..100 {
        let mut ekf = filter(&mut random);
        let map = map(&mut random, &mut ekf);
        let grid = ManhattanFrame::of(&ekf);
        for _ in 0..40 {
            let phi = random.uniform(-f64::from(PI), f64::from(PI)) as f32;
            let at = [0, 1].map(|_| random.uniform(-1.5, 1.5) as f32);
            let beam = FixedMount::new(&crate::Mount::default()).beam(at, sin_cos(phi));
            let found = first_met(&ekf, &grid, map.walls(), &beam, 0.0, 5.0, 0.2);
            // Ranges on every wall, in f64, with how clearly they are on it.
            let ranges: Vec<(f64, f64, usize)> = (map.walls().iter().enumerate())
                .filter_map(|(i, wall)| {
                    let line = wall.line(&ekf, &grid);
                    let (rho, beta) = (f64::from(line.rho_m), f64::from(line.beta_rad));
                    let range = ray_to_line(at.map(f64::from), phi.into(), rho, beta);
                    let along = f64::from(line.along(beam.at(range as f32)));
                    let outside = (f64::from(wall.lo_m) - along).max(along - f64::from(wall.hi_m));
                    let faces = (beta - f64::from(phi)).cos() > 0.1 && range > 0.0 && range < 5.0;
                    faces.then_some((range, outside, i))
                })
                .collect();
            let nearest =
                ranges.iter().filter(|(_, outside, _)| *outside < 0.0).map(|r| r.0).fold(f64::INFINITY, f64::min);
            let Some(found) = found else {
                assert!(nearest.is_infinite(), "missed a wall at {nearest} m");
                missed += 1;
                continue;
            };
            met += 1;
            assert!(f64::from(found.range_m) < nearest + 1e-4);
            // A wall within its extent, or prolonged by less than a door.
            let itself = ranges.iter().find(|r| r.2 == found.index);
            assert!(itself.is_none_or(|(range, outside, _)| {
                (range - f64::from(found.range_m)).abs() < 1e-4 * (1.0 + range) && *outside < 0.6
            }));
        }
    }
    assert!(met > 500 && missed > 500, "{met} {missed}");
}

/// Beams that pass near an end take the overshoot back by and by, from either end; beams that pass elsewhere do not.
#[test]
fn beams_that_pass_near_an_end_shorten_a_wall() {
    let mut random = Random::new(8);
    let mut ekf = filter(&mut random);
    let mut map = Map::<CAPACITY>::EMPTY;
    let rho = ekf.augment(2.0, &Jacobian::new(), 1e-4).unwrap();
    map.add(Wall::at(rho, Direction::Grid(0), (0.0, 2.0)), 20, 0.0);
    for _ in 0..60 {
        map.met(0, 1.0, 0.0);
        map.passed_through(0, 1.8);
        map.passed_through(0, 0.1);
        map.passed_through(0, 1.0);
    }
    let wall = map.walls()[0];
    assert!((wall.hi_m - 1.8).abs() < 1e-3 && (wall.lo_m - 0.1).abs() < 1e-3, "{wall:?}");
}
