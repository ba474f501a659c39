use std::vec::Vec;

use slam_core::{DriveModel, Mount, Pose, RangeModel, RangeSensor, Rig};

use super::random::Random;
use crate::frame::Frame;
use crate::gains::Gains;
use crate::group::Group;
use crate::redundancy::lessen;
use crate::rows::{GAINS, WALLS, of_group};
use crate::wall::{Line, Wall};

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

pub fn gains(sensors: usize) -> Gains {
    let mount = Mount { x_m: 0.0, y_m: 0.0, bearing_rad: 0.0 };
    let model = RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 };
    let sensor = RangeSensor { mount, min_m: 0.1, max_m: 2.0, max_incidence_rad: 1.2, gain_sigma: 0.01, model };
    let drive = DriveModel::Wheels {
        track_m: 0.2,
        track_sigma: 0.0,
        metres_per_tick: 1e-4,
        scale_sigma: 0.0,
        noise_m2_per_m: 1e-5,
    };
    Gains::of_rig::<8>(&Rig { drive, adc: None, sensors: core::iter::repeat_n(sensor, sensors).collect() })
}

/// Groups of two sensors put together: later on both go with the gain of one, as far as the gains have one size in common.
#[test]
fn a_group_that_another_sensor_tells_goes_on_with_its_gain() {
    let mut gains = gains(2);
    gains.values[..2].copy_from_slice(&[1.02, 0.99]);
    let own = Group::of([0.1, 0.0], [1.3, 0.2], 1e4, 1.0, 1);
    let told = gains.told_by(0, &own);
    assert_eq!(told.sensor(), 0);
    for common in [1.0, 0.97, 1.03] {
        let mut later = gains;
        later.values[..2].iter_mut().for_each(|gain| *gain *= common);
        let (own, told) = (later.correct(&own).mean_m, later.correct(&told).mean_m);
        assert!((own[0] - told[0]).abs() + (own[1] - told[1]).abs() < 1e-6, "{common}: {own:?} {told:?}");
    }
}

/// Hits that came out short or long tell as much of a gain: else their noise would draw it up.
#[test]
fn the_noise_of_hits_does_not_draw_gains() {
    let gains = gains(1);
    let wall = Wall { rho_m: 1.0, lo_m: -1.0, hi_m: 1.0, hits: 20, is_placed: true, ..Wall::NEW };
    for off_m in [-0.05, 0.0, 0.05] {
        let group = Group::of([0.0; 2], [1.0 + off_m, 0.0], 1e4, 1.0, 0);
        let [apart, _] = of_group(&group, &gains, &Pose::ORIGIN, &Frame::of(&Pose::ORIGIN), &wall, WALLS);
        let by_gain = apart.border.iter().find(|(place, _)| *place == GAINS).expect("a gain that is not known").1;
        assert!((by_gain - 1.0).abs() < 1e-6, "{off_m}: {by_gain}");
    }
}

/// A pose takes three numbers of what is seen from it: of more groups on walls that both poses see, all but three are left.
#[test]
fn what_a_pose_takes_its_groups_no_longer_say() {
    let wall = |beta_rad: f32| {
        Some(Wall { rho_m: 2.0, beta_rad, lo_m: -1.0, hi_m: 1.0, hits: 20, is_placed: true, ..Wall::NEW })
    };
    let walls: Vec<_> = [0.0, 1.6, 3.1, 4.7, 0.8, 2.4].map(wall).into();
    let group = |(number, wall): (usize, &Option<Wall>)| {
        let (sin, cos) = f64::from(wall.expect("a wall").beta_rad).sin_cos();
        // Off the foot of the wall, so that it tells of the heading, too.
        let at_m = [(2.0 * cos - 0.7 * sin) as f32, (2.0 * sin + 0.7 * cos) as f32];
        let mut group = Group::of([0.0; 2], at_m, 1e5, 1.0, 0);
        group.set_wall(Some(number));
        group
    };
    let seen: Vec<Group> = walls.iter().enumerate().map(group).collect();
    let there = Pose::new(0.2, 0.1, 0.3);
    let left = |own: &[Group], noise: [f32; 3]| {
        let mut others = seen.clone();
        lessen(own, &mut others, (&Pose::ORIGIN, &there), &walls, noise);
        others.iter().map(|group| group.weight / 1e5).sum::<f32>()
    };
    let unknown = [1.0, 1.0, 1.0];
    assert!((left(&seen, unknown) - 3.0).abs() < 0.05, "of six {}", left(&seen, unknown));
    let of_others = left(&seen[..3], unknown);
    assert!(
        of_others > 1.0 && of_others < 2.0,
        "three that place the pose, and three that are as well known as that: {of_others}"
    );
    assert!(left(&[], unknown) < 1e-3, "nobody knows from where they were seen");
    assert!(left(&[], [1e-8; 3]) > 5.9 && left(&seen, [1e-8; 3]) > 5.9, "it is known from where");
}
