//! Founding the grid, and which walls it takes in.

use core::f32::consts::FRAC_PI_2;

use crate::filter::ekf::{Ekf, Jacobian, storage};
use crate::filter::layout::{ALPHA, THETA};
use crate::geometry::angle::wrap;
use crate::walls::decision::{GRID_SHARE, decide};
use crate::walls::founding::upkeep;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::{Map, MapFrame};
use crate::walls::tolerance::Tolerance;
use crate::walls::wall::WallPolicy;
use crate::walls::wall::{Direction, Wall, WallKind};

type Filter = Ekf<{ storage(24) }>;

const DEGREE: f32 = core::f32::consts::PI / 180.0;

/// Free walls of 1.2 m with these directions, each known to 0.3 degrees relative to a heading known to 3.
fn home(directions_deg: &[f32]) -> (Filter, Map<8>) {
    home_known_to(0.3, directions_deg)
}

/// The same with directions known to so much, degrees, 1-sigma.
fn home_known_to(sigma_deg: f32, directions_deg: &[f32]) -> (Filter, Map<8>) {
    let (mut ekf, mut map) = (Filter::EMPTY, Map::EMPTY);
    for i in 0..4 {
        ekf.augment(0.0, &Jacobian::new(), if i == THETA { 9.0 * DEGREE * DEGREE } else { 0.0 });
    }
    for direction_deg in directions_deg {
        add_free(&mut ekf, &mut map, (1.0, *direction_deg), sigma_deg);
    }
    (ekf, map)
}

/// Adds a free wall of 1.2 m so far from the origin, metres, with this direction, known to so much relative to the heading, degrees.
fn add_free(ekf: &mut Filter, map: &mut Map<8>, (rho_m, direction_deg): (f32, f32), sigma_deg: f32) {
    let rho = ekf.augment(rho_m, &Jacobian::new(), 1e-4).unwrap();
    let mut jacobian = Jacobian::new();
    jacobian.push((THETA, 1.0)).unwrap();
    let theta = ekf.augment(direction_deg * DEGREE, &jacobian, sigma_deg * sigma_deg * DEGREE * DEGREE).unwrap();
    map.add(Wall::at(rho, Direction::Free(theta as u16), (-0.6, 0.6)), 30, 0.0);
}

/// Whether walls at such places and directions (metres, degrees), drawn under a heading that is known to three degrees against a grid at
/// zero, are taken into that.
fn are_taken_in(policy: WallPolicy, walls: &[(f32, f32)]) -> bool {
    let (mut ekf, mut map) = home(&[]);
    map.has_grid = true;
    for wall in walls {
        add_free(&mut ekf, &mut map, *wall, 0.3);
    }
    for turn in 0..4 * walls.len() {
        upkeep(&mut map, &mut ekf, policy, turn);
    }
    let taken = kinds(&map).iter().filter(|kind| **kind != WallKind::Free).count();
    assert!(taken == 0 || taken == walls.len(), "{taken} of {}", walls.len());
    if taken > 0 {
        let heading_deg = ekf.mean(THETA) / DEGREE;
        let share = -heading_deg / walls[0].1;
        assert!((0.75..1.0).contains(&share), "the heading was off by as much: {heading_deg} degrees");
    }
    taken > 0
}

#[test]
fn a_second_grid_is_the_first_under_a_heading_astray() {
    let grid = WallPolicy::Grid;
    assert!(are_taken_in(grid, &[(3.0, 8.0), (3.0, 98.0), (3.0, -172.0), (2.0, -82.0)]));
    assert!(are_taken_in(grid, &[(3.0, -12.0), (3.0, 78.0), (3.0, 168.0), (2.0, -102.0), (6.0, 78.0)]));
    assert!(!are_taken_in(grid, &[(3.0, 8.0), (3.0, 98.0)]), "two walls may both stand askew");
    assert!(!are_taken_in(grid, &[(3.0, 8.0), (3.0, 108.0), (3.0, -160.0), (2.0, -115.0)]), "each by its own angle");
    assert!(!are_taken_in(grid, &[(0.5, 8.0), (0.5, 98.0), (0.5, -172.0), (0.5, -82.0)]), "a chest that stands askew");
    let wing = [(3.0, 20.0), (3.0, 110.0), (3.0, -160.0), (2.0, -70.0), (6.0, 110.0), (7.0, 20.0)];
    assert!(!are_taken_in(grid, &wing), "farther off than any heading: a wing");
    for other in [WallPolicy::Snapped { theta_moves: false }, WallPolicy::NearGrid] {
        assert!(!are_taken_in(other, &[(3.0, 8.0), (3.0, 98.0), (3.0, -172.0), (2.0, -82.0)]), "{other:?}");
    }
}

fn kinds(map: &Map<8>) -> std::vec::Vec<WallKind> {
    map.walls().iter().map(|wall| wall.kind()).collect()
}

#[test]
fn one_wall_alone_founds_no_grid() {
    for directions in [&[][..], &[10.0], &[10.0, 55.0]] {
        let (mut ekf, mut map) = home(directions);
        for turn in 0..20 {
            upkeep(&mut map, &mut ekf, WallPolicy::Grid, turn);
        }
        assert!(!map.has_grid, "{directions:?}");
        assert_eq!(ekf.covariance(ALPHA, ALPHA), 0.0);
        assert!(kinds(&map).iter().all(|kind| *kind == WallKind::Free));
    }
}

#[test]
fn a_pair_of_which_little_is_known_founds_no_grid_again() {
    for (sigma_deg, is_enough) in [(1.0, true), (3.0, false)] {
        let (mut ekf, mut map) = home_known_to(sigma_deg, &[10.0, 100.0]);
        map.is_grid_expected = true;
        for turn in 0..20 {
            upkeep(&mut map, &mut ekf, WallPolicy::Grid, turn);
        }
        assert_eq!(map.has_grid, is_enough, "{sigma_deg} degrees");
    }
}

