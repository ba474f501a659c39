//! New walls: every covariance that a birth makes against a dense J P J^T + R with numerical J.

use std::vec;
use std::vec::Vec;

use super::numeric::derivative;
use super::oracle::{Matrix, Oracle, multiply, sandwich, transpose};
use super::random::Random;
use crate::births::birth::add_states;
use crate::births::local_line::LocalLine;
use crate::births::verdict::Verdict;
use crate::filter::ekf::{Ekf, Jacobian, storage};
use crate::filter::layout::{ALPHA, THETA, X, Y};
use crate::walls::wall::Direction;

type Filter = Ekf<{ storage(24) }>;

/// Pose, grid, drive (4 to 6), four gains (7 to 10), one wall.
const STATES: usize = 12;

/// A filter whose states are all correlated.
fn filter(random: &mut Random) -> Filter {
    let root: Matrix = (0..STATES).map(|_| (0..STATES).map(|_| 0.02 * random.gaussian()).collect()).collect();
    let covariance = multiply(&root, &transpose(&root));
    let mut ekf = Filter::EMPTY;
    for (i, row) in covariance.iter().enumerate() {
        let mean = match i {
            X | Y => random.uniform(-4.0, 4.0),
            THETA => random.uniform(-3.0, 3.0),
            ALPHA => random.uniform(-0.8, 0.8),
            _ => 1.0,
        };
        ekf.augment(mean as f32, &Jacobian::new(), row[i] as f32);
        for (j, entry) in row.iter().enumerate().take(i) {
            ekf.correlate(i, j, *entry as f32);
        }
    }
    ekf
}

fn line(random: &mut Random) -> LocalLine {
    let mut r = |m: f64| random.uniform(-m, m) as f32;
    let by_calibration = (4..11).map(|i| (i, r(1.5), r(0.5))).collect();
    LocalLine {
        centroid_m: [r(1.5), r(1.5)],
        normal_rad: r(3.1),
        variance_m2: 4e-5,
        direction_variance: 2e-4,
        seen_direction_variance: 2e-4,
        length_m: 0.8,
        count: 20,
        seen_m: [0.0; 2],
        path_m: 0.0,
        by_calibration,
    }
}

/// What a birth computes, of the states, the line's own offset and direction errors, and calibration errors about 1.
fn born(values: &[f64; STATES + 2], line: &LocalLine, verdict: Verdict) -> [f64; 2] {
    let [x, y, theta, alpha] = [values[X], values[Y], values[THETA], values[ALPHA]];
    let (mut offset, mut direction) = (values[STATES], f64::from(line.normal_rad) + values[STATES + 1]);
    for &(state, by_offset, by_direction) in &line.by_calibration {
        offset += f64::from(by_offset) * (values[state] - 1.0);
        direction += f64::from(by_direction) * (values[state] - 1.0);
    }
    let (s, c) = theta.sin_cos();
    let [qx, qy] = line.centroid_m.map(f64::from);
    let beta = match verdict {
        Verdict::OnGrid(quarter) => alpha + f64::from(quarter) * core::f64::consts::FRAC_PI_2,
        _ => theta + direction,
    };
    let centroid = [x + c * qx - s * qy, y + s * qx + c * qy];
    [centroid[0] * beta.cos() + centroid[1] * beta.sin() + offset, beta]
}

