use std::vec::Vec;

use slam_core::Pose;

use super::random::Random;
use crate::frame::Frame;
use crate::group::Group;
use crate::wall::Line;

fn some(random: &mut Random, hits: usize) -> (Vec<[f32; 2]>, Group) {
    let at = |random: &mut Random| [3.0 + 0.3 * random.even() as f32, 4.0 + 0.02 * random.normal() as f32];
    let points: Vec<[f32; 2]> = (0..hits).map(|_| at(random)).collect();
    let one = |at_m: &[f32; 2]| Group::of([0.1, 0.0], *at_m, 2000.0, 2.0, 0);
    let mut group = one(&points[0]);
    points[1..].iter().for_each(|at_m| group.add(&one(at_m)));
    (points, group)
}

#[test]
fn sums_tell_the_distances_of_the_hits_to_any_line() {
    let mut random = Random(1);
    for _ in 0..200 {
        let (points, group) = some(&mut random, 25);
        let pose =
            Pose::new(20.0 * random.normal() as f32, 20.0 * random.normal() as f32, 3.0 * random.normal() as f32);
        let frame = Frame::of(&pose);
        let beta = 6.0 * random.even();
        let normal = [beta.cos() as f32, beta.sin() as f32];
        let middle = frame.point([3.0, 4.0]);
        let rho_m = normal[0] * middle[0] + normal[1] * middle[1] + 0.05;
        let found = group.offset(&frame, &Line { rho_m, normal }).square;
        let (s, c) = f64::from(pose.theta_rad).sin_cos();
        let behind = |[x, y]: &[f32; 2]| {
            let (x, y) = (f64::from(*x), f64::from(*y));
            let at = [f64::from(pose.x_m) + c * x - s * y, f64::from(pose.y_m) + s * x + c * y];
            at[0] * f64::from(normal[0]) + at[1] * f64::from(normal[1]) - f64::from(rho_m)
        };
        // A weight of 2000 for one of two that are alike is a variance of 1/4000.
        let expected = points.iter().map(|at| behind(at).powi(2)).sum::<f64>() / points.len() as f64 * 4000.0;
        assert!((f64::from(found) - expected).abs() < 1e-3 * expected + 1e-3, "{found} {expected}");
    }
}

#[test]
fn groups_put_together_are_the_group_of_all_hits() {
    let mut random = Random(2);
    let (_, mut first) = some(&mut random, 10);
    let (points, second) = some(&mut random, 7);
    let mut all = first;
    points.iter().for_each(|at_m| all.add(&Group::of([0.1, 0.0], *at_m, 2000.0, 2.0, 0)));
    first.add(&second);
    assert_eq!((first.hits, all.hits), (17, 17));
    for (one, other) in first.scatter.iter().zip(all.scatter) {
        assert!((one - other).abs() < 1e-3 * other.abs() + 1e-3, "{one} {other}");
    }
    assert!((first.mean_m[0] - all.mean_m[0]).abs() < 1e-6 && (first.independent - 8.5).abs() < 1e-6);
}