#[test]
fn a_grid_is_founded_again_by_directions_that_are_less_sure() {
    for is_expected in [false, true] {
        let (mut ekf, mut map) = home_known_to(3.0, &[10.0, 102.0, -79.0]);
        map.is_grid_expected = is_expected;
        for turn in 0..20 {
            upkeep(&mut map, &mut ekf, WallPolicy::Grid, turn);
        }
        assert_eq!(map.has_grid, is_expected);
        map.forget_walls(&mut ekf);
        assert_eq!((map.has_grid, map.is_grid_expected), (false, is_expected));
        map.clear(MapFrame::Start);
        assert!(!map.is_grid_expected, "it may be another home");
    }
}

#[test]
fn walls_that_agree_found_the_grid_and_stand_on_it() {
    let directions = [10.1, 100.0, -80.03, 55.0];
    let (mut ekf, mut map) = home_known_to(0.1, &directions);
    map.tolerance = Some(Tolerance::Exact);
    let states = ekf.len();
    for turn in 0..20 {
        upkeep(&mut map, &mut ekf, WallPolicy::Grid, turn);
    }
    assert!(map.has_grid);
    assert_eq!(
        kinds(&map),
        [WallKind::Grid, WallKind::Grid, WallKind::Grid, WallKind::Free],
        "the last is a sofa set askew"
    );
    assert_eq!(ekf.len(), states - 3, "the directions that the grid gives are states no more");
    let grid = ManhattanFrame::of(&ekf);
    for (wall, direction) in map.walls().iter().zip(directions) {
        let beta = wall.line(&ekf, &grid).beta_rad;
        assert!(wrap(beta - direction * DEGREE).abs() < 0.15 * DEGREE, "{beta} of {direction}");
    }
    // Alpha is the mean of what the three say, as sure of the heading as they are together.
    assert!((grid.alpha_rad / DEGREE - 10.02).abs() < 0.03, "{} degrees", grid.alpha_rad / DEGREE);
    let relative = ekf.covariance(ALPHA, ALPHA) + ekf.covariance(THETA, THETA) - 2.0 * ekf.covariance(ALPHA, THETA);
    let sigma_deg = relative.sqrt() / DEGREE;
    assert!((sigma_deg - 0.1 / 3.0f32.sqrt()).abs() < 0.01, "{sigma_deg} degrees");
}

#[test]
fn snapped_walls_keep_their_direction_state_and_free_ones_know_no_grid() {
    for (policy, kind, grid) in [
        (WallPolicy::Snapped { theta_moves: false }, WallKind::Snapped, true),
        (WallPolicy::Free, WallKind::Free, false),
    ] {
        let (mut ekf, mut map) = home(&[10.0, 100.0, 190.0]);
        let states = ekf.len();
        for turn in 0..20 {
            upkeep(&mut map, &mut ekf, policy, turn);
        }
        assert_eq!(map.has_grid, grid);
        assert_eq!(ekf.len(), states);
        assert!(kinds(&map).iter().all(|k| *k == kind), "{policy:?}");
    }
}

#[test]
fn a_direction_is_on_the_grid_off_it_or_not_clear_yet() {
    let sigma = 0.5 * DEGREE;
    assert_eq!(decide(0.0, sigma * sigma, GRID_SHARE), Some(true));
    assert_eq!(decide(0.3 * DEGREE, sigma * sigma, GRID_SHARE), Some(true));
    assert_eq!(decide(10.0 * DEGREE, sigma * sigma, GRID_SHARE), Some(false));
    assert_eq!(decide(-FRAC_PI_2 / 2.0, sigma * sigma, GRID_SHARE), Some(false));
    // Between the two, and where next to nothing is known.
    let unclear = (0..100)
        .map(|i| 0.1 * i as f32 * DEGREE)
        .filter(|off| decide(*off, sigma * sigma, GRID_SHARE).is_none())
        .count();
    assert!((1..30).contains(&unclear), "{unclear} tenths of a degree");
    assert_eq!(decide(10.0 * DEGREE, 400.0 * DEGREE * DEGREE, GRID_SHARE), None);
}

#[test]
fn built_walls_keep_a_deviation_of_their_own() {
    let directions = [10.0, 100.5, -80.3, 55.0];
    let (mut ekf, mut map) = home(&directions);
    let states = ekf.len();
    for turn in 0..20 {
        upkeep(&mut map, &mut ekf, WallPolicy::NearGrid, turn);
    }
    assert!(map.has_grid);
    assert_eq!(ekf.len(), states);
    let grid = ManhattanFrame::of(&ekf);
    for (wall, direction) in map.walls().iter().zip(directions).take(3) {
        let Direction::NearGrid(theta, quarter) = wall.direction else { panic!("{direction}: {:?}", wall.direction) };
        let theta = usize::from(theta);
        // Tied to half a degree, not to the spot: each stays nearer to where it was seen than the grid is.
        let (own, of_grid) =
            (wrap(ekf.mean(theta) - direction * DEGREE), wrap(grid.beta(quarter) - direction * DEGREE));
        assert!(own.abs() <= of_grid.abs() + 1e-6, "{direction}: {own} and {of_grid}");
        let relative = ekf.covariance(theta, theta) + ekf.covariance(ALPHA, ALPHA) - 2.0 * ekf.covariance(theta, ALPHA);
        assert!(relative > 0.2 * 0.2 * DEGREE * DEGREE && relative < 0.6 * 0.6 * DEGREE * DEGREE, "{relative}");
    }
    assert!(matches!(map.walls()[3].direction, Direction::Free(_)));
}
