//! What holds the map frame.

use core::f32::consts::{FRAC_PI_2, PI};

use super::random::Random;
use crate::filter::ekf::storage;
use crate::geometry::line::Line;
use crate::walls::map_frame::CommonMotion;
use crate::{
    Config, DriveModel, Increment, MapFrame, Motion, Mount, Pose, RangeInput, RangeModel, RangeSensor, Rig, Sample,
    Slam,
};
use crate::{Estimate, WallSettings};

fn line(rho_m: f32, beta_rad: f32) -> Line {
    Line { rho_m, beta_rad, normal: [beta_rad.cos(), beta_rad.sin()] }
}

/// A line of a frame, as it is seen from the outer one.
fn moved(motion: &Pose, was: &Line) -> Line {
    let beta_rad = was.beta_rad + motion.theta_rad;
    let normal = [beta_rad.cos(), beta_rad.sin()];
    line(was.rho_m + motion.x_m * normal[0] + motion.y_m * normal[1], beta_rad)
}

/// A room's four walls.
fn room() -> [Line; 4] {
    [line(3.0, 0.0), line(2.0, FRAC_PI_2), line(4.0, PI), line(5.0, -FRAC_PI_2)]
}

fn assert_near(found: &Pose, expected: &Pose, tolerance: f32) {
    let off = [found.x_m - expected.x_m, found.y_m - expected.y_m, found.theta_rad - expected.theta_rad];
    assert!(off.iter().all(|off| off.abs() < tolerance), "{found:?}, not {expected:?}");
}

#[test]
fn the_motion_that_all_walls_have_is_found() {
    let motion = Pose { x_m: 0.001, y_m: -0.002, theta_rad: 0.000_5 };
    for pivot in [[0.0, 0.0], [2.0, -3.0], [8.0, 6.0]] {
        let mut common = CommonMotion::about(pivot);
        for was in &room() {
            for along_m in [-1.0, 1.5] {
                common.add(was, &moved(&motion, was), along_m, 1.0);
            }
        }
        // But for what the frame weighs itself.
        assert_near(&common.solve().expect("a motion"), &motion, 1e-4);
    }
}

#[test]
fn a_few_walls_that_a_loop_moves_do_not_take_the_frame_along() {
    let jump = Pose { x_m: 0.8, y_m: 0.0, theta_rad: 0.0 };
    let mut common = CommonMotion::about([0.0, 0.0]);
    for was in room().iter().cycle().take(12) {
        common.add(was, was, -1.0, 1.0);
        common.add(was, was, 1.0, 1.0);
    }
    let loose = line(-2.0, 0.0);
    common.add(&loose, &moved(&jump, &loose), -1.0, 1.0);
    common.add(&loose, &moved(&jump, &loose), 1.0, 1.0);
    assert_near(&common.solve().expect("a motion"), &Pose::ORIGIN, 1e-3);
}

#[test]
fn where_no_wall_holds_the_frame_it_stays() {
    assert_eq!(CommonMotion::about([1.0, 2.0]).solve(), Some(Pose::ORIGIN));
    // Two sides of a corridor tell nothing of the way along it.
    let motion = Pose { x_m: 0.0, y_m: 0.005, theta_rad: 0.0 };
    let mut common = CommonMotion::about([0.0, 0.0]);
    for was in [line(1.0, FRAC_PI_2), line(1.0, -FRAC_PI_2)] {
        common.add(&was, &moved(&motion, &was), -2.0, 1.0);
        common.add(&was, &moved(&motion, &was), 2.0, 1.0);
    }
    assert_near(&common.solve().expect("a motion"), &motion, 2e-4);
    let mut broken = CommonMotion::about([0.0, 0.0]);
    broken.add(&line(f32::NAN, 0.0), &line(1.0, 0.0), 0.0, 1.0);
    assert_eq!(broken.solve(), None);
}

#[test]
fn a_wall_askew_to_a_corridor_s_sides_does_not_draw_the_frame_along() {
    // It moved by 30 cm beside the others, as its own error does: along the corridor that would be 1.7 m.
    let own = Pose { x_m: 0.0, y_m: 0.3, theta_rad: 0.0 };
    let mut common = CommonMotion::about([0.0, 0.0]);
    for was in [line(1.0, FRAC_PI_2), line(1.0, -FRAC_PI_2)] {
        common.add(&was, &was, -2.0, 1.0);
        common.add(&was, &was, 2.0, 1.0);
    }
    let askew = line(1.0, FRAC_PI_2 - 10.0f32.to_radians());
    common.add(&askew, &moved(&own, &askew), -1.0, 1.0);
    common.add(&askew, &moved(&own, &askew), 1.0, 1.0);
    let step = common.steadied().solve().expect("a motion");
    assert!(step.x_m.abs() < 1e-3, "{step:?}");
}

