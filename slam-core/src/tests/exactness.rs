//! Walls stand on the grid exactly once that is known of them, and walls that stand askew together find others that do.

use core::f32::consts::{FRAC_PI_2, PI};
use std::vec::Vec;

use crate::births::askew::{Among, among};
use crate::births::local_line::LocalLine;
use crate::filter::ekf::{Ekf, Jacobian, storage};
use crate::filter::layout::{ALPHA, THETA};
use crate::geometry::angle::{off_quarter, wrap};
use crate::tests::random::Random;
use crate::walls::exactness::Exactness;
use crate::walls::founding::upkeep;
use crate::walls::map::Map;
use crate::walls::tolerance::{BUILT_RAD, Tolerance};
use crate::walls::wall::{Direction, Wall, WallPolicy};

const DEGREE: f32 = PI / 180.0;

type Filter = Ekf<{ storage(96) }>;

/// Length of the walls, metres.
const LENGTH_M: f32 = 1.2;

/// A free wall: its direction, degrees, what that is known to against the robot and off by, 1-sigma, degrees, and its length, metres.
type Found = (f32, f32, f32);

/// A robot whose heading is known to a degree, and walls that all are known so well.
fn home(random: &mut Random, sigma_deg: f64, directions_deg: &[f32]) -> (Filter, Map<40>) {
    let walls: Vec<Found> =
        directions_deg.iter().map(|direction_deg| (*direction_deg, sigma_deg as f32, LENGTH_M)).collect();
    home_of(random, &walls)
}

fn home_of(random: &mut Random, walls: &[Found]) -> (Filter, Map<40>) {
    let (mut ekf, mut map) = (Filter::EMPTY, Map::EMPTY);
    for i in 0..4 {
        ekf.augment(0.0, &Jacobian::new(), if i == THETA { DEGREE * DEGREE } else { 0.0 });
    }
    for &(direction_deg, sigma_deg, length_m) in walls {
        let rho = ekf.augment(1.0, &Jacobian::new(), 1e-4).unwrap();
        let mut jacobian = Jacobian::new();
        jacobian.push((THETA, 1.0)).unwrap();
        let found_deg = direction_deg + sigma_deg * random.gaussian() as f32;
        let variance = (sigma_deg * DEGREE) * (sigma_deg * DEGREE);
        let theta = ekf.augment(found_deg * DEGREE, &jacobian, variance).unwrap();
        let direction = Direction::Free(theta as u16);
        map.add(Wall::at(rho, direction, (0.0, length_m)), 30, 0.0);
    }
    (ekf, map)
}

/// Which walls stand on the grid exactly after a while.
fn stand(ekf: &mut Filter, map: &mut Map<40>) -> Vec<bool> {
    for turn in 0..400 {
        upkeep(map, ekf, WallPolicy::Grid, turn);
    }
    map.walls().iter().map(|wall| matches!(wall.direction, Direction::Grid(_))).collect()
}

#[test]
fn walls_of_an_exact_grid_end_on_it() {
    let mut random = Random::new(1);
    let directions: Vec<f32> = (0..16).map(|i| 90.0 * (i % 4) as f32).collect();
    // Of walls that are known no better than built ones stand off it, how these do has to be known.
    for (sigma_deg, tolerance) in [(0.1, None), (0.3, Some(Tolerance::Exact))] {
        let (mut ekf, mut map) = home(&mut random, sigma_deg, &directions);
        map.tolerance = tolerance;
        let exact = stand(&mut ekf, &mut map).iter().filter(|is_exact| **is_exact).count();
        assert!(exact >= 14, "{exact} of 16 known to {sigma_deg} degrees");
        // As sure of the grid against the heading as all of them are together.
        let relative = ekf.covariance(ALPHA, ALPHA) + ekf.covariance(THETA, THETA) - 2.0 * ekf.covariance(ALPHA, THETA);
        assert!(relative.sqrt() < 0.4 * sigma_deg as f32 * DEGREE, "{} degrees", relative.sqrt() / DEGREE);
    }
}

#[test]
fn built_walls_stay_as_they_stand() {
    let mut random = Random::new(9);
    for stand_off_deg in [0.3, 0.5] {
        let directions: Vec<f32> =
            (0..16).map(|i| 90.0 * (i % 4) as f32 + if i % 3 == 0 { stand_off_deg } else { -stand_off_deg }).collect();
        let (mut ekf, mut map) = home(&mut random, 0.1, &directions);
        assert!(stand(&mut ekf, &mut map).iter().all(|is_exact| !is_exact), "{:?}", map.walls());
        assert_eq!(map.tolerance, Some(Tolerance::Built));
        assert_eq!(Exactness::of_quarters(map.exactness.quarters(map.tolerance)).1, Some(Tolerance::Built), "kept");
        for (wall, direction_deg) in map.walls().iter().zip(&directions) {
            let off_rad = wrap(wall.beta_rad(&ekf) - direction_deg * DEGREE);
            assert!(off_rad.abs() < 0.4 * DEGREE, "{} degrees", off_rad / DEGREE);
        }
        // No surer of the grid than so many walls that stand so far off it tell.
        let grid_rad = off_quarter(ekf.mean(ALPHA), 0.0);
        let sigma_rad = ekf.covariance(ALPHA, ALPHA).sqrt();
        assert!(grid_rad.abs() < 3.0 * sigma_rad && sigma_rad > BUILT_RAD / 5.0, "{grid_rad} of {sigma_rad}");
    }
}

