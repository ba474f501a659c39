//! The covariance of the pose over whole simulated runs, for every policy.

use hal_sim::{SimOptions, default_rig};
use slam_core::{Clustering, Config, HostSlam, WallPolicy};
use tests::frames::recorded;
use tests::sanity::{Tally, assert_sane};

#[test]
fn it_is_a_covariance_at_every_step_of_a_run() {
    let frames = recorded("flat", 4.0, 3, SimOptions::default());
    for walls in [
        WallPolicy::Free,
        WallPolicy::Grid,
        WallPolicy::Snapped { theta_moves: false },
        WallPolicy::Snapped { theta_moves: true },
    ] {
        let clustering = if walls == WallPolicy::Free { Clustering::Dbscan } else { Clustering::BySensor };
        let mut slam = HostSlam::with_config(
            default_rig(),
            Config { walls: walls.into(), births: clustering.into(), ..Config::default() },
        )
        .unwrap();
        let mut tally = Tally::default();
        for frame in &frames {
            let report = slam.step(&frame.sample);
            tally.add(&frame.sample, &report, slam.rig().sensors.len(), true);
            assert_sane(&slam);
        }
        tally.assert_agrees(&slam);
        assert!(slam.counters().updates > 2000, "{walls:?}: {} updates", slam.counters().updates);
        assert!(slam.walls().count() >= 4, "{walls:?}");
    }
}
