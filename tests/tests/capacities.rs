//! What the estimator does when something is full, and how large it is.

use hal_sim::{Frame, SimOptions, default_rig};
use slam_core::ekf::{Ekf, storage};
use slam_core::{Config, Counters, DriveModel, HostSlam, Rig, RobotSlam, Slam, WallPolicy};
use tests::frames::{narrowed, narrowed_rig, recorded};
use tests::sanity::{Tally, assert_sane};

/// Runs an estimator over the frames and returns its counters and the most walls and states that it ever had.
fn run<const W: usize, const B: usize, const ROWS: usize>(
    frames: &[Frame],
    walls: WallPolicy,
) -> (Counters, usize, usize) {
    let rig = narrowed_rig(&default_rig());
    let mut config = Config { walls: walls.into(), ..Config::default() };
    // The smallest state has no room for the readings' age beside a free wall.
    config.sensing.calibrate_age = ROWS > storage(16);
    let mut slam = Slam::<8, W, B, ROWS>::with_config(rig, config).unwrap();
    let mut tally = Tally::default();
    let (mut most_walls, mut most_states) = (0, 0);
    for frame in frames {
        let sample = narrowed(&frame.sample);
        let before = slam.counters().map_full;
        let report = slam.step(&sample);
        tally.add(&sample, &report, 8, true);
        if slam.counters().map_full > before {
            assert_eq!(report.births, 0, "a birth refused is no birth");
        }
        assert_sane(&slam);
        most_walls = most_walls.max(slam.walls().count());
        most_states = most_states.max(slam.state_len());
    }
    tally.assert_agrees(&slam);
    (*slam.counters(), most_walls, most_states)
}

#[test]
fn the_robot_s_estimator_fits_into_32_kib() {
    assert!(size_of::<RobotSlam>() <= 32 * 1024, "{} bytes", size_of::<RobotSlam>());
    // Eight sensors with a gain each and an age, wheels with a scale each and a track, a grid and a pose, and 64 grid walls.
    let mut rig: Rig<8> = narrowed_rig(&default_rig());
    if let DriveModel::Wheels { track_sigma, .. } = &mut rig.drive {
        *track_sigma = 0.01;
    }
    let empty = RobotSlam::with_config(rig, Config::default()).unwrap();
    assert_eq!(empty.state_len() + 64, 80);
}

#[test]
fn the_workbench_s_estimator_holds_64_free_walls() {
    let empty = HostSlam::with_config(default_rig(), Config::default()).unwrap();
    assert!(
        empty.state_len() + 2 * 64 <= Ekf::<{ storage(160) }>::CAPACITY,
        "{} states before the first wall",
        empty.state_len()
    );
}

#[test]
fn a_full_map_refuses_births_counts_them_and_goes_on() {
    let frames = recorded("flat", 2.0, 1, SimOptions::default());
    let (roomy, walls, _) = run::<64, 128, { storage(80) }>(&frames, WallPolicy::Grid);
    assert!(walls > 8 && roomy.map_full == 0, "{walls} walls: too tame for this test");
    let (full, most_walls, _) = run::<4, 128, { storage(80) }>(&frames, WallPolicy::Grid);
    assert_eq!(most_walls, 4);
    assert!(full.map_full > 10, "{full:?}");
    // What is known keeps being used; what is not keeps its place in the buffer.
    assert!(full.updates > 100 && full.overwritten > 0, "{full:?}");
}

#[test]
fn a_full_state_refuses_births_that_do_not_fit() {
    let frames = recorded("flat", 2.0, 1, SimOptions::default());
    // 16 states, of which pose, grid, two wheel scales and eight gains take 14: room for one free wall, which alone founds
    // no grid.
    for policy in [WallPolicy::Free, WallPolicy::Snapped { theta_moves: false }, WallPolicy::Grid] {
        let (counters, walls, states) = run::<64, 128, { storage(16) }>(&frames, policy);
        assert_eq!((walls, states), (1, 16), "{policy:?}");
        assert!(counters.map_full > 0, "{policy:?}: {counters:?}");
    }
    // 32 states: room for nine free walls.
    let (counters, walls, states) = run::<64, 128, { storage(32) }>(&frames, WallPolicy::Free);
    assert!(walls >= 8 && states <= 32, "{walls} walls, {states} states: {counters:?}");
}

#[test]
fn a_full_buffer_overwrites_its_oldest_and_counts_them() {
    let frames = recorded("clutter", 1.0, 2, SimOptions::default());
    let (small, ..) = run::<64, 16, { storage(80) }>(&frames, WallPolicy::Grid);
    assert!(small.overwritten > 0, "{small:?}");
    // What came in and was not overwritten became walls or is still there.
    assert!(small.buffered - small.overwritten <= 16 + 16 * small.births, "{small:?}");
    let (large, ..) = run::<64, 128, { storage(80) }>(&frames, WallPolicy::Grid);
    assert!(large.births > 0);
    // With no room for a wall at all everything is overwritten but the last.
    let (none, walls, _) = run::<0, 16, { storage(80) }>(&frames, WallPolicy::Grid);
    assert_eq!((walls, none.births, none.buffered - none.overwritten), (0, 0, 16), "{none:?}");
}