#[test]
fn a_line_along_the_grid_is_held_to_stand_as_built_walls_do_before_it_is_known_how() {
    // Three walls of which a degree is known: too little to tell exact walls from others.
    let (mut ekf, mut map) = home_of(&mut Random::new(10), &[(0.0, 1.0, 3.0), (90.0, 1.0, 3.0), (180.0, 1.0, 3.0)]);
    stand(&mut ekf, &mut map);
    assert_eq!(map.tolerance, None);
    for wall in map.walls() {
        assert!(matches!(wall.direction, Direction::Built(..)), "{wall:?}");
    }
}

#[test]
fn partitions_that_stand_askew_keep_their_directions() {
    let mut random = Random::new(2);
    for askew_deg in [1.5, 3.0, -6.0, 14.0] {
        let directions: Vec<f32> =
            (0..16).map(|i| 90.0 * (i % 4) as f32 + if i < 8 { 0.0 } else { askew_deg }).collect();
        let (mut ekf, mut map) = home(&mut random, 0.15, &directions);
        let exact = stand(&mut ekf, &mut map);
        // Whichever half the grid is, none of the other stands on it.
        let halves = [&exact[..8], &exact[8..]].map(|half| half.iter().filter(|is_exact| **is_exact).count());
        assert!(halves.contains(&0), "{askew_deg} degrees: {halves:?}");
        for (wall, direction_deg) in map.walls().iter().zip(&directions) {
            let off = wall.beta_rad(&ekf) - direction_deg * DEGREE;
            let off_deg = (off - (off / (2.0 * PI)).round() * 2.0 * PI) / DEGREE;
            assert!(off_deg.abs() < 0.7, "{direction_deg} degrees is off by {off_deg}");
        }
    }
}

/// How many of these pieces of furniture end on the grid of eight long walls.
fn furniture_on_the_grid(seed: u64, pieces: &[(f32, f32)]) -> usize {
    let walls = (0..8).map(|i| (90.0 * (i % 4) as f32, 0.1, 4.0));
    let pieces = pieces.iter().map(|&(direction_deg, sigma_deg)| (direction_deg, sigma_deg, 0.8));
    let (mut ekf, mut map) = home_of(&mut Random::new(seed), &walls.chain(pieces).collect::<Vec<Found>>());
    let exact = stand(&mut ekf, &mut map);
    assert!(exact[..8].iter().filter(|is_exact| **is_exact).count() >= 7, "long walls: {exact:?}");
    exact[8..].iter().filter(|is_exact| **is_exact).count()
}

#[test]
fn furniture_stands_on_the_grid_once_its_own_readings_tell() {
    for seed in 4..8 {
        // Just found along the grid, as a piece that stands six degrees askew is: what others do does not decide.
        assert_eq!(furniture_on_the_grid(seed, &[(0.0, 2.5); 8]), 0);
        // Where all pieces are along the walls those that are known less well follow.
        assert!(furniture_on_the_grid(seed, &[(0.0, 0.3), (90.0, 0.3), (90.0, 0.3), (0.0, 0.3), (0.0, 0.3)]) >= 4);
        let (along, askew) = ([(0.0, 0.2), (90.0, 0.2)], [(7.0, 0.2), (-4.0, 0.2), (84.0, 0.2), (93.0, 0.2)]);
        assert!(furniture_on_the_grid(seed, &[along, along, along].concat()) >= 5);
        assert!(furniture_on_the_grid(seed, &[&askew[..], &askew[..]].concat()) == 0);
    }
}

#[test]
fn a_line_is_of_the_walls_that_it_is_along() {
    let line = |off_deg: f32, sigma_deg: f32| LocalLine {
        centroid_m: [1.0, 0.0],
        normal_rad: off_deg * DEGREE,
        variance_m2: 1e-4,
        direction_variance: sigma_deg * sigma_deg * DEGREE * DEGREE,
        seen_direction_variance: sigma_deg * sigma_deg * DEGREE * DEGREE,
        length_m: 0.4,
        count: 10,
        seen_m: [1.0, 0.0],
        path_m: 0.0,
        by_calibration: heapless::Vec::new(),
    };
    let of_walls = |directions_deg: &[f32], line: &LocalLine| {
        let (ekf, map) = home(&mut Random::new(3), 0.01, directions_deg);
        let off_rad = line.normal_rad - (line.normal_rad / FRAC_PI_2).round() * FRAC_PI_2;
        among(&ekf, map.walls(), line, (off_rad, line.direction_variance, 0.9), 1.0)
    };
    let of = |askew_deg: f32, line: &LocalLine| of_walls(&[askew_deg, askew_deg + 90.0], line);
    // Across a wall that stands six degrees askew, and along the grid.
    assert!(matches!(of(6.0, &line(96.2, 1.0)), Some(Among::Askew(..))));
    assert_eq!(of(6.0, &line(90.3, 1.0)), Some(Among::Grid));
    // Of neither.
    assert_eq!(of(6.0, &line(30.0, 1.0)), Some(Among::Off));
    // Between both: drawn loosely where they are near one another, else it waits.
    assert!(matches!(of(3.0, &line(1.9, 1.0)), Some(Among::Either(_))));
    assert_eq!(of(8.0, &line(4.5, 1.8)), Some(Among::Unclear));
    // A vague line is theirs where many stand so, not where as many stand askew each by an angle of its own.
    assert!(matches!(of_walls(&[6.0, 96.0, 6.0, 96.0, 6.0, 6.0], &line(7.0, 2.5)), Some(Among::Askew(..))));
    assert_eq!(of_walls(&[6.0, 14.0, -8.0, 21.0, -15.0, 30.0], &line(7.0, 2.5)), Some(Among::Unclear));
    // Where no wall stands askew there is no such question.
    let (ekf, map) = home(&mut Random::new(3), 0.01, &[]);
    assert_eq!(among(&ekf, map.walls(), &line(0.0, 1.0), (0.0, DEGREE * DEGREE, 0.9), 1.0), None);
}
