//! Clustering: DBSCAN against its definition, grouping by sensor, corners.

use std::vec;
use std::vec::Vec;

use super::outliers::OUTLIER;
use super::random::Random;
use crate::Clustering;
use crate::births::buffer::{Outlier, OutlierBuffer};
use crate::births::cluster::newest_line;
use crate::births::dbscan::{NOISE, dbscan};

const B: usize = 96;

/// The definition: core points within reach of each other are one cluster.
fn components(near: &[Vec<bool>], is_core: &[bool]) -> Vec<usize> {
    let mut component: Vec<usize> = (0..is_core.len()).collect();
    loop {
        let mut changed = false;
        for i in 0..is_core.len() {
            for j in 0..is_core.len() {
                if is_core[i] && is_core[j] && near[i][j] && component[j] < component[i] {
                    component[i] = component[j];
                    changed = true;
                }
            }
        }
        if !changed {
            return component;
        }
    }
}

fn assert_is_dbscan(points: &[[f32; 2]], epsilon_m: f32, min_points: usize) -> usize {
    let labels = dbscan::<B>(points, epsilon_m, min_points);
    let distance_squared = |a: &[f32; 2], b: &[f32; 2]| (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]);
    let near: Vec<Vec<bool>> = points
        .iter()
        .map(|a| points.iter().map(|b| distance_squared(a, b) <= epsilon_m * epsilon_m).collect())
        .collect();
    let is_core: Vec<bool> = near.iter().map(|row| row.iter().filter(|n| **n).count() >= min_points).collect();
    let component = components(&near, &is_core);
    let n = points.len();
    for i in 0..n {
        if is_core[i] {
            assert_ne!(labels[i], NOISE, "core point {i}");
            for j in (0..n).filter(|&j| is_core[j]) {
                assert_eq!(labels[i] == labels[j], component[i] == component[j], "core points {i} and {j}");
            }
            continue;
        }
        let in_reach: Vec<u8> = (0..n).filter(|&j| is_core[j] && near[i][j]).map(|j| labels[j]).collect();
        if in_reach.is_empty() {
            assert_eq!(labels[i], NOISE, "noise {i}");
        } else {
            assert!(in_reach.contains(&labels[i]), "border point {i}");
        }
    }
    assert!(labels[n..].iter().all(|l| *l == NOISE));
    let mut used: Vec<u8> = labels.iter().copied().filter(|l| *l != NOISE).collect();
    used.sort_unstable();
    used.dedup();
    // Counted from 0 without gaps.
    assert!(used.iter().enumerate().all(|(i, l)| usize::from(*l) == i));
    used.len()
}

#[test]
fn dbscan_is_what_its_authors_define() {
    let mut random = Random::new(1);
    let mut most = 0;
    for round in 0..300 {
        let n = random.below(B + 1);
        // From all alone to all in one.
        let size = random.uniform(0.5, 8.0);
        let points: Vec<[f32; 2]> = (0..n)
            .map(|_| {
                let mut at = || random.uniform(0.0, size) as f32;
                // Some on a lattice: distances of exactly epsilon, and twins.
                if round % 3 == 0 { [(at() * 4.0).round() * 0.25, (at() * 4.0).round() * 0.25] } else { [at(), at()] }
            })
            .collect();
        for min_points in 1..7 {
            most = most.max(assert_is_dbscan(&points, 0.25, min_points));
        }
    }
    assert!(most > 20, "too tame: {most} clusters at most");
}

#[test]
fn dbscan_of_nothing_and_of_too_much() {
    assert!(dbscan::<4>(&[], 1.0, 1).iter().all(|l| *l == NOISE));
    // More points than labels: the rest is ignored.
    let points = vec![[0.0, 0.0]; 9];
    assert_eq!(dbscan::<4>(&points, 1.0, 3), [0; 4]);
    let bad = [[f32::NAN, 0.0], [0.0, 0.0], [0.01, 0.0], [f32::INFINITY, 0.0]];
    assert_eq!(dbscan::<4>(&bad, 1.0, 2), [NOISE, 0, 0, NOISE]);
}