/// A robot that turns in a room, with both frames: where each says that the robot, its start and the walls are.
fn turned(frame: MapFrame) -> Slam<4, 16, 64, { storage(48) }> {
    let sensors = (0..4).map(|i| RangeSensor {
        mount: Mount { x_m: 0.0, y_m: 0.0, bearing_rad: FRAC_PI_2 * i as f32 },
        min_m: 0.1,
        max_m: 8.0,
        max_incidence_rad: 1.2,
        gain_sigma: 0.0,
        model: RangeModel::Metric { noise_m: 0.01, noise_rel: 0.0 },
    });
    let drive = DriveModel::Odometry {
        scale_sigma: 0.05,
        noise_m2_per_m: 1e-4,
        noise_rad2_per_m: 1e-4,
        noise_rad2_per_rad: 1e-3,
        veer_sigma: 0.0,
    };
    let rig = Rig { drive, adc: None, sensors: sensors.collect() };
    let config = Config { walls: WallSettings { frame, ..WallSettings::real_rooms() }, ..Config::real_rooms() };
    let mut slam = Slam::with_config(rig, config).expect("a rig that can be");
    let mut random = Random::new(5);
    let mut theta = 0.0f32;
    for step in 0..400u64 {
        let turn_rad = if (step / 100).is_multiple_of(2) { 0.03 } else { -0.03 };
        // Odometry says three per cent more than the robot turns.
        theta += turn_rad / 1.03;
        let increment = Increment { forward_m: 0.0, left_m: 0.0, turn_rad };
        let ranges = core::array::from_fn(|i| {
            let bearing = theta + FRAC_PI_2 * i as f32;
            let range = room().into_iter().map(|wall| wall.rho_m / (bearing - wall.beta_rad).cos());
            let nearest = range.filter(|range| *range > 0.0).fold(f32::MAX, f32::min);
            RangeInput::Metres(nearest + 0.01 * random.gaussian() as f32)
        });
        slam.step(&Sample { time_us: 40_000 * step, motion: Motion::Increment(increment), ranges });
    }
    slam
}

#[test]
fn both_frames_are_one_map() {
    let (held, still) = (turned(MapFrame::Walls), turned(MapFrame::Start));
    assert_eq!(still.start_pose(), Pose::ORIGIN);
    assert!(held.walls().count() >= 4 && held.start_pose() != Pose::ORIGIN, "{:?}", held.start_pose());
    assert_near(&held.start_pose().inverse().compose(&held.pose()), &still.pose(), 1e-4);
    for (wall, other) in held.walls().zip(still.walls()) {
        let here = moved(&held.start_pose(), &line(other.rho_m, other.beta_rad));
        assert!((wall.rho_m - here.rho_m).abs() < 1e-4, "{wall:?}, {here:?}");
        assert!((wall.hi_m - wall.lo_m - (other.hi_m - other.lo_m)).abs() < 1e-4, "{wall:?}, {other:?}");
    }
}

/// e' P^-1 e, by Gauss' elimination.
fn normalised(mut p: [[f64; 3]; 3], mut e: [f64; 3]) -> f64 {
    let mut sum = 0.0;
    for i in 0..3 {
        sum += e[i] * e[i] / p[i][i];
        for j in i + 1..3 {
            let factor = p[j][i] / p[i][i];
            e[j] -= factor * e[i];
            for k in i..3 {
                p[j][k] -= factor * p[i][k];
            }
        }
    }
    sum
}

#[test]
fn pose_and_covariance_are_in_one_frame() {
    let mut slam = turned(MapFrame::Walls);
    // The robot has turned back to where it began: the truth is where the walls say that the start is.
    let (Estimate { pose, covariance }, start) = (slam.estimate(), slam.start_pose());
    let off = [pose.x_m - start.x_m, pose.y_m - start.y_m, pose.theta_rad - start.theta_rad];
    let rows: [[f32; 3]; 3] = covariance.into();
    // 99.9 % of a chi-square distribution with three degrees of freedom.
    assert!(normalised(rows.map(|row| row.map(f64::from)), off.map(f64::from)) < 16.3, "{pose:?}, {start:?}");
    // An uncertainty that is long in one direction, and a frame that has turned by forty degrees.
    let start = Pose::new(0.4, -0.3, 0.7);
    slam.map.start = start;
    let from_start = [0, 1, 2].map(|i| [0, 1, 2].map(|j| slam.ekf.covariance(i, j)));
    let estimate = slam.estimate();
    assert_eq!(estimate.pose, slam.pose());
    assert_ne!(estimate.covariance, from_start.into());
    // What the true pose is in the frame of the start it is in the map frame by the start pose: the error of an estimate
    // is the same number of standard deviations in either.
    let mut random = Random::new(3);
    let pose = start.inverse().compose(&estimate.pose);
    for _ in 0..20 {
        let off = [0, 1, 2].map(|i| from_start[i][i].sqrt() * random.gaussian() as f32);
        let truth = Pose::new(pose.x_m + off[0], pose.y_m + off[1], pose.theta_rad + off[2]);
        let in_map = start.compose(&truth);
        let error = [
            in_map.x_m - estimate.pose.x_m,
            in_map.y_m - estimate.pose.y_m,
            in_map.theta_rad - estimate.pose.theta_rad,
        ];
        let covariance: [[f32; 3]; 3] = estimate.covariance.into();
        let [here, there] = [(covariance, error), (from_start, off)]
            .map(|(p, e)| normalised(p.map(|row| row.map(f64::from)), e.map(f64::from)));
        assert!((here - there).abs() < 0.02 * there + 1e-3, "{here} in the map, {there} from the start");
    }
}
