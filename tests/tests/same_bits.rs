//! The same samples give the same bits.

use hal_sim::{Frame, SimOptions, default_rig};
use slam_core::{Clustering, Config, HostSlam, WallPolicy};
use tests::frames::recorded;

/// The bits of everything that an estimator shows.
fn bits(slam: &HostSlam) -> Vec<u32> {
    let pose = slam.pose();
    let dead = slam.dead_reckoning();
    let mut numbers = vec![pose.x_m, pose.y_m, pose.theta_rad, dead.x_m, dead.y_m, dead.theta_rad];
    numbers.extend(slam.estimate().covariance.iter());
    numbers.extend(slam.alpha().into_iter().flat_map(<[f32; 2]>::from));
    for wall in slam.walls() {
        numbers.extend([wall.rho_m, wall.beta_rad, wall.lo_m, wall.hi_m, wall.sigma_rho_m, wall.updates as f32]);
    }
    numbers.extend(slam.calibration().flat_map(|(_, factor, sigma)| [factor, sigma]));
    numbers.into_iter().map(f32::to_bits).collect()
}

/// A hash of the bits after every step.
fn run(frames: &[Frame], config: Config) -> (Vec<u64>, HostSlam) {
    let mut slam = HostSlam::with_config(default_rig(), config).unwrap();
    let mut hash = 0xCBF2_9CE4_8422_2325_u64;
    let hashes = frames
        .iter()
        .map(|frame| {
            slam.step(&frame.sample);
            for word in bits(&slam) {
                hash = (hash ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01B3);
            }
            hash
        })
        .collect();
    (hashes, slam)
}

#[test]
fn the_same_samples_give_the_same_bits_at_every_step() {
    let options = SimOptions::default();
    let frames = recorded("clutter", 1.5, 5, options);
    assert_eq!(frames, recorded("clutter", 1.5, 5, options), "the simulator and the pilot repeat too");
    let mut ends = Vec::new();
    for walls in [WallPolicy::Free, WallPolicy::Grid, WallPolicy::Snapped { theta_moves: true }] {
        for clustering in [Clustering::BySensor, Clustering::Dbscan] {
            let config = Config { walls: walls.into(), births: clustering.into(), ..Config::default() };
            let ((first, slam), (second, _)) = (run(&frames, config), run(&frames, config));
            assert_eq!(first, second, "{config:?}");
            assert!(slam.walls().count() > 0, "{config:?}");
            ends.push(*first.last().unwrap());
        }
    }
    // And what should differ does.
    let all = ends.len();
    ends.sort_unstable();
    ends.dedup();
    assert_eq!(ends.len(), all);
    let other = recorded("clutter", 1.5, 6, options);
    assert_ne!(run(&frames, Config::default()).0, run(&other, Config::default()).0);
}