#[test]
fn dbscan_has_a_label_for_every_point_of_the_largest_buffer() {
    let points: Vec<[f32; 2]> = (0..255).map(|i| [i as f32, 0.0]).collect();
    let labels = dbscan::<255>(&points, 0.5, 1);
    assert!(labels.iter().enumerate().all(|(i, l)| usize::from(*l) == i));
    assert!(dbscan::<255>(&points, 1.0, 1).iter().all(|l| *l == 0));
}

/// A hit of a beam that runs along +y or +x into a wall.
fn hit(sensor: u8, at: [f64; 2], direction: [f32; 2]) -> Outlier {
    Outlier { sensor, hit_m: at.map(|v| v as f32), direction, ..OUTLIER }
}

const UP: [f32; 2] = [0.0, 1.0];
const RIGHT: [f32; 2] = [1.0, 0.0];

/// Sensor 0 on the wall y = 1, sensor 1 on the wall y = -1, in turns, 1 cm of noise.
fn two_walls(random: &mut Random) -> OutlierBuffer<B> {
    let mut buffer = OutlierBuffer::default();
    for i in 0..20 {
        let along = 0.05 * f64::from(i);
        buffer.push(hit(0, [along, 1.0 + 0.01 * random.gaussian()], UP));
        buffer.push(hit(1, [along, -1.0 + 0.01 * random.gaussian()], [0.0, -1.0]));
    }
    buffer
}

#[test]
fn a_sensor_s_cluster_is_its_own_and_what_lies_on_its_line() {
    let mut random = Random::new(2);
    let (mut lines, mut points) = (0, 0);
    for _ in 0..50 {
        let buffer = two_walls(&mut random);
        for (clustering, sensor) in
            [(Clustering::BySensor, 0), (Clustering::BySensor, 1), (Clustering::Dbscan, 0), (Clustering::Dbscan, 1)]
        {
            // The newest points may by chance lie off a line: then a later one will tell.
            let Some((members, line)) = newest_line(&buffer, sensor, clustering, 0.05, 0.0) else { continue };
            let of: Vec<u8> = buffer.iter().zip(&members).filter(|(_, m)| **m).map(|(p, _)| p.sensor).collect();
            assert!(of.iter().all(|s| *s == sensor), "{clustering:?}");
            assert_eq!(line.count as usize, of.len());
            (lines, points) = (lines + 1, points + of.len());
            let expected = if sensor == 0 { 1.0 } else { -1.0 };
            let (off_m, _) = line.residual([line.centroid_m[0], expected]);
            assert!(off_m.abs() < 5.0 * line.variance_m2.sqrt(), "{clustering:?}: {off_m}");
            let off = libm::atan2f(line.normal[0], line.normal[1] * expected);
            assert!(off.abs() < 5.0 * line.direction_variance.sqrt(), "{clustering:?}: {off}");
        }
    }
    assert!(lines > 120, "{lines} of 200 walls found");
    assert!(points > 15 * lines, "{points} points in {lines} lines of 20");
}

/// A corner at (1, 1): `first` points along y = 1, then `second` down x = 1.
fn corner(random: &mut Random, first: usize, second: usize) -> OutlierBuffer<B> {
    let mut buffer = OutlierBuffer::default();
    for i in 0..first {
        let x = 1.0 - 0.03 * (first - i) as f64;
        buffer.push(hit(0, [x, 1.0 + 0.01 * random.gaussian()], UP));
    }
    for i in 0..second {
        let y = 1.0 - 0.03 * i as f64;
        buffer.push(hit(0, [1.0 + 0.01 * random.gaussian(), y], RIGHT));
    }
    buffer
}

