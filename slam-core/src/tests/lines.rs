//! Noise or line, and the uncertainty of a fitted line.

use std::vec::Vec;

use super::outliers::OUTLIER;
use super::random::Random;
use crate::births::buffer::Outlier;
use crate::births::line_fit::{FittedLine, Influence, Moments, Scatter, fit};
use crate::sensing::range::SURFACE_M;

const SURFACE: f64 = SURFACE_M as f64;

/// Points along a line through (0.4, 1.2) whose normal has direction `normal_rad`, each with `sigma_m` along its beam.
fn points(random: &mut Random, n: usize, normal_rad: f64, sigma_m: f64, surface_m: f64) -> Vec<Outlier> {
    let (s, c) = normal_rad.sin_cos();
    (0..n)
        .map(|i| {
            let along = 0.04 * (i as f64 - 0.5 * n as f64);
            // Beams fan out by up to 30 degrees on either side of the normal.
            let beam = normal_rad + random.uniform(-0.5, 0.5);
            // Along the beam the sensor's noise, along the normal the surface's.
            let (range, surface) = (sigma_m * random.gaussian(), surface_m * random.gaussian());
            let off = [range * beam.cos() + surface * c, range * beam.sin() + surface * s];
            Outlier {
                hit_m: [(0.4 - along * s + off[0]) as f32, (1.2 + along * c + off[1]) as f32],
                direction: [beam.cos() as f32, beam.sin() as f32],
                range_m: 0.8 + 0.01 * i as f32,
                sigma_m: sigma_m as f32,
                ..OUTLIER
            }
        })
        .collect()
}

fn scatter(points: &[Outlier]) -> Scatter {
    let mut moments = Moments::about(points[0].hit_m, 0.0);
    for point in points {
        moments.add(point);
    }
    moments.scatter()
}

fn fitted(points: &[Outlier]) -> FittedLine {
    fit::<128>(points.iter(), &scatter(points), 0.0)
}

/// A laser along a wall with door frames: its own noise, along the beam, is not what the hits are off by.
#[test]
fn a_wall_with_relief_is_straight_for_who_expects_it() {
    let mut random = Random::new(11);
    let straight = |relief_m: f32, random: &mut Random| {
        let points = points(random, 20, 0.3, 0.01, 0.02);
        fit::<128>(points.iter(), &scatter(&points), relief_m).is_straight()
    };
    let share = |relief_m: f32, random: &mut Random| (0..200).filter(|_| straight(relief_m, random)).count();
    let (with, without) = (share(0.02, &mut random), share(0.0, &mut random));
    assert!(with > 180 && without < 20, "{with} and {without} of 200");
}

fn off(line: &FittedLine, normal_rad: f64) -> f64 {
    let difference = f64::from(line.normal_rad) - normal_rad;
    difference.sin().atan2(difference.cos())
}

#[test]
fn a_line_with_the_sensor_s_noise_is_straight_and_more_noise_is_not() {
    let mut random = Random::new(1);
    let (mut lines, mut clouds) = (0, 0);
    for round in 0..400 {
        let mut straight = points(&mut random, 20, 0.01 * f64::from(round), 0.01, SURFACE);
        lines += usize::from(scatter(&straight).is_straight());
        // Three times the noise that the sensor claims.
        for point in &mut straight {
            point.sigma_m /= 3.0;
        }
        clouds += usize::from(scatter(&straight).is_straight());
    }
    // Two sigma of a chi-square with 18 degrees of freedom; beams at a slant have less noise across.
    assert!(lines > 380, "{lines} of 400 lines");
    assert!(clouds < 4, "{clouds} of 400 clouds");
}

#[test]
fn the_fit_is_as_uncertain_as_it_says() {
    let mut random = Random::new(2);
    let (mut direction, mut offset) = (0.0, 0.0);
    let rounds = 2000;
    for round in 0..rounds {
        let normal_rad = 0.003 * f64::from(round);
        let line = fitted(&points(&mut random, 24, normal_rad, 0.01, SURFACE));
        direction += off(&line, normal_rad).powi(2) / f64::from(line.direction_variance);
        // Distance of the fitted line from the true one at the fitted centroid.
        let (s, c) = normal_rad.sin_cos();
        let error = (f64::from(line.centroid_m[0]) - 0.4) * c + (f64::from(line.centroid_m[1]) - 1.2) * s;
        offset += error * error / f64::from(line.variance_m2);
    }
    // Chi-square with 2000 degrees of freedom over 2000: one, within 3.2 % at one sigma; a little more for a second step
    // of Gauss-Newton that is not made.
    for (what, mean) in [("direction", direction / f64::from(rounds)), ("offset", offset / f64::from(rounds))] {
        assert!((0.88..1.15).contains(&mean), "{what}: {mean}");
    }
}

#[test]
fn normals_point_away_from_the_robot() {
    let mut random = Random::new(3);
    for step in 0..63 {
        let normal_rad = 0.1 * f64::from(step);
        let line = fitted(&points(&mut random, 20, normal_rad, 0.005, 0.0));
        assert!(off(&line, normal_rad).abs() < 0.05, "{normal_rad}");
        assert!((f64::from(line.normal[0]) - f64::from(line.normal_rad).cos()).abs() < 1e-5);
        assert!((line.length_m() - 0.04 * 19.0).abs() < 0.02);
    }
}

/// The derivatives of a fit by a parameter are those of fitting again what the parameter moved.
#[test]
fn derivatives_by_a_parameter_are_those_of_fitting_again() {
    let mut random = Random::new(4);
    for round in 0..100 {
        let normal_rad = 0.0631 * f64::from(round);
        // Points on the line itself: the derivative is exact where nothing bends it.
        let original = points(&mut random, 20, normal_rad, 1e-5, 0.0)
            .into_iter()
            .map(|p| Outlier { sigma_m: 0.01, ..p })
            .collect::<Vec<_>>();
        let line = fitted(&original);
        // The gain of the sensor that saw every other point.
        let gains = |p: &Outlier| -> [f32; 2] { p.direction.map(|d| -p.range_m * d) };
        let moved_points = original.iter().enumerate().filter(|(i, _)| i % 2 == 0).map(|(_, p)| p);
        let mut influence = Influence::default();
        for p in moved_points {
            line.add_shift(&mut influence, line.weight(p), gains(p));
        }
        let (by_offset, by_direction) = line.by_parameter(&influence);
        let again = |step: f32| {
            let shifted: Vec<Outlier> = original
                .iter()
                .enumerate()
                .map(|(i, p)| {
                    let shift = if i % 2 == 0 { gains(p) } else { [0.0; 2] };
                    Outlier { hit_m: [p.hit_m[0] + step * shift[0], p.hit_m[1] + step * shift[1]], ..*p }
                })
                .collect();
            fitted(&shifted)
        };
        let (above, below) = (again(2e-3), again(-2e-3));
        let direction = off(&above, below.normal_rad.into()) / 4e-3;
        // How far the line moved along its normal, at the centroid.
        let at_centroid =
            |l: &FittedLine| f64::from(l.residual(line.centroid_m).0) / off(l, line.normal_rad.into()).cos();
        let offset = -(at_centroid(&above) - at_centroid(&below)) / 4e-3;
        assert!((direction - f64::from(by_direction)).abs() < 0.02, "{direction} {by_direction}");
        assert!((offset - f64::from(by_offset)).abs() < 0.01, "{offset} {by_offset}");
    }
}