/// Births a wall and compares mean and covariance of everything with the dense ones.
fn assert_birth(random: &mut Random, verdict: Verdict) {
    let mut ekf = filter(random);
    let line = line(random);
    let before = Oracle::of(&ekf);
    let (rho, direction) = add_states(&mut ekf, verdict, &line).unwrap();
    let mut at = [0.0; STATES + 2];
    at[..STATES].copy_from_slice(&before.mean);
    let expected = born(&at, &line, verdict);
    assert!((f64::from(ekf.mean(rho)) - expected[0]).abs() < 5e-6);
    let mut indices = vec![(rho, 0)];
    match (verdict, direction) {
        (Verdict::OnGrid(quarter), Direction::Grid(got)) => assert_eq!(quarter, got),
        (Verdict::Free, Direction::Free(theta)) | (Verdict::Snapped, Direction::Snapped(theta)) => {
            let theta = usize::from(theta);
            assert!((f64::from(ekf.mean(theta)) - expected[1]).sin().abs() < 5e-6);
            assert!(ekf.mean(theta).abs() <= core::f32::consts::PI);
            indices.push((theta, 1));
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(ekf.len(), STATES + indices.len());
    indices.sort_unstable();
    // J over the states and the line's two errors, whose variances stand behind the states'.
    let mut j: Matrix = (0..STATES).map(|i| (0..STATES + 2).map(|k| f64::from(u8::from(i == k))).collect()).collect();
    for &(_, which) in &indices {
        j.push((0..STATES + 2).map(|k| derivative(|v| born(v, &line, verdict)[which], &at, k)).collect());
    }
    let mut p: Matrix = before.covariance.iter().map(|row| [row.as_slice(), &[0.0, 0.0]].concat()).collect();
    for (i, variance) in [line.variance_m2, line.direction_variance].into_iter().enumerate() {
        let mut row = vec![0.0; STATES + 2];
        row[STATES + i] = variance.into();
        p.push(row);
    }
    let oracle = Oracle { mean: Oracle::of(&ekf).mean, covariance: sandwich(&j, &p) };
    let error = oracle.covariance_error(&ekf);
    assert!(error < 2e-5, "{verdict:?}: {error}");
}

#[test]
fn a_birth_is_exactly_as_uncertain_as_it_should_be() {
    let mut random = Random::new(1);
    for round in 0..200u8 {
        assert_birth(&mut random, Verdict::OnGrid(round % 4));
        assert_birth(&mut random, Verdict::Free);
        assert_birth(&mut random, Verdict::Snapped);
    }
}

#[test]
fn a_birth_that_finds_no_room_changes_nothing() {
    let mut random = Random::new(2);
    for (verdict, states) in [(Verdict::OnGrid(1), 1), (Verdict::Free, 2), (Verdict::Snapped, 2)] {
        let mut ekf = filter(&mut random);
        let line = line(&mut random);
        while ekf.len() + states <= Filter::CAPACITY {
            assert!(add_states(&mut ekf, verdict, &line).is_some());
        }
        let before = Oracle::of(&ekf);
        assert!(add_states(&mut ekf, verdict, &line).is_none(), "{verdict:?}");
        assert_eq!(before.mean, Oracle::of(&ekf).mean);
        assert_eq!(before.covariance, Oracle::of(&ekf).covariance);
    }
}

#[test]
fn a_line_that_is_not_clear_yet_adds_no_state() {
    let mut random = Random::new(3);
    let mut ekf = filter(&mut random);
    assert!(add_states(&mut ekf, Verdict::Wait, &line(&mut random)).is_none());
    assert_eq!(ekf.len(), STATES);
}

/// Two walls born from one pose share its error: the difference of their rho knows nothing of it.
#[test]
fn walls_seen_from_one_pose_are_correlated_through_it() {
    let mut ekf = Filter::EMPTY;
    for (value, variance) in [(1.0, 0.01), (2.0, 0.01), (0.0, 0.0), (0.0, 0.0)] {
        ekf.augment(value, &Jacobian::new(), variance);
    }
    let at =
        |x: f32| LocalLine { centroid_m: [x, 0.0], by_calibration: heapless::Vec::new(), ..line(&mut Random::new(5)) };
    let walls: Vec<usize> = [0.5, 1.5]
        .into_iter()
        .filter_map(|x| add_states(&mut ekf, Verdict::OnGrid(0), &at(x)))
        .map(|(rho, _)| rho)
        .collect();
    let mut difference = Jacobian::new();
    difference.push((walls[0], 1.0)).unwrap();
    difference.push((walls[1], -1.0)).unwrap();
    assert!((ekf.variance(&difference) - 2.0 * 4e-5).abs() < 1e-8);
    assert!((ekf.covariance(walls[0], walls[0]) - 0.010_04).abs() < 1e-8);
}

#[test]
fn a_plane_is_known_less_well_than_the_line_of_a_surface_with_relief() {
    let mut random = Random::new(11);
    let fitted = line(&mut random);
    let with_relief = |length_m: f32, relief_m: f32| {
        let mut line = LocalLine { length_m, ..fitted.clone() };
        line.add_relief(relief_m);
        [line.variance_m2 - fitted.variance_m2, line.direction_variance - fitted.direction_variance]
    };
    assert_eq!(with_relief(1.0, 0.0), [0.0, 0.0]);
    // A metre has five stretches, each 2 cm off by itself.
    let [across_m2, direction] = with_relief(1.0, 0.02);
    assert!((across_m2 - 0.0004 / 5.0).abs() < 1e-6 && (direction - 12.0 * 0.0004 / 5.0).abs() < 1e-5);
    let longer = with_relief(2.0, 0.02);
    assert!(longer[0] < across_m2 && longer[1] < 0.2 * direction, "{longer:?}");
}