/// Half a metre is what a free wall must have: shorter lines may have two or three points from around the corner hidden
/// in their noise, which turns them by ten degrees.
#[test]
fn a_cluster_around_a_corner_is_split_at_the_corner() {
    let mut random = Random::new(3);
    for clustering in [Clustering::BySensor, Clustering::Dbscan] {
        let (mut found, mut slanted) = (0, 0);
        for round in 0..660 {
            let buffer = corner(&mut random, 25, 8 + round % 22);
            let Some((members, line)) = newest_line(&buffer, 0, clustering, 0.03, 0.0) else { continue };
            if !line.is_straight() || line.length_m() < 0.5 {
                continue;
            }
            found += 1;
            let off = libm::atan2f(line.normal[1], line.normal[0]);
            slanted += usize::from(off.abs() > 4.0 * line.direction_variance.sqrt());
            assert!(off.abs() < 0.1, "{clustering:?}: {} degrees", off.to_degrees());
            let strangers = buffer.iter().zip(&members).filter(|(p, m)| **m && p.hit_m[0] < 0.9).count();
            assert_eq!(strangers, 0, "{clustering:?}");
        }
        assert!(found > 15, "{clustering:?}: {found} second walls found in 660 corners");
        assert!(4 * slanted < found, "{clustering:?}: {slanted} of {found} lines are slanted");
    }
}

#[test]
fn scattered_points_are_no_line() {
    let mut random = Random::new(4);
    let mut lines = 0;
    for _ in 0..50 {
        let mut buffer = OutlierBuffer::<B>::default();
        for _ in 0..40 {
            buffer.push(hit(0, [random.uniform(0.0, 1.0), random.uniform(0.0, 1.0)], UP));
        }
        for clustering in [Clustering::BySensor, Clustering::Dbscan] {
            lines += usize::from(newest_line(&buffer, 0, clustering, 0.05, 0.0).is_some());
        }
    }
    // Five points within the noise of a line, by chance.
    assert!(lines <= 3, "{lines} lines in 100 clouds");
}

#[test]
fn too_few_points_and_unknown_sensors_are_no_line() {
    let mut buffer = OutlierBuffer::<B>::default();
    for i in 0..4 {
        buffer.push(hit(0, [0.05 * f64::from(i), 1.0], UP));
        for clustering in [Clustering::BySensor, Clustering::Dbscan] {
            assert!(newest_line(&buffer, 0, clustering, 0.05, 0.0).is_none());
            assert!(newest_line(&buffer, 1, clustering, 0.05, 0.0).is_none());
        }
    }
}

#[test]
fn a_sparse_run_without_a_miss_is_one_line() {
    let mut buffer = OutlierBuffer::<B>::default();
    for step in 0..12 {
        buffer.push(Outlier { step, ..hit(0, [0.5 * f64::from(step), 1.0], UP) });
    }
    let (_, line) = newest_line(&buffer, 0, Clustering::BySensor, 0.04, 0.0).unwrap();
    assert!((line.length_m() - 11.0 * 0.5).abs() < 1e-3);
}

#[test]
fn a_gap_as_wide_as_a_door_ends_a_line() {
    let mut buffer = OutlierBuffer::<B>::default();
    for i in 0..30_u16 {
        // Five steps without a reading: the beam went through.
        let (gap_m, missed) = if i < 15 { (0.0, 0) } else { (1.0, 5) };
        let step = i + missed;
        buffer.push(Outlier { step, ..hit(0, [0.04 * f64::from(i) + gap_m, 1.0], UP) });
    }
    for clustering in [Clustering::BySensor, Clustering::Dbscan] {
        let (members, line) = newest_line(&buffer, 0, clustering, 0.04, 0.0).unwrap();
        let first = members.iter().take(15).filter(|m| **m).count();
        assert_eq!(first, 0, "{clustering:?}");
        assert!((line.length_m() - 14.0 * 0.04).abs() < 1e-4);
    }
}
